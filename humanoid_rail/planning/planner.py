"""Plans a trajectory: checks what it is given, has a method compute a motion, judges it and certifies it."""

from __future__ import annotations

import time

import numpy as np

from humanoid_rail._arrays import Array, frozen
from humanoid_rail._native import why_no_engine
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.collision.certifier import bound_resolution, certify, least_distance
from humanoid_rail.errors import InvalidInput, check_kind
from humanoid_rail.kinematics.joint_limits import limit_violations, sampled
from humanoid_rail.kinematics.state import KinematicsModel
from humanoid_rail.kinematics.task import count_rows
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.methods import as_method
from humanoid_rail.planning.options import PlanningMethod
from humanoid_rail.planning.segments import Segments, joined, plan_segments, segment_problem
from humanoid_rail.problem import Problem
from humanoid_rail.result import Motion, Provenance, Samples, Status, Verdict
from humanoid_rail.scene.obstacles import name_of
from humanoid_rail.scene.scene import Scene, check_scene
from humanoid_rail.trajectory import Trajectory

UNPROVEN = "the native engine, which proves motions free of contact, is not installed"
"""This is said of a motion that could not be looked at."""


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
        certificate fails is not `reached`. Its timing is the method's own; :func:`retime` gives one that a drive can
        follow.

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
    start = np.array(robot.initial if scene.initial is None else scene.initial, float)
    first = segment_problem(robot, scene, 0, start)
    # The motion is judged with all hands, also those that have no target.
    kinematics = chosen.kinematics(first if first.robot is robot else Problem(robot, scene, first.tasks, start))
    _check_start(kinematics, scene, start, chosen)
    segments = plan_segments(first, robot, scene, chosen)
    return _result(kinematics, scene, chosen, segments, started)


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
    chosen = as_method(method)
    chosen.gains.diagonal(count_rows(problem.tasks))
    kinematics = chosen.kinematics(problem)
    _check_start(kinematics, problem.scene, problem.q, chosen)
    segments = joined(problem.robot, [chosen.plan(problem)], 1)
    return _result(kinematics, problem.scene, chosen, segments, started)


def _result(
    kinematics: KinematicsModel, scene: Scene, method: PlanningMethod, segments: Segments, started: float
) -> Trajectory:
    """Return a motion as a trajectory, with the verdict on it."""
    robot, motion = kinematics.robot, segments.motion
    course = kinematics.along(motion.q, np.inf if method.far_clearances else method.epsilon, motion.t)
    computed = time.perf_counter()
    certificate = None if why_no_engine() else certify(robot, scene.obstacles, motion.t, motion.q)
    certified = time.perf_counter()
    status, reason = judged(certificate, method.kept_distance, motion.status, motion.reason)
    verdict = Verdict(
        status=status,
        reason=reason,
        certificate=certificate,
        # Between samples a motion is linear; how fast it is at the integrator's own steps does not depend on dt.
        violations=limit_violations(robot, sampled(motion.t, motion.q), motion.visited),
        arrivals=segments.arrivals,
    )
    return Trajectory(
        motion=Motion(frozen(motion.t), frozen(motion.q), robot.joint_names),
        samples=Samples(
            hands=frozen(course.hands),
            hand_names=robot.hand_names,
            clearance=frozen(course.clearance),
            manipulability=frozen(course.manipulability),
        ),
        verdict=verdict,
        provenance=Provenance(
            scene=scene.name,
            method=method,
            engine=method.engine,
            found_by=segments.found_by,
            path=segments.path,
            search=segments.search,
            evaluations=motion.evaluations,
            planning_time=time.perf_counter() - started,
            certification_time=certified - computed,
        ),
    )


def judged(
    certificate: Certificate | None, kept_distance: float | None, status: Status, reason: str
) -> tuple[Status, str]:
    """Return the status and the reason of a motion, once it is known what is proven of it.

    Args:
        certificate: What is proven; None where nothing could be looked at.
        kept_distance: The safety distance that the method keeps, m; None for a method that keeps none.
        status: What became of the targets.
        reason: The status in a sentence.
    """
    if certificate is None:
        return status, f"{reason}; {UNPROVEN}"
    if kept_distance is None:
        return status, reason
    if status is Status.REACHED and not certificate.certified:
        unproven = f"no clearance larger than {certificate.clearance_bound} m could be proven"
        found = certificate.contact or certificate.reason or unproven
        status, reason = Status.UNCERTIFIED, f"{reason}, but {found}"
    nearest = certificate.clearance_bound
    if nearest is not None and nearest < kept_distance - bound_resolution() - least_distance():
        reason += f"; the safety distance of {kept_distance:g} m could not be kept everywhere"
    return status, reason


def _check_start(kinematics: KinematicsModel, scene: Scene, start: Array, method: PlanningMethod) -> None:
    """Check that a start is clear of what the method keeps clear of."""
    robot, least = kinematics.robot, method.least_start()
    there = kinematics.measure(start, horizon=0.0)
    rounded = [round(float(x), 6) for x in start]
    if there.clearance.size and there.clearance.min() < least:
        link, obstacle = np.unravel_index(there.clearance.argmin(), there.clearance.shape)
        near = f"{robot.link_names[link]} is {_where(there.clearance.min())} {name_of(scene.obstacles, int(obstacle))}"
        raise InvalidInput("initial", rounded, f"a start clear of obstacles: {near}")
    if least > 0 and there.self_clearance.size and there.self_clearance.min() < least:
        one, other = robot.self_collision_pairs[int(there.self_clearance.argmin())]
        near = f"{robot.link_names[one]} is {_where(there.self_clearance.min())} {robot.link_names[other]}"
        raise InvalidInput("initial", rounded, f"a start in which no links touch: {near}")


def _where(clearance: float) -> str:
    return f"{-clearance:.4g} m inside" if clearance < 0 else f"{clearance:.4g} m, too near to tell from touching, from"
