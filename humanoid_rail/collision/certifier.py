"""Proves a motion free of contact, including between samples, or finds the first contact.

The native engine follows pair after pair of bodies along the motion and looks again where two could have come near
enough to matter (`engine/collision/certifier.cpp`); how distances are bounded between two moments is in
`swept_distance.cpp`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from humanoid_rail._arrays import Array
from humanoid_rail._native import engine
from humanoid_rail.collision.certificate import Certificate, Contact
from humanoid_rail.model.native_robot import native_robot
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.native_obstacles import native_obstacles
from humanoid_rail.scene.obstacles import Obstacle, name_of

if TYPE_CHECKING:
    from humanoid_rail import _engine


def certify(robot: Robot, obstacles: tuple[Obstacle, ...], t: Array, q: Array) -> Certificate:
    """Return what can be proven of a motion that is linear in q between its samples.

    Args:
        robot: The robot.
        obstacles: What its links must not touch, beside each other.
        t: Times (N,), strictly increasing, s.
        q: Configurations (N, n), m and rad.

    Raises:
        EngineMissing: If there is no native engine.
    """
    found = engine().Certifier(native_robot(robot), native_obstacles(obstacles)).certify(t, q)
    some_obstacle, some_pair = bool(obstacles), bool(robot.self_collision_pairs)
    return Certificate(
        certified=found.certified,
        min_clearance_obstacles=found.min_obstacles if some_obstacle else None,
        min_clearance_self=found.min_links if some_pair else None,
        clearance_bound=found.bound if some_obstacle or some_pair else None,
        contact=None if found.contact is None else named_contact(robot, obstacles, found.contact),
        unchecked_pairs=robot.unchecked_pairs,
        links_without_body=robot.links_without_body,
    )


def named_contact(robot: Robot, obstacles: Sequence[Obstacle], found: _engine.Contact) -> Contact:
    """Return a contact by names from one of the engine, which has numbers."""
    name = name_of(obstacles, found.other) if found.with_obstacle else robot.link_names[found.other]
    x, y, z = (float(c) for c in found.point)
    return Contact(float(found.t), robot.link_names[found.link], name, (x, y, z))


def bound_resolution() -> float:
    """Return how far a clearance bound may lie below the smallest clearance that was found, m."""
    return float(engine().RESOLUTION)


def least_distance() -> float:
    """Return the distance that a step keeps between all pairs, m: twice the precision of coal's distances."""
    return float(engine().APART)
