"""Plans a trajectory: checks what it is given, has an engine integrate q_dot, and judges the motion."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from humanoid_rail.arrays import Array, frozen
from humanoid_rail.engines import get_engine
from humanoid_rail.errors import InvalidInput, checked_number
from humanoid_rail.integration import Settings
from humanoid_rail.limits import limit_violations, sampled
from humanoid_rail.resolution import METHODS, Gains
from humanoid_rail.robot import Robot
from humanoid_rail.scene import Scene, check_scene
from humanoid_rail.trajectory import Trajectory

MAX_SAMPLES = 1_000_000
"""The most samples that a trajectory may have."""


def plan(
    robot: Robot,
    scene: Scene,
    method: str = "gradient-projection",
    *,
    engine: str = "native",
    gain: float | Sequence[float] | Array = 1.0,
    c_mu: float = 1.0,
    c_kappa: float = 1.0,
    epsilon: float = 1.0,
    tolerance: float = 0.01,
    dt: float = 0.01,
    max_time: float = 60.0,
    rtol: float = 1e-6,
    atol: float = 1e-6,
    far_clearances: bool = False,
) -> Trajectory:
    """Plan a motion of all hands to their targets.

    Args:
        robot: The robot.
        scene: Start, targets and obstacles.
        method: How q_dot is found: `gradient-projection` is eq. 4.9. It neither prevents collisions nor knows limits:
            the result says what happened (`collision_free`, `limits_ok`), whatever its status.
        engine: What computes it: `native` (C++) or `python` (the reference, 40 to 200 times slower). Where the
            native engine was not built, a RuntimeWarning says so and the other one is used.
        gain: Diagonal of K in 1/s: one number for all coordinates of the hands, or one for each.
        c_mu: Gain of the manipulability's gradient, 0 or more.
        c_kappa: Gain of the penalties' gradient, 0 or more.
        epsilon: Activation distance of the penalty in m, 0 or more.
        tolerance: The motion ends where the norm of e, all coordinates of all hands together, falls to this, m.
        dt: Time between samples, s.
        max_time: Longest motion, s.
        rtol: Relative tolerance of the integrator (Dormand and Prince, order 5(4)).
        atol: Absolute tolerance of the integrator, m and rad.
        far_clearances: Whether to measure at each sample also the clearances that are beyond the activation distance.
            If not, they are given as infinite, save the smallest, so that `min_clearance` is right in any case.

    Returns:
        The trajectory up to where it got, with a status and a reason.

    Raises:
        InvalidInput: If an argument is not valid, the scene is not one for this robot, or the start is outside the
            position limits or in penetration with an obstacle.
    """
    started = time.perf_counter()
    for name, value, kind in (("robot", robot, Robot), ("scene", scene, Scene)):
        if not isinstance(value, kind):
            raise InvalidInput(name, value, f"a {kind.__name__}")
    if not isinstance(method, str) or method not in METHODS:
        raise InvalidInput("method", method, f"one of {', '.join(METHODS)}")
    given = {"tolerance": tolerance, "dt": dt, "max_time": max_time, "rtol": rtol, "atol": atol}
    settings = Settings(**{name: checked_number(name, value, above=0.0) for name, value in given.items()})
    if max_time / dt > MAX_SAMPLES:
        valid = (
            f"at least {max_time / MAX_SAMPLES:g} s with max_time = {max_time:g} s, for at most {MAX_SAMPLES} samples"
        )
        raise InvalidInput("dt", dt, valid)
    if not isinstance(far_clearances, bool):
        raise InvalidInput("far_clearances", far_clearances, "True or False")
    gains = Gains(gain, c_mu, c_kappa, epsilon)
    gains.diagonal(3 * len(robot.hands))
    computing = get_engine(engine)
    check_scene(robot, scene)
    kinematics = computing.kinematics(robot, scene.obstacles)
    start = np.array(robot.initial if scene.initial is None else scene.initial, float)
    _check_start(kinematics.measure(start, horizon=0.0).clearance, robot, start, scene)

    targets = np.array([scene.targets[name] for name in robot.hand_names])
    motion = computing.integrate(kinematics, method, start, targets, gains, settings)
    course = kinematics.along(motion.q, np.inf if far_clearances else gains.epsilon)
    return Trajectory(
        t=frozen(motion.t),
        q=frozen(motion.q),
        hands=frozen(course.hands),
        clearance=frozen(course.clearance),
        manipulability=frozen(course.manipulability),
        status=motion.status,
        reason=motion.reason,
        # Between samples a motion is linear; how fast it is at the integrator's own steps does not depend on dt.
        violations=limit_violations(robot, sampled(motion.t, motion.q), motion.visited),
        planning_time=time.perf_counter() - started,
        evaluations=motion.evaluations,
        joint_names=robot.joint_names,
        hand_names=robot.hand_names,
        scene=scene.name,
        method=method,
        engine=computing.name,
        settings={
            **asdict(settings),
            "gain": gains.diagonal(targets.size).tolist(),
            "c_mu": gains.c_mu,
            "c_kappa": gains.c_kappa,
            "epsilon": gains.epsilon,
            "far_clearances": far_clearances,
        },
    )


def _check_start(clearance: Array, robot: Robot, start: Array, scene: Scene) -> None:
    if clearance.size and clearance.min() < 0:
        link, obstacle = np.unravel_index(clearance.argmin(), clearance.shape)
        where = f"{robot.link_names[link]} is {-clearance.min():.4g} m inside obstacles[{obstacle}]"
        valid = f"a start clear of obstacles: {where} ({scene.obstacles[obstacle].type})"
        raise InvalidInput("initial", [round(float(x), 6) for x in start], valid)
