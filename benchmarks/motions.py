"""Judges motions by whatever planner, and counts per family of scenes what came of them and how long they take."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from benchmarks.evaluation import ALL, BEYOND
from humanoid_rail._arrays import Array
from humanoid_rail.collision.certifier import certify
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.methods import Auto
from humanoid_rail.scene.scene import Scene, target_points

MILLISECOND = 1e-3
QUICK = "quick"
"""This package without optimisation, retimed."""
OPTIMISED = "optimised"
"""This package's `Auto()`."""
BEFORE = "before"
"""The package in the other checkout, retimed."""
ROBOPLAN = "roboplan"
DRAKE_STRAIGHT = "drake, straight seed"
DRAKE_SEEDED = "drake, quick as seed"
DRAKE = (DRAKE_STRAIGHT, DRAKE_SEEDED)
"""Those that begin with a motion of `quick`, and end where it ends."""
EVERY = (QUICK, OPTIMISED, BEFORE, ROBOPLAN, *DRAKE)
"""All methods."""


@dataclass(frozen=True)
class Outcome:
    """What came of one scene by one method."""

    scene: str
    family: str
    seed: int
    method: str
    reason: str
    """What the method says of it."""
    planning_time: float
    """Processor time until there is a path, or what the method has instead, s."""
    total_time: float
    """Processor time until there is a motion with a timing, s; that of planning where there is none."""
    reached: bool = False
    """Whether there is a motion, and the hands are at their targets at its end."""
    certified: bool = False
    """Whether the motion is proven free of contact, as the cubic spline through its samples."""
    touched: bool = False
    """Whether there is a contact."""
    excess: float = 0.0
    """By how much the motion exceeds a limit at the most: of positions in m and rad, of velocities and accelerations as
    a share of the limit; 0 if it keeps to them."""
    duration: float | None = None
    """T, s; None without a motion."""
    bound: float | None = None
    """No motion from rest to rest between the same configurations takes less, s."""

    @property
    def good(self) -> bool:
        """Whether the hands are at their targets and the motion is proven free of contact."""
        return self.reached and self.certified


@dataclass(frozen=True)
class Row:
    """What came of the motions of one family by one method.

    A ratio is of medians, or the median of the ratios scene by scene; it is None where there is nothing to compare.
    Motions are those that reach their targets certified, by both methods where two are compared.
    """

    family: str
    method: str
    motions: int
    reached: int
    certified: int
    touched: int
    beyond_limits: int
    """Motions that exceed a limit by more than 1e-6."""
    median_time: float
    """Of planning, s."""
    p95_time: float
    """95th percentile, s."""
    median_to_before: float | None
    by_scene_to_before: float | None
    p95_to_before: float | None
    total_time: float
    """Median until there is a motion with a timing, s."""
    duration: float | None
    """Median, s."""
    to_bound: float | None
    """Median of the ratios."""
    duration_to_before: float | None
    duration_by_scene: float | None
    longest_to_before: float | None
    """The largest of the ratios."""
    to_drake: float | None
    """Median of the ratios to Drake's motion from this package's plan."""


def judge(robot: Robot, scene: Scene, known: Mapping[str, Any], answer: Mapping[str, Any]) -> Outcome:
    """Return what came of a scene, by what is `known` before (scene, family, seed, method) and a worker's answer."""
    spent = float(answer["planning_time"])
    if "failed" in answer:
        return Outcome(**known, reason=str(answer["failed"]), planning_time=spent, total_time=spent)
    t, q, velocity = (np.array(answer[name], float) for name in ("t", "q", "velocity"))
    certificate = certify(robot, scene.obstacles, t, q, velocity)
    hands = NativeKinematics(robot, scene.obstacles).state(q[-1]).hands
    fastest, strongest = largest_rates(robot, t, q, velocity)
    beyond = float(np.maximum(q - robot.upper, robot.lower - q).max())
    return Outcome(
        **known,
        reason=str(answer["reason"]),
        planning_time=spent,
        total_time=float(answer["time"]),
        reached=bool(np.linalg.norm(hands - target_points(robot, scene)) <= Auto().tolerance),
        certified=certificate.certified,
        touched=certificate.contact is not None,
        excess=max(0.0, beyond, fastest - 1.0, strongest - 1.0),
        duration=float(t[-1]),
        bound=least_duration(robot, q[0], q[-1]),
    )


def largest_rates(robot: Robot, t: Array, q: Array, velocity: Array) -> tuple[float, float]:
    """Return the largest velocity and acceleration of a cubic spline in units of the limits, by differences at 1 ms.

    The motion rests before and after: it exceeds a limit of acceleration where it begins or ends in motion.
    """
    if len(t) == 1:
        return 0.0, 0.0
    times = np.arange(-2.0 * MILLISECOND, t[-1] + 3.0 * MILLISECOND, MILLISECOND)
    positions = CubicHermiteSpline(t, q, velocity)(np.clip(times, 0.0, t[-1]))
    first, second = (
        float((abs(np.diff(positions, order, axis=0)) / MILLISECOND**order / limit).max())
        for order, limit in ((1, robot.velocity_limit), (2, robot.acceleration_limit))
    )
    return first, second


def least_duration(robot: Robot, start: Array, goal: Array) -> float:
    """Return how long the slowest joint takes from rest to rest between two configurations (n,), all by itself, s.

    It speeds up and slows down at its limit of acceleration, with its limit of velocity between where it gets there.
    """
    way, fastest, strongest = abs(goal - start), robot.velocity_limit, robot.acceleration_limit
    trapezoid = way / fastest + fastest / strongest
    triangle = 2.0 * np.sqrt(way / strongest)
    return float(np.where(way * strongest > fastest**2, trapezoid, triangle).max())


def make_rows(outcomes: Sequence[Outcome]) -> list[Row]:
    """Return a row per family and method; if there are several families also one per method for all of them."""
    families = sorted({outcome.family for outcome in outcomes})
    groups = [(family, {family}) for family in families]
    if len(families) > 1:
        groups.append((ALL, set(families)))
    rows = []
    for name, members in groups:
        some = [outcome for outcome in outcomes if outcome.family in members]
        methods = {outcome.method for outcome in some}
        rows += [make_row(name, method, some) for method in EVERY if method in methods]
    return rows


def make_row(family: str, method: str, outcomes: Sequence[Outcome]) -> Row:
    """Return what came of some scenes by one of the methods that planned them."""
    by_method: dict[str, dict[tuple[str, int], Outcome]] = {name: {} for name in EVERY}
    for outcome in outcomes:
        by_method[outcome.method][outcome.scene, outcome.seed] = outcome
    own = by_method[method]
    before = [(one, by_method[BEFORE][key]) for key, one in own.items() if key in by_method[BEFORE]]
    times = [one.planning_time for one, _ in before], [other.planning_time for _, other in before]
    durations = _durations(own, by_method[BEFORE])
    low, high = (np.quantile([one.planning_time for one in own.values()], share) for share in (0.5, 0.95))
    good = [one for one in own.values() if one.good]
    lengths, bounds = [one.duration or 0.0 for one in good], [one.bound or 0.0 for one in good]
    return Row(
        family=family,
        method=method,
        motions=len(own),
        reached=sum(one.reached for one in own.values()),
        certified=sum(one.certified for one in own.values()),
        touched=sum(one.touched for one in own.values()),
        beyond_limits=sum(one.excess > BEYOND for one in own.values()),
        median_time=float(low),
        p95_time=float(high),
        median_to_before=_of_quantiles(*times, 0.5),
        by_scene_to_before=_of_ratios(*times, np.median),
        p95_to_before=_of_quantiles(*times, 0.95),
        total_time=float(np.median([one.total_time for one in own.values()])),
        duration=float(np.median(lengths)) if good else None,
        to_bound=_of_ratios(lengths, bounds, np.median),
        duration_to_before=_of_quantiles(*durations, 0.5),
        duration_by_scene=_of_ratios(*durations, np.median),
        longest_to_before=_of_ratios(*durations, np.max),
        to_drake=_of_ratios(*_durations(own, by_method[DRAKE_SEEDED]), np.median),
    )


Key = tuple[str, int]
"""The name of a scene, and a seed."""


def _durations(ones: Mapping[Key, Outcome], others: Mapping[Key, Outcome]) -> tuple[list[float], list[float]]:
    """Return the durations of the scenes that both solve, of each in the same order, s."""
    both = [(one, others[key]) for key, one in ones.items() if key in others and one.good and others[key].good]
    return [one.duration or 0.0 for one, _ in both], [other.duration or 0.0 for _, other in both]


def _of_quantiles(above: Sequence[float], below: Sequence[float], share: float) -> float | None:
    return float(np.quantile(above, share) / np.quantile(below, share)) if above else None


def _of_ratios(above: Sequence[float], below: Sequence[float], reduce: Callable[[Array], Any]) -> float | None:
    return float(reduce(np.array(above) / np.array(below))) if above else None
