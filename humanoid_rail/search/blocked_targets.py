"""Targets at which a hand touches something, whatever the configuration."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import TypeGuard

import coal
import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.errors import told_apart
from humanoid_rail.kinematics.task import PointTask, Task
from humanoid_rail.model.collision_bodies import coal_placement
from humanoid_rail.model.pair_distances import own_distances
from humanoid_rail.model.robot import Hand, Robot, called
from humanoid_rail.scene.obstacles import Obstacle, name_of
from humanoid_rail.scene.shapes import PlacedShape, distance_between, placed_shapes

POINT = 1e-9
"""A point is a ball of this radius, m."""


def blocked_target(
    robot: Robot, tasks: Sequence[Task], obstacles: tuple[Obstacle, ...], distance: float, tolerance: float
) -> str | None:
    """Return why a hand cannot be at its target, whatever the configuration; None if it may be.

    The body of a hand holds a ball around the hand's point. Where the ball touches something, so does the body.

    Args:
        robot: The robot.
        tasks: What is to be reached; those that put a hand's own point somewhere are looked at.
        obstacles: At rest.
        distance: What links keep from obstacles and from each other, m.
        tolerance: How far a hand may stay from its target, m.
    """
    targets = {task.hand: np.array(task.target, float) for task in tasks if _is_hand_at_point(task)}
    balls = {hand.name: _ball(robot, hand) for hand in robot.hands if hand.name in targets}
    for name, (radius, body) in balls.items():
        if body < 0:
            continue  # A point outside of all bodies, as between fingers, may be inside of what they hold.
        for i, obstacle in enumerate(obstacles):
            clearance = _distance(max(radius, POINT), targets[name], obstacle)
            if clearance < distance - tolerance:
                return f"{called(name)} at its target would {_near(clearance, name_of(obstacles, i), distance)}"
    for one, other in combinations(balls, 2):
        gap = float(np.linalg.norm(targets[one] - targets[other]))
        clearance = gap - balls[one][0] - balls[other][0]
        kept = _kept_apart(robot, balls[one][1], balls[other][1], distance)
        if clearance < kept - 2 * tolerance:
            near = _near(clearance, called(other), kept)
            return f"with both at their targets, {called(one)} would {near}"
    return None


def targets_inside(tasks: Sequence[Task], obstacles: tuple[Obstacle, ...]) -> Iterator[str]:
    """Yield which targets of hands are inside of which obstacles.

    That need not be why a hand cannot be there: a point between its fingers may be inside of what they hold.

    Args:
        tasks: What is to be reached; those that put a hand's own point somewhere are looked at.
        obstacles: At rest.
    """
    for task in tasks:
        if not _is_hand_at_point(task):
            continue
        for i, obstacle in enumerate(obstacles):
            depth = -_distance(POINT, np.array(task.target, float), obstacle)
            if depth > 0.0:
                yield f"the target of {called(task.hand)} is {depth:.3g} m inside {name_of(obstacles, i)}"


def _distance(radius: float, center: Array, obstacle: Obstacle) -> float:
    """Return how far a ball is from an obstacle, m; negative inside."""
    ball = PlacedShape(coal.Sphere(radius), coal.Transform3s(np.eye(3), center))
    return min(distance_between(ball, piece) for piece in placed_shapes(obstacle))


def _is_hand_at_point(task: Task) -> TypeGuard[PointTask]:
    return type(task) is PointTask and not any(task.offset)


def _ball(robot: Robot, hand: Hand) -> tuple[float, int]:
    """Return the radius of the largest ball around a hand's point that a body holds, m, and the body, or -1."""
    frame = robot.model.frames[robot.model.getFrameId(hand.frame)]
    point = PlacedShape(coal.Sphere(POINT), coal.Transform3s(np.eye(3), frame.placement.translation))
    radius, holds = 0.0, -1
    for i, body in enumerate(robot.collision_model.geometryObjects):
        if body.parentJoint == frame.parentJoint:
            depth = -distance_between(point, PlacedShape(body.geometry, coal_placement(body.placement)))
            if depth > radius:
                radius, holds = depth, i
    return radius, holds


def _kept_apart(robot: Robot, one: int, other: int, distance: float) -> float:
    """Return how far apart two bodies are kept, m; minus infinity if they are not checked against each other."""
    pairs = zip(robot.self_collision_pairs, own_distances(robot), strict=True)
    return max((min(distance, float(own)) for pair, own in pairs if {*pair} == {one, other}), default=-np.inf)


def _near(clearance: float, what: str, distance: float) -> str:
    if clearance < 0:
        return f"be {-clearance:.3g} m inside {what}, and has to keep safety_distance = {distance:g} m from it"
    near = told_apart(clearance, distance, 3)
    return f"be {near} m from {what}, nearer than the safety distance, safety_distance = {distance:g} m"
