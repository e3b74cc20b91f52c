"""The planning methods: frozen options, each with a `plan` of its own.

To add one, write such a class and enter it in `METHODS`; nothing else needs to know it.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import Any, ClassVar, Protocol

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.collision.certifier import least_distance
from humanoid_rail.errors import InvalidInput, checked_number
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.kinematics.path_metric import path_quality
from humanoid_rail.kinematics.state import KinematicsModel
from humanoid_rail.problem import Problem
from humanoid_rail.resolution.integrate import Integration, Settings, integrate
from humanoid_rail.resolution.native_velocity import integrate_natively
from humanoid_rail.resolution.qp import Equality, Safety
from humanoid_rail.resolution.rollout import rollout
from humanoid_rail.resolution.velocity import Gains, Objective
from humanoid_rail.scene.obstacles import at_rest
from humanoid_rail.scene.scene import Scene, field_of_step
from humanoid_rail.scene.targets import Pose, is_oriented
from humanoid_rail.search.auto import Budget, as_far_as_qp, find_path, follow
from humanoid_rail.search.reachability import followed
from humanoid_rail.trajectory import MAX_SAMPLES, Search, Status

ENGINES = ("native", "python")
"""What can compute gradient projection: C++, or the Python that is there to be read."""
FUNCTIONS = ("objectives", "equalities")
"""Options that hold functions, of which plain data has only the names."""


@dataclass(frozen=True, eq=False)
class Planned:
    """A motion to the tasks of one problem, or as far as it got."""

    motion: Integration
    """Its times begin at 0."""
    found_by: str
    """What found its path; empty if nothing did."""
    search: Search | None = None
    """What `auto` did to find it."""


class PlanningMethod(Protocol):
    """What plans a problem: a frozen options object."""

    name: ClassVar[str]
    """The name that stands for the method with its default options."""

    @property
    def gains(self) -> Gains:
        """Parameters of eq. 4.9."""
        ...

    @property
    def dt(self) -> float:
        """Time between samples, s."""
        ...

    @property
    def max_time(self) -> float:
        """Longest motion, s."""
        ...

    @property
    def epsilon(self) -> float:
        """Activation distance of the penalty, m."""
        ...

    @property
    def far_clearances(self) -> bool:
        """Whether clearances beyond the activation distance are measured too."""
        ...

    @property
    def engine(self) -> str:
        """What computes the motion, `native` or `python`."""
        ...

    @property
    def kept_distance(self) -> float | None:
        """The safety distance that is kept, m; None for a method that keeps none."""
        ...

    def options(self) -> dict[str, Any]:
        """Return all options as plain data."""
        ...

    def kinematics(self, problem: Problem) -> KinematicsModel:
        """Return the robot among the obstacles of a problem, in the method's engine."""
        ...

    def least_start(self) -> float:
        """Return the clearance that a start must have, m."""
        ...

    def check(self, scene: Scene) -> None:
        """Check that the method can do what a scene asks for.

        Raises:
            InvalidInput: If it cannot.
        """
        ...

    def plan(self, problem: Problem, number: int = 0, spent: float = 0.0, moved: float = 0.0) -> Planned:
        """Plan a motion to the tasks of a problem.

        Args:
            problem: The robot, the scene, the tasks and the start.
            number: The number of the segment, of which there may be several.
            spent: The time that planning the segments before took, s.
            moved: The time that the motion of the segments before takes, s.
        """
        ...


@dataclass(frozen=True, kw_only=True)
class _Options:
    """What all methods have in common.

    Raises:
        InvalidInput: If an option is not valid.
    """

    name: ClassVar[str]

    gain: float | Sequence[float] | Array = 1.0
    """Diagonal of K in 1/s: one number for all rows of the tasks, or one for each. Kept as a tuple."""
    c_mu: float = 1.0
    """Gain of the manipulability's gradient, 0 or more."""
    c_kappa: float = 1.0
    """Gain of the penalties' gradient, 0 or more."""
    epsilon: float = 1.0
    """Activation distance of the penalty in m, 0 or more. The paper does not give it."""
    objectives: Sequence[Objective] = ()
    """Further secondary objectives: functions from a :class:`State` to a velocity (n,) in m/s and rad/s, which eq. 4.8
    adds to its own. See docs/objective.md."""
    tolerance: float = 0.01
    """The motion ends where the norm of e, all rows of all tasks together, falls to this, m."""
    dt: float = 0.01
    """Time between samples, s."""
    max_time: float = 60.0
    """Longest motion, s."""
    far_clearances: bool = False
    """Whether to measure at each sample also the clearances beyond the activation distance. If not, they are infinite,
    except for the smallest, so `min_clearance` is right in any case."""

    def __post_init__(self) -> None:
        gains = Gains(self.gain, self.c_mu, self.c_kappa, self.epsilon, self.objectives)
        for field in fields(Gains):
            object.__setattr__(self, field.name, getattr(gains, field.name))
        for name in ("tolerance", "dt", "max_time"):
            object.__setattr__(self, name, checked_number(name, getattr(self, name), above=0.0))
        if self.max_time / self.dt > MAX_SAMPLES:
            least = f"{self.max_time / MAX_SAMPLES:g} s with max_time = {self.max_time:g} s"
            raise InvalidInput("dt", self.dt, f"at least {least}, for at most {MAX_SAMPLES} samples")
        if not isinstance(self.far_clearances, bool):
            raise InvalidInput("far_clearances", self.far_clearances, "True or False")

    @property
    def gains(self) -> Gains:
        """Parameters of eq. 4.9."""
        return Gains(self.gain, self.c_mu, self.c_kappa, self.epsilon, self.objectives)

    @property
    def engine(self) -> str:
        """What computes the motion: `native`."""
        return ENGINES[0]

    @property
    def kept_distance(self) -> float | None:
        """None: nothing is kept clear."""
        return None

    def options(self) -> dict[str, Any]:
        """Return all options as plain data; of functions their names."""
        plain: dict[str, Any] = {field.name: getattr(self, field.name) for field in fields(self)}
        plain["gain"] = list(plain["gain"])
        for name in FUNCTIONS:
            if name in plain:
                plain[name] = [getattr(function, "__name__", type(function).__name__) for function in plain[name]]
        return {name: None if value == np.inf else value for name, value in plain.items()}

    def kinematics(self, problem: Problem) -> KinematicsModel:
        """Return the robot among the obstacles of a problem."""
        return NativeKinematics(problem.robot, problem.obstacles)

    def least_start(self) -> float:
        """Return 0: a start must not be in penetration, m."""
        return 0.0

    def check(self, scene: Scene) -> None:
        """Check that no hand has to be turned.

        Raises:
            InvalidInput: If one has to be.
        """
        _check_no_turns(scene)

    def _settings(self, moved: float = 0.0, **more: float) -> Settings:
        given = {"rtol": 1.0, "atol": 1.0, **more}
        return Settings(tolerance=self.tolerance, dt=self.dt, max_time=self.max_time - moved, **given)


@dataclass(frozen=True, kw_only=True)
class GradientProjection(_Options):
    """Follows q_dot of eq. 4.9, the paper's own law.

    It neither prevents collisions nor knows limits: the verdict says what happened, whatever the status.

    Raises:
        InvalidInput: If an option is not valid.
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
            raise InvalidInput("engine", self.engine, f"one of {', '.join(ENGINES)}")

    def kinematics(self, problem: Problem) -> KinematicsModel:
        """Return the robot among the obstacles of a problem, in the engine that was asked for."""
        kind = Kinematics if self.engine == "python" else NativeKinematics
        return kind(problem.robot, problem.obstacles)

    def plan(self, problem: Problem, number: int = 0, spent: float = 0.0, moved: float = 0.0) -> Planned:
        """Integrate eq. 4.9; see :meth:`PlanningMethod.plan`."""
        settings, kinematics = self._settings(moved, rtol=self.rtol, atol=self.atol), self.kinematics(problem)
        if isinstance(kinematics, NativeKinematics):
            motion = integrate_natively(kinematics, problem.q, problem.tasks, self.gains, settings)
        else:
            assert isinstance(kinematics, Kinematics)
            motion = integrate(kinematics, problem.q, problem.tasks, self.gains, settings)
        return Planned(motion, _found_by(self.name, motion))


@dataclass(frozen=True, kw_only=True)
class _Safe(_Options):
    """What the methods that keep clear have in common."""

    safety_distance: float = 0.01
    """Clearances are kept from falling below this, m, 0 or more. A start that is nearer to something is led away."""
    damper_gain: float = 1.4
    """Clearances fall to the safety distance no faster than exp(-damper_gain t), 1/s."""

    def __post_init__(self) -> None:
        super().__post_init__()
        safety = self.safety
        for field in fields(Safety):
            if hasattr(self, field.name):
                object.__setattr__(self, field.name, getattr(safety, field.name))

    @property
    def safety(self) -> Safety:
        """Parameters of the constraints."""
        return Safety(self.safety_distance, self.damper_gain)

    @property
    def kept_distance(self) -> float | None:
        """The safety distance, m."""
        return self.safety_distance

    def least_start(self) -> float:
        """Return what coal can tell from touching, m: from anything nearer no step can be proven."""
        return least_distance()


@dataclass(frozen=True, kw_only=True)
class SafeVelocity(_Safe):
    """Follows the q_dot closest to eq. 4.9's that keeps clear of obstacles and links, and within the joint limits.

    A quadratic program in each step of dt, which is proven free of contact before it is made. A local method: it may get
    stuck where a path exists.

    Raises:
        InvalidInput: If an option is not valid.
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
        kinematics = NativeKinematics(problem.robot, problem.obstacles)
        motion = rollout(kinematics, problem.q, problem.tasks, self.gains, self.safety, self._settings(moved))
        return Planned(motion, _found_by(self.name, motion))


@dataclass(frozen=True, kw_only=True)
class Auto(_Safe):
    """Global planning where the local method gets stuck: `qp` first, then sampled paths, shortened and smoothed.

    The motion follows its path as fast as the speed limits allow. Among obstacles that move it is `qp`. See docs/auto.md.

    Raises:
        InvalidInput: If an option is not valid.
    """

    name: ClassVar[str] = "auto"

    max_edge_checks: int = 200_000
    """The most edges that each segment's search may check. What is found depends on this number, never on time."""
    max_planning_time: float = np.inf
    """Planning is cut off after this time, s; then the status is `planning_timeout`."""
    seed: int = 0
    """Seed of the random numbers, from 0 to 2^31 - 1. The same seed gives the same plan, bit for bit."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.max_planning_time != np.inf:
            limit = checked_number("max_planning_time", self.max_planning_time, above=0.0)
            object.__setattr__(self, "max_planning_time", limit)
        _check_whole("seed", self.seed, 0, 2**31 - 1)
        _check_whole("max_edge_checks", self.max_edge_checks, 1, 2**31 - 1)

    def check(self, scene: Scene) -> None:
        """Check that hands are turned only among obstacles at rest.

        Raises:
            InvalidInput: If one has to be turned among obstacles that move.
        """
        if not at_rest(scene.obstacles):
            _check_no_turns(scene)

    def plan(self, problem: Problem, number: int = 0, spent: float = 0.0, moved: float = 0.0) -> Planned:
        """Look for a path and follow it; see :meth:`PlanningMethod.plan`."""
        started, left = time.perf_counter(), max(self.max_planning_time - spent, 0.0)
        kinematics = NativeKinematics(problem.robot, problem.obstacles)
        settings = self._settings(moved, max_planning_time=left)
        tasks = followed(problem.tasks)
        if not at_rest(problem.obstacles):
            motion = rollout(kinematics, problem.q, tasks, self.gains, self.safety, settings)
            return Planned(motion, _found_by(SafeVelocity.name, motion))
        random = np.random.default_rng(self.seed if number == 0 else (self.seed, number))
        budget = Budget(self.max_edge_checks, random)
        found = find_path(problem, kinematics, self.gains, self.safety, settings, budget)
        raw = None if found.raw is None else path_quality(problem.robot, found.raw)
        search = Search(self.seed, found.goals, found.searches, found.checks, raw)
        if found.path is not None:
            return Planned(follow(problem, found, settings), found.found_by, search)
        # What is left of the time, which is little where that is why there is no path.
        rest = replace(settings, max_planning_time=max(left - (time.perf_counter() - started), 0.0))
        motion = as_far_as_qp(found, rollout(kinematics, problem.q, tasks, self.gains, self.safety, rest))
        if motion.status is Status.REACHED and len(tasks) < len(problem.tasks):
            # It turns no hand.
            motion = replace(motion, status=found.status, reason=f"{found.reason}; qp reaches the points alone")
        return Planned(motion, _found_by(SafeVelocity.name, motion), search)


METHODS: Mapping[str, type[GradientProjection] | type[SafeVelocity] | type[Auto]] = MappingProxyType(
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
    if isinstance(method, str) or isinstance(method, type) or not callable(getattr(method, "plan", None)):
        valid = f"one of {', '.join(METHODS)}, or an object such as Auto(seed=3)"
        raise InvalidInput("method", method, valid)
    return method


def _found_by(name: str, motion: Integration) -> str:
    return name if motion.status is Status.REACHED else ""


def _check_whole(name: str, value: object, least: int, most: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= most:
        raise InvalidInput(name, value, f"a whole number from {least} to {most}")


def _check_no_turns(scene: Scene) -> None:
    for number, step in enumerate(scene.steps):
        for hand, target in step.items():
            if isinstance(target, Pose) and is_oriented(target):
                valid = "a point: only auto turns hands, and only among obstacles at rest"
                field = f"{field_of_step(scene, number)}.{hand}"
                raise InvalidInput(field, target.model_dump(exclude_none=True), valid)
