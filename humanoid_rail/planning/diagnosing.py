"""Finds out why a plan failed: how near the robot can get, what blocks it there, and what would help.

Three cases are told apart. Where the targets are out of reach, the nearest miss is where the errors are smallest within
the joint limits. Where no configuration at the targets is clear of everything, it is the one at the smallest shift of
the targets that was found. Else there is no path: then it is the configuration nearest to the targets to which the
sampling planner has one, or where the local method ends.

All of it is bounded by numbers of calls and edge checks, so the same plan always has the same diagnosis. A limit on the
planning time cuts it off too.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from humanoid_rail._arrays import Array, triple
from humanoid_rail.diagnosis import HELPS, MISS, BlockingPair, Diagnosis, Miss, Remedy
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.kinematics.task import Task
from humanoid_rail.kinematics.task_stack import stack_error
from humanoid_rail.planning.blocking import blocking_on_edge, blocking_pairs
from humanoid_rail.planning.methods import Auto
from humanoid_rail.planning.options import PlanningMethod
from humanoid_rail.planning.probe import Probe, hands_with_targets, target_of
from humanoid_rail.planning.reach_miss import reach_miss
from humanoid_rail.planning.remedies import (
    PLANNED,
    USE_AUTO,
    by_auto,
    fewer_hands,
    more_checks,
    smaller_distance,
    targets_moved,
    turned_freely,
    without_obstacles,
)
from humanoid_rail.planning.segments import Unreached
from humanoid_rail.planning.target_shift import shifted_targets
from humanoid_rail.result import Status
from humanoid_rail.scene.obstacles import Obstacle, at_rest

MOST_PAIRS = 8
"""So many pairs are kept."""
MOST_REMEDIES = 4
"""So many remedies are looked for."""
BY_AUTO = " (auto finds a plan then)"
"""Of other methods it is said that it was `auto` that tried out what would help."""
CLEAR = ", which keeps the safety distance too"
"""This is said of how far targets are moved."""
UNTRIED = f"; {HELPS} is not looked for among obstacles that move"
"""A remedy is tried out by configurations at the targets that are clear of everything, and by paths to them. Among
moving obstacles a configuration is clear at its own time alone, and nothing searches for paths in time."""


def diagnose(unreached: Unreached, method: PlanningMethod, started: float) -> Diagnosis:
    """Return why a segment did not reach its targets.

    Args:
        unreached: The segment.
        method: What planned it.
        started: When planning began, on the clock of `time.perf_counter`, s.

    Raises:
        EngineMissing: If there is no native engine.
    """
    problem, motion = unreached.problem, unreached.planned.motion
    tasks, end = problem.tasks, motion.q[-1]
    deadline = started + getattr(method, "max_planning_time", np.inf)
    status = motion.status
    if not at_rest(problem.obstacles) or status in CUT_OFF or time.perf_counter() > deadline:
        t = float(motion.t[-1])
        pairs = blocking_pairs(problem.native, end, end, _near(method), t)
        return _diagnosis(unreached, end, "motion", pairs, (), [], 0)
    best = _best(unreached)
    probe = Probe(problem, method, [best, end, problem.q], deadline)
    if status is Status.TARGET_OUT_OF_REACH:
        found = reach_miss(probe, tasks)
        pairs = blocking_pairs(problem.native, found.q, found.q, probe.kept)
        return _diagnosis(unreached, found.q, "reach", pairs, found.limits, found.remedies, probe.solves)
    goal = None if status is Status.TARGET_IN_COLLISION else probe.posture(tasks)
    if goal is None:
        return _without_goal(unreached, probe, best)
    return _without_path(unreached, probe, best, goal, method)


def in_one_line(diagnosis: Diagnosis, method: PlanningMethod, obstacles: Sequence[Obstacle]) -> str:
    """Return what a reason says of a diagnosis; of the miss nothing where only the end of a motion was looked at.

    Args:
        diagnosis: Why a segment did not reach its targets.
        method: What planned it. Where it is another than `auto`, it is said that `auto` tried out what would help.
        obstacles: The obstacles of the scene. Where one moves, it is said that nothing was tried out.
    """
    untried = "" if at_rest(obstacles) else UNTRIED
    if diagnosis.found_by == "motion" and not diagnosis.blocking and not diagnosis.remedies:
        return untried
    at_once = " with all hands at once" if diagnosis.found_by == "reach" and len(diagnosis.misses) > 1 else ""
    said = f"; {MISS}{at_once}: {diagnosis.miss}" if diagnosis.miss else ""
    if not diagnosis.remedies:
        return said + untried
    remedy = diagnosis.remedies[0]
    by_another = not isinstance(method, Auto) and remedy.proven == PLANNED and remedy.what != USE_AUTO
    return f"{said}; {HELPS}: {remedy.what}{BY_AUTO if by_another else ''}"


CUT_OFF = (Status.PLANNING_TIMEOUT, Status.TIME_LIMIT, Status.OVERRUN, Status.UNCERTIFIED)
"""Motions of these are only looked at where they end."""


def _without_goal(unreached: Unreached, probe: Probe, best: Array) -> Diagnosis:
    """Return the diagnosis where no configuration at the targets is clear of everything."""
    problem, tasks = unreached.problem, unreached.problem.tasks
    found = shifted_targets(probe, tasks, [best, problem.q])
    q, by, remedies = best, "motion", list[Remedy | None]()
    if found is not None:
        moved, q = found
        by = "posture"
        remedies.append(targets_moved(probe, tasks, moved, CLEAR if probe.has_distance else ""))
    there = probe.solve(q, tasks, -np.inf)
    pairs = blocking_pairs(problem.native, q, there.q, probe.kept) if there.reached else ()
    remedies += [
        smaller_distance(probe, tasks, [q]),
        without_obstacles(probe, tasks, pairs),
        turned_freely(probe, tasks),
        fewer_hands(probe, tasks),
    ]
    return _diagnosis(unreached, q, by, pairs, (), remedies, probe.solves)


def _without_path(unreached: Unreached, probe: Probe, best: Array, goal: Array, method: PlanningMethod) -> Diagnosis:
    """Return the diagnosis where there is a configuration at the targets, but no path to it."""
    problem, tasks = unreached.problem, unreached.problem.tasks
    by = "motion" if np.array_equal(best, unreached.planned.motion.q[-1]) else "search"
    pairs = blocking_on_edge(problem.native, best, goal, probe.kept)
    remedies = [
        by_auto(probe, tasks, method),
        more_checks(probe, tasks, method),
        without_obstacles(probe, tasks, pairs),
        smaller_distance(probe, tasks, [goal]),
    ]
    return _diagnosis(unreached, best, by, pairs, (), remedies, probe.solves)


def _best(unreached: Unreached) -> Array:
    """Return the configuration (n,) nearest to the targets to which there is a path."""
    problem, explored = unreached.problem, unreached.planned.explored
    bare = NativeKinematics(problem.robot)
    known: list[Array] = [unreached.planned.motion.q[-1], *([] if explored is None else explored)]
    # Only the hands count here: what else tasks ask for is far slower to evaluate for so many.
    hands = hands_with_targets(problem.tasks)
    if not hands:
        return min(known, key=lambda q: float(np.linalg.norm(stack_error(bare.state(q), problem.tasks))))
    places = bare.along(np.array(known)).hands[:, [problem.robot.hand(hand) for hand in hands]]
    misses = np.linalg.norm(places - [target_of(problem.tasks, hand) for hand in hands], axis=(1, 2))
    return known[int(misses.argmin())]


def _diagnosis(
    unreached: Unreached,
    q: Array,
    found_by: str,
    pairs: Sequence[BlockingPair],
    limits: Sequence[str],
    remedies: Sequence[Remedy | None],
    solves: int,
) -> Diagnosis:
    problem = unreached.problem
    return Diagnosis(
        step=unreached.step,
        q=tuple(q.tolist()),
        found_by=found_by,
        misses=_misses(problem.native, problem.tasks, q),
        blocking=tuple(pairs[:MOST_PAIRS]),
        limits=tuple(limits),
        remedies=tuple([remedy for remedy in remedies if remedy is not None][:MOST_REMEDIES]),
        solves=solves,
    )


def _misses(kinematics: NativeKinematics, tasks: Sequence[Task], q: Array) -> tuple[Miss, ...]:
    hands = kinematics.measure(q, 0.0).hands
    return tuple(
        Miss(hand, triple(hands[kinematics.robot.hand(hand)]), target_of(tasks, hand))
        for hand in hands_with_targets(tasks)
    )


def _near(method: PlanningMethod) -> float:
    """Return the distance within which a pair is said to block where a motion ends, m."""
    return 2.0 * (method.kept_distance or 0.0)
