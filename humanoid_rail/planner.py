"""Integrates q_dot to a trajectory."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import RK45, DenseOutput, OdeSolution
from scipy.optimize import brentq

from humanoid_rail.arrays import Array, frozen
from humanoid_rail.errors import InvalidInput, checked_number
from humanoid_rail.kinematics import Kinematics, State
from humanoid_rail.limits import limit_violations
from humanoid_rail.resolution import Gains, gradient_projection, lost_direction, task_error
from humanoid_rail.robot import Robot
from humanoid_rail.scene import Scene, check_scene
from humanoid_rail.trajectory import Status, Trajectory

Method = Callable[[State, Array, Gains], Array]

METHODS: dict[str, Method] = {"gradient-projection": gradient_projection}
"""Methods by name: q_dot (n,) from a state, the targets (h, 3) and the gains."""

MAX_SAMPLES = 1_000_000
"""The most samples that a trajectory may have."""
MAX_EVALUATIONS = 10_000
"""Evaluations of q_dot after which a motion is called stalled."""
PATIENCE = 0.25
"""How long a motion may stay at a singularity that keeps a hand from its target, in time constants 1 / min(K)."""


@dataclass(frozen=True)
class _Motion:
    """What the integration found: q(t) up to the end, and why it ended."""

    q_of_t: Callable[[Array], Array]
    end: float
    status: Status
    reason: str
    evaluations: int


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
    if method not in METHODS:
        raise InvalidInput("method", method, f"one of {', '.join(METHODS)}")
    positive = {"tolerance": tolerance, "dt": dt, "max_time": max_time, "rtol": rtol, "atol": atol}
    for name, value in positive.items():
        checked_number(name, value, above=0.0)
    if max_time / dt > MAX_SAMPLES:
        raise InvalidInput("dt", dt, f"at least {max_time / MAX_SAMPLES:g} s, for at most {MAX_SAMPLES} samples")
    gains = Gains(gain, c_mu, c_kappa, epsilon)
    gains.diagonal(3 * len(robot.hands))
    check_scene(robot, scene)
    kinematics = Kinematics(robot, scene.obstacles)
    start = np.array(robot.initial if scene.initial is None else scene.initial, float)
    _check_start(kinematics, start)

    targets = np.array([scene.targets[name] for name in robot.hand_names])
    motion = _integrate(kinematics, METHODS[method], start, targets, gains, tolerance, max_time, rtol, atol)
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
        violations=limit_violations(robot, t, q),
        planning_time=time.perf_counter() - started,
        evaluations=motion.evaluations,
        joint_names=robot.joint_names,
        hand_names=robot.hand_names,
    )


def _integrate(
    kinematics: Kinematics,
    method: Method,
    start: Array,
    targets: Array,
    gains: Gains,
    tolerance: float,
    max_time: float,
    rtol: float,
    atol: float,
) -> _Motion:
    """Integrate q_dot from the start until |e| falls to the tolerance or nothing more can come of it."""
    K = gains.diagonal(targets.size)

    latest = kinematics.state(start)

    def state_at(q: Array) -> State:
        # The integrator's last evaluation in a step is at the step's end, where the checks below look again.
        nonlocal latest
        if not np.array_equal(latest.q, q):
            latest = kinematics.state(q)
        return latest

    def velocity(_t: float, q: Array) -> Array:
        return method(state_at(q), targets, gains)

    def distance(q: Array) -> float:
        return float(np.linalg.norm(kinematics.hand_positions(q) - targets))

    def still(_t: Array) -> Array:
        return start[None, :]

    if distance(start) <= tolerance:
        return _Motion(still, 0.0, Status.REACHED, f"the hands start within {tolerance:g} m of their targets", 0)

    solver = RK45(velocity, 0.0, start, max_time, rtol=rtol, atol=atol)
    times: list[float] = [0.0]
    steps: list[DenseOutput] = []

    def q_of_t(t: Array) -> Array:
        samples: Array = OdeSolution(times, steps)(t).T
        return samples

    def ended(status: Status, reason: str) -> _Motion:
        motion = q_of_t if steps else still
        return _Motion(motion, times[-1], status, reason, solver.nfev)

    singular_since = np.inf
    while True:
        message = solver.step()
        if solver.status == "failed":
            return ended(Status.STALLED, f"the integrator gave up at t = {times[-1]:.4g} s: {message}")
        step = solver.dense_output()
        times.append(solver.t)
        steps.append(step)
        left = distance(solver.y)
        if left <= tolerance:
            times[-1] = _time_of_arrival(step, distance, tolerance)
            return ended(Status.REACHED, f"|e| fell to {tolerance:g} m after {times[-1]:.4f} s")
        if _is_held_by_singularity(state_at(solver.y), targets, tolerance):
            singular_since = min(singular_since, solver.t)
        else:
            singular_since = np.inf
        exhausted = solver.nfev > MAX_EVALUATIONS
        if solver.t - singular_since > PATIENCE / K.min() or (exhausted and singular_since < np.inf):
            return ended(
                Status.SINGULAR,
                f"|e| is {left:.4g} m at t = {solver.t:.4g} s: an arm is stretched to a singularity that keeps "
                "its hand from the target, which may be out of reach",
            )
        if exhausted:
            return ended(
                Status.STALLED,
                f"|e| is {left:.4g} m at t = {solver.t:.4g} s after {solver.nfev} evaluations of q_dot, the most "
                "allowed: q_dot jumps back and forth where the nearest points of links and obstacles do",
            )
        if solver.status == "finished":
            return ended(Status.TIME_LIMIT, f"|e| is {left:.4g} m after the longest motion allowed, {max_time:g} s")


def _time_of_arrival(step: DenseOutput, distance: Callable[[Array], float], tolerance: float) -> float:
    """Return when in an integrator's step the distance falls to the tolerance."""

    def excess(t: float) -> float:
        return distance(step(t)) - tolerance

    # Interpolated, the end of the step may miss by rounding what the step itself reached.
    return float(brentq(excess, step.t_old, step.t, xtol=1e-12)) if excess(step.t) < 0 else float(step.t)


def _is_held_by_singularity(state: State, targets: Array, tolerance: float) -> bool:
    """Whether more than the tolerance of e lies in a direction that J has lost."""
    lost = lost_direction(state.jacobian)
    return lost is not None and abs(float(lost @ task_error(state, targets))) > tolerance


def _check_start(kinematics: Kinematics, start: Array) -> None:
    clearance = kinematics.measure(start).clearance
    if clearance.size and clearance.min() < 0:
        link, obstacle = np.unravel_index(clearance.argmin(), clearance.shape)
        raise InvalidInput(
            "initial",
            [round(float(x), 6) for x in start],
            f"a start clear of obstacles; {kinematics.robot.link_names[link]} is {-clearance.min():.4g} m "
            f"inside obstacles[{obstacle}]",
        )


def _sample_times(end: float, dt: float) -> Array:
    """Return 0, dt, 2 dt, ... and the end."""
    regular = dt * np.arange(int(np.floor(end / dt)) + 1)
    # A last multiple that is the end up to rounding would make an interval of no length.
    return np.append(regular[regular < end - 1e-9 * dt], end)
