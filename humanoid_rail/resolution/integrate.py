"""Integrates q_dot from a start until the hands reach their targets, or cannot.

This is the reference; `native.py` has the same in C++.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import RK45, DenseOutput, OdeSolution
from scipy.optimize import brentq

from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.kinematics import Kinematics, State
from humanoid_rail.kinematics.joint_limits import Motion
from humanoid_rail.resolution.velocity import Gains, gradient_projection, lost_direction, task_error
from humanoid_rail.trajectory import Status

MAX_EVALUATIONS = 10_000
"""Evaluations of q_dot after which a motion is called stalled."""
PATIENCE = 0.25
"""How long a motion may stay at a singularity that keeps a hand from its target, in time constants 1 / min(K)."""


@dataclass(frozen=True)
class Settings:
    """When a motion ends, how it is sampled and how precisely it is integrated."""

    tolerance: float
    """Norm of e that ends the motion, m."""
    dt: float
    """Time between samples, s."""
    max_time: float
    """Longest motion, s."""
    rtol: float
    """Relative tolerance of the integrator."""
    atol: float
    """Absolute tolerance of the integrator, m and rad."""
    max_planning_time: float = np.inf
    """How long a rollout of the safe velocity may take, s."""


@dataclass(frozen=True, eq=False)
class Integration:
    """A sampled motion and why it ended."""

    t: Array
    """Times (N,): 0, dt, 2 dt, ... and the end, s."""
    q: Array
    """Configurations (N, n), m and rad."""
    status: Status
    reason: str
    evaluations: int
    """Number of evaluations of q_dot."""
    visited: Motion
    """Where the integrator's steps begin, with q_dot there."""


def integrate(kinematics: Kinematics, start: Array, targets: Array, gains: Gains, settings: Settings) -> Integration:
    """Integrate q_dot of eq. 4.9 from the start until |e| falls to the tolerance or nothing more can come of it.

    Args:
        kinematics: The robot among its obstacles.
        start: Configuration (n,) at t = 0.
        targets: x_f (h, 3), m.
        gains: Parameters of eq. 4.9.
        settings: When to end, how to sample, how precise to be.
    """
    K = gains.diagonal(targets.size)
    latest, latest_t = kinematics.state(start), 0.0

    def state_at(t: float, q: Array) -> State:
        # The integrator's last evaluation in a step is at the step's end, where the checks below look again.
        nonlocal latest, latest_t
        if t != latest_t or not np.array_equal(latest.q, q):
            latest, latest_t = kinematics.state(q, t), t
        return latest

    def velocity(t: float, q: Array) -> Array:
        return gradient_projection(state_at(t, q), targets, gains)

    def distance(q: Array) -> float:
        return float(np.linalg.norm(kinematics.hand_positions(q) - targets))

    times: list[float] = [0.0]
    steps: list[DenseOutput] = []
    places, velocities = [start], [np.zeros(start.size)]
    evaluations = 0

    def ended(status: Status, left: float, broken: str = "") -> Integration:
        t = sample_times(times[-1], settings.dt)
        q = OdeSolution(times, steps)(t).T if steps else start[None, :]
        reason = explain(status, times[-1], left, evaluations, settings, broken)
        visited = Motion(np.array(times[: len(places)]), np.array(places), np.array(velocities))
        return Integration(t, q, status, reason, evaluations, visited)

    left = distance(start)
    if left <= settings.tolerance:
        return ended(Status.REACHED, left)

    solver = RK45(velocity, 0.0, start, settings.max_time, rtol=settings.rtol, atol=settings.atol)
    velocities = [solver.f]
    singular_since = np.inf
    while True:
        message = solver.step()
        evaluations = solver.nfev
        if solver.status == "failed":
            return ended(Status.STALLED, left, message or "unknown")
        step = solver.dense_output()
        times.append(solver.t)
        steps.append(step)
        left = distance(solver.y)
        if left <= settings.tolerance:
            times[-1] = _time_of_arrival(step, distance, settings.tolerance)
            return ended(Status.REACHED, left)
        places.append(solver.y)
        velocities.append(solver.f)
        held = is_held_by_singularity(state_at(solver.t, solver.y), targets, settings.tolerance)
        singular_since = min(singular_since, solver.t) if held else np.inf
        exhausted = evaluations > MAX_EVALUATIONS
        if solver.t - singular_since > PATIENCE / K.min() or (exhausted and held):
            return ended(Status.SINGULAR, left)
        if exhausted:
            return ended(Status.STALLED, left)
        if solver.status == "finished":
            return ended(Status.TIME_LIMIT, left)


def explain(status: Status, end: float, left: float, evaluations: int, settings: Settings, broken: str = "") -> str:
    """Return a status in a sentence, with numbers.

    Args:
        status: What became of the targets.
        end: T, s.
        left: |e| there, m.
        evaluations: Number of evaluations of q_dot.
        settings: Tolerance and longest motion.
        broken: Why the integrator could not go on, if that is how it ended.
    """
    where = f"|e| is {left:.4g} m at t = {end:.4g} s"
    match status:
        case Status.REACHED if evaluations == 0:
            return f"the hands start within {settings.tolerance:g} m of their targets"
        case Status.REACHED:
            return f"|e| fell to {settings.tolerance:g} m after {end:.4f} s"
        case Status.TIME_LIMIT:
            return f"|e| is {left:.4g} m after the longest motion allowed, {settings.max_time:g} s"
        case Status.SINGULAR:
            return (
                f"{where}: an arm is stretched to a singularity that keeps its hand from the target, "
                "which may be out of reach"
            )
        case Status.STALLED if broken:
            return f"{where}, where the integrator gave up: {broken}"
        case Status.STALLED:
            return (
                f"{where} after {evaluations} evaluations of q_dot, the most allowed; often q_dot jumps to and fro "
                "because the nearest points of links and obstacles do"
            )
    raise ValueError(f"no motion by eq. 4.9 ends as {status}")


def sample_times(end: float, dt: float) -> Array:
    """Return 0, dt, 2 dt, ... and the end, s."""
    regular = dt * np.arange(int(np.floor(end / dt)) + 1)
    # A last multiple that is the end up to rounding would make an interval of no length.
    return np.append(regular[regular < end - 1e-9 * min(dt, end)], end)


def _time_of_arrival(step: DenseOutput, distance: Callable[[Array], float], tolerance: float) -> float:
    """Return when in an integrator's step the distance falls to the tolerance."""

    def excess(t: float) -> float:
        return distance(step(t)) - tolerance

    # Interpolated, the end of the step may miss by rounding what the step itself reached.
    return float(brentq(excess, step.t_old, step.t, xtol=1e-12)) if excess(step.t) < 0 else float(step.t)


def is_held_by_singularity(state: State, targets: Array, tolerance: float) -> bool:
    """Whether more than the tolerance of e lies in a direction that J has lost."""
    lost = lost_direction(state.jacobian)
    return lost is not None and abs(float(lost @ task_error(state, targets))) > tolerance
