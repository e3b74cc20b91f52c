"""Motions along smooth paths, from rest to rest, as control points of a cubic spline in time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress

import numpy as np
from scipy.interpolate import BSpline

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput
from humanoid_rail.kinematics.path_metric import speed_units
from humanoid_rail.model.robot import Robot
from humanoid_rail.result import MAX_SAMPLES
from humanoid_rail.timing.jerk_limited import with_bounded_jerk
from humanoid_rail.timing.time_optimal import Limits, Progress, averaged, fastest_profile, rise_time

WINDOWS = (0.5, 1.0, 1.5, 2.0, 3.0)
"""Toppra's profile is averaged over these windows, in units of the time that joints take to reach its accelerations."""
SLOWDOWNS = 20
"""A motion is slowed down at most this often to be within limits exactly."""
SLOWDOWN = 1e-4
"""A motion is slowed down by this share more than it seems to need, and by more each time."""
ROUNDING = 1e-9
"""A duration that exceeds whole intervals by this share of one is taken for whole intervals."""


def follow(
    robot: Robot,
    segments: Sequence[Array],
    paths: Sequence[BSpline | None],
    limits: Limits,
    dt: float,
    dwell: float,
    cut: float,
) -> tuple[Array, list[int]]:
    """Return the control points (N + 2, n) of a motion along segments, and at which samples these end.

    Args:
        robot: The robot.
        segments: Paths (K, n) from one rest to the next, m and rad.
        paths: The same, smooth; None for one that goes nowhere.
        limits: What joints can do.
        dt: Time between control points, s.
        dwell: How long to rest after each segment but the last, s.
        cut: How far the motion may be from the smooth paths, s, joint coordinates in units of their speed limits.

    Raises:
        InvalidInput: If there would be too many samples.
    """
    # A sample depends on three control points: where these are equal it is at rest.
    parts, ends, passed = [np.tile(segments[0][0], (3, 1))], list[int](), 0
    for number, (segment, path) in enumerate(zip(segments, paths, strict=True)):
        if path is not None:
            parts.append(_control_points(path, limits, speed_units(robot), dt, cut))
            passed += len(parts[-1])
        ends.append(passed)
        if dwell and number < len(segments) - 1:
            waits = _count(dwell, dt)
            parts.append(np.repeat(segment[-1:], waits, axis=0))
            passed += waits
        if passed > MAX_SAMPLES:
            raise _too_many(dt)
    return np.vstack(parts), ends


def _profiles(path: BSpline, limits: Limits) -> Iterator[Progress]:
    """Yield profiles that follow a path fast.

    Without jerk limits there is one, the fastest within limits of velocity and acceleration. With them there are
    several, and none need be the fastest of all: ruckig's, whose jerk is bounded, and toppra's, averaged over a while
    so that accelerations do not jump. These may still exceed limits of jerk, until they are slowed down.
    """
    free = fastest_profile(path, limits._replace(jerk=np.full_like(limits.jerk, np.inf)))
    yield averaged(free, 0.0)
    if np.isfinite(limits.jerk).any():
        turning = fastest_profile(path, limits)
        with suppress(RuntimeError):  # where ruckig has no answer
            yield with_bounded_jerk(path, turning, limits)
        rise = rise_time(path, free, limits)
        for share in WINDOWS:
            yield averaged(free, share * rise)
            yield averaged(turning, share * rise)


def _control_points(path: BSpline, limits: Limits, units: Array, dt: float, cut: float) -> Array:
    """Return the control points of a segment after those at which it begins, the last three where it ends."""
    best = None
    for progress in _profiles(path, limits):
        most = MAX_SAMPLES if best is None else len(best) - 1
        found = _within_limits(path, progress, limits, units, dt, cut, most)
        best = best if found is None else found
    if best is None:
        raise _too_many(dt)
    return best


def _within_limits(
    path: BSpline, progress: Progress, limits: Limits, units: Array, dt: float, cut: float, most: int
) -> Array | None:
    """Return control points at which the path is followed, slowed down as far as limits and the cut ask for.

    None if there would be more than `most`, or if it is still beyond them after many attempts.
    """
    slower = 1.0
    for attempt in range(SLOWDOWNS):
        if progress.duration * slower / dt > most:
            return None
        control = _sampled(path, progress, slower, dt)
        if len(control) > most:
            return None
        excess = _excess(np.vstack([np.tile(path.c[0], (3, 1)), control]), limits, units, dt, cut)
        if excess <= 1.0:
            return control
        # Other moments are sampled then, so that a little more may be needed.
        slower *= excess * (1.0 + SLOWDOWN * (2**attempt - 1))
    return None


def _sampled(path: BSpline, progress: Progress, slower: float, dt: float) -> Array:
    on_the_way = path(progress.position(dt / slower * np.arange(1.0, _count(progress.duration * slower, dt))))
    return np.vstack([on_the_way, np.tile(path.c[-1], (3, 1))])


def _count(duration: float, dt: float) -> int:
    """Return how many intervals a duration takes."""
    return int(np.ceil(duration / dt - ROUNDING))


def _too_many(dt: float) -> InvalidInput:
    longest = f"{MAX_SAMPLES * dt:g} s"
    valid = (
        f"at most {longest}, for at most {MAX_SAMPLES} samples with dt = {dt:g} s: larger limits of velocity, "
        "acceleration and jerk, or a larger dt"
    )
    return InvalidInput("duration", f"more than {longest}", valid)


def _excess(control: Array, limits: Limits, units: Array, dt: float, cut: float) -> float:
    """Return the factor by which a spline has to be slowed down."""
    # The spline is as far from a control point as a sixth of the second difference there.
    away = np.linalg.norm(np.diff(control, 2, axis=0) / units, axis=1).max(initial=0.0) / 6.0
    excess = float(np.sqrt(away / cut))
    for order, limit in enumerate(limits, start=1):
        largest = abs(np.diff(control, order, axis=0)).max(axis=0, initial=0.0) / dt**order
        # What does not move may have a limit of 0.
        share = np.divide(largest, limit, out=np.zeros_like(largest), where=largest > 0)
        excess = max(excess, float(share.max() ** (1.0 / order)))
    return excess
