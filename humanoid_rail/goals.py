"""Goals: configurations with the hands at their targets, and why there may be none.

A hand at its target may touch something whatever the configuration is; its target may be farther away than any
configuration reaches. Both are told apart before a way is looked for.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from itertools import combinations, islice

import coal
import numpy as np
from scipy.optimize import least_squares

from humanoid_rail.arrays import Array
from humanoid_rail.engines import Engine
from humanoid_rail.inverse_kinematics import Posture
from humanoid_rail.kinematics import State
from humanoid_rail.obstacles import name_of
from humanoid_rail.paths import speed_units
from humanoid_rail.robot import Hand, Robot
from humanoid_rail.scene import Scene
from humanoid_rail.shapes import placed_shapes

Solve = Callable[[Array], Posture]
"""Inverse kinematics from a configuration (n,)."""

WIDEST = 10.0
"""Joints without position limits are taken to have these, m and rad."""
PULLS = 8
"""How often a goal is pulled towards the start."""
REACH_SEEDS = 48
"""Starts of the inverse kinematics that judges the reach."""
MOST_STEPS = 100
"""Of the search for the smallest error."""
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


def blocked_target(robot: Robot, scene: Scene, distance: float, tolerance: float) -> str | None:
    """Return why a hand cannot be at its target, whatever the configuration; None if it may be.

    The body of a hand holds a ball around the hand's point. Where the ball touches something, so does the body.

    Args:
        robot: The robot.
        scene: Targets and obstacles, at rest.
        distance: What links keep from obstacles and from each other, m.
        tolerance: How far a hand may stay from its target, m.
    """
    balls = {hand.name: _ball(robot, hand) for hand in robot.hands}
    request = coal.DistanceRequest()
    for name, radius in balls.items():
        ball, center = coal.Sphere(max(radius, POINT)), coal.Transform3s(np.eye(3), np.array(scene.targets[name]))
        for i, obstacle in enumerate(scene.obstacles):
            for shape, placement in placed_shapes(obstacle):
                clearance = coal.distance(ball, center, shape, placement, request, coal.DistanceResult())
                if clearance < distance - tolerance:
                    return f"the {name} hand at its target would {_near(clearance, name_of(scene.obstacles, i))}"
    for one, other in combinations(balls, 2):
        gap = float(np.linalg.norm(np.subtract(scene.targets[one], scene.targets[other])))
        clearance = gap - balls[one] - balls[other]
        if clearance < distance - 2 * tolerance and _are_checked(robot, one, other):
            return f"with both at their targets, the {one} hand would {_near(clearance, f'the {other} hand')}"
    return None


def out_of_reach(
    robot: Robot,
    targets: Array,
    start: Array,
    computing: Engine,
    random: np.random.Generator,
    tolerance: float,
    deadline: float = np.inf,
) -> str | None:
    """Return by how much targets are out of reach, and for which hand; None if they are not.

    Args:
        robot: The robot; its limits count, obstacles and other links do not.
        targets: x_f (h, 3), m.
        start: Where to look first (n,).
        computing: The engine.
        random: For where else to look.
        tolerance: How far |e| may stay from 0, m.
        deadline: When to stop looking, on the clock of `time.perf_counter`, s; then targets count as in reach.
    """
    solver, kinematics = computing.inverse_kinematics(robot, ()), computing.kinematics(robot, ())

    free = np.flatnonzero((robot.velocity_limit > 0) & (robot.lower < robot.upper))

    def least_error(hands: list[int]) -> float | None:
        """Return the least error of some hands that is found in time."""
        weights = np.zeros_like(targets)
        weights[hands] = 1.0
        rows = np.flatnonzero(weights)
        best = Posture(start, np.inf, np.inf)
        for seed in islice(seeds(robot, start, random), REACH_SEEDS):
            found = solver.solve(seed, targets.ravel(), weights.ravel(), -np.inf)
            best = min(best, found, key=lambda posture: posture.error)
            if best.error <= tolerance:
                return float(best.error)
            if time.perf_counter() > deadline:
                return None

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
            error,
            best.q[free],
            slope,
            bounds=(robot.lower[free], robot.upper[free]),
            max_nfev=MOST_STEPS,
        )
        return min(float(best.error), float(np.sqrt(2.0 * closest.cost)))

    every = list(range(len(robot.hands)))
    together = least_error(every)
    if together is None or together <= tolerance:
        return None
    far = []
    for i in every:
        alone = together if len(every) == 1 else least_error([i])
        if alone is None:
            return None
        if alone > tolerance:
            far.append(f"the target of the {robot.hand_names[i]} hand is {alone:.3g} m out of reach")
    if far:
        return ", and ".join(far)
    names = " and the ".join(robot.hand_names)
    return f"each target is in reach of its hand, but not both at once: the {names} hands stay {together:.3g} m away"


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
