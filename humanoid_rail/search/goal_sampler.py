"""Goals: configurations with the hands at their targets, and why there may be none.

A hand at its target may touch something whatever the configuration is; its target may be farther away than any
configuration reaches. Both are told apart before a way is looked for.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from itertools import combinations, islice

import coal
import numpy as np
from scipy.optimize import least_squares

from humanoid_rail._arrays import Array
from humanoid_rail.planning.engines import Engine
from humanoid_rail.kinematics.inverse_kinematics import Posture
from humanoid_rail.kinematics.kinematics import State
from humanoid_rail.scene.obstacles import Obstacle, name_of
from humanoid_rail.search.smoothing import speed_units
from humanoid_rail.model.robot import Hand, Robot
from humanoid_rail.scene.shapes import placed_shapes
from humanoid_rail.kinematics.task import LEVER, Task

Solve = Callable[[Array], Posture]
"""Inverse kinematics from a configuration (n,)."""

WIDEST = 10.0
"""Joints without position limits are taken to have these, m and rad."""
PULLS = 8
"""How often a goal is pulled towards the start."""
REACH_SEEDS, TURN_SEEDS = 48, 1000
"""Starts of the inverse kinematics that judges the reach, and how hands can be turned: few lead there."""
MOST_STEPS = 100
"""Of the search for the smallest error."""
TURNED = 1e-5
"""Hands whose points are no farther from where they have to be can be turned as they have to be, m."""
POINT = 1e-9
"""The radius of a point, m."""


def seeds(robot: Robot, start: Array, random: np.random.Generator) -> Iterator[Array]:
    """Yield a start (n,), and then random configurations on the straight ways from it to anywhere, without end.

    Joints whose speed limit is 0 stay where they are.
    """
    moves = robot.velocity_limit > 0
    lower = np.where(moves, np.maximum(robot.lower, start - WIDEST), start)
    upper = np.where(moves, np.minimum(robot.upper, start + WIDEST), start)
    yield start
    while True:
        yield start + random.random() * (random.uniform(lower, upper) - start)


def pull(robot: Robot, goal: Array, start: Array, solve: Solve, distance: float, deadline: float = np.inf) -> Array:
    """Return a goal (n,) nearer to a start (n,), or the same: again and again looked for from between the two."""
    units = speed_units(robot)
    share, length = 0.5, float(np.linalg.norm((goal - start) / units))
    for _ in range(PULLS):
        if time.perf_counter() > deadline:
            break
        posture = solve(goal + share * (start - goal))
        nearer = float(np.linalg.norm((posture.q - start) / units))
        if posture.reaches(distance) and nearer < length:
            goal, length = posture.q, nearer
        else:
            share /= 2
    return goal


def blocked_target(
    robot: Robot, targets: Array, obstacles: tuple[Obstacle, ...], distance: float, tolerance: float
) -> str | None:
    """Return why a hand cannot be at its target, whatever the configuration; None if it may be.

    The body of a hand holds a ball around the hand's point. Where the ball touches something, so does the body.

    Args:
        robot: The robot.
        targets: x_f (h, 3), m.
        obstacles: At rest.
        distance: What links keep from obstacles and from each other, m.
        tolerance: How far a hand may stay from its target, m.
    """
    balls = {hand.name: _ball(robot, hand) for hand in robot.hands}
    request = coal.DistanceRequest()
    for (name, radius), target in zip(balls.items(), targets, strict=True):
        ball, center = coal.Sphere(max(radius, POINT)), coal.Transform3s(np.eye(3), target)
        for i, obstacle in enumerate(obstacles):
            for shape, placement in placed_shapes(obstacle):
                clearance = coal.distance(ball, center, shape, placement, request, coal.DistanceResult())
                if clearance < distance - tolerance:
                    return f"the {name} hand at its target would {_near(clearance, name_of(obstacles, i))}"
    for (i, one), (j, other) in combinations(enumerate(balls), 2):
        gap = float(np.linalg.norm(targets[i] - targets[j]))
        clearance = gap - balls[one] - balls[other]
        if clearance < distance - 2 * tolerance and _are_checked(robot, one, other):
            return f"with both at their targets, the {one} hand would {_near(clearance, f'the {other} hand')}"
    return None


def out_of_reach(
    task: Task,
    start: Array,
    computing: Engine,
    random: np.random.Generator,
    tolerance: float,
    deadline: float = np.inf,
) -> str | None:
    """Return by how much targets are out of reach, and for which hand; None if they are not.

    Args:
        task: The robot and its targets; the robot's limits count, obstacles and other links do not.
        start: Where to look first (n,).
        computing: The engine.
        random: For where else to look.
        tolerance: How far |e| may stay from 0, m.
        deadline: When to stop looking, on the clock of `time.perf_counter`, s; then targets count as in reach.
    """

    def too_far(robot: Robot, points: Array, some: list[int], tolerance: float, attempts: int) -> float | None:
        """Return the least error of some points of a robot, if it is more than a tolerance in m."""
        places = islice(seeds(robot, start, random), attempts)
        error = _least_error(robot, points, some, places, computing, tolerance, deadline)
        return error if error is not None and error > tolerance else None

    hands = task.robot.hand_names
    every = list(range(len(hands)))
    together = too_far(task.robot, task.targets, every, tolerance, REACH_SEEDS)
    if together is not None:
        errors = [too_far(task.robot, task.targets, [i], tolerance, REACH_SEEDS) for i in every]
        named = zip(hands, errors, strict=True)
        far = [f"the target of the {name} hand is {error:.3g} m out of reach" for name, error in named if error]
        if far:
            return ", and ".join(far)
        if time.perf_counter() > deadline:
            return None
        names = " and the ".join(hands)
        return (
            f"each target is in reach of its hand, but not both at once: the {names} hands stay {together:.3g} m away"
        )
    if not task.is_oriented:
        return None
    # No tolerance is about how hands are turned.
    together = too_far(task.posed, task.points, list(range(len(task.points))), TURNED, TURN_SEEDS)
    if together is None:
        return None
    levers = len(task.points) - len(task.targets)
    on = [[i for i, owner in enumerate(task.owners) if owner == hand] for hand in every]
    alone = [too_far(task.posed, task.points, some, TURNED, TURN_SEEDS) for some in on]
    far = [
        f"the {name} hand is {_degrees(error, len(some) - 1)} deg from how it has to be turned"
        for name, some, error in zip(hands, on, alone, strict=True)
        if error
    ]
    if far:
        return f"the targets are in reach, but there {', and '.join(far)}, or more"
    if time.perf_counter() > deadline:
        return None
    left = _degrees(together, levers)
    return f"each hand can be turned as it has to be, but not both at once: {left} deg are left, or more"


def _degrees(error: float, levers: int) -> str:
    """Return by how much a hand is turned wrongly, or more, if that is the error of its points.

    Turned by an angle, a hand at its target has each of its further points off by 2 LEVER sin(angle / 2), or less.
    """
    return f"{np.rad2deg(2.0 * np.arcsin(min(1.0, error / (2.0 * LEVER * np.sqrt(max(1, levers)))))):.2g}"


def _least_error(
    robot: Robot,
    targets: Array,
    some: list[int],
    places: Iterable[Array],
    computing: Engine,
    tolerance: float,
    deadline: float,
) -> float | None:
    """Return the least error in m of some of a robot's points that is found in time; None if time runs out.

    The search begins at some places (n,).
    """
    solver, kinematics = computing.inverse_kinematics(robot, ()), computing.kinematics(robot, ())
    weights = np.zeros_like(targets)
    weights[some] = 1.0
    rows = np.flatnonzero(weights)
    best = Posture(np.empty(0), np.inf, np.inf)
    for place in places:
        found = solver.solve(place, targets.ravel(), weights.ravel(), -np.inf)
        best = min(found, best, key=lambda posture: posture.error)
        if best.error <= tolerance:
            return float(best.error)
        if time.perf_counter() > deadline:
            return None
    free = np.flatnonzero((robot.velocity_limit > 0) & (robot.lower < robot.upper))

    def state(x: Array) -> State:
        q = best.q.copy()
        q[free] = x
        there: State = kinematics.state(q)
        return there

    def error(x: Array) -> Array:
        remaining: Array = state(x).hands.ravel()[rows] - targets.ravel()[rows]
        return remaining

    def slope(x: Array) -> Array:
        jacobian: Array = state(x).jacobian[np.ix_(rows, free)]
        return jacobian

    # Inverse kinematics is made for errors that vanish; from where it ends this finds the smallest.
    closest = least_squares(
        error, best.q[free], slope, bounds=(robot.lower[free], robot.upper[free]), max_nfev=MOST_STEPS
    )
    return min(float(best.error), float(np.sqrt(2.0 * closest.cost)))


def _ball(robot: Robot, hand: Hand) -> float:
    """Return the radius of the largest ball around a hand's point that its body holds, m."""
    frame = robot.model.frames[robot.model.getFrameId(hand.frame)]
    point = coal.Sphere(POINT)
    center = coal.Transform3s(np.eye(3), frame.placement.translation)
    radius = 0.0
    for body in robot.collision_model.geometryObjects:
        if body.parentJoint == frame.parentJoint:
            placement = coal.Transform3s(body.placement.rotation, body.placement.translation)
            result = coal.DistanceResult()
            distance = coal.distance(point, center, body.geometry, placement, coal.DistanceRequest(), result)
            radius = max(radius, -float(distance))
    return radius


def _are_checked(robot: Robot, one: str, other: str) -> bool:
    """Return whether two hands' bodies must not touch."""
    joints = {hand.name: robot.model.frames[robot.model.getFrameId(hand.frame)].parentJoint for hand in robot.hands}
    bodies = robot.collision_model.geometryObjects
    checked = {frozenset((bodies[a].parentJoint, bodies[b].parentJoint)) for a, b in robot.self_collision_pairs}
    return frozenset((joints[one], joints[other])) in checked


def _near(clearance: float, what: str) -> str:
    if clearance < 0:
        return f"be {-clearance:.3g} m inside {what}"
    return f"be {clearance:.3g} m from {what}, nearer than the safety distance"
