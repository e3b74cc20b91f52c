"""Gives a planned path the fastest timing that a drive can follow: at rest at both ends, within all limits.

1. The path is rounded to one that turns continuously (`smooth_path.py`).
2. It is followed as fast as the limits allow (`speed.py`).
3. The motion becomes a cubic spline in time, in which the limits hold at all times (`spline.py`).
4. The spline is certified afresh. Where it comes nearer to something than the plan does, the path is followed more
   closely.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from importlib import import_module
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline

from humanoid_rail.arrays import Array, frozen
from humanoid_rail.certificate import Certificate
from humanoid_rail.certification import RESOLUTION
from humanoid_rail.engines import Engine, get_engine
from humanoid_rail.errors import InvalidInput, check_kind, checked_number
from humanoid_rail.limits import Motion, limit_violations
from humanoid_rail.paths import path_length, path_quality, speed_units
from humanoid_rail.planner import MAX_SAMPLES, SAFE, judged, not_kept
from humanoid_rail.robot import Robot, check_joint_names
from humanoid_rail.scene import Scene
from humanoid_rail.smooth_path import deviation, smooth_path
from humanoid_rail.speed import Limits, Progress, fastest
from humanoid_rail.spline import certify_spline, peaks, samples
from humanoid_rail.timing import Peak, Timing
from humanoid_rail.trajectory import Status, Trajectory

SPACINGS = (0.05, 0.025, 0.0125, 0.006, 0.003)
"""How closely the path is followed, in turns until the certificate is as good as the plan's: the lengths between the
control points of its spline, joint coordinates in units of their speed limits, s."""
DEVIATION, CUT = 0.01, 0.005
"""The smooth path is no farther from the planned one than the first; the motion, which cuts its corners the more the
larger dt is, no farther from that than the second; s, joint coordinates in units of their speed limits."""
RETIMED = "; retimed"
"""Where in the reason begins what retiming adds."""
SLOWDOWNS, SLOWDOWN = 20, 1e-4
"""How often a motion is slowed down a little to be within limits exactly, and how much more each time."""
STANDSTILL = 1e-9
"""A shorter path is none, s."""


class _Motion(NamedTuple):
    """A motion at its samples, and what is proven of it."""

    t: Array
    q: Array
    velocity: Array
    acceleration: Array
    ends: list[int]
    """The samples at which its legs end."""
    certificate: Certificate
    certification_time: float


def retime(
    trajectory: Trajectory,
    robot: Robot,
    scene: Scene,
    *,
    dt: float | None = None,
    velocity_limit: ArrayLike | None = None,
    acceleration_limit: ArrayLike | None = None,
    jerk_limit: ArrayLike | None = None,
    dwell: float = 0.0,
    engine: str = "native",
) -> Trajectory:
    """Return a trajectory along the same path, as fast as velocities and accelerations may be, at rest at both ends.

    The motion is a cubic spline with continuous accelerations. It rests at each of the scene's targets in turn.

    Args:
        trajectory: What :func:`plan` or :func:`read_trajectory` returned.
        robot: The robot it was planned for.
        scene: The scene it was planned in, whose obstacles the certificate is about; those that move start at t = 0.
        dt: Time between samples, s; that of the trajectory if not given. All intervals are of this length. The motion
            takes two to three of them longer than the fastest, because accelerations set in over one. Where they are
            so long, 0.05 s and more, that it would leave the path in between, it is slowed down.
        velocity_limit: One number for all joints, or one for each (n,), m/s and rad/s; the robot's if not given.
        acceleration_limit: The same, m/s^2 and rad/s^2.
        jerk_limit: The same, m/s^3 and rad/s^3; none if not given.
        dwell: How long to rest at each target before the next, s.
        engine: What certifies it; see :func:`plan`.

    Returns:
        The trajectory with its `timing`, with the status it had, and with a certificate, clearances and violations of
        its own. A certified plan by `auto` or `qp` that cannot be certified any more is `uncertified`, as can happen
        where obstacles move.

    Raises:
        InvalidInput: If an argument is not valid, the trajectory is for another robot, or a joint that moves has no
            finite limit of acceleration.
    """
    check_kind("trajectory", trajectory, Trajectory)
    check_kind("robot", robot, Robot)
    check_kind("scene", scene, Scene)
    check_joint_names(robot, trajectory.joint_names)
    import_module("toppra.algorithm")  # seconds that are spent once are no time for planning
    started = time.perf_counter()
    step = checked_number("dt", trajectory.settings["dt"] if dt is None else dt, above=0.0)
    rest = checked_number("dwell", dwell, least=0.0)
    computing = get_engine(engine)
    limits = Limits(
        _limit("velocity_limit", velocity_limit, robot, robot.velocity_limit),
        _limit("acceleration_limit", acceleration_limit, robot, robot.acceleration_limit),
        _limit("jerk_limit", jerk_limit, robot, np.full(robot.n, np.inf)),
    )
    legs = _legs(trajectory)
    _check_moving(robot, legs, limits)

    motion = _certified_motion(robot, scene, legs, limits, step, rest, _wanted(trajectory), computing)
    t, certificate = motion.t, motion.certificate
    status, reason = (
        trajectory.status,
        f"{trajectory.reason.split(RETIMED)[0]}{RETIMED}, the motion takes {t[-1]:.4g} s",
    )
    if trajectory.method in SAFE and status in (Status.REACHED, Status.UNCERTIFIED):
        status, reason = judged(certificate, reason)
    if trajectory.method in SAFE:
        reason += not_kept(certificate, float(np.max(trajectory.settings["safety_distance"])))
    horizon = np.inf if trajectory.settings["far_clearances"] else trajectory.settings["epsilon"]
    course = computing.kinematics(robot, scene.obstacles).along(motion.q, float(np.max(horizon)), t)
    return replace(
        trajectory,
        t=frozen(t),
        q=frozen(motion.q),
        hands=frozen(course.hands),
        clearance=frozen(course.clearance),
        manipulability=frozen(course.manipulability),
        status=status,
        reason=reason,
        violations=limit_violations(robot, Motion(t, motion.q, motion.velocity, motion.acceleration)),
        certificate=certificate,
        timing=Timing(frozen(motion.velocity), frozen(motion.acceleration), _peaks(robot, motion, step, limits)),
        arrivals=tuple(float(t[end]) for end in motion.ends[: len(trajectory.arrivals)]),
        planning_time=trajectory.planning_time + time.perf_counter() - started,
        certification_time=motion.certification_time,
        path=path_quality(robot, *(motion.q[a : b + 1] for a, b in pairwise([0, *motion.ends]))),
        settings={**trajectory.settings, "dt": step, "dwell": rest},
    )


def _times(count: int, dt: float) -> Array:
    return np.arange(count, dtype=float) * dt


def _limit(name: str, given: ArrayLike | None, robot: Robot, default: Array) -> Array:
    """Return a limit (n,)."""
    if given is None:
        return default
    try:
        values = np.asarray(given, float)
    except (TypeError, ValueError):
        values = np.array(np.nan)
    if values.shape not in ((), (robot.n,)) or not (values > 0).all():
        raise InvalidInput(name, given, f"a number greater than 0, or one for each of the {robot.n} joints")
    return np.broadcast_to(values, (robot.n,)).copy()


def _legs(trajectory: Trajectory) -> list[Array]:
    """Return the paths from one rest to the next."""
    given = [0.0, *trajectory.arrivals, trajectory.duration]
    if any(later < sooner for sooner, later in pairwise(given)):
        raise InvalidInput("trajectory.arrivals", trajectory.arrivals, "times of the motion, in their order")
    arrivals = [int(np.argmin(abs(trajectory.t - arrival))) for arrival in trajectory.arrivals]
    ends = [0, *arrivals] + [len(trajectory.t) - 1] * (not arrivals or arrivals[-1] < len(trajectory.t) - 1)
    return [trajectory.q[a : b + 1] for a, b in pairwise(ends)]


def _check_moving(robot: Robot, legs: Sequence[Array], limits: Limits) -> None:
    """Check that what moves has limits to be timed by."""
    moves = np.any([np.ptp(leg, axis=0) > 0 for leg in legs], axis=0)
    for name, limit in (("velocity_limit", limits.velocity), ("acceleration_limit", limits.acceleration)):
        for j in np.flatnonzero(moves):
            if not limit[j] > 0 or (name == "acceleration_limit" and not np.isfinite(limit[j])):
                valid = "finite and greater than 0 for a joint that moves: give the argument, or the limit in the URDF"
                raise InvalidInput(f"{name} ({robot.joint_names[j]})", float(limit[j]), valid)


def _wanted(trajectory: Trajectory) -> float:
    """Return the bound that a certificate has to come up to, m: the plan's, but no more than it was asked to keep."""
    bound, asked = trajectory.clearance_bound, trajectory.settings.get("safety_distance")
    if bound is None or not trajectory.certified:
        return -np.inf
    return min(bound, np.inf if asked is None else float(np.max(asked))) - RESOLUTION


def _certified_motion(
    robot: Robot,
    scene: Scene,
    legs: Sequence[Array],
    limits: Limits,
    dt: float,
    dwell: float,
    wanted: float,
    computing: Engine,
) -> _Motion:
    """Return the motion that follows the legs no more closely than it has to for its bound to be what is wanted, m.

    If that cannot be had, the one with the largest bound.
    """
    best, largest = None, -np.inf
    for spacing in SPACINGS:
        paths = [smooth_path(robot, leg, spacing) if path_length(robot, leg) > STANDSTILL else None for leg in legs]
        strays = (deviation(robot, leg, path) for leg, path in zip(legs, paths, strict=True) if path is not None)
        if max(strays, default=0.0) > DEVIATION and spacing > SPACINGS[-1]:
            continue
        control, ends = _follow(robot, legs, paths, limits, dt, dwell)
        q, velocity, acceleration = samples(control, dt)
        t = _times(len(q), dt)
        began = time.perf_counter()
        certificate = certify_spline(robot, scene.obstacles, t, q, velocity, computing.certify)
        motion = _Motion(t, q, velocity, acceleration, ends, certificate, time.perf_counter() - began)
        bound = np.inf if certificate.clearance_bound is None else certificate.clearance_bound
        if best is None or bound > largest:
            best, largest = motion, bound
        if bound >= wanted:
            break
    assert best is not None  # the last spacing is always tried
    return best


def _follow(
    robot: Robot, legs: Sequence[Array], paths: Sequence[BSpline | None], limits: Limits, dt: float, dwell: float
) -> tuple[Array, list[int]]:
    """Return the control points (N + 2, n) of the whole motion, and at which samples its legs end."""
    # A sample depends on three control points: where these are equal it is at rest.
    parts, ends, passed = [np.tile(legs[0][0], (3, 1))], list[int](), 0
    for number, (leg, path) in enumerate(zip(legs, paths, strict=True)):
        if path is not None:
            parts.append(_control_points(path, limits, speed_units(robot), dt))
            passed += len(parts[-1])
        ends.append(passed)
        if dwell and number < len(legs) - 1:
            waits = _count(dwell, dt)
            parts.append(np.repeat(leg[-1:], waits, axis=0))
            passed += waits
    return np.vstack(parts), ends


def _control_points(path: BSpline, limits: Limits, units: Array, dt: float) -> Array:
    """Return the control points of a leg after those at which it begins, the last three where it ends.

    With a limit of jerk the shorter of two: by ruckig, and by toppra, slowed down as a whole.
    """
    loose = limits._replace(jerk=np.full_like(limits.jerk, np.inf))
    found = [_within_limits(path, fastest(path, loose), limits, units, dt)]
    if np.isfinite(limits.jerk).any():
        # Where ruckig has no answer there is still the other.
        with suppress(RuntimeError):
            found.append(_within_limits(path, fastest(path, limits), limits, units, dt))
    return min(found, key=len)


def _within_limits(path: BSpline, progress: Progress, limits: Limits, units: Array, dt: float) -> Array:
    """Return control points at which the path is followed, slowed down as far as the limits ask for."""
    slower = 1.0
    for attempt in range(SLOWDOWNS):
        control = _sampled(path, progress, slower, dt)
        excess = _excess(np.vstack([np.tile(path.c[0], (3, 1)), control]), limits, units, dt)
        if excess <= 1.0:
            return control
        # Other moments are sampled then, so that a little more may be needed.
        slower *= excess * (1.0 + attempt * SLOWDOWN)
    raise RuntimeError(f"a motion slowed down {SLOWDOWNS} times is still beyond its limits")


def _sampled(path: BSpline, progress: Progress, slower: float, dt: float) -> Array:
    count = _count(progress.duration * slower, dt)
    on_the_way = path(progress.position(_times(count, dt)[1:] / slower))
    return np.vstack([on_the_way, np.tile(path.c[-1], (3, 1))])


def _count(duration: float, dt: float) -> int:
    """Return how many intervals a duration takes."""
    if duration / dt > MAX_SAMPLES:
        valid = (
            f"at least {duration / MAX_SAMPLES:g} s for a motion of {duration:g} s, for at most {MAX_SAMPLES} samples"
        )
        raise InvalidInput("dt", dt, valid)
    return int(np.ceil(duration / dt - 1e-9))


def _excess(control: Array, limits: Limits, units: Array, dt: float) -> float:
    """Return the factor by which a spline has to be slowed down."""
    # The spline is as far from a control point as a sixth of the second difference there.
    cut = np.linalg.norm(np.diff(control, 2, axis=0) / units, axis=1).max(initial=0.0) / 6.0
    excess = float(np.sqrt(cut / CUT))
    for order, limit in enumerate(limits, start=1):
        largest = abs(np.diff(control, order, axis=0)).max(axis=0, initial=0.0) / dt**order
        # What does not move may have a limit of 0.
        share = np.divide(largest, limit, out=np.zeros_like(largest), where=largest > 0)
        excess = max(excess, float(share.max() ** (1.0 / order)))
    return excess


def _peaks(robot: Robot, motion: _Motion, dt: float, limits: Limits) -> tuple[Peak, ...]:
    columns = zip(
        *(part for pair in zip(peaks(motion.velocity, motion.acceleration, dt), limits, strict=True) for part in pair),
        strict=True,
    )
    return tuple(Peak(name, *(float(x) for x in row)) for name, row in zip(robot.joint_names, columns, strict=True))
