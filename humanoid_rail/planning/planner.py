"""Plans a trajectory: checks what it is given, has a method compute a motion, judges it and certifies it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from humanoid_rail._arrays import Array, frozen
from humanoid_rail._native import why_no_engine
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.collision.certifier import bound_resolution, least_distance
from humanoid_rail.errors import check_kind
from humanoid_rail.holding.phases import certify_motion, sampled_motion, samples_of
from humanoid_rail.kinematics.joint_limits import JointMotion, limit_violations, sampled
from humanoid_rail.kinematics.task_stack import count_rows
from humanoid_rail.model.position_limits import within_position_limits
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.diagnosing import diagnose, in_one_line
from humanoid_rail.planning.kept import allowed_by, deviations_of
from humanoid_rail.planning.methods import as_method
from humanoid_rail.planning.moves import moves_of
from humanoid_rail.planning.options import PlanningMethod
from humanoid_rail.planning.segments import Segments, Unreached, joined, move_problem, plan_segments
from humanoid_rail.planning.size import check_size, size_hint
from humanoid_rail.planning.stage import after_happenings, first_stage
from humanoid_rail.planning.start import check_start, warn_of_depth
from humanoid_rail.planning.units import warn_of_units
from humanoid_rail.problem import Problem
from humanoid_rail.resolution.integrate import Integration
from humanoid_rail.result import Method, Motion, Provenance, Status, Verdict
from humanoid_rail.scene.scene import Scene, check_scene, start_of_scene
from humanoid_rail.timing.lower_bound import least_duration_of
from humanoid_rail.timing.time_optimal import limits_of
from humanoid_rail.timing.timed_motion import TimedMotion, joined_motion
from humanoid_rail.trajectory import Trajectory

UNPROVEN = "the native engine, which proves motions free of contact, is not installed"
"""The reason of a motion that nothing could be proven of says this."""
RESTS = "it rests at targets that were to be passed"
"""So does that of one that cannot do without."""


def plan(robot: Robot, scene: Scene, method: PlanningMethod | str = "auto") -> Trajectory:
    """Plan a motion of all hands to their targets.

    Args:
        robot: The robot.
        scene: Start, targets and obstacles. Several steps of targets are reached one after the other, each by a segment
            of the motion that begins where the one before ended; `auto` also turns hands as their poses ask.
        method: How each segment is planned: a name, `auto`, `qp` or `gradient-projection`, for the default options, or
            an object with options, such as ``Auto(seed=3)``, ``SafeVelocity(safety_distance=0.02)`` or
            ``GradientProjection(epsilon=0.7)``. docs/plan.md says which one to take.

    Returns:
        The trajectory up to where it got, with the status of its last segment, a reason and a certificate of what is
        proven of the motion, including between samples; see :func:`verify`. By `qp` and `auto` a motion whose
        certificate fails is not `reached`. By `auto` it is a motion of least time that a drive can follow, unless its
        provenance says why it is not; by other methods its timing is the method's own, and :func:`retime` gives one
        that a drive can follow.

    Raises:
        InvalidInput: If an argument is not valid, the scene is not one for this robot, or the start is outside the
            position limits or in penetration with an obstacle; for `qp` and `auto` also if anything touches there,
            links included. Also where an objective returns anything else than n finite numbers.
        EngineMissing: If there is no native engine; ``GradientProjection(engine="python")`` needs none.
    """
    started = time.perf_counter()
    check_kind("robot", robot, Robot)
    check_kind("scene", scene, Scene)
    chosen = as_method(method)
    chosen.gains.diagonal(3 * len(robot.hands))
    check_scene(robot, scene)
    chosen.check(scene)
    check_size(robot, chosen)
    warn_of_units(robot, scene)
    warn_of_depth(robot, scene)
    moves = moves_of(scene)
    start = within_position_limits(robot, start_of_scene(robot, scene), "initial", said_from=0.0)
    stage = after_happenings(first_stage(scene), robot, scene, moves[0], moves[0].begins, 0.0, start)
    first = move_problem(robot, scene, moves[0], stage, start)
    # The motion is judged with all hands, also those that have no target.
    whole = first if len(first.robot.hands) == len(robot.hands) else _with_all_hands(robot, first)
    check_start("initial", chosen.kinematics(whole), first.scene, first.q, chosen.least_start())
    segments = plan_segments(robot, scene, chosen, first, moves, stage)
    return _result(robot, scene, chosen, segments, started)


def solve(problem: Problem, method: PlanningMethod | str = "auto") -> Trajectory:
    """Plan a motion to tasks of one's own, instead of to the targets of a scene.

    Args:
        problem: The robot, the scene with its obstacles, the tasks and the start.
        method: How it is planned; see :func:`plan`.

    Returns:
        What :func:`plan` returns.

    Raises:
        InvalidInput: As for :func:`plan`, or if a task does not suit the robot.
        EngineMissing: As for :func:`plan`.
    """
    started = time.perf_counter()
    check_kind("problem", problem, Problem)
    robot, problem = problem.robot, _among_objects(problem)
    chosen = as_method(method)
    chosen.gains.diagonal(count_rows(problem.tasks))
    check_size(problem.robot, chosen)
    kinematics = chosen.kinematics(problem)
    check_start("start", kinematics, problem.scene, problem.q, chosen.least_start())
    planned = replace(chosen.plan(problem), constraints=tuple(problem.constraints))
    unreached = None if planned.motion.status is Status.REACHED else Unreached(0, problem, planned)
    segments = replace(joined(robot, [planned]), unreached=unreached)
    return _result(robot, problem.scene, chosen, segments, started)


def _among_objects(problem: Problem) -> Problem:
    """Return a problem in whose robot the objects of its scene are links, where they stand at first."""
    robot, _ = first_stage(problem.scene).robot(problem.robot, problem.scene)
    return problem if robot is problem.robot else replace(problem, robot=robot)


def _with_all_hands(robot: Robot, problem: Problem) -> Problem:
    return Problem(replace(problem.robot, hands=robot.hands), problem.scene, problem.tasks, problem.q)


def _result(robot: Robot, scene: Scene, method: PlanningMethod, segments: Segments, started: float) -> Trajectory:
    """Return a motion as a trajectory, with the verdict on it."""
    motion = segments.motion

    def proof(t: Array, q: Array, velocity: Array | None = None) -> Certificate:
        return certify_motion(robot, scene, sampled_motion(robot, t, q, velocity, segments.events))

    timed = None if segments.timed is None else joined_motion(segments.timed, proof)
    certificate, certification_time = _certified(motion, timed, proof)
    certificate = _with_deviations(certificate, robot, segments, timed)
    status, reason = judged(certificate, method, motion.status, motion.reason)
    reason = "; ".join([reason, *segments.said])
    if segments.optimisation is not None and segments.optimisation.stopped:
        reason += f"; {RESTS}: {segments.optimisation.stopped}"
    planning_time, diagnosis = time.perf_counter() - started, None
    if segments.unreached is not None and certificate is not None:
        diagnosis = diagnose(segments.unreached, method, started)
        reason += in_one_line(diagnosis, method, scene.obstacles)
    if status is not Status.REACHED:
        reason += _held(robot) + size_hint(robot, method, status)
    found = Motion(
        frozen(motion.t),
        frozen(motion.q),
        robot.joint_names,
        None if timed is None else timed.timing(robot, limits_of(robot)),
        segments.events,
        segments.ends,
    )
    verdict = Verdict(
        status=status,
        reason=reason,
        certificate=certificate,
        violations=limit_violations(robot, *_joint_motions(motion, timed)),
        arrivals=segments.arrivals,
        least_duration=(
            least_duration_of(found, segments.arrivals, robot.velocity_limit) if status is Status.REACHED else None
        ),
        diagnosis=diagnosis,
    )
    return Trajectory(
        motion=found,
        samples=samples_of(robot, scene, found, method, method.engine),
        verdict=verdict,
        provenance=Provenance(
            scene=scene.name,
            method=method,
            engine=method.engine,
            found_by=segments.found_by,
            path=segments.path,
            search=segments.search,
            evaluations=motion.evaluations,
            planning_time=planning_time,
            certification_time=certification_time,
            optimisation=segments.optimisation,
            c_mu=method.gains.c_mu_of(robot),
        ),
        robot=robot,
        scene=scene,
    )


def _with_deviations(
    certificate: Certificate | None, robot: Robot, segments: Segments, timed: TimedMotion | None
) -> Certificate | None:
    """Return a certificate with how far the motion leaves what it keeps."""
    if certificate is None:
        return None
    motion = segments.motion
    samples = (motion.t, motion.q, None) if timed is None else (timed.t, timed.q, timed.velocity)
    return replace(certificate, deviations=deviations_of(robot, segments.kept, *samples))


def _certified(
    motion: Integration, timed: TimedMotion | None, proof: Callable[[Array, Array], Certificate]
) -> tuple[Certificate | None, float]:
    """Return what is proven of a motion, None where nothing can be, and how long that took, s."""
    if timed is not None:
        return timed.certificate, timed.certification_time
    began = time.perf_counter()
    certificate = None if why_no_engine() else proof(motion.t, motion.q)
    return certificate, time.perf_counter() - began


def _joint_motions(motion: Integration, timed: TimedMotion | None) -> tuple[JointMotion, ...]:
    """Return what of a motion is held against the limits."""
    if timed is not None:
        return (timed.joint_motion,)
    # Between samples it is linear; how fast it is at the integrator's own steps does not depend on dt.
    return sampled(motion.t, motion.q), motion.visited


def judged(certificate: Certificate | None, method: Method, status: Status, reason: str) -> tuple[Status, str]:
    """Return the status and the reason of a motion, once it is known what is proven of it.

    Args:
        certificate: What is proven; None where nothing could be looked at.
        method: What the motion was to keep.
        status: What became of the targets.
        reason: The status in a sentence.
    """
    if certificate is None:
        return status, f"{reason}; {UNPROVEN}"
    kept_distance = method.kept_distance
    left = allowed_by(method).exceeded(certificate.deviations)
    if left is not None:
        status, reason = Status.UNCERTIFIED if status is Status.REACHED else status, f"{reason}, but {left}"
    if kept_distance is None:
        return status, reason
    if status is Status.REACHED and not certificate.certified:
        unproven = f"no clearance larger than {certificate.clearance_bound} m could be proven"
        found = certificate.contact or certificate.reason or unproven
        status, reason = Status.UNCERTIFIED, f"{reason}, but {found}"
    spare = bound_resolution() + least_distance()
    nearest = certificate.kept_bound
    if nearest is not None and nearest < kept_distance - spare:
        reason += f"; the safety distance of {kept_distance:g} m could not be kept everywhere"
    elif certificate.clearance_bound is not None and certificate.clearance_bound < kept_distance - spare:
        reason += "; only links with a distance of their own (pair_distances) are nearer than the safety distance"
    return status, reason


def _held(robot: Robot) -> str:
    """Say which joints a velocity limit of 0 keeps where they are; nothing if there are none."""
    passive = [name for name in list(robot.model.names)[1:] if name not in robot.joint_names]
    limits = [robot.model.velocityLimit[robot.model.joints[robot.model.getJointId(name)].idx_v] for name in passive]
    named = [*zip(robot.joint_names, robot.velocity_limit, strict=True), *zip(passive, limits, strict=True)]
    held = [name for name, limit in named if limit == 0.0]
    return f"; these joints have a velocity limit of 0 and stay where they are: {', '.join(held)}" if held else ""
