"""Plans a trajectory: checks what it is given, has an engine compute a motion, judges it and certifies it."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from humanoid_rail._arrays import Array, frozen
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.collision.certifier import RESOLUTION
from humanoid_rail.planning.engines import get_engine
from humanoid_rail.errors import InvalidInput, check_kind, checked_number
from humanoid_rail.resolution.integrate import Settings
from humanoid_rail.planning.segments import travel_legs
from humanoid_rail.kinematics.joint_limits import limit_violations, sampled
from humanoid_rail.scene.obstacles import at_rest, name_of
from humanoid_rail.resolution.velocity import Gains, Objective
from humanoid_rail.model.robot import Robot
from humanoid_rail.resolution.rollout import APART
from humanoid_rail.resolution.qp import Safety
from humanoid_rail.scene.scene import Scene, check_scene, field_of_step
from humanoid_rail.scene.targets import Pose, is_oriented
from humanoid_rail.kinematics.task import tasks_of
from humanoid_rail.trajectory import MAX_SAMPLES, Status, Trajectory

METHODS = ("auto", "qp", "gradient-projection")
"""How a plan is made; see :func:`plan`."""
SAFE = ("auto", "qp")
"""Those that keep clear."""
MAX_PLANNING_TIME = 10.0
"""How long `auto` may look for a way unless told otherwise, s."""


def plan(
    robot: Robot,
    scene: Scene,
    method: str = "auto",
    *,
    engine: str = "native",
    gain: float | Sequence[float] | Array = 1.0,
    c_mu: float = 1.0,
    c_kappa: float = 1.0,
    epsilon: float = 1.0,
    safety_distance: float = 0.01,
    damper_gain: float = 1.4,
    tolerance: float = 0.01,
    dt: float = 0.01,
    max_time: float = 60.0,
    rtol: float = 1e-6,
    atol: float = 1e-6,
    far_clearances: bool = False,
    max_planning_time: float = MAX_PLANNING_TIME,
    seed: int = 0,
    objectives: Sequence[Objective] = (),
) -> Trajectory:
    """Plan a motion of all hands to their targets.

    Args:
        robot: The robot.
        scene: Start, targets and obstacles. Several steps of targets are reached one after the other, each by a leg of
            the motion that begins where the one before ended; `auto` also turns hands as their poses ask.
        method: How each leg is planned. `gradient-projection` follows q_dot of eq. 4.9. It neither prevents collisions
            nor knows limits: the result says what happened (`certified`, `limits_ok`), whatever its status. `qp`
            follows the q_dot closest to it that keeps links clear of obstacles and of each other, and joints within
            their position and speed limits. `auto` follows `qp` first and looks for another way where that gets stuck,
            then makes the path short and smooth and follows it as fast as the speed limits allow; among obstacles that
            move it is `qp`. See docs/auto.md.
        engine: What computes it: `native` (C++) or `python` (the reference, 40 to 200 times slower). Where the
            native engine was not built, a RuntimeWarning says so and the other one is used.
        gain: Diagonal of K in 1/s: one number for all coordinates of the hands, or one for each.
        c_mu: Gain of the manipulability's gradient, 0 or more.
        c_kappa: Gain of the penalties' gradient, 0 or more.
        epsilon: Activation distance of the penalty in m, 0 or more.
        safety_distance: `qp` and `auto` keep clearances from falling below this, m, 0 or more. A start that is nearer
            to something is led away from it.
        damper_gain: Of `qp`, 1/s: clearances fall to the safety distance no faster than exp(-damper_gain t).
        tolerance: The motion ends where the norm of e, all coordinates of all hands together, falls to this, m.
        dt: Time between samples, s. `qp` holds its velocity for so long.
        max_time: Longest motion, s.
        rtol: Relative tolerance of the integrator of eq. 4.9 (Dormand and Prince, order 5(4)).
        atol: Absolute tolerance of the integrator, m and rad.
        far_clearances: Whether to measure at each sample also the clearances that are beyond the activation distance.
            If not, they are given as infinite, save the smallest, so that `min_clearance` is right in any case.
        max_planning_time: How long `auto` may look for ways in all, s.
        seed: Of the random numbers of `auto`, from 0 to 2^31 - 1. The same seed gives the same plan, bit for bit,
            unless the time for planning cuts it off.
        objectives: Further secondary objectives of `qp` and `gradient-projection`, for the Python engine: functions
            from a :class:`State` to a velocity (n,) in m/s and rad/s, which eq. 4.8 adds to its own. See
            docs/objective.md.

    Returns:
        The trajectory up to where it got, with the status of its last leg, a reason and a certificate of what is proven
        of the motion between its samples; see :func:`verify`. By `qp` and `auto` a motion whose certificate fails is
        not `reached`.

    Raises:
        InvalidInput: If an argument is not valid, the scene is not one for this robot, or the start is outside the
            position limits or in penetration with an obstacle; for `qp` and `auto` also if anything touches there,
            links included, and for other methods if parameters of these are given. Also where an objective returns
            anything else than n finite numbers.
    """
    started = time.perf_counter()
    check_kind("robot", robot, Robot)
    check_kind("scene", scene, Scene)
    if not isinstance(method, str) or method not in METHODS:
        raise InvalidInput("method", method, f"one of {', '.join(METHODS)}")
    given = {"tolerance": tolerance, "dt": dt, "max_time": max_time, "rtol": rtol, "atol": atol}
    given = {name: checked_number(name, value, above=0.0) for name, value in given.items()}
    settings = Settings(**given)
    if max_time / dt > MAX_SAMPLES:
        valid = (
            f"at least {max_time / MAX_SAMPLES:g} s with max_time = {max_time:g} s, for at most {MAX_SAMPLES} samples"
        )
        raise InvalidInput("dt", dt, valid)
    if not isinstance(far_clearances, bool):
        raise InvalidInput("far_clearances", far_clearances, "True or False")
    gains = Gains(gain, c_mu, c_kappa, epsilon, objectives)
    gains.diagonal(3 * len(robot.hands))
    safety = Safety(safety_distance, damper_gain)
    checked_number("max_planning_time", max_planning_time, above=0.0)
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or not 0 <= seed < 2**31:
        raise InvalidInput("seed", seed, "a whole number from 0 to 2^31 - 1")
    _check_unused(method, safety, max_planning_time, seed)
    computing = get_engine(engine)
    if gains.objectives and (method == "auto" or engine != "python"):
        valid = 'none by "auto" or the native engine; "qp" and "gradient-projection" take them with engine="python"'
        raise InvalidInput("objectives", gains.objective_names, valid)
    check_scene(robot, scene)
    _check_turns(scene, method)
    kinematics = computing.kinematics(robot, scene.obstacles)
    start = np.array(robot.initial if scene.initial is None else scene.initial, float)
    there = kinematics.measure(start, horizon=0.0)
    # From where anything touches, to coal's precision, no step can be proven.
    least = APART if method in SAFE else 0.0
    _check_start(there.clearance, robot, start, scene, least)
    if method in SAFE:
        _check_links(there.self_clearance, robot, start, least)

    limited = replace(settings, max_planning_time=float(max_planning_time)) if method == "auto" else settings
    tasks = tasks_of(robot, scene)
    journey = travel_legs(kinematics, tasks, method, computing, start, gains, safety, limited, int(seed))
    motion = journey.motion
    course = kinematics.along(motion.q, np.inf if far_clearances else gains.epsilon, motion.t)
    integrated = time.perf_counter()
    certificate = computing.certify(robot, scene.obstacles, motion.t, motion.q)
    certified = time.perf_counter()
    status, reason = motion.status, motion.reason
    if method in SAFE and status is Status.REACHED:
        status, reason = judged(certificate, reason)
    if method in SAFE:
        reason += not_kept(certificate, safety.safety_distance)
    return Trajectory(
        t=frozen(motion.t),
        q=frozen(motion.q),
        hands=frozen(course.hands),
        clearance=frozen(course.clearance),
        manipulability=frozen(course.manipulability),
        status=status,
        reason=reason,
        # Between samples a motion is linear; how fast it is at the integrator's own steps does not depend on dt.
        violations=limit_violations(robot, sampled(motion.t, motion.q), motion.visited),
        certificate=certificate,
        timing=None,
        arrivals=journey.arrivals,
        planning_time=time.perf_counter() - started,
        certification_time=certified - integrated,
        evaluations=motion.evaluations,
        found_by=journey.found_by,
        path=journey.path,
        search=journey.search,
        joint_names=robot.joint_names,
        hand_names=robot.hand_names,
        scene=scene.name,
        method=method,
        engine=computing.name,
        settings={
            **given,
            "gain": gains.diagonal(3 * len(robot.hands)).tolist(),
            "c_mu": gains.c_mu,
            "c_kappa": gains.c_kappa,
            "epsilon": gains.epsilon,
            "objectives": list(gains.objective_names),
            **(
                {"safety_distance": safety.safety_distance, "damper_gain": safety.damper_gain} if method in SAFE else {}
            ),
            **({"max_planning_time": float(max_planning_time), "seed": int(seed)} if method == "auto" else {}),
            "far_clearances": far_clearances,
        },
    )


def judged(certificate: Certificate, reason: str) -> tuple[Status, str]:
    """Return the status and the reason of a motion that has to be certified and leads to the targets."""
    if certificate.certified:
        return Status.REACHED, reason
    found = certificate.contact or f"no clearance larger than {certificate.clearance_bound} m could be proven"
    return Status.UNCERTIFIED, f"{reason}, but {found}"


def not_kept(certificate: Certificate, safety_distance: float) -> str:
    """Return what has to be added to a reason where a motion does not keep the safety distance in m."""
    nearest = certificate.clearance_bound
    if nearest is None or nearest >= safety_distance - RESOLUTION - APART:
        return ""
    return f"; the safety distance of {safety_distance:g} m could not be kept everywhere"


def _check_unused(method: str, safety: Safety, max_planning_time: float, seed: int) -> None:
    """Check that no parameter is given that the method does not use."""
    unused: dict[str, tuple[float, float]] = {}
    if method not in SAFE:
        unused |= {
            name: (getattr(safety, name), getattr(Safety(), name)) for name in ("safety_distance", "damper_gain")
        }
    if method != "auto":
        unused |= {"max_planning_time": (max_planning_time, MAX_PLANNING_TIME), "seed": (seed, 0)}
    for name, (value, default) in unused.items():
        if value != default:
            raise InvalidInput(name, value, f"the default with {method}, which does not use it")


def _check_turns(scene: Scene, method: str) -> None:
    """Check that hands are turned only by the method that can."""
    if method == "auto" and at_rest(scene.obstacles):
        return
    for number, step in enumerate(scene.steps):
        for hand, target in step.items():
            if isinstance(target, Pose) and is_oriented(target):
                valid = "a point: only auto turns hands, and only among obstacles at rest"
                raise InvalidInput(
                    f"{field_of_step(scene, number)}.{hand}", target.model_dump(exclude_none=True), valid
                )


def _check_start(clearance: Array, robot: Robot, start: Array, scene: Scene, least: float) -> None:
    if clearance.size and clearance.min() < least:
        link, obstacle = np.unravel_index(clearance.argmin(), clearance.shape)
        where = f"{robot.link_names[link]} is {_where(clearance.min())} {name_of(scene.obstacles, int(obstacle))}"
        raise InvalidInput("initial", _rounded(start), f"a start clear of obstacles: {where}")


def _check_links(clearance: Array, robot: Robot, start: Array, least: float) -> None:
    if clearance.size and clearance.min() < least:
        one, other = robot.self_collision_pairs[int(clearance.argmin())]
        where = f"{robot.link_names[one]} is {_where(clearance.min())} {robot.link_names[other]}"
        raise InvalidInput("initial", _rounded(start), f"a start in which no links touch: {where}")


def _where(clearance: float) -> str:
    return f"{-clearance:.4g} m inside" if clearance < 0 else f"{clearance:.4g} m, too near to tell from touching, from"


def _rounded(start: Array) -> list[float]:
    return [round(float(x), 6) for x in start]
