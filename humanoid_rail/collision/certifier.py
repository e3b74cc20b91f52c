"""Proves a motion free of contact, including between samples, or finds the first contact.

The native engine follows pair after pair of bodies along the motion and looks again where two could have come near
enough to matter (`engine/collision/certifier.cpp`); how distances are bounded between two moments is in
`swept_distance.cpp`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail._native import engine
from humanoid_rail.collision.certificate import Certificate, Contact
from humanoid_rail.collision.unmoved_pairs import unmoved_pairs
from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.beyond_limits import robot_of_motion
from humanoid_rail.model.native_robot import native_robot
from humanoid_rail.model.pair_distances import own_distances
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.native_obstacles import native_obstacles
from humanoid_rail.scene.obstacles import Obstacle, covers_of, name_of

if TYPE_CHECKING:
    from humanoid_rail import _engine

LARGEST_BUDGET = 10**12
"""A budget of checks cannot be larger: it would take weeks to use up."""


def certify(
    robot: Robot,
    obstacles: tuple[Obstacle, ...],
    t: Array,
    q: Array,
    velocity: Array | None = None,
    *,
    max_checks: int | None = None,
) -> Certificate:
    """Return what can be proven of a motion.

    A body of the robot and an obstacle neither of which ever moves are not looked at, as no motion changes how near
    they are; of these the certificate names those that are nearer than its bound. Neighbours that only the position
    limits keep apart are checked too if the motion leaves these limits.

    Args:
        robot: The robot.
        obstacles: What its links must not touch, beside each other.
        t: Times (N,), strictly increasing, s.
        q: Configurations (N, n), m and rad.
        velocity: Velocities (N, n), m/s and rad/s, of the cubic spline that the motion is; without them it is linear in
            q between its samples.
        max_checks: How many distances may be measured; :func:`default_max_checks` if not given.

    Raises:
        InvalidInput: If `max_checks` is no whole number greater than 0.
        EngineMissing: If there is no native engine.
    """
    budget = default_max_checks() if max_checks is None else max_checks
    if isinstance(budget, bool) or not isinstance(budget, int) or not 0 < budget <= LARGEST_BUDGET:
        raise InvalidInput("max_checks", budget, f"a whole number from 1 to {LARGEST_BUDGET}")
    robot = robot_of_motion(robot, t, q, velocity)
    certifier = engine().Certifier(native_robot(robot), native_obstacles(obstacles))
    found = certifier.certify(t, q, np.empty((0, robot.n)) if velocity is None else velocity, budget)
    own = own_distances(robot)
    some_own = bool(np.isfinite(own).any())
    reason = None if found.stopped is None else f"budget of {budget} checks used up at t = {found.stopped:.4g} s"
    bound = _finite(found.bound) if reason is None else None
    nearer_than = np.inf if bound is None else max(bound, 0.0)
    return Certificate(
        certified=found.certified,
        min_clearance_obstacles=_finite(found.min_obstacles),
        min_clearance_self=_finite(found.min_links),
        clearance_bound=bound,
        contact=None if found.contact is None else named_contact(robot, obstacles, found.contact),
        unchecked_pairs=(*robot.unchecked_pairs, *(pair for pair, _ in unmoved_pairs(robot, obstacles, nearer_than))),
        links_without_body=robot.links_without_body,
        reason=reason,
        others_bound=_finite(found.others_bound) if some_own and reason is None else None,
        covers=covers_of(obstacles),
        only_own_distances=some_own and bool(np.isfinite(own).all() and np.isinf(found.min_obstacles)),
    )


def _finite(clearance: float) -> float | None:
    """Return a clearance, or None where there is none, or the budget was used up before any was measured."""
    return clearance if np.isfinite(clearance) else None


def named_contact(robot: Robot, obstacles: Sequence[Obstacle], found: _engine.Contact) -> Contact:
    """Return a contact by names from one of the engine, which has numbers."""
    name = name_of(obstacles, found.other) if found.with_obstacle else robot.link_names[found.other]
    x, y, z = (float(c) for c in found.point)
    return Contact(float(found.t), robot.link_names[found.link], name, (x, y, z))


def default_max_checks() -> int:
    """Return how many distances a proof measures at most, unless it is told otherwise."""
    return int(engine().MAX_CHECKS)


def bound_resolution() -> float:
    """Return how far a clearance bound may lie below the smallest clearance that was found, m."""
    return float(engine().RESOLUTION)


def least_distance() -> float:
    """Return the distance that a step keeps between all pairs, m: twice what a proof takes off a distance."""
    return float(engine().APART)
