"""Plans a trajectory: checks what it is given, integrates q_dot, samples and judges the motion."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from humanoid_rail.arrays import Array, frozen
from humanoid_rail.errors import InvalidInput, checked_number
from humanoid_rail.integration import Method, integrate
from humanoid_rail.kinematics import Kinematics
from humanoid_rail.limits import limit_violations, sampled
from humanoid_rail.resolution import Gains, gradient_projection
from humanoid_rail.robot import Robot
from humanoid_rail.scene import Scene, check_scene
from humanoid_rail.trajectory import Trajectory

METHODS: dict[str, Method] = {"gradient-projection": gradient_projection}
"""Methods by name: q_dot (n,) from a state, the targets (h, 3) and the gains."""

MAX_SAMPLES = 1_000_000
"""The most samples that a trajectory may have."""


def plan(
    robot: Robot,
    scene: Scene,
    method: str = "gradient-projection",
    *,
    gain: float | Sequence[float] | Array = 1.0,
    c_mu: float = 1.0,
    c_kappa: float = 1.0,
    epsilon: float = 1.0,
    tolerance: float = 0.01,
    dt: float = 0.01,
    max_time: float = 60.0,
    rtol: float = 1e-6,
    atol: float = 1e-6,
) -> Trajectory:
    """Plan a motion of all hands to their targets.

    Args:
        robot: The robot.
        scene: Start, targets and obstacles.
        method: How q_dot is found: `gradient-projection` is eq. 4.9. It neither prevents collisions nor knows limits:
            the result says what happened (`collision_free`, `limits_ok`), whatever its status.
        gain: Diagonal of K in 1/s: one number for all coordinates of the hands, or one for each.
        c_mu: Gain of the manipulability's gradient, 0 or more.
        c_kappa: Gain of the penalties' gradient, 0 or more.
        epsilon: Activation distance of the penalty in m, 0 or more.
        tolerance: The motion ends where the norm of e, all coordinates of all hands together, falls to this, m.
        dt: Time between samples, s.
        max_time: Longest motion, s.
        rtol: Relative tolerance of the integrator (Dormand and Prince, order 5(4)).
        atol: Absolute tolerance of the integrator, m and rad.

    Returns:
        The trajectory up to where it got, with a status and a reason.

    Raises:
        InvalidInput: If an argument is not valid, the scene is not one for this robot, or the start is outside the
            position limits or in penetration with an obstacle.
    """
    started = time.perf_counter()
    if not isinstance(method, str) or method not in METHODS:
        raise InvalidInput("method", method, f"one of {', '.join(METHODS)}")
    given = {"tolerance": tolerance, "dt": dt, "max_time": max_time, "rtol": rtol, "atol": atol}
    positive = {name: checked_number(name, value, above=0.0) for name, value in given.items()}
    if max_time / dt > MAX_SAMPLES:
        valid = (
            f"at least {max_time / MAX_SAMPLES:g} s with max_time = {max_time:g} s, for at most {MAX_SAMPLES} samples"
        )
        raise InvalidInput("dt", dt, valid)
    gains = Gains(gain, c_mu, c_kappa, epsilon)
    gains.diagonal(3 * len(robot.hands))
    check_scene(robot, scene)
    kinematics = Kinematics(robot, scene.obstacles)
    start = np.array(robot.initial if scene.initial is None else scene.initial, float)
    _check_start(kinematics, start, scene)

    targets = np.array([scene.targets[name] for name in robot.hand_names])
    motion = integrate(kinematics, METHODS[method], start, targets, gains, tolerance, max_time, rtol, atol)
    t = _sample_times(motion.end, dt)
    q = motion.q_of_t(t)
    measured = [kinematics.measure(row) for row in q]
    return Trajectory(
        t=frozen(t),
        q=frozen(q),
        hands=frozen(np.array([m.hands for m in measured])),
        clearance=frozen(np.array([m.clearance.min(axis=0) for m in measured])),
        manipulability=frozen(np.array([m.manipulability for m in measured])),
        status=motion.status,
        reason=motion.reason,
        # Between samples a motion is linear; how fast it is at the integrator's own steps does not depend on dt.
        violations=limit_violations(robot, sampled(t, q), motion.visited),
        planning_time=time.perf_counter() - started,
        evaluations=motion.evaluations,
        joint_names=robot.joint_names,
        hand_names=robot.hand_names,
        scene=scene.name,
        method=method,
        settings={
            **positive,
            "gain": gains.diagonal(targets.size).tolist(),
            "c_mu": gains.c_mu,
            "c_kappa": gains.c_kappa,
            "epsilon": gains.epsilon,
        },
    )


def _check_start(kinematics: Kinematics, start: Array, scene: Scene) -> None:
    clearance = kinematics.measure(start).clearance
    if clearance.size and clearance.min() < 0:
        link, obstacle = np.unravel_index(clearance.argmin(), clearance.shape)
        where = f"{kinematics.robot.link_names[link]} is {-clearance.min():.4g} m inside obstacles[{obstacle}]"
        valid = f"a start clear of obstacles: {where} ({scene.obstacles[obstacle].type})"
        raise InvalidInput("initial", [round(float(x), 6) for x in start], valid)


def _sample_times(end: float, dt: float) -> Array:
    """Return 0, dt, 2 dt, ... and the end."""
    regular = dt * np.arange(int(np.floor(end / dt)) + 1)
    # A last multiple that is the end up to rounding would make an interval of no length.
    return np.append(regular[regular < end - 1e-9 * dt], end)
