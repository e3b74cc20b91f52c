"""Gives a planned path the fastest timing that a drive can follow: at rest at both ends, within all limits.

1. The path is rounded to one that turns continuously (`smooth_path.py`).
2. It is followed as fast as the limits allow (`speed.py`).
3. The motion becomes a cubic spline in time (`rest_to_rest.py`), in which the limits hold at all times (`spline.py`).
4. The spline is certified afresh. Where it comes nearer to something than the plan does, the path is followed more
   closely.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from importlib import import_module
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicHermiteSpline

from humanoid_rail._arrays import Array, frozen
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.collision.certifier import RESOLUTION
from humanoid_rail.planning.engines import Engine, get_engine
from humanoid_rail.errors import InvalidInput, check_kind, checked_number
from humanoid_rail.planning.segments import arrival
from humanoid_rail.kinematics.joint_limits import Motion, limit_violations
from humanoid_rail.search.smoothing import STANDSTILL, path_length, path_quality
from humanoid_rail.planning.planner import SAFE, judged, not_kept
from humanoid_rail.retiming.rest_to_rest import follow
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.scene import Scene
from humanoid_rail.retiming.smooth_path import deviation, smooth_path
from humanoid_rail.retiming.time_optimal import Limits
from humanoid_rail.retiming.bspline import certify_spline, fastest_in_between, peaks, samples
from humanoid_rail.timing import Peak, Timing
from humanoid_rail.trajectory import MAX_SAMPLES, Status, Trajectory
from humanoid_rail.planning.verification import check_robot

SPACINGS = (0.05, 0.025, 0.0125, 0.006, 0.003)
"""How closely the path is followed, in turns until the certificate is as good as the plan's: the lengths between the
control points of its spline, joint coordinates in units of their speed limits, s."""
DEVIATION, CUT = 0.01, 0.005
"""The smooth path is no farther from the planned one than the first; the motion, which cuts its corners the more the
larger dt is, no farther from that than the second, and less the more closely the path is followed; s, joint coordinates
in units of their speed limits."""
FINE = 5e-3
"""Time between the points of a path that are taken from a motion that was retimed already, s."""
LONGEST_STEP = 10.0
"""The longest time between samples, s."""
LEAST_SPEED = 1e-3
"""The smallest share of the limits of velocity that may be asked for."""
SMALLEST_LIMIT, LARGEST_LIMIT = 1e-6, 1e9
"""Of velocity, acceleration or jerk, if they are given; SI units."""


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
    speed: float = 1.0,
    dwell: float = 0.0,
    max_time: float | None = None,
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
        speed: Share of the limits of velocity to use; of those of acceleration its square is used, as if time went
            slower, from 0.001 to 1. A limit of jerk stays.
        dwell: How long to rest at each target before the next, s.
        max_time: Longest motion, s; one that takes longer is `time_limit`, though it is there. None if not given.
        engine: What certifies it; see :func:`plan`.

    Returns:
        The trajectory with its `timing`, with a certificate, clearances and violations of its own, and with the status
        it had. But what reaches its targets by `auto` or `qp` and cannot be certified is `uncertified`, as can happen
        where obstacles move. Of what does not get there the reason is the plan's, as are the times in it.

    Raises:
        InvalidInput: If an argument is not valid, the trajectory is for another robot, or a joint that moves has no
            finite limit of acceleration.
    """
    check_kind("scene", scene, Scene)
    check_robot(robot, trajectory)
    import_module("toppra.algorithm")  # seconds that are spent once are no time for planning
    started = time.perf_counter()
    step = checked_number("dt", trajectory.settings["dt"] if dt is None else dt, above=0.0, most=LONGEST_STEP)
    rest = checked_number("dwell", dwell, least=0.0, most=step * MAX_SAMPLES)
    longest = np.inf if max_time is None else checked_number("max_time", max_time, above=0.0)
    computing = get_engine(engine)
    share = checked_number("speed", speed, least=LEAST_SPEED, most=1.0)
    limits = Limits(
        share * _limit("velocity_limit", velocity_limit, robot, robot.velocity_limit),
        share**2 * _limit("acceleration_limit", acceleration_limit, robot, robot.acceleration_limit),
        _limit("jerk_limit", jerk_limit, robot, np.full(robot.n, np.inf)),
    )
    legs = _legs(trajectory)
    _check_moving(robot, legs, limits)

    motion = _certified_motion(robot, scene, legs, limits, step, rest, _wanted(trajectory), computing)
    t, certificate = motion.t, motion.certificate
    arrivals = tuple(float(t[end]) for end in motion.ends[: len(trajectory.arrivals)])
    status, reason = _judged(trajectory, len(scene.steps), arrivals, float(t[-1]), longest, certificate)
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
        violations=limit_violations(
            robot,
            Motion(t, motion.q, fastest_in_between(motion.velocity, motion.acceleration, step), motion.acceleration),
        ),
        certificate=certificate,
        timing=Timing(frozen(motion.velocity), frozen(motion.acceleration), _peaks(robot, motion, step, limits)),
        arrivals=arrivals,
        planning_time=trajectory.planning_time + time.perf_counter() - started,
        certification_time=motion.certification_time,
        path=path_quality(robot, *(motion.q[a : b + 1] for a, b in pairwise([0, *motion.ends]))),
        settings={**trajectory.settings, "dt": step, "speed": share, "dwell": rest},
    )


def _judged(
    trajectory: Trajectory,
    steps: int,
    arrivals: Sequence[float],
    end: float,
    longest: float,
    certificate: Certificate,
) -> tuple[Status, str]:
    """Return the status and the reason of a motion that ends at a time in s and may not take longer than another."""
    status, reason = trajectory.status, trajectory.reason
    if len(arrivals) == steps:
        status, reason = Status.REACHED, arrival(arrivals)
        if trajectory.method in SAFE:
            status, reason = judged(certificate, reason)
        if status is Status.REACHED and end > longest:
            status, reason = Status.TIME_LIMIT, f"{reason}, but no motion may take longer than {longest:g} s"
    if trajectory.method in SAFE:
        note = not_kept(certificate, float(np.max(trajectory.settings["safety_distance"])))
        reason += note if note not in reason else ""
    return status, reason


def _limit(name: str, given: ArrayLike | None, robot: Robot, default: Array) -> Array:
    """Return a limit (n,)."""
    if given is None:
        return default
    try:
        values = np.asarray(given).astype(float, casting="same_kind")
    except (TypeError, ValueError):  # no numbers, or rows of different lengths
        values = np.array(np.nan)
    meaningful = ((values >= SMALLEST_LIMIT) & (values <= LARGEST_LIMIT)) | (values == np.inf)
    if isinstance(given, bool) or values.shape not in ((), (robot.n,)) or not meaningful.all():
        valid = f"from {SMALLEST_LIMIT:g} to {LARGEST_LIMIT:g} or infinite, one, or one for each of {robot.n} joints"
        raise InvalidInput(name, given, valid)
    return np.broadcast_to(values, (robot.n,)).copy()


def _legs(trajectory: Trajectory) -> list[Array]:
    """Return the paths from one rest to the next."""
    given = [0.0, *trajectory.arrivals, trajectory.duration]
    if any(later < sooner for sooner, later in pairwise(given)):
        raise InvalidInput("trajectory.arrivals", trajectory.arrivals, "times of the motion, in their order")
    t, q = trajectory.t, trajectory.q
    if trajectory.timing is not None and len(t) > 1:
        # It is no polyline.
        spline = CubicHermiteSpline(t, q, trajectory.timing.velocity)
        t = np.unique(np.concatenate([t, np.arange(0.0, t[-1], max(FINE, t[-1] / MAX_SAMPLES))]))
        q = spline(t)
        q[np.searchsorted(t, trajectory.t)] = trajectory.q  # to the last bit
    arrivals = [int(np.argmin(abs(t - arrival))) for arrival in trajectory.arrivals]
    ends = [0, *arrivals] + [len(t) - 1] * (not arrivals or arrivals[-1] < len(t) - 1)
    return [q[a : b + 1] for a, b in pairwise(ends)]


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
        control, ends = follow(robot, legs, paths, limits, dt, dwell, CUT * spacing / SPACINGS[0])
        q, velocity, acceleration = samples(control, dt)
        t = np.arange(len(q), dtype=float) * dt
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


def _peaks(robot: Robot, motion: _Motion, dt: float, limits: Limits) -> tuple[Peak, ...]:
    columns = zip(
        *(part for pair in zip(peaks(motion.velocity, motion.acceleration, dt), limits, strict=True) for part in pair),
        strict=True,
    )
    return tuple(Peak(name, *(float(x) for x in row)) for name, row in zip(robot.joint_names, columns, strict=True))
