"""The planning methods: frozen options, each with a `plan` of its own.

To add one, write such a class and enter it in `METHODS`; nothing else needs to know it.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from humanoid_rail.errors import InvalidInput, checked_number, did_you_mean
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.kinematics.path_metric import path_quality
from humanoid_rail.kinematics.state import KinematicsModel
from humanoid_rail.kinematics.task import Task
from humanoid_rail.kinematics.task_stack import count_rows
from humanoid_rail.kinematics.within_task import nominal
from humanoid_rail.planning.kept import allowed_by, brought_back
from humanoid_rail.planning.options import (
    ENGINES,
    Options,
    Planned,
    PlanningMethod,
    SafeOptions,
    check_no_turns,
    checked_whole,
    found_by,
)
from humanoid_rail.planning.passing_plan import without_stopping
from humanoid_rail.planning.timed_plan import with_least_time
from humanoid_rail.problem import Problem
from humanoid_rail.resolution.integrate import Settings, integrate
from humanoid_rail.resolution.native_velocity import integrate_natively
from humanoid_rail.resolution.qp import Equality, Safety
from humanoid_rail.resolution.rollout import rollout
from humanoid_rail.resolution.velocity import Gains
from humanoid_rail.result import Search, Status
from humanoid_rail.scene.obstacles import at_rest
from humanoid_rail.scene.scene import Scene
from humanoid_rail.search.auto import Budget, find_path
from humanoid_rail.search.exact_end import EXACT, led_on
from humanoid_rail.search.path_result import as_far_as_qp, follow
from humanoid_rail.search.reachability import followed, followed_gains, turning

LARGEST_SEED = 2**31 - 1
"""The largest seed, and the largest number of edge checks: such numbers are passed on as 32 bits."""
KEPT_GAIN = 10.0
"""Gradient projection corrects errors of constraints with so many times the gain of the tasks."""
NEARER = 0.9
"""With constraints it ends at this share of the tolerance."""
MOST_STEPS = 1000
"""The largest number of steps of the optimisation."""


@dataclass(frozen=True, kw_only=True)
class GradientProjection(Options):
    """Follows q_dot of eq. 4.9, the paper's own law.

    It neither prevents collisions nor knows limits: the verdict says what happened, whatever the status.

    Raises:
        InvalidInput: If there is no such option, or one is not valid.
    """

    name: ClassVar[str] = "gradient-projection"

    rtol: float = 1e-6
    """Relative tolerance of the integrator (Dormand and Prince, order 5(4))."""
    atol: float = 1e-6
    """Absolute tolerance of the integrator, m and rad."""
    engine: str = "native"
    """What computes it: `native` (C++), or `python`, the reference, which needs no native engine and is 40 to 200 times
    slower."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("rtol", "atol"):
            object.__setattr__(self, name, checked_number(name, getattr(self, name), above=0.0))
        if not isinstance(self.engine, str) or self.engine not in ENGINES:
            raise InvalidInput(
                "engine", self.engine, f"one of {', '.join(ENGINES)}{did_you_mean(self.engine, ENGINES)}"
            )

    def kinematics(self, problem: Problem) -> KinematicsModel:
        """Return the robot among the obstacles of a problem, in the engine that was asked for."""
        return Kinematics(problem.robot, problem.obstacles) if self.engine == "python" else problem.native

    def plan(self, problem: Problem, number: int = 0, spent: float = 0.0, moved: float = 0.0) -> Planned:
        """Integrate eq. 4.9; see :meth:`PlanningMethod.plan`."""
        problem, taken = problem.taking(problem.nearest), problem.nearest
        settings, kinematics = self._settings(moved, rtol=self.rtol, atol=self.atol), self.kinematics(problem)
        tasks, gains, settings = _with_constraints(problem, self.gains, settings)
        if isinstance(kinematics, NativeKinematics):
            motion = integrate_natively(kinematics, problem.q, tasks, gains, settings)
        else:
            assert isinstance(kinematics, Kinematics)
            motion = integrate(kinematics, problem.q, tasks, gains, settings)
        if problem.constraints:
            motion = brought_back(problem, motion, self.tolerance)
        return Planned(motion, found_by(self.name, motion), taken=taken)


@dataclass(frozen=True, kw_only=True)
class SafeVelocity(SafeOptions):
    """Follows the q_dot closest to eq. 4.9's that keeps clear of obstacles and links, and within the joint limits.

    A quadratic program in each step of dt, which is proven free of contact before it is made. A local method: it may
    get stuck where a path exists.

    Raises:
        InvalidInput: If there is no such option, or one is not valid.
    """

    name: ClassVar[str] = "qp"

    equalities: Sequence[Equality] = ()
    """Linear equalities A q_dot = b: functions from a :class:`State` to A (k, n) and b (k,)."""

    @property
    def safety(self) -> Safety:
        """Parameters of the constraints."""
        return Safety(self.safety_distance, self.damper_gain, self.equalities)

    def plan(self, problem: Problem, number: int = 0, spent: float = 0.0, moved: float = 0.0) -> Planned:
        """Follow the safe velocity; see :meth:`PlanningMethod.plan`."""
        settings = self._settings(moved)
        problem, taken = problem.taking(problem.nearest), problem.nearest
        motion = rollout(
            problem.native, problem.q, nominal(problem.tasks), self.gains, self.safety, settings, problem.constraints
        )
        return Planned(motion, found_by(self.name, motion), taken=taken)


@dataclass(frozen=True, kw_only=True)
class Auto(SafeOptions):
    """Global planning: goals by inverse kinematics, sampled paths, and `qp` where these do not help.

    The path is made a motion of least time within the limits of velocity, acceleration and jerk, at rest at its ends
    and at the targets of each step: docs/least_time.md. Among obstacles that move the motion is `qp`. See docs/auto.md.

    Raises:
        InvalidInput: If there is no such option, or one is not valid.
    """

    name: ClassVar[str] = "auto"

    max_edge_checks: int = 150_000
    """The most edges that each segment's search may check. What is found depends on this number, never on time."""
    max_planning_time: float = np.inf
    """Planning all segments together is cut off after this time, s; then the status is `planning_timeout`."""
    seed: int = 0
    """Seed of the random numbers, from 0 to 2^31 - 1. The same seed gives the same plan, bit for bit."""
    optimise: bool = True
    """Whether to make a motion of least time that a drive can follow. If not, planning is quicker, and the motion
    follows its path as fast as the speed limits allow: accelerations are not limited. Where a joint that moves has no
    acceleration limit, or obstacles move, it is as if this were false."""
    max_optimisation_steps: int = 8
    """The most quadratic programs to solve for each segment, besides those of repairs and of a second attempt. What is
    found depends on this number, never on time; with 0 the motion follows its path."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (isinstance(self.max_planning_time, float) and self.max_planning_time == np.inf):
            limit = checked_number("max_planning_time", self.max_planning_time, above=0.0)
            object.__setattr__(self, "max_planning_time", limit)
        checked_number("tolerance", self.tolerance, least=EXACT)
        object.__setattr__(self, "seed", checked_whole("seed", self.seed, 0, LARGEST_SEED))
        checks = checked_whole("max_edge_checks", self.max_edge_checks, 1, LARGEST_SEED)
        object.__setattr__(self, "max_edge_checks", checks)
        if not isinstance(self.optimise, bool):
            raise InvalidInput("optimise", self.optimise, "True or False")
        steps = checked_whole("max_optimisation_steps", self.max_optimisation_steps, 0, MOST_STEPS)
        object.__setattr__(self, "max_optimisation_steps", steps)

    def check(self, scene: Scene) -> None:
        """Check that hands are turned only among obstacles at rest.

        Raises:
            InvalidInput: If one has to be turned among obstacles that move.
        """
        if not at_rest(scene.obstacles):
            check_no_turns(scene)

    def plan(self, problem: Problem, number: int = 0, spent: float = 0.0, moved: float = 0.0) -> Planned:
        """Look for a path, and follow it in the least time; see :meth:`PlanningMethod.plan`."""
        started, left = time.perf_counter(), max(self.max_planning_time - spent, 0.0)
        settings = self._settings(moved, max_planning_time=left, max_planning_time_of_all=self.max_planning_time)
        planned = self._plan_path(problem, number, settings)
        if not self.optimise or not at_rest(problem.obstacles):
            return planned
        steps, deadline = self.max_optimisation_steps, started + left
        problem = problem.taking(planned.taken).pinned(planned.motion.q[-1])
        return with_least_time(planned, problem, self.safety_distance, allowed_by(self), steps, settings, deadline)

    def passing(self, planned: Sequence[Planned], problems: Sequence[Problem], spent: float = 0.0) -> Sequence[Planned]:
        """Make one motion of least time of several; see :meth:`PlanningMethod.passing`."""
        deadline = time.perf_counter() + max(self.max_planning_time - spent, 0.0)
        steps = self.max_optimisation_steps * len(planned)
        problems = [problem.pinned(one.motion.q[-1]) for problem, one in zip(problems, planned, strict=True)]
        return without_stopping(planned, problems, self.dt, self.safety_distance, steps, deadline)

    def _plan_path(self, problem: Problem, number: int, settings: Settings) -> Planned:
        """Look for a path and follow it as fast as the speed limits allow."""
        started, left = time.perf_counter(), settings.max_planning_time
        nearest = problem.taking(problem.nearest)
        tasks, gains = followed(nearest.tasks), followed_gains(self.gains, nearest.tasks)
        if not at_rest(problem.obstacles):
            problem, taken = nearest, problem.nearest
            if len(tasks) < len(problem.tasks):
                raise InvalidInput(
                    "tasks",
                    turning(problem.tasks),
                    "none that turns a hand: auto turns hands only among obstacles at rest",
                )
            motion = rollout(problem.native, problem.q, tasks, gains, self.safety, settings, problem.constraints)
            return Planned(motion, found_by(SafeVelocity.name, motion), taken=taken)
        random = np.random.default_rng(self.seed if number == 0 else (self.seed, number))
        budget = Budget(self.max_edge_checks, random)
        found = find_path(problem, gains, self.safety, settings, budget)
        raw = None if found.raw is None else path_quality(problem.robot, found.raw)
        search = Search(self.seed, found.goals, found.searches, found.checks, raw)
        problem, taken = problem.taking(found.taken), found.taken
        tasks, gains = followed(problem.tasks), followed_gains(self.gains, problem.tasks)
        if found.path is not None:
            return Planned(follow(problem, found, settings), found.found_by, search, taken=taken)
        # What is left of the time, which is little where that is why there is no path.
        rest = replace(settings, max_planning_time=max(left - (time.perf_counter() - started), 0.0))
        local = rollout(problem.native, problem.q, tasks, gains, self.safety, rest, problem.constraints)
        motion = as_far_as_qp(found, local, rest)
        if len(tasks) == len(problem.tasks):
            motion = led_on(problem, motion, self.safety_distance, settings)
        elif motion.status is Status.REACHED:
            # It turns no hand.
            motion = replace(motion, status=found.status, reason=f"{found.reason}; qp reaches the points alone")
        return Planned(motion, found_by(SafeVelocity.name, motion), search, found.explored, taken=taken)


def _with_constraints(problem: Problem, gains: Gains, settings: Settings) -> tuple[tuple[Task, ...], Gains, Settings]:
    """Return tasks with the constraints among them, which are done from the start on: e' = -K e keeps them at 0.

    Near singularities, where eq. 4.6 is damped, the larger gain keeps them near to that.
    """
    if not problem.constraints:
        return nominal(problem.tasks), gains, settings
    K = gains.diagonal(count_rows(problem.tasks))
    kept = np.full(count_rows(problem.constraints), KEPT_GAIN * K.max())
    # What is left of the constraints' errors when the motion is brought back onto them may take from the tolerance.
    nearer = replace(settings, tolerance=NEARER * settings.tolerance)
    return (*problem.constraints, *nominal(problem.tasks)), replace(gains, gain=np.concatenate([kept, K])), nearer


METHODS: Mapping[str, type[PlanningMethod]] = MappingProxyType(
    {method.name: method for method in (Auto, SafeVelocity, GradientProjection)}
)
"""The methods by their names."""


def as_method(method: PlanningMethod | str) -> PlanningMethod:
    """Return a method: the one given, or the one of that name with its default options.

    Raises:
        InvalidInput: If it is neither.
    """
    if isinstance(method, str) and method in METHODS:
        return METHODS[method]()
    if isinstance(method, type) or not isinstance(method, PlanningMethod):
        valid = f"one of {', '.join(METHODS)}, or an object such as Auto(seed=3){did_you_mean(method, METHODS)}"
        raise InvalidInput("method", method, valid)
    return method
