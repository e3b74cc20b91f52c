"""Integrates q_dot of eq. 4.9 from a start until the tasks are done, or cannot be.

The Python here is the reference, to be read; the native engine has the same in C++.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.joint_limits import JointMotion
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.kinematics.state import State
from humanoid_rail.kinematics.task import Task
from humanoid_rail.kinematics.task_stack import count_rows, stack_error, stack_jacobian
from humanoid_rail.resolution.remaining import what_remains
from humanoid_rail.resolution.velocity import Gains, gradient_projection, lost_direction, singular_value
from humanoid_rail.result import Status

if TYPE_CHECKING:
    from scipy.integrate import DenseOutput

MAX_EVALUATIONS = 10_000
"""After this many evaluations of q_dot a motion has stalled."""
SINGULAR_TIME = 0.25
"""A motion may stay at a singularity that keeps a hand from its target for this long, in time constants 1 / min(K)."""
HELD = 0.05
"""While a singularity holds a motion, the error in the lost direction does not fall by this share."""
ROUNDING = 1e-9
"""A last sample interval that is shorter than this share of dt is dropped."""


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
    """How long a rollout of the safe velocity may take before it is cut off, s."""
    max_time_of_all: float | None = None
    """Longest motion of all segments together, s; `max_time` if there is one segment."""
    max_planning_time_of_all: float | None = None
    """How long planning all segments may take, s; `max_planning_time` if there is one segment."""
    begun: float = 0.0
    """When the motion begins, as a segment of a longer one, s: times in reasons count from the start of that."""

    @property
    def time_option(self) -> str:
        """The option that limits the time of the motion, with its value."""
        return f"max_time = {self.max_time_of_all or self.max_time:g} s"

    def at(self, t: float) -> str:
        """Say when something is, after a time in s of this motion."""
        return f"t = {self.begun + t:.4g} s"

    @property
    def planning_time_option(self) -> str:
        """The option that limits the time of planning, with its value."""
        return f"max_planning_time = {self.max_planning_time_of_all or self.max_planning_time:g} s"


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
    visited: JointMotion
    """Where the integrator's steps begin, with q_dot there."""


def integrate(
    kinematics: Kinematics, start: Array, tasks: Sequence[Task], gains: Gains, settings: Settings
) -> Integration:
    """Integrate q_dot of eq. 4.9 from the start until |e| falls to the tolerance or nothing more can come of it.

    Args:
        kinematics: The robot among its obstacles.
        start: Configuration (n,) at t = 0.
        tasks: What is to be reached.
        gains: Parameters of eq. 4.9.
        settings: When to end, how to sample, how precise to be.
    """
    return _Integrator(kinematics, start, tasks, gains, settings).run()


@dataclass(frozen=True)
class SingularityWatch:
    """How long a singularity has held a motion: that is while the error in the lost direction hardly falls.

    Tasks whose rows depend on each other have lost a direction everywhere; there their error falls with the others'.
    """

    since: float = np.inf
    """When it began, s."""
    error: float = np.inf
    """The error then, m."""

    def at(self, t: float, lost: float, tolerance: float) -> SingularityWatch:
        """Return what is known at a time in s, when an error in m is in the lost direction."""
        if lost <= tolerance:
            return SingularityWatch()
        return SingularityWatch(t, lost) if lost < (1.0 - HELD) * self.error else self


class _Integrator:
    """One integration, step by step."""

    def __init__(
        self, kinematics: Kinematics, start: Array, tasks: Sequence[Task], gains: Gains, settings: Settings
    ) -> None:
        self._kinematics, self._tasks, self._gains, self._settings = kinematics, tasks, gains, settings
        self._latest = kinematics.state(start)
        self._times: list[float] = [0.0]
        self._steps: list[DenseOutput] = []
        self._places, self._velocities = [start], [np.zeros(start.size)]
        self._evaluations = 0

    def run(self) -> Integration:
        # Imported here: SciPy takes longer than the whole package, and the native engine needs none of it.
        from scipy.integrate import RK45

        settings, start = self._settings, self._places[0]
        left = self._distance(0.0, start)
        if left <= settings.tolerance:
            return self._ended(Status.REACHED, left)
        solver = RK45(self._velocity, 0.0, start, settings.max_time, rtol=settings.rtol, atol=settings.atol)
        self._velocities = [solver.f]
        patience = SINGULAR_TIME / self._gains.diagonal(count_rows(self._tasks)).min()
        singular = SingularityWatch()
        while True:
            message = solver.step()
            self._evaluations = solver.nfev
            if solver.status == "failed":
                return self._ended(Status.STALLED, left, message or "unknown")
            step = solver.dense_output()
            self._times.append(solver.t)
            self._steps.append(step)
            left = self._distance(solver.t, solver.y)
            if left <= settings.tolerance:
                self._times[-1] = _time_of_arrival(step, self._distance, settings.tolerance)
                return self._ended(Status.REACHED, left)
            self._places.append(solver.y)
            self._velocities.append(solver.f)
            lost = lost_error(self._state(solver.t, solver.y), self._tasks)
            singular = singular.at(solver.t, lost, settings.tolerance)
            exhausted = self._evaluations > MAX_EVALUATIONS
            if solver.t - singular.since > patience or (exhausted and lost > settings.tolerance):
                return self._ended(Status.SINGULAR, left)
            if exhausted:
                return self._ended(Status.STALLED, left)
            if solver.status == "finished":
                return self._ended(Status.TIME_LIMIT, left)

    def _state(self, t: float, q: Array) -> State:
        # The integrator's last evaluation in a step is at the step's end, where the checks look again.
        if t != self._latest.t or not np.array_equal(self._latest.q, q):
            self._latest = self._kinematics.state(q, t)
        return self._latest

    def _velocity(self, t: float, q: Array) -> Array:
        return gradient_projection(self._state(t, q), self._tasks, self._gains)

    def _distance(self, t: float, q: Array) -> float:
        return float(np.linalg.norm(stack_error(self._kinematics.state(q, t), self._tasks)))

    def _ended(self, status: Status, left: float, broken: str = "") -> Integration:
        from scipy.integrate import OdeSolution

        times, places, settings = self._times, self._places, self._settings
        t = sample_times(times[-1], settings.dt)
        q = OdeSolution(times, self._steps)(t).T if self._steps else places[0][None, :]
        remains = what_remains(self._kinematics.state(q[-1], times[-1]), self._tasks, left)
        reason = explain(status, times[-1], remains, self._evaluations, settings, broken)
        visited = JointMotion(np.array(times[: len(places)]), np.array(places), np.array(self._velocities))
        return Integration(t, q, status, reason, self._evaluations, visited)


def explain(status: Status, end: float, remains: str, evaluations: int, settings: Settings, broken: str = "") -> str:
    """Return a status in a sentence, with numbers.

    Args:
        status: What became of the targets.
        end: T, s.
        remains: What remains to be done there, in words.
        evaluations: Number of evaluations of q_dot.
        settings: Tolerance and longest motion.
        broken: Why the integrator could not go on, if that is how it ended.
    """
    where = f"{remains} at {settings.at(end)}"
    match status:
        case Status.REACHED if evaluations == 0:
            return f"the hands start within tolerance = {settings.tolerance:g} m of their targets"
        case Status.REACHED:
            return f"|e| fell to tolerance = {settings.tolerance:g} m after {end:.4f} s"
        case Status.TIME_LIMIT:
            return f"{remains} after the longest motion allowed, {settings.time_option}"
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
    return np.append(regular[regular < end - ROUNDING * min(dt, end)], end)


def _time_of_arrival(step: DenseOutput, distance: Callable[[float, Array], float], tolerance: float) -> float:
    """Return when in an integrator's step the distance falls to the tolerance."""
    from scipy.optimize import brentq

    def excess(t: float) -> float:
        return distance(t, step(t)) - tolerance

    # Interpolated, the end of the step may miss by rounding what the step itself reached.
    return float(brentq(excess, step.t_old, step.t, xtol=1e-12)) if excess(step.t) < 0 else float(step.t)


def lost_error(state: State, tasks: Sequence[Task]) -> float:
    """Return how much of e lies in a direction that J has lost, m; 0 if there is none."""
    lost = lost_direction(stack_jacobian(state, tasks), singular_value(state.robot))
    return 0.0 if lost is None else abs(float(lost @ stack_error(state, tasks)))
