"""The closest bodies at each moment of a motion: a link and an obstacle, and two links."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array
from humanoid_rail.collision import closest_pairs as collision
from humanoid_rail.holding.phases import Phase, in_phases, phases_of
from humanoid_rail.model.robot import Robot
from humanoid_rail.resampling import evaluate
from humanoid_rail.scene.obstacles import name_of
from humanoid_rail.scene.scene import Scene
from humanoid_rail.trajectory import Trajectory

REFINED = 1.0 / 30.0
"""The samples of a motion this long before and after the closest of the given moments are looked at too, s."""


class Closest(NamedTuple):
    """The two bodies of a kind that are closest to each other at a moment."""

    t: float
    """s."""
    link: str
    """Link of the robot."""
    other: str
    """An obstacle, such as ``obstacles[3] (sphere)``, or another link."""
    distance: float
    """m; negative in penetration."""
    points: Array
    """The nearest points (2, 3) on the link and on the other, in the base frame, m. In penetration each is the one
    deepest inside the other body."""


class ClosestPairs(NamedTuple):
    """The closest pairs at each of some moments."""

    obstacles: tuple[Closest, ...] = ()
    """A link and an obstacle at each moment; empty without obstacles."""
    links: tuple[Closest, ...] = ()
    """Two links at each moment; empty without pairs to check."""


def closest_pairs(robot: Robot, scene: Scene, trajectory: Trajectory, times: ArrayLike) -> ClosestPairs:
    """Return the closest pairs at some moments of a motion.

    Args:
        robot: The robot.
        scene: The scene the motion was planned in; obstacles that move start at t = 0.
        trajectory: The motion.
        times: The moments (K,), in order, s.

    Raises:
        EngineMissing: If there is no native engine.
    """
    t = np.asarray(times, float)
    parts = [
        _closest_in(phase, t[inside], evaluate(trajectory.motion, t[inside])[0])
        for phase, inside in in_phases(phases_of(robot, scene, trajectory.motion), t)
    ]
    obstacles = [pair for part in parts for pair in part.obstacles]
    links = [pair for part in parts for pair in part.links]
    # Of a kind that is not there in some phases nothing is said at all.
    return ClosestPairs(*(tuple(kind) if len(kind) == len(t) else () for kind in (obstacles, links)))


def _closest_in(phase: Phase, t: Array, q: Array) -> ClosestPairs:
    robot, among = phase.robot, phase.obstacles
    obstacles, links = collision.closest_pairs(robot, among, t, q)
    names = robot.link_names
    return ClosestPairs(
        obstacles=tuple(
            Closest(at, names[pair.link], name_of(among, pair.other), pair.distance, pair.points)
            for at, pair in zip(t.tolist(), obstacles, strict=bool(obstacles))
        ),
        links=tuple(
            Closest(at, names[pair.link], names[pair.other], pair.distance, pair.points)
            for at, pair in zip(t.tolist(), links, strict=bool(links))
        ),
    )


def closest_of_all(robot: Robot, scene: Scene, trajectory: Trajectory, pairs: ClosestPairs) -> tuple[Closest, ...]:
    """Return the closest link and obstacle and the closest two links of a whole motion, as far as there are any.

    Args:
        robot: The robot.
        scene: The scene the motion was planned in.
        trajectory: The motion.
        pairs: The closest pairs at moments all along it. The samples around the closest ones are looked at too, and
            the moments at which the trajectory says that it is closest to obstacles or in contact.

    Raises:
        EngineMissing: If there are such pairs but no native engine.
    """
    if not any(pairs):
        return ()
    found = [_closest(kind) for kind in pairs if kind]
    times = [trajectory.t[abs(trajectory.t - closest.t) <= REFINED] for closest in found]
    if trajectory.clearance.size:
        times.append(trajectory.t[[trajectory.clearance.min(axis=1).argmin()]])
    if trajectory.certificate is not None and trajectory.certificate.contact is not None:
        times.append(np.array([trajectory.certificate.contact.t]))
    finer = closest_pairs(robot, scene, trajectory, np.unique(np.concatenate(times)))
    return tuple(_closest([*rough, *fine]) for rough, fine in zip(pairs, finer, strict=True) if rough)


def _closest(some: Iterable[Closest]) -> Closest:
    """Return the closest of some pairs; of those as close up to rounding, the first."""
    return min(some, key=lambda closest: round(closest.distance, 6))


def trace_clearance(trajectory: Trajectory, pairs: ClosestPairs) -> Array | None:
    """Return the clearance that the colours of the hands' traces show, at each sample (N,), m.

    It is the one from obstacles; without obstacles the one between links; None without both.
    """
    if trajectory.clearance.size:
        nearest: Array = trajectory.clearance.min(axis=1)
        return nearest
    if not pairs.links:
        return None
    return np.interp(trajectory.t, [pair.t for pair in pairs.links], [pair.distance for pair in pairs.links])
