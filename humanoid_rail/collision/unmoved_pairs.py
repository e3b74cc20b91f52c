"""Bodies of a robot and obstacles neither of which ever moves: no motion changes how near they are to each other."""

from __future__ import annotations

from collections.abc import Iterator
from weakref import WeakKeyDictionary

import numpy as np
import pinocchio as pin

from humanoid_rail.model.collision_bodies import coal_placement
from humanoid_rail.model.pairs import NEITHER_MOVES, UncheckedPair
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import Obstacle, is_moving, name_of
from humanoid_rail.scene.shapes import PlacedShape, distance_between, placed_shapes

PRECISION = 1e-6
"""Two that are nearer than this cannot be told from touching, m."""

_resting: WeakKeyDictionary[Robot, dict[str, list[PlacedShape]]] = WeakKeyDictionary()


def unmoved_pairs(
    robot: Robot, obstacles: tuple[Obstacle, ...], nearer_than: float = np.inf
) -> Iterator[tuple[UncheckedPair, float]]:
    """Yield links and obstacles that are near each other and never move, and their distance, m; negative inside.

    Args:
        robot: The robot.
        obstacles: What it is among.
        nearer_than: Those that are farther apart are left out, m.
    """
    bodies = _bodies_at_rest(robot)
    if not bodies:
        return
    resting = [(i, placed_shapes(obstacle)) for i, obstacle in enumerate(obstacles) if not is_moving(obstacle)]
    for link, shapes in bodies.items():
        for i, pieces in resting:
            distance = min(distance_between(shape, piece) for shape in shapes for piece in pieces)
            if distance <= nearer_than + PRECISION:
                deep = f" by {-distance:.3g} m" if distance < -PRECISION else ""
                near = f"they are {distance:.4g} m apart" if distance > PRECISION else f"they touch{deep}"
                yield UncheckedPair(link, name_of(obstacles, i), f"{NEITHER_MOVES}; {near}"), distance


def _bodies_at_rest(robot: Robot) -> dict[str, list[PlacedShape]]:
    """Return the bodies that no actuated joint moves, by their links, where they are."""
    if robot in _resting:
        return _resting[robot]
    data, found = robot.model.createData(), dict[str, list[PlacedShape]]()
    pin.forwardKinematics(robot.model, data, robot.full_configuration(robot.initial))
    rows = zip(robot.link_names, robot.collision_model.geometryObjects, robot.moving_bodies, strict=True)
    for link, body, moves in rows:
        if not moves and link not in robot.objects:
            place = data.oMi[body.parentJoint] * body.placement
            found.setdefault(link, []).append(PlacedShape(body.geometry, coal_placement(place)))
    _resting[robot] = found
    return found
