"""The segments of a motion: each leads from where the one before ended to the next targets."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array
from humanoid_rail.events import Event
from humanoid_rail.kinematics.joint_limits import JointMotion
from humanoid_rail.kinematics.path_metric import PathQuality, path_quality
from humanoid_rail.kinematics.task import ConfigurationTask
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.keeping import constraints_of
from humanoid_rail.planning.kept import Kept
from humanoid_rail.planning.move_constraints import move_constraints
from humanoid_rail.planning.moves import WHY_REST, Move
from humanoid_rail.planning.object_tasks import hands_in, object_tasks
from humanoid_rail.planning.options import Planned, PlanningMethod
from humanoid_rail.planning.said_of_end import said_of_end
from humanoid_rail.planning.stage import Stage, after_happenings
from humanoid_rail.planning.target_tasks import tasks_of
from humanoid_rail.problem import Problem
from humanoid_rail.resolution.integrate import Integration
from humanoid_rail.result import Optimisation, Search, Status
from humanoid_rail.scene.keep import kept_hands
from humanoid_rail.scene.obstacles import at_rest, moved
from humanoid_rail.scene.scene import Scene
from humanoid_rail.timing.timed_motion import TimedMotion


@dataclass(frozen=True, eq=False)
class Unreached:
    """A segment that did not reach its targets."""

    step: int
    """The step of targets that it was to reach, from 0."""
    problem: Problem
    planned: Planned


@dataclass(frozen=True, eq=False)
class Segments:
    """Segments, one after the other, as one motion."""

    motion: Integration
    found_by: str
    search: Search | None
    path: PathQuality
    arrivals: tuple[float, ...]
    """When each segment that reached its targets ends, s."""
    timed: tuple[TimedMotion, ...] | None = None
    """The segments with timings that a drive can follow; None unless each one has such a timing."""
    optimisation: Optimisation | None = None
    kept: tuple[Kept, ...] = ()
    """What holds along the segments."""
    unreached: Unreached | None = None
    """The segment at which planning ended; None if all targets are reached, or time was up before it."""
    events: tuple[Event, ...] = ()
    """What happens to objects."""
    ends: tuple[float, ...] = ()
    """When each move ends, s."""
    said: tuple[str, ...] = ()
    """Which alternatives were taken, and how far hands are from targets that have a tolerance."""


def plan_segments(
    robot: Robot, scene: Scene, method: PlanningMethod, first: Problem, moves: Sequence[Move], stage: Stage
) -> Segments:
    """Plan move after move until one does not reach its targets; moves that pass their targets become one motion.

    Args:
        robot: The robot, with all its hands and without objects.
        scene: The scene.
        method: What plans each segment.
        first: The problem of the first move.
        moves: The moves of the scene.
        stage: What is true of its objects when the first one begins.
    """
    started = time.perf_counter()
    planned, problems, begun, start = list[Planned](), list[Problem](), 0.0, first.q
    unreached: Unreached | None = None
    taken: dict[int, int] = {}
    for number, one in enumerate(moves):
        # All moves of a step go to the same alternatives.
        move = replace(one, targets=one.choices[taken[one.step]], choices=()) if one.step in taken else one
        if begun >= method.max_time:
            reason = f"the longest motion allowed, max_time = {method.max_time:g} s, is over"
            planned.append(Planned(_standstill(start, Status.TIME_LIMIT, reason), ""))
            break
        if number > 0:
            stage = after_happenings(stage, robot, scene, move, move.begins, begun, start)
        problem = first if number == 0 else move_problem(robot, scene, move, stage, start, begun)
        spent = time.perf_counter() - started
        found = _for_its_hands(method, robot, problem).plan(problem, number, spent, begun)
        planned.append(replace(found, constraints=tuple(problem.constraints)))
        if move.choices:
            taken[move.step] = found.taken
        problem = problem.taking(found.taken)
        problems.append(problem)
        if planned[-1].motion.status is not Status.REACHED:
            unreached = Unreached(move.step, problem, planned[-1])
            break
        begun += float(planned[-1].motion.t[-1])
        if number > 0 and moves[number - 1].passes and not move.passes:
            group = slice(_first_of_group(moves, number), None)
            planned[group] = method.passing(planned[group], problems[group], time.perf_counter() - started)
            begun = sum(float(one.motion.t[-1]) for one in planned)
        start = planned[-1].motion.q[-1]
        stage = after_happenings(stage, robot, scene, move, move.ends, begun, start)
    ends = [(moves[i], problem, planned[i]) for i, problem in enumerate(problems)]
    said = tuple(text for move, problem, one in ends for text in said_of_end(move, problem, one, taken))
    return replace(joined(robot, planned, moves), unreached=unreached, events=stage.events, said=said)


def _first_of_group(moves: Sequence[Move], last: int) -> int:
    """Return the number of the first move of those that are made without a rest up to the end of another one."""
    first = last
    while first > 0 and moves[first - 1].passes:
        first -= 1
    return first


def move_problem(robot: Robot, scene: Scene, move: Move, stage: Stage, start: ArrayLike, begun: float = 0.0) -> Problem:
    """Return the problem of a move that begins at a time in s, for the hands alone that have targets.

    The objects of the scene are links of its robot.
    """
    whole, obstacles = stage.robot(robot, scene)
    if begun > 0 and not at_rest(obstacles):
        obstacles = tuple(moved(obstacle, begun) for obstacle in obstacles)
    there = scene if obstacles is scene.obstacles else scene.model_copy(update={"obstacles": obstacles})
    q, keep = np.asarray(start, float), move.targets.keep
    constraints = (*constraints_of(robot, keep, q), *move_constraints(robot, move, stage.holding, q))
    aimed = whole.with_hands([name for name in robot.hand_names if move.targets.get(name) is not None])
    tasks = (*tasks_of(aimed, move.targets), *object_tasks(whole, move.targets, stage.holding))
    needed = {hand for task in (*tasks, *constraints) for hand in hands_in(task)}
    # Where joints alone have to be somewhere, the motion is planned with all hands.
    hands = whole.with_hands([*aimed.hand_names, *needed, *kept_hands(keep)] or robot.hand_names)
    choices = [(*tasks_of(aimed, targets), *object_tasks(whole, targets, stage.holding)) for targets in move.choices]
    return Problem(hands, there, tasks, start, constraints, choices)


def _for_its_hands(method: PlanningMethod, robot: Robot, problem: Problem) -> PlanningMethod:
    """Return the method with the gains of the hands alone that have targets, if it has one for each coordinate."""
    gain = np.ravel(np.asarray(method.gains.gain, float))
    has_joints = any(isinstance(task, ConfigurationTask) for task in problem.tasks)
    if gain.size == 1 or (problem.robot is robot and not has_joints):
        return method
    names = [
        name for name in problem.robot.hand_names if any(getattr(task, "hand", "") == name for task in problem.tasks)
    ]
    rows = [3 * robot.hand_names.index(name) + axis for name in names for axis in range(3)]
    # Joints that have to be somewhere get there as fast as the fastest coordinate.
    others = sum(task.rows for task in problem.tasks if isinstance(task, ConfigurationTask))
    return replace(method, gain=(*gain[rows], *[gain.max()] * others))  # type: ignore[type-var]


def arrival(times: Sequence[float]) -> str:
    """Return the reason of a motion that reaches the targets of each step, at times in s."""
    return f"at the targets at t = {', '.join(f'{t:.4g}' for t in times)} s"


def _standstill(q: Array, status: Status, reason: str) -> Integration:
    visited = JointMotion(np.zeros(1), q[None, :], np.zeros((1, q.size)))
    return Integration(np.zeros(1), q[None, :], status, reason, 0, visited)


def joined(robot: Robot, planned: Sequence[Planned], moves: Sequence[Move] = ()) -> Segments:
    """Return segments as one motion, of the moves that there should be; of one segment if none are given."""
    motions = [segment.motion for segment in planned]
    ends = np.cumsum([motion.t[-1] for motion in motions]).tolist()
    return Segments(
        motion=motions[0] if len(moves) <= 1 else _joined_motion(motions, ends, moves),
        found_by=", ".join(dict.fromkeys(segment.found_by for segment in planned if segment.found_by)),
        path=path_quality(robot, *(motion.q for motion in motions)),
        search=_joined_search([segment.search for segment in planned if segment.search is not None]),
        arrivals=_arrivals(motions, ends, moves),
        timed=_timed(planned),
        ends=() if all(move.arrives for move in moves) else tuple(ends),
        optimisation=_joined_optimisation(planned, moves),
        kept=tuple(
            Kept(segment.constraints, begin, end)
            for segment, begin, end in zip(planned, [0.0, *ends[:-1]], ends, strict=True)
            if segment.constraints
        ),
    )


def _arrivals(motions: Sequence[Integration], ends: Sequence[float], moves: Sequence[Move]) -> tuple[float, ...]:
    """Return when the targets of each step are reached, s."""
    arrives = [move.arrives for move in moves[: len(motions)]] or [True]
    reached = [motion.status is Status.REACHED for motion in motions]
    return tuple(end for end, there, arrived in zip(ends, arrives, reached, strict=True) if there and arrived)


def _timed(planned: Sequence[Planned]) -> tuple[TimedMotion, ...] | None:
    timed = tuple(segment.timed for segment in planned if segment.timed is not None)
    return timed if len(timed) == len(planned) else None


def _joined_optimisation(planned: Sequence[Planned], moves: Sequence[Move]) -> Optimisation | None:
    """Return what is said of the optimisation of several segments as one."""
    done = [segment.optimisation for segment in planned if segment.optimisation is not None]
    if not done:
        return None
    reasons = [one.reason for one in done if one.reason]
    if not reasons and _timed(planned) is None:
        reasons = ["the last targets are not reached"]
    stopped = [one.stopped for one in done if one.stopped]
    if _timed(planned) is not None and any(move.has_to_rest for move in moves[:-1]):
        stopped.append(WHY_REST)
    return Optimisation(
        steps=sum(one.steps for one in done),
        optimised=sum(one.optimised for one in done),
        reason="; ".join(dict.fromkeys(reasons)),
        passed=sum(one.passed for one in done),
        stopped="; ".join(dict.fromkeys(stopped)),
    )


def _joined_motion(motions: Sequence[Integration], ends: Sequence[float], moves: Sequence[Move]) -> Integration:
    """Return motions that end at times in s as one."""
    last, begins = motions[-1], [0.0, *ends[:-1]]
    if len(motions) == len(moves) and last.status is Status.REACHED:
        reason = arrival(_arrivals(motions, ends, moves))
    else:
        reason = f"{moves[len(motions) - 1].said}, begun at t = {begins[-1]:.4g} s: {last.reason}"
    visits = [motion.visited for motion in motions]
    return Integration(
        # Where a segment begins is where the one before ended.
        t=np.concatenate([motion.t[k > 0 :] + begins[k] for k, motion in enumerate(motions)]),
        q=np.vstack([motion.q[k > 0 :] for k, motion in enumerate(motions)]),
        status=last.status,
        reason=reason,
        evaluations=sum(motion.evaluations for motion in motions),
        visited=JointMotion(
            np.concatenate([visit.t + begin for visit, begin in zip(visits, begins, strict=True)]),
            np.vstack([visit.q for visit in visits]),
            np.vstack([visit.velocity for visit in visits]),
        ),
    )


def _joined_search(searches: Sequence[Search]) -> Search | None:
    """Return several searches as one."""
    if not searches:
        return None
    raws = [search.raw for search in searches if search.raw is not None]
    # Lengths are comparable if they are of all segments.
    complete = len(raws) == len(searches)
    return Search(
        seed=searches[0].seed,
        goals=sum(search.goals for search in searches),
        searches=sum(search.searches for search in searches),
        checks=sum(search.checks for search in searches),
        raw=PathQuality(sum(raw.length for raw in raws), max(raw.sharpest_turn for raw in raws)) if complete else None,
    )
