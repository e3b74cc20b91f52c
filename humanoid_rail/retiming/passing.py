"""Retimed motions that pass targets without stopping, where the steps of their scene say so."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.errors import told_apart
from humanoid_rail.events import Event
from humanoid_rail.holding.phases import sampled_motion
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.kinematics.path_metric import path_length
from humanoid_rail.kinematics.task import Task
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.moves import WHY_REST, moves_of
from humanoid_rail.planning.target_tasks import tasks_of
from humanoid_rail.resampling import evaluate
from humanoid_rail.scene.scene import Scene
from humanoid_rail.timing.time_optimal import Limits
from humanoid_rail.timing.timed_motion import TimedMotion, along_path
from humanoid_rail.trajectory import Trajectory

LOOK, CLOSER = 1e-3, 40
"""The moment nearest to a target is looked for every so often, s, and in so many parts of twice that."""


class Retimed(NamedTuple):
    """A motion along a path."""

    motion: TimedMotion
    arrivals: tuple[float, ...]
    """When it is at each target, or nearest to it, s."""
    stopped: str
    """Why it rests at targets that were to be passed; empty if it does not."""
    events: tuple[Event, ...] = ()
    """What happens to objects along it."""
    ends: tuple[float, ...] = ()
    """When each of its moves ends, s; empty where that is not known."""


@dataclass(frozen=True, eq=False)
class _Target:
    """What is to be passed at the end of a segment."""

    segment: int
    tasks: Sequence[Task]
    solver: InverseKinematics


def along_segments(
    robot: Robot,
    scene: Scene,
    segments: Sequence[Array],
    trajectory: Trajectory,
    limits: Limits,
    dt: float,
    dwell: float,
    wanted: float,
) -> Retimed:
    """Return the motion that follows segments, at rest at the targets of all steps but those that it is to pass.

    It may cut the path's corner at these, within the method's tolerance. If it comes no nearer it rests there.

    Args:
        robot: The robot.
        scene: The scene, whose steps say where to rest.
        segments: Paths (K, n) to each target in turn and on from the last one that was reached, m and rad.
        trajectory: What is retimed.
        limits: What joints can do.
        dt: Time between samples, s.
        dwell: How long to rest, s.
        wanted: The bound of clearances that is wanted, m.
    """
    reached, tolerance = len(trajectory.arrivals), trajectory.method.tolerance
    moves = [move for move in moves_of(scene) if move.arrives][:reached]
    targets = []
    for number, move in enumerate(moves[: len(segments) - 1]):
        if move.passes:
            hands = robot.with_hands([name for name in robot.hand_names if move.targets.get(name) is not None])
            targets.append(_Target(number, tasks_of(hands, move.targets), InverseKinematics(hands, ())))
    stopped = WHY_REST if any(move.has_to_rest for move in moves[: len(scene.steps) - 1]) else ""
    if targets:
        groups = list(_groups(segments, {target.segment for target in targets}))
        paths = [np.vstack(group) for group in groups]

        def is_near(motion: TimedMotion) -> bool:
            return all(left <= tolerance for _, left in _passed(robot, motion, segments, targets).values())

        motion = along_path(robot, scene.obstacles, paths, limits, dt, dwell, wanted, is_near)
        passed = _passed(robot, motion, segments, targets)
        left = max(left for _, left in passed.values())
        if left <= tolerance and motion.bound >= wanted:
            rests = iter(motion.t[motion.ends])
            times = [passed[k][0] if k in passed else float(next(rests)) for k in range(len(segments))]
            return Retimed(motion, tuple(times[:reached]), stopped)
        why = "it would come too near to something"
        if left > tolerance:
            why = f"it would pass them {told_apart(left, tolerance)} m away, not within tolerance = {tolerance:g} m"
        stopped = f"{stopped}; {why}" if stopped else why
    motion = along_path(robot, scene.obstacles, segments, limits, dt, dwell, wanted)
    return Retimed(motion, tuple(float(motion.t[end]) for end in motion.ends[:reached]), stopped)


def _groups(segments: Sequence[Array], passed: set[int]) -> Iterator[list[Array]]:
    """Yield the segments from one rest to the next."""
    group = list[Array]()
    for number, segment in enumerate(segments):
        group.append(segment)
        if number not in passed:
            yield group
            group = []


def _passed(
    robot: Robot, motion: TimedMotion, segments: Sequence[Array], targets: Sequence[_Target]
) -> dict[int, tuple[float, float]]:
    """Return by segment when a motion is nearest to the target at its end, s, and the error that is left then, m."""
    spline = sampled_motion(robot, motion.t, motion.q, motion.velocity)
    t = np.append(np.arange(0.0, motion.duration, LOOK), motion.duration)
    q, _, _ = evaluate(spline, t)
    gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(q / robot.speed_units, axis=0), axis=1))])
    ends = np.cumsum([path_length(robot, segment) for segment in segments])
    # Each is looked for on the half of the way from and to its neighbours.
    halves = np.concatenate([[0.0], (ends[:-1] + ends[1:]) / 2.0])
    halves *= gone[-1] / ends[-1] if ends[-1] > 0.0 else 0.0
    from_to = np.minimum(np.searchsorted(gone, halves), len(t) - 1)
    found = {}
    for target in targets:
        first = int(from_to[target.segment])
        last = max(first + 1, int(from_to[target.segment + 1]))
        best = first + int(_errors(target, q[first:last]).argmin())
        close = np.linspace(t[max(best - 1, first)], t[min(best + 1, len(t) - 1)], CLOSER + 1)
        errors = _errors(target, evaluate(spline, close)[0])
        found[target.segment] = float(close[errors.argmin()]), float(errors.min())
    return found


def _errors(target: _Target, q: Array) -> Array:
    return np.array([float(np.linalg.norm(target.solver.evaluate(there, target.tasks)[0])) for there in q])
