"""The closest bodies at each moment of a motion: of links and obstacles, and of two links."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array
from humanoid_rail.scene.obstacles import name_of
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.scene import Scene
from humanoid_rail.collision.swept_distance import Nearest, Pair, Snapshot, Sweep
from humanoid_rail.trajectory import Trajectory

AROUND = 1.0 / 30.0
"""How long before and after the closest of the given moments the samples are looked at too, s."""
TIE = 1e-5
"""The closest pair remains so until another is closer by this, m: some links are always equally far from each other."""


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

    obstacles: tuple[Closest, ...]
    """Of a link and an obstacle; empty without obstacles."""
    links: tuple[Closest, ...]
    """Of two links; empty without pairs to check."""


def closest_pairs(robot: Robot, scene: Scene, trajectory: Trajectory, times: ArrayLike) -> ClosestPairs:
    """Return the closest pairs at some moments of a motion.

    Args:
        robot: The robot.
        scene: The scene the motion was planned in; obstacles that move start at t = 0.
        trajectory: The motion.
        times: When (K,), in order, s.
    """
    sweep = Sweep(robot, scene.obstacles)
    moments = [sweep.take(float(t), trajectory.configuration(float(t))) for t in np.asarray(times, float)]
    ways = [sweep.ways(a.q, b.q) for a, b in pairwise(moments)]
    links = np.array([own.travel for own, _ in ways]).reshape(len(ways), len(robot.link_names))
    between = np.array([relative.travel for _, relative in ways]).reshape(len(ways), len(sweep.link_pairs))
    speeds = np.array([sweep.speed(pair) for pair in sweep.obstacle_pairs])
    around = links[:, [pair.link for pair in sweep.obstacle_pairs]] + np.outer(
        np.diff([at.t for at in moments]), speeds
    )

    def closest(pairs: Sequence[Pair], ways: Array) -> tuple[Closest, ...]:
        return tuple(_named(robot, scene, *found) for found in _follow(sweep, pairs, moments, ways))

    return ClosestPairs(
        obstacles=closest(sweep.obstacle_pairs, around) if sweep.obstacle_pairs else (),
        links=closest(sweep.link_pairs, between) if sweep.link_pairs else (),
    )


def closest_of_all(robot: Robot, scene: Scene, trajectory: Trajectory, pairs: ClosestPairs) -> tuple[Closest, ...]:
    """Return the closest link and obstacle and the closest two links of a whole motion, as far as there are any.

    Args:
        robot: The robot.
        scene: The scene the motion was planned in.
        trajectory: The motion.
        pairs: The closest pairs at moments all along it. Around the closest ones the samples are looked at too, and
            the moments at which the trajectory says that it is closest to obstacles or in contact.
    """
    found = [_least(kind) for kind in pairs if kind]
    times = [trajectory.t[abs(trajectory.t - closest.t) <= AROUND] for closest in found]
    if trajectory.clearance.size:
        times.append(trajectory.t[[trajectory.clearance.min(axis=1).argmin()]])
    if trajectory.certificate.contact is not None:
        times.append(np.array([trajectory.certificate.contact.t]))
    if not times:
        return ()
    finer = closest_pairs(robot, scene, trajectory, np.unique(np.concatenate(times)))
    return tuple(_least([*rough, *fine]) for rough, fine in zip(pairs, finer, strict=True) if rough)


def _least(some: Iterable[Closest]) -> Closest:
    return min(some, key=lambda closest: round(closest.distance, 6))


def _named(robot: Robot, scene: Scene, t: float, pair: Pair, nearest: Nearest) -> Closest:
    other = robot.link_names[pair.other] if pair.piece is None else name_of(scene.obstacles, pair.other)
    points = np.array([nearest.point, nearest.point + nearest.distance * nearest.normal])
    return Closest(t, robot.link_names[pair.link], other, nearest.distance, points)


def _follow(
    sweep: Sweep, pairs: Sequence[Pair], moments: Sequence[Snapshot], ways: Array
) -> Iterator[tuple[float, Pair, Nearest]]:
    """Yield the closest of some pairs at each moment; of those as close, the one before.

    A pair is measured only when it could be the closest: its distance has shrunk by no more than how far the two have
    come since it was measured last.

    Args:
        sweep: What measures.
        pairs: The pairs (P,).
        moments: The moments (K,).
        ways: How far the two of each pair get relative to each other from each moment to the next (K - 1, P), m.
    """
    bound = np.full(len(pairs), -np.inf)
    before = -1
    for at, way in zip(moments, np.vstack([np.zeros(len(pairs)), ways]), strict=True):
        bound -= way
        measured: dict[int, Nearest] = {}
        # The one with the least bound is the closest once its bound is what was measured.
        while (i := int(bound.argmin())) not in measured:
            measured[i] = sweep.measure(pairs[i], at)
            bound[i] = measured[i].distance - (TIE if i == before else 0.0)
        before = i
        yield at.t, pairs[i], measured[i]
