"""Integrates q_dot from a start until the hands reach their targets, or cannot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import RK45, DenseOutput, OdeSolution
from scipy.optimize import brentq

from humanoid_rail.arrays import Array
from humanoid_rail.kinematics import Kinematics, State
from humanoid_rail.limits import Motion
from humanoid_rail.resolution import Gains, lost_direction, task_error
from humanoid_rail.trajectory import Status

Method = Callable[[State, Array, Gains], Array]
"""q_dot (n,) from a state, the targets (h, 3) and the gains."""

MAX_EVALUATIONS = 10_000
"""Evaluations of q_dot after which a motion is called stalled."""
PATIENCE = 0.25
"""How long a motion may stay at a singularity that keeps a hand from its target, in time constants 1 / min(K)."""


@dataclass(frozen=True, eq=False)
class Integration:
    """A motion q(t) and why it ended."""

    q_of_t: Callable[[Array], Array]
    """Configurations (N, n) at times (N,)."""
    end: float
    """T, s."""
    status: Status
    reason: str
    evaluations: int
    """Number of evaluations of q_dot."""
    visited: Motion
    """Where the integrator's steps begin, with q_dot there."""


def integrate(
    kinematics: Kinematics,
    method: Method,
    start: Array,
    targets: Array,
    gains: Gains,
    tolerance: float,
    max_time: float,
    rtol: float,
    atol: float,
) -> Integration:
    """Integrate q_dot from the start until |e| falls to the tolerance or nothing more can come of it.

    Args:
        kinematics: The robot among its obstacles.
        method: q_dot from a state, the targets and the gains.
        start: Configuration (n,) at t = 0.
        targets: x_f (h, 3), m.
        gains: Parameters of the method.
        tolerance: Norm of e that ends the motion, m.
        max_time: Longest motion, s.
        rtol: Relative tolerance of the integrator.
        atol: Absolute tolerance of the integrator, m and rad.
    """
    K = gains.diagonal(targets.size)
    latest = kinematics.state(start)

    def state_at(q: Array) -> State:
        # The integrator's last evaluation in a step is at the step's end, where the checks below look again.
        nonlocal latest
        if not np.array_equal(latest.q, q):
            latest = kinematics.state(q)
        return latest

    def velocity(_: float, q: Array) -> Array:
        return method(state_at(q), targets, gains)

    def distance(q: Array) -> float:
        return float(np.linalg.norm(kinematics.hand_positions(q) - targets))

    def still(_: Array) -> Array:
        return start[None, :]

    times: list[float] = [0.0]
    steps: list[DenseOutput] = []
    places, velocities = [start], [np.zeros(start.size)]

    def visited() -> Motion:
        return Motion(np.array(times[: len(places)]), np.array(places), np.array(velocities))

    if distance(start) <= tolerance:
        reason = f"the hands start within {tolerance:g} m of their targets"
        return Integration(still, 0.0, Status.REACHED, reason, 0, visited())

    solver = RK45(velocity, 0.0, start, max_time, rtol=rtol, atol=atol)
    velocities = [solver.f]

    def q_of_t(t: Array) -> Array:
        samples: Array = OdeSolution(times, steps)(t).T
        return samples

    def ended(status: Status, reason: str) -> Integration:
        motion = q_of_t if steps else still
        return Integration(motion, times[-1], status, reason, solver.nfev, visited())

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
        places.append(solver.y)
        velocities.append(solver.f)
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
                "allowed; often q_dot jumps to and fro because the nearest points of links and obstacles do",
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
