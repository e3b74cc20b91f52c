"""How far a motion leaves constraints, bounded at all times, including between its samples.

On a piece of a motion of duration T, a twice differentiable h is no farther from its chord than max |h''| T^2 / 8, so

    |h(t)| <= max(|h(0)|, |h(T)|) + max |h''| T^2 / 8.

h is what a constraint keeps at 0: the vector from where a point has to be, the difference of a distance, of unit
vectors, or the vector part of a quaternion. |h''| follows from bounds on the motion of the hands (`hand_bounds.py`),
which hold on the whole piece; nothing is sampled. Pieces are halved until the bounds are as near to the largest
deviation found as they have to be.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from humanoid_rail._arrays import Array
from humanoid_rail._native import why_no_engine
from humanoid_rail.kinematics.cubic import hermite
from humanoid_rail.kinematics.deviation import Deviation, name_of
from humanoid_rail.kinematics.hand_bounds import HandBounds, HandMotion, Rates
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.kinematics.kept_tasks import AxisTask, DistanceTask, LineTask, OrientationTask
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.kinematics.task import ConfigurationTask, DirectionTask, PointTask, RelativeTask, Task
from humanoid_rail.kinematics.task_stack import stack_error
from humanoid_rail.model.robot import Robot

RESOLUTION = 1e-5
"""Bounds are at most this much larger than the largest deviation that was found, m or rad, ..."""
MAX_HALVINGS = 14
"""... unless pieces were halved this often."""

Errors = Callable[[Array], Array]
"""The errors (N, m) of all tasks, one after the other, at configurations (N, n)."""
Places = NDArray[np.int_]


def deviations(
    robot: Robot, tasks: Sequence[Task], t: Array, q: Array, velocity: Array | None = None
) -> tuple[Deviation, ...]:
    """Return how far a motion leaves each of some constraints at the most.

    Args:
        robot: The robot.
        tasks: The constraints, each one of `KEPT_TASKS`.
        t: Times (N,), s.
        q: Configurations (N, n), m and rad.
        velocity: Velocities (N, n) of the cubic spline that the motion is; without them it is linear in q between its
            samples.
    """
    if not tasks:
        return ()
    errors, motion = _errors(robot, tasks), _Motion(robot, t, q, velocity)
    rows = np.cumsum([0, *(task.rows for task in tasks)]).tolist()
    kept = [_Kept(robot, task, motion.bounds, a, b) for task, a, b in zip(tasks, rows[:-1], rows[1:], strict=True)]
    there = errors(q)
    found = np.array([one.size(there).max() for one in kept])
    proven = [(-np.inf, float(t[0]))] * len(tasks)
    intervals = max(1, len(t) - 1)
    pieces = _Pieces(
        np.arange(intervals), np.zeros(intervals), np.ones(intervals), there[:intervals], there[-intervals:]
    )
    for halving in range(MAX_HALVINGS + 1):
        rates, duration = motion.rates(pieces)
        bounds = np.column_stack([one.bound(rates, duration, pieces.before, pieces.after) for one in kept])
        is_open = np.any(bounds > found + RESOLUTION, axis=1) & np.bool_(halving < MAX_HALVINGS)
        closed = np.flatnonzero(~is_open)
        for i, column in enumerate(bounds[closed].T):
            if column.size and column.max() > proven[i][0]:
                proven[i] = float(column.max()), motion.time(pieces, int(closed[column.argmax()]))
        if not is_open.any():
            break
        pieces, middle = motion.halved(pieces, is_open, errors)
        found = np.maximum(found, [one.size(middle).max() for one in kept])
    return tuple(
        Deviation(name_of(task), one.unit, one.amount(largest), when, float(t[0]), float(t[-1]), task)
        for task, one, (largest, when) in zip(tasks, kept, proven, strict=True)
    )


def _errors(robot: Robot, tasks: Sequence[Task]) -> Errors:
    """Return what computes the errors of tasks."""
    if why_no_engine():
        kinematics = Kinematics(robot)
        return lambda q: np.array([stack_error(kinematics.state(row), tasks) for row in q])
    solver = InverseKinematics(robot, ())
    return lambda q: solver.errors(q, tasks)


class _Pieces(NamedTuple):
    """Pieces of a motion, with the errors of all tasks at their ends."""

    sample: Places
    """The sample (P,) before each."""
    begin: Array
    """Shares (P,) of the interval to the next sample where each begins, ..."""
    end: Array
    """... and where it ends."""
    before: Array
    """(P, m)"""
    after: Array


class _Motion:
    """A motion that is linear or a cubic spline between its samples."""

    def __init__(self, robot: Robot, t: Array, q: Array, velocity: Array | None) -> None:
        self.bounds = HandBounds(robot)
        self._coupling, self._offset = np.asarray(robot.coupling), robot.full_configuration(np.zeros(robot.n))
        if len(t) == 1:
            t, q = np.append(t, t[0] + 1.0), np.vstack([q, q])
            velocity = None if velocity is None else np.zeros_like(q)
        self._t, self._q, self._velocity = t, q, velocity

    def time(self, pieces: _Pieces, k: int) -> float:
        """Return when the middle of a piece is, s."""
        i, share = int(pieces.sample[k]), (pieces.begin[k] + pieces.end[k]) / 2.0
        return float(self._t[i] + share * (self._t[i + 1] - self._t[i]))

    def _at(self, sample: Places, share: Array) -> tuple[Array, Array, Array]:
        h = (self._t[sample + 1] - self._t[sample])[:, None]
        u = share[:, None]
        ends = self._q[sample], self._q[sample + 1]
        if self._velocity is None:
            return ends[0] + u * (ends[1] - ends[0]), (ends[1] - ends[0]) / h, np.zeros_like(ends[0])
        return hermite(*ends, self._velocity[sample], self._velocity[sample + 1], h, u)

    def rates(self, pieces: _Pieces) -> tuple[Rates, Array]:
        """Return what is known of all joints on pieces, and how long these are (P,), s."""
        here, there = self._at(pieces.sample, pieces.begin), self._at(pieces.sample, pieces.end)
        duration = (pieces.end - pieces.begin) * (self._t[pieces.sample + 1] - self._t[pieces.sample])
        # The velocity is a quadratic polynomial, the acceleration linear.
        middle = here[1] + duration[:, None] / 2.0 * here[2]
        S = self._coupling.T
        velocity = np.stack([here[1] @ S, middle @ S, there[1] @ S], axis=1)
        acceleration = np.stack([here[2] @ S, there[2] @ S], axis=1)
        ends = np.maximum(abs(here[0] @ S + self._offset), abs(there[0] @ S + self._offset))
        return Rates(
            velocity, acceleration, ends + abs(acceleration).max(axis=1) * duration[:, None] ** 2 / 8.0
        ), duration

    def halved(self, pieces: _Pieces, chosen: NDArray[np.bool_], errors: Errors) -> tuple[_Pieces, Array]:
        """Return both halves of those pieces that are chosen (P,), and the errors in their middles."""
        sample = pieces.sample[chosen]
        begin, end = pieces.begin[chosen], pieces.end[chosen]
        half = (begin + end) / 2.0
        middle = errors(self._at(sample, half)[0])
        halves = _Pieces(
            np.concatenate([sample, sample]),
            np.concatenate([begin, half]),
            np.concatenate([half, end]),
            np.vstack([pieces.before[chosen], middle]),
            np.vstack([middle, pieces.after[chosen]]),
        )
        return halves, middle


class _Kept:
    """A constraint: the size of its h, and the bounds on that."""

    def __init__(self, robot: Robot, task: Task, bounds: HandBounds, begin: int, end: int) -> None:
        self._robot, self._task, self._bounds, self._rows = robot, task, bounds, slice(begin, end)
        self.unit = "rad" if isinstance(task, AxisTask | DirectionTask | OrientationTask) else "m"
        if isinstance(task, ConfigurationTask):
            self._columns = task.columns(robot)
            model = robot.model
            names = [model.joints[model.getJointId(name)].shortname() for name in task.joints]
            self.unit = "m" if all("P" in name for name in names) else "rad"

    def size(self, error: Array) -> Array:
        """Return |h| (P,) at errors (P, m) of all tasks."""
        norm: Array = np.linalg.norm(error[:, self._rows], axis=1)
        match self._task:
            case AxisTask() as task:  # e is 2 lever tan(angle / 2), h the difference of unit vectors
                half: Array = np.arctan(norm / (2.0 * task.lever_of(self._robot)))
                return 2.0 * np.sin(half)
            case DirectionTask() | OrientationTask() as task:
                return norm / task.lever_of(self._robot)
        return norm

    def amount(self, size: float) -> float:
        """Return the deviation in m or rad of a size of h."""
        return (
            2.0 * float(np.arcsin(min(size / 2.0, 1.0)))
            if self.unit == "rad" and not isinstance(self._task, ConfigurationTask)
            else size
        )

    def bound(self, rates: Rates, duration: Array, before: Array, after: Array) -> Array:
        """Return bounds on |h| (P,) on pieces, from all errors (P, m) at their ends."""
        second = self._second(rates, duration, before, after)
        bound: Array = np.maximum(self.size(before), self.size(after)) + second * duration**2 / 8.0
        return bound

    def _of(self, hand: str, rates: Rates, offset: object = 0.0, origin: int = 0) -> HandMotion:
        found = self._bounds.motion(self._robot.hand(hand), rates, origin)
        return found.of_point(float(np.linalg.norm(np.asarray(offset, float))))

    def _second(self, rates: Rates, duration: Array, before: Array, after: Array) -> Array:
        """Return bounds on |h''| (P,)."""
        match self._task:
            case PointTask() | LineTask() as task:
                return self._of(task.hand, rates, task.offset).acceleration
            case AxisTask() | DirectionTask() as task:
                hand = self._of(task.hand, rates)
                bound: Array = hand.twist + hand.turn**2
                return bound
            case OrientationTask() as task:
                turn, twist = self._turning(task, rates)
                return twist + turn**2 / 2.0
            case RelativeTask() | DistanceTask() as task:
                return self._of_two(task, rates, duration, before, after)
        # |q''| of the joints of a ConfigurationTask.
        largest = abs(rates.acceleration[..., self._joints()]).max(axis=1)
        norm: Array = np.linalg.norm(largest, axis=1)
        return norm

    def _joints(self) -> list[int]:
        model = self._robot.model
        assert isinstance(self._task, ConfigurationTask)
        return [model.joints[model.getJointId(name)].idx_v for name in self._task.joints]

    def _turning(self, task: OrientationTask, rates: Rates) -> tuple[Array, Array]:
        if task.reference is None:
            hand = self._of(task.hand, rates)
            return hand.turn, hand.twist
        first, second = self._robot.hand(task.reference), self._robot.hand(task.hand)
        origin = self._bounds.common(first, second)
        before, hand = self._bounds.motion(first, rates, origin), self._bounds.motion(second, rates, origin)
        return hand.turn + before.turn, hand.twist + before.twist + before.turn * hand.turn

    def _of_two(
        self, task: RelativeTask | DistanceTask, rates: Rates, duration: Array, before: Array, after: Array
    ) -> Array:
        one, other = self._robot.hand(task.first), self._robot.hand(task.second)
        is_base = isinstance(task, RelativeTask) and not task.in_first
        # What two hands are to each other does not change with what carries both.
        origin = 0 if is_base else self._bounds.common(one, other)
        first, second = self._bounds.motion(one, rates, origin), self._bounds.motion(other, rates, origin)
        speed, acceleration = first.speed + second.speed, first.acceleration + second.acceleration
        if isinstance(task, DistanceTask):
            ends = np.minimum(before[:, self._rows], after[:, self._rows])[:, 0] + task.distance
            least = ends - speed * duration / 2.0
            ratio = np.divide(speed**2, least, out=np.full_like(speed, np.inf), where=least > 0.0)
            acceleration = acceleration + np.where(speed > 0.0, ratio, 0.0)
        if not isinstance(task, RelativeTask) or not task.in_first:
            return acceleration
        ends = np.maximum(self.size(before), self.size(after)) + np.linalg.norm(task.difference)
        apart = ends + speed * duration / 2.0
        bound: Array = acceleration + (first.twist + first.turn**2) * apart + 2.0 * first.turn * speed
        return bound
