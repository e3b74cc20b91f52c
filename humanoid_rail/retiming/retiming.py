"""Gives a planned path the fastest timing that a drive can follow: at rest at both ends, within all limits.

1. The path is rounded to one that turns continuously (`smooth_path.py`).
2. It is followed as fast as the limits allow (`time_optimal.py`).
3. The motion becomes a cubic spline in time (`rest_to_rest.py`), in which the limits hold at all times (`bspline.py`).
4. The spline is certified afresh. Where it comes nearer to something than the plan does, the path is followed more
   closely.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from importlib import import_module
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array, frozen
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.errors import InvalidInput, check_kind, checked_number, told_apart
from humanoid_rail.holding.phases import samples_of
from humanoid_rail.kinematics.joint_limits import limit_violations
from humanoid_rail.kinematics.path_metric import path_quality
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.kept import recorded
from humanoid_rail.planning.planner import RESTS, judged
from humanoid_rail.planning.segments import arrival
from humanoid_rail.planning.verification import check_robot
from humanoid_rail.resampling import SAME_TIME, evaluate
from humanoid_rail.result import MAX_SAMPLES, Motion, Retiming, Status, Verdict
from humanoid_rail.retiming.passing import Retimed, along_segments
from humanoid_rail.retiming.piecewise import along_pieces, rests_of
from humanoid_rail.scene.scene import Scene
from humanoid_rail.timing.lower_bound import least_duration_of
from humanoid_rail.timing.time_optimal import Limits
from humanoid_rail.timing.timed_motion import wanted_bound
from humanoid_rail.trajectory import Trajectory

FINE = 5e-3
"""The points of a path that is taken from a retimed motion are this far apart in time, s."""
LONGEST_STEP = 10.0
"""The time between samples is at most this, s."""
LEAST_SPEED = 1e-3
"""At least this share of the velocity limits has to be asked for."""
SMALLEST_LIMIT = 1e-6
"""A limit of velocity, acceleration or jerk that is given has to be at least this; SI units."""
LARGEST_LIMIT = 1e9
"""A limit of velocity, acceleration or jerk that is given has to be at most this, or infinite; SI units."""


def retime(
    trajectory: Trajectory,
    robot: Robot | None = None,
    scene: Scene | None = None,
    *,
    dt: float | None = None,
    velocity_limit: ArrayLike | None = None,
    acceleration_limit: ArrayLike | None = None,
    jerk_limit: ArrayLike | None = None,
    speed: float = 1.0,
    dwell: float = 0.0,
    max_time: float | None = None,
) -> Trajectory:
    """Return a trajectory along the same path, as fast as the limits allow, at rest at both ends and at each target.

    Targets of steps with `stop` false are passed, within the method's tolerance of them; `reason` says why if not.

    The motion is a cubic spline with continuous accelerations, and is certified afresh. It is `uncertified` if it
    reaches its targets by `auto` or `qp` and cannot be certified, as can happen among moving obstacles; if it does not
    reach them, the reason and the times in it are the plan's.

    Args:
        trajectory: What :func:`plan` or :func:`read_trajectory` returned.
        robot: The robot it was planned for; the one it knows if not given.
        scene: The scene it was planned in, the one it knows if not given; obstacles that move start at t = 0.
        dt: Time between samples, s; that of the trajectory if not given. The motion takes two to three of them longer
            than the fastest, because accelerations set in over one; from 0.05 s it is slowed down to stay on its path.
        velocity_limit: One number for all joints, or one for each (n,), m/s and rad/s; the robot's if not given.
        acceleration_limit: The same, m/s^2 and rad/s^2.
        jerk_limit: The same, m/s^3 and rad/s^3; most robots have none.
        speed: Share of the velocity limits to use, from 0.001 to 1; of the acceleration limits its square is used, as
            if time went slower. A jerk limit stays.
        dwell: How long to rest at each target before the next, s, where it rests.
        max_time: Longest motion, s; one that takes longer is `time_limit`, although it is returned.

    Raises:
        InvalidInput: If an argument is not valid, the trajectory is for another robot, or a joint that moves has no
            finite acceleration limit.
        EngineMissing: If there is no native engine.
    """
    check_kind("trajectory", trajectory, Trajectory)
    robot, scene = trajectory.planned_for(robot, scene)
    check_kind("scene", scene, Scene)
    check_robot(robot, trajectory)
    import_module("toppra.algorithm")  # seconds that are spent once do not count as planning time
    started = time.perf_counter()
    own = trajectory.provenance.retiming or trajectory.method
    step = checked_number("dt", own.dt if dt is None else dt, above=0.0, most=LONGEST_STEP)
    rest = checked_number("dwell", dwell, least=0.0, most=step * MAX_SAMPLES)
    longest = np.inf if max_time is None else checked_number("max_time", max_time, above=0.0)
    share = checked_number("speed", speed, least=LEAST_SPEED, most=1.0)
    limits = _limits(robot, share, velocity_limit, acceleration_limit, jerk_limit)
    along = _along(trajectory, robot, scene, limits, step, rest)
    retimed = _result(trajectory, robot, scene, along, longest, limits)
    spent = trajectory.planning_time + time.perf_counter() - started
    done = Retiming(step, share, rest)
    return replace(retimed, provenance=replace(retimed.provenance, planning_time=spent, retiming=done))


def _along(trajectory: Trajectory, robot: Robot, scene: Scene, limits: Limits, step: float, dwell: float) -> Retimed:
    """Return the motion along the path of a plan, with samples a step apart in s."""
    kept = recorded(trajectory.certificate)
    in_pieces = bool(trajectory.events or kept)
    rests = rests_of(trajectory, kept) if in_pieces else _targets(trajectory)
    segments = _segments(trajectory, rests)
    _check_moving(robot, segments, limits)
    if in_pieces:
        return along_pieces(trajectory, robot, scene, kept, rests, segments, limits, step, dwell)
    wanted = wanted_bound(trajectory.certificate, trajectory.method.kept_distance)
    return along_segments(robot, scene, segments, trajectory, limits, step, dwell, wanted)


def _result(
    trajectory: Trajectory, robot: Robot, scene: Scene, along: Retimed, longest: float, limits: Limits
) -> Trajectory:
    """Return a retimed motion as a trajectory, with a verdict of its own."""
    motion, arrivals, stopped, events, move_ends = along
    t, q, certificate = frozen(motion.t), frozen(motion.q), motion.certificate
    status, reason = _judged(trajectory, len(scene.steps), arrivals, float(t[-1]), longest, certificate)
    if stopped:
        reason += f"; {RESTS}: {stopped}"
    found = Motion(t, q, robot.joint_names, motion.timing(robot, limits), events, move_ends)
    return Trajectory(
        motion=found,
        samples=samples_of(robot, scene, found, trajectory.method),
        verdict=Verdict(
            status=status,
            reason=reason,
            certificate=certificate,
            violations=limit_violations(robot, motion.joint_motion),
            arrivals=arrivals,
            least_duration=least_duration_of(found, arrivals, None) if status is Status.REACHED else None,
            diagnosis=trajectory.diagnosis,
        ),
        provenance=replace(
            trajectory.provenance,
            path=path_quality(robot, *(q[a : b + 1] for a, b in pairwise([0, *motion.ends]))),
            certification_time=motion.certification_time,
        ),
        robot=robot,
        scene=scene,
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
    method = trajectory.method
    if len(arrivals) < steps:
        # What the plan's own verdict says already is not said twice.
        status, reason = judged(certificate, method, trajectory.status, trajectory.reason)
        return status, trajectory.reason if reason.removeprefix(trajectory.reason) in trajectory.reason else reason
    status, reason = judged(certificate, method, Status.REACHED, arrival(arrivals))
    if status is Status.REACHED and end > longest:
        return Status.TIME_LIMIT, f"{reason}, longer than max_time = {told_apart(longest, end)} s"
    return status, reason


def _limits(
    robot: Robot, share: float, velocity: ArrayLike | None, acceleration: ArrayLike | None, jerk: ArrayLike | None
) -> Limits:
    """Return the limits to keep, given or the robot's, of which a share is used."""
    return Limits(
        share * _limit("velocity_limit", velocity, robot, robot.velocity_limit),
        share**2 * _limit("acceleration_limit", acceleration, robot, robot.acceleration_limit),
        _limit("jerk_limit", robot.jerk_limit if jerk is None else jerk, robot, robot.jerk_limit),
    )


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


def _targets(trajectory: Trajectory) -> list[float]:
    """Return when the plan begins, is at each of its targets, and ends, s."""
    given = [0.0, *trajectory.arrivals, trajectory.duration]
    if any(later < sooner for sooner, later in pairwise(given)):
        raise InvalidInput("trajectory.arrivals", trajectory.arrivals, "times of the motion, in their order")
    is_over = len(given) > 2 and int(np.argmin(abs(trajectory.t - given[-2]))) == len(trajectory.t) - 1
    return given[:-1] if is_over else given


def _segments(trajectory: Trajectory, rests: Sequence[float]) -> list[Array]:
    """Return the paths from one rest to the next, from their times in s."""
    t, q = trajectory.t, trajectory.q
    if trajectory.timing is not None and len(t) > 1:
        # It is no polyline.
        passed = [arrival for arrival in trajectory.arrivals if abs(t - arrival).min() > SAME_TIME]
        t = np.unique(np.concatenate([t, passed, np.arange(0.0, t[-1], max(FINE, t[-1] / MAX_SAMPLES))]))
        q, _, _ = evaluate(trajectory.motion, t)
    ends = [int(np.argmin(abs(t - rest))) for rest in rests]
    return [q[a : b + 1] for a, b in pairwise(ends)]


def _check_moving(robot: Robot, segments: Sequence[Array], limits: Limits) -> None:
    """Check that what moves has limits to be timed by."""
    moves = np.any([np.ptp(segment, axis=0) > 0 for segment in segments], axis=0)
    for name, limit in (("velocity_limit", limits.velocity), ("acceleration_limit", limits.acceleration)):
        for j in np.flatnonzero(moves):
            if not limit[j] > 0 or (name == "acceleration_limit" and not np.isfinite(limit[j])):
                valid = "finite and greater than 0 for a joint that moves: give the argument, or the limit in the URDF"
                raise InvalidInput(f"{name} ({robot.joint_names[j]})", float(limit[j]), valid)
