"""Motions with a timing that a drive can follow, among them those along paths."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from humanoid_rail._arrays import Array, frozen
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.collision.certifier import bound_resolution, certify
from humanoid_rail.kinematics.joint_limits import JointMotion
from humanoid_rail.kinematics.path_metric import STANDSTILL, path_length
from humanoid_rail.model.robot import Robot
from humanoid_rail.result import Peak, Timing
from humanoid_rail.scene.obstacles import Obstacle
from humanoid_rail.timing.bspline import fastest_in_between, peaks, samples, samples_between
from humanoid_rail.timing.rest_to_rest import follow
from humanoid_rail.timing.smooth_path import deviation, smooth_path
from humanoid_rail.timing.time_optimal import Limits

SPACINGS = (0.05, 0.025, 0.0125, 0.006, 0.003)
"""The control points of the path's spline are this far apart in turn, until the certificate is as good as wanted;
lengths in s, joint coordinates in units of their speed limits."""
DEVIATION = 0.01
"""The smooth path is no farther than this from the planned one, s, joint coordinates in units of their speed limits."""
CUT = 0.005
"""The motion is no farther than this from the smooth path, s, and nearer the more closely the path is followed."""


class TimedMotion(NamedTuple):
    """A motion at its samples, and what is proven of it.

    They are evenly spaced in each segment, but for those where a target is passed.
    """

    t: Array
    """(N,), s."""
    q: Array
    """(N, n), m and rad."""
    velocity: Array
    acceleration: Array
    ends: list[int]
    """The samples at which its segments end."""
    certificate: Certificate
    certification_time: float
    """s."""

    @property
    def duration(self) -> float:
        """S."""
        return float(self.t[-1])

    @property
    def bound(self) -> float:
        """The certificate's bound, m: infinite with nothing to touch, minus infinity where nothing is known."""
        bound = self.certificate.kept_bound
        return bound if bound is not None else np.inf if self.certificate.certified else -np.inf

    @property
    def intervals(self) -> Array:
        """Times between samples (N - 1, 1), s."""
        return np.diff(self.t)[:, None]

    @property
    def joint_motion(self) -> JointMotion:
        """The motion with the velocity that is largest from each sample to before the next."""
        fastest = fastest_in_between(self.velocity, self.acceleration, self.intervals)
        return JointMotion(self.t, self.q, fastest, self.acceleration)

    def timing(self, robot: Robot, limits: Limits) -> Timing:
        """Return velocities and accelerations with the peaks of each joint beside limits."""
        found = peaks(self.velocity, self.acceleration, self.intervals)
        columns = (part for pair in zip(found, limits, strict=True) for part in pair)
        rows = zip(robot.joint_names, zip(*columns, strict=True), strict=True)
        every = tuple(Peak(name, *(float(x) for x in row)) for name, row in rows)
        return Timing(frozen(self.velocity), frozen(self.acceleration), every)


def certified_motion(
    robot: Robot,
    obstacles: tuple[Obstacle, ...],
    control: Array,
    dt: float,
    ends: list[int],
    between: Sequence[float] = (),
) -> TimedMotion:
    """Return the motion of control points (N + 2, n), m and rad, that are dt apart in s, certified.

    Args:
        robot: The robot.
        obstacles: What its links must not touch, beside each other.
        control: Those of a cubic spline.
        dt: Time between them, s.
        ends: The samples at which the motion's segments end.
        between: Where there are further samples between these, as numbers of samples, in their order.
    """
    q, velocity, acceleration = samples(control, dt)
    t = np.arange(len(q), dtype=float) * dt
    if len(between) > 0:
        places = np.asarray(between, float)
        more, at = samples_between(control, dt, places), np.ceil(places).astype(int)
        t = np.insert(t, at, places * dt)
        q, velocity, acceleration = (
            np.insert(of_all, at, of_more, axis=0)
            for of_all, of_more in zip((q, velocity, acceleration), more, strict=True)
        )
        ends = [end + int((places < end).sum()) for end in ends]
    began = time.perf_counter()
    certificate = certify(robot, obstacles, t, q, velocity)
    return TimedMotion(t, q, velocity, acceleration, ends, certificate, time.perf_counter() - began)


def parts_of(motion: TimedMotion, at: Sequence[int]) -> list[TimedMotion]:
    """Return the parts of a motion before, between and after samples, each from t = 0 on, with its certificate."""
    return [
        motion._replace(
            t=motion.t[a : b + 1] - motion.t[a],
            q=motion.q[a : b + 1],
            velocity=motion.velocity[a : b + 1],
            acceleration=motion.acceleration[a : b + 1],
            ends=[b - a],
        )
        for a, b in pairwise([0, *at, len(motion.t) - 1])
    ]


def joined_motion(motions: Sequence[TimedMotion], proof: Callable[[Array, Array, Array], Certificate]) -> TimedMotion:
    """Return motions that follow each other as one; each begins where the one before ends, and as fast.

    Args:
        motions: The motions, among obstacles at rest: each is certified as if it began at t = 0.
        proof: Certifies the whole, from times (N,), configurations (N, n) and velocities (N, n).
    """
    if len(motions) == 1:
        return motions[0]
    begins = np.concatenate([[0.0], np.cumsum([motion.duration for motion in motions])])
    t = np.concatenate([motion.t[k > 0 :] + begins[k] for k, motion in enumerate(motions)])
    q, velocity, acceleration = (
        np.vstack([getattr(motion, name)[k > 0 :] for k, motion in enumerate(motions)])
        for name in ("q", "velocity", "acceleration")
    )
    ends = np.cumsum([len(motion.t) - 1 for motion in motions]).tolist()
    began = time.perf_counter()
    certificate = proof(t, q, velocity)
    return TimedMotion(t, q, velocity, acceleration, ends, certificate, time.perf_counter() - began)


def wanted_bound(certificate: Certificate | None, asked: float | None) -> float:
    """Return the bound that the certificate of a timed motion has to come up to, m: its path's, but no more than asked.

    Args:
        certificate: That of the path.
        asked: The distance that the path was to keep, m; None if it was to keep none.
    """
    if certificate is None or not certificate.certified:
        return -np.inf
    bound = certificate.kept_bound
    if bound is None:  # nothing is to keep the safety distance, but nothing may touch either
        return 0.0
    return min(bound, np.inf if asked is None else asked) - bound_resolution()


def along_path(
    robot: Robot,
    obstacles: tuple[Obstacle, ...],
    segments: Sequence[Array],
    limits: Limits,
    dt: float,
    dwell: float,
    wanted: float,
    fits: Callable[[TimedMotion], bool] = lambda _: True,
) -> TimedMotion:
    """Return the motion that follows segments no more closely than it has to for its bound to be as wanted.

    If that cannot be had, it is the motion with the largest bound, of those that fit if any do.

    Args:
        robot: The robot.
        obstacles: What its links must not touch, beside each other.
        segments: Paths (K, n) from one rest to the next, m and rad.
        limits: What joints can do.
        dt: Time between samples, s.
        dwell: How long to rest after each segment but the last, s.
        wanted: The bound that is wanted, m.
        fits: What else a motion has to be.
    """
    if np.isfinite(limits.jerk).any():
        # Where a limit of jerk does not bind it should cost nothing.
        free = along_path(robot, obstacles, segments, limits.without_jerk(), dt, dwell, wanted, fits)
        if (np.array([peak.jerk for peak in free.timing(robot, limits).peaks]) <= limits.jerk).all():
            return free
    best: tuple[bool, float] | None = None
    for control, ends in followings(robot, segments, limits, dt, dwell):
        motion = certified_motion(robot, obstacles, control, dt, ends)
        how_good = fits(motion), motion.bound
        if best is None or how_good > best:
            best, chosen = how_good, motion
        if how_good >= (True, wanted):
            break
    assert best is not None  # the last spacing is always tried
    return chosen


def followings(
    robot: Robot, segments: Sequence[Array], limits: Limits, dt: float, dwell: float
) -> Iterator[tuple[Array, list[int]]]:
    """Yield control points (N + 2, n) of motions that follow segments more and more closely, and where these end.

    See :func:`along_path` for the arguments.
    """
    for spacing in SPACINGS:
        paths = [
            smooth_path(robot, path, spacing) if path_length(robot, path) > STANDSTILL else None for path in segments
        ]
        pairs = zip(segments, paths, strict=True)
        strays = (deviation(robot, path, smooth) for path, smooth in pairs if smooth is not None)
        if max(strays, default=0.0) <= DEVIATION or spacing == SPACINGS[-1]:
            yield follow(robot, segments, paths, limits, dt, dwell, CUT * spacing / SPACINGS[0])
