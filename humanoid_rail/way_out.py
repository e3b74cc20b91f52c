"""A way to the targets whenever there is one: `method="auto"`.

1. The safe velocity of `safety.py` is followed first. Where it arrives, its path is a way.
2. Goals, configurations with the hands at their targets, are looked for by inverse kinematics from many starts. Of the
   nearest, those are kept that the secondary objectives of eq. 4.9 prefer.
3. Where the safe velocity did not arrive, RRT-Connect looks for ways to all of the goals at once (`sampling.py`), again
   and again with more checks and in a larger box: one long search fails more often than many short ones.
4. A way is made shorter, and others are tried while that may pay. The shortest one is rounded (`paths.py`).

Every straight piece of a way is proven to keep the safety distance (`validity.py`). Budgets are numbers of checks and
never seconds, so that a seed always gives the same plan; the time for planning only cuts it off.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import chain, islice
from typing import Any

import numpy as np

from humanoid_rail.arrays import Array
from humanoid_rail.engines import Engine
from humanoid_rail.goals import Solve, blocked_target, out_of_reach, pull, seeds
from humanoid_rail.integration import Integration, Settings
from humanoid_rail.limits import sampled
from humanoid_rail.paths import path_length, round_corners, speed_units, time_path
from humanoid_rail.resolution import Gains, penalty
from humanoid_rail.robot import Robot
from humanoid_rail.safety import Safety
from humanoid_rail.sampling import Sampler, Validity
from humanoid_rail.scene import Scene
from humanoid_rail.trajectory import Status

STEP = 0.05
"""How long the safe velocity is held, in time constants 1 / max(K): only its path matters."""
SPARE = 8e-4
"""How much more than the safety distance the corners of a way keep, so that there is room to round them, m."""
SEEDS = 16
"""Starts of the inverse kinematics, ..."""
MORE_SEEDS = 48
"""... of which there are more if few of them lead to goals, ..."""
MOST_SEEDS = 4096
"""... and how many at most, if none does."""
NEAREST, GOALS = 8, 4
"""Of so many goals nearest to the start, so many are kept."""
FIRST_CHECKS, GROWTH = 600, 1.5
"""Checks of the first search, and how many times as many each of the next gets."""
EDGES = (0.7, 0.3, 0.15)
"""The longest edge of the trees, s, in turns: short ones find narrow ways, long ones are quick."""
FIRST_MARGIN, MARGIN_GROWTH = 0.6, 1.25
"""How far the box of the first search reaches beyond start and goals, s, and how many times as far that of the next."""
GOOD = 1.05
"""A way is short enough if it is no longer than this, in units of the distance to the nearest goal."""
EFFORT_AFTER_QP = 250
"""Checks spent on a shorter way than that of the safe velocity."""
EFFORT, LEAST_EFFORT, MOST_EFFORT = 10.0, 1500, 8000
"""Checks spent on a shorter way than the first that was sampled: as many times what that one took, within bounds."""
RESERVE = 0.03
"""The share of the time for planning that is left for what follows a search."""
FEW = 50
"""It is not worth while to start a search with fewer checks."""
QP, STRAIGHT, RRT_CONNECT = "qp", "straight line", "rrt-connect"
"""What finds ways."""


@dataclass(frozen=True, eq=False)
class Way:
    """A way to the targets, or as far as one was found."""

    status: Status
    reason: str
    path: Array
    """Configurations (K, n), m and rad."""
    evaluations: int
    """Of q_dot of the safe velocity."""
    t: Array | None = None
    """When the safe velocity was at them (K,), s, where it is no way but as far as that got."""
    found_by: str = ""
    """`qp`, `straight line` or `rrt-connect`; empty if there is no way."""
    raw: Array | None = None
    """The first way of the sampling planner (K, n), as it was; None if that was not needed."""
    goals: int = 0
    """How many goals it had to choose from."""
    checks: int = 0
    """How many straight ways were checked."""
    searches: int = 0
    """How often the sampling planner was started."""


def find_way(
    robot: Robot,
    scene: Scene,
    computing: Engine,
    kinematics: Any,
    start: Array,
    gains: Gains,
    safety: Safety,
    settings: Settings,
    seed: int,
) -> Way:
    """Look for a way from a start to the targets among obstacles at rest.

    Args:
        robot: The robot.
        scene: Targets and obstacles.
        computing: The engine.
        kinematics: The robot among the obstacles, of that engine.
        start: Configuration (n,), m and rad, at which nothing touches.
        gains: Parameters of eq. 4.9.
        safety: Parameters of the constraints.
        settings: When a motion ends, and how long planning may take.
        seed: Of the random numbers.
    """
    searching = (1.0 - RESERVE) * settings.max_planning_time
    deadline = time.perf_counter() + searching
    targets = np.array([scene.targets[name] for name in robot.hand_names])
    random = np.random.default_rng(seed)
    # A whole number of steps, so that the motion has the same corners when it is sampled.
    steps = max(1, int(STEP / gains.diagonal(targets.size).max() / settings.dt))
    coarse = replace(settings, dt=steps * settings.dt, max_planning_time=searching)
    motion = computing.rollout(kinematics, start, targets, gains, safety, coarse)
    arrived = motion.status is Status.REACHED
    if arrived and len(motion.q) == 1:
        return Way(Status.REACHED, motion.reason, motion.q, motion.evaluations, found_by=QP)
    solver = computing.inverse_kinematics(robot, scene.obstacles)
    left = float(np.linalg.norm(kinematics.measure(motion.q[-1], 0.0).hands - targets))
    if not arrived:
        fault = blocked_target(robot, scene, safety.safety_distance, settings.tolerance)
        if fault is not None:
            return Way(Status.TARGET_IN_COLLISION, _partly(fault, left), motion.q, motion.evaluations, motion.t)
        fault = out_of_reach(robot, targets, start, computing, random, settings.tolerance, deadline)
        if fault is not None:
            return Way(Status.TARGET_OUT_OF_REACH, _partly(fault, left), motion.q, motion.evaluations, motion.t)

    first, distance = _first_clear(kinematics, motion.q, safety.safety_distance + SPARE)
    validity = computing.validity(robot, scene.obstacles, distance)
    weights = np.ones(targets.size)
    search = _Search(
        robot=robot,
        validity=validity,
        solve=lambda q: solver.solve(q, targets.ravel(), weights, distance),
        distance=distance,
        start=motion.q[first],
        seeds=chain([motion.q[-1]], seeds(robot, motion.q[first], random)),
        random=random,
        deadline=deadline,
    )
    if arrived:
        search.consider(QP, search.completed(motion.q[first:]))
    search.choose_goals(lambda q: _objective(kinematics, gains, q))
    search.go_straight()
    search.sample()
    way = Way(
        Status.STUCK,
        _partly(search.explain(settings.max_planning_time), left),
        motion.q,
        motion.evaluations,
        motion.t,
        raw=search.raw,
        goals=search.known,
        checks=search.checks,
        searches=search.searches,
    )
    if search.best is None:
        return way
    loose = computing.validity(robot, scene.obstacles, distance - min(SPARE / 2, 0.05 * distance))
    path = round_corners(robot, np.vstack([motion.q[:first], search.best]), loose.holds_between)
    left = float(np.linalg.norm(kinematics.measure(path[-1], 0.0).hands - targets))
    return replace(
        way, status=Status.REACHED, reason=f"|e| is {left:.2g} m", path=path, t=None, found_by=search.found_by
    )


def follow(robot: Robot, way: Way, settings: Settings) -> Integration:
    """Return the motion along a way, sampled: as fast as the speed limits let it, or as the safe velocity made it."""
    status, reason = way.status, way.reason
    if way.t is None:
        t, q = time_path(robot, way.path, settings.dt)
    else:
        count = int(np.ceil(way.t[-1] / settings.dt - 1e-9))
        t = np.append(settings.dt * np.arange(count), way.t[-1])
        q = np.column_stack([np.interp(t, way.t, column) for column in way.path.T])
    if t[-1] > settings.max_time:
        status = Status.TIME_LIMIT
        reason = f"the way that was found takes {t[-1]:.4g} s at the speed limits, longer than {settings.max_time:g} s"
        t, q = t[t <= settings.max_time], q[t <= settings.max_time]
    else:
        reason += f" at t = {t[-1]:.4g} s"
    return Integration(t, q, status, reason, way.evaluations, sampled(t, q))


def _partly(reason: str, left: float) -> str:
    """Add to a reason how far the safe velocity got."""
    return f"{reason}; the safe velocity came to |e| = {left:.3g} m"


def _first_clear(kinematics: Any, motion: Array, distance: float) -> tuple[int, float]:
    """Return where a motion (N, n) first keeps a distance in m from everything, and that distance.

    A start that is nearer to something is led away by the safe velocity. Where it never gets so far, the place where it
    is farthest, and a little less than how far that is.
    """
    farthest, place = -np.inf, 0
    for i, q in enumerate(motion):
        there = kinematics.measure(q, 0.0)
        clearance = float(min(there.clearance.min(initial=np.inf), there.self_clearance.min(initial=np.inf)))
        if clearance >= distance:
            return i, distance
        if clearance > farthest:
            farthest, place = clearance, i
    return place, 0.95 * farthest


def _objective(kinematics: Any, gains: Gains, q: Array) -> float:
    """Return what the secondary objectives of eq. 4.8 climb: c_mu mu - c_kappa sum kappa(psi)."""
    there = kinematics.measure(q, gains.epsilon)
    near = there.clearance[np.isfinite(there.clearance)]
    return gains.c_mu * float(there.manipulability) - gains.c_kappa * float(penalty(near, gains.epsilon).sum())


@dataclass(eq=False)
class _Search:
    """What is known while a way is looked for."""

    robot: Robot
    validity: Validity
    solve: Solve
    """Inverse kinematics."""
    distance: float
    """What a goal keeps from everything, m."""
    start: Array
    seeds: Iterator[Array]
    """Where the inverse kinematics begins."""
    random: np.random.Generator
    deadline: float
    goals: list[Array] = field(default_factory=list)
    """Those nearest to the start."""
    tried: int = 0
    """From how many configurations goals were looked for."""
    known: int = 0
    """How many goals there are in all."""
    best: Array | None = None
    found_by: str = ""
    raw: Array | None = None
    checks: int = 0
    searches: int = 0

    def is_over(self) -> bool:
        return time.perf_counter() > self.deadline

    def length(self, path: Array) -> float:
        return path_length(self.robot, path)

    def from_start(self, q: Array) -> float:
        return self.length(np.array([self.start, q]))

    def consider(self, found_by: str, path: Array) -> None:
        """Keep a way if it is the shortest so far."""
        if self.best is None or self.length(path) < self.length(self.best):
            self.best, self.found_by = path, found_by

    def completed(self, path: Array) -> Array:
        """Return a path that ends within the tolerance of the targets, led on to a goal if there is a straight way."""
        posture = self.solve(path[-1])
        exact = posture.reaches(self.distance) and self.validity.holds_between(path[-1], posture.q)
        return np.vstack([path, posture.q]) if exact else path

    def find_goals(self, count: int, most: int) -> list[Array]:
        """Return goals that are found from `count` starts, or from up to `most` as long as there are few."""
        found: list[Array] = []
        for i, seed in enumerate(islice(self.seeds, most)):
            if self.is_over() or (i >= count and len(found) >= GOALS):
                break
            self.tried += 1
            posture = self.solve(seed)
            if posture.reaches(self.distance):
                found.append(posture.q)
        return found

    def choose_goals(self, objective: Callable[[Array], float]) -> None:
        """Of the goals nearest to the start, keep the first, and those of the others whose objective is largest."""
        found = self.find_goals(SEEDS, MORE_SEEDS)
        if not found and self.best is None:
            found = self.find_goals(0, MOST_SEEDS)
        nearest = sorted(found, key=self.from_start)[:NEAREST]
        kept = [*nearest[:1], *sorted(nearest[1:], key=objective, reverse=True)[: GOALS - 1]]
        pulled = (pull(self.robot, q, self.start, self.solve, self.distance) for q in kept)
        self.goals = sorted(pulled, key=self.from_start)
        if not self.goals and self.best is not None:
            self.goals = [self.best[-1]]
        self.known = len(self.goals)

    def go_straight(self) -> None:
        """Look for a straight way to a goal."""
        for goal in self.goals:
            self.checks += 1
            if self.validity.holds_between(self.start, goal):
                self.consider(self.found_by or STRAIGHT, np.array([self.start, goal]))
                return

    def sample(self) -> None:
        """Look for ways by sampling until there is one, and for shorter ones while that may pay."""
        margin, most, effort = FIRST_MARGIN, float(FIRST_CHECKS), float(EFFORT_AFTER_QP)
        goals, others = self.goals, list[Array]()
        shortened = self.best is None or len(self.best) == 2
        while self.goals and not self.is_over():
            left = np.inf
            if self.best is not None:
                left = effort - self.checks
                if self.length(self.best) <= GOOD * self.from_start(self.goals[0]) or left < FEW:
                    break
            sampler = Sampler(self.robot, self.validity, *self._box(goals, margin), self.deadline)
            if self.best is not None and not shortened:
                self.consider(self.found_by, sampler.shorten(self.best, self._seed()))
                shortened = True
            else:
                edge = EDGES[self.searches % len(EDGES)]
                self.searches += 1
                path = sampler.connect(self.start, goals, self._seed(), edge, int(min(most, left)))
                if path is not None:
                    if self.best is None:
                        effort = min(max(EFFORT * (self.checks + sampler.checks), LEAST_EFFORT), MOST_EFFORT)
                        goals = [*self.goals, path[-1]]
                    self.raw = path if self.raw is None else self.raw
                    self.consider(RRT_CONNECT, sampler.shorten(path, self._seed()))
                elif self.best is None:
                    # Perhaps these goals are where nothing leads to: others are tried, then all, and so on.
                    if self.searches % 2:
                        found = self.find_goals(SEEDS, MORE_SEEDS)
                        others += found
                        goals = found or self.goals
                    else:
                        goals = [*self.goals, *others]
                    margin, most = margin * MARGIN_GROWTH, most * GROWTH
            # A search that ends at once has to end too.
            self.checks += max(1, sampler.checks)
        self.known = len(self.goals) + len(others)

    def explain(self, max_planning_time: float) -> str:
        """Say why there is no way."""
        if not self.goals and self.is_over():
            return f"{max_planning_time:g} s did not suffice to find a configuration at the targets, let alone a way"
        if not self.goals:
            what = f"no configuration at the targets that keeps {self.distance:.3g} m from everything"
            return f"{what} was found by inverse kinematics from {self.tried} starts"
        return (
            f"no way to any of {self.known} configurations at the targets was found in {max_planning_time:g} s "
            f"({self.searches} searches, {self.checks} straight ways checked); what is in the way may leave none"
        )

    def _box(self, goals: list[Array], margin: float) -> tuple[Array, Array]:
        ends = np.array([self.start, *goals, *([] if self.best is None else self.best)])
        beyond = margin * speed_units(self.robot)
        lower = np.maximum(self.robot.lower, ends.min(axis=0) - beyond)
        return lower, np.minimum(self.robot.upper, ends.max(axis=0) + beyond)

    def _seed(self) -> int:
        return int(self.random.integers(1, 2**31))
