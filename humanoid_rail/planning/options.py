"""What the planning methods have in common: their interface, their options and the checks of these."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, ClassVar, Protocol, Self, runtime_checkable

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.collision.certifier import least_distance
from humanoid_rail.errors import InvalidInput, checked_number, did_you_mean, told_apart
from humanoid_rail.kinematics.state import KinematicsModel
from humanoid_rail.kinematics.task import Task
from humanoid_rail.problem import Problem
from humanoid_rail.resolution.integrate import Integration, Settings
from humanoid_rail.resolution.qp import Safety
from humanoid_rail.resolution.velocity import Gains, Objective
from humanoid_rail.result import MAX_SAMPLES, Method, Optimisation, Search, Status
from humanoid_rail.scene.scene import Scene, field_of_step
from humanoid_rail.scene.targets import AnyOf, Pose, is_oriented
from humanoid_rail.timing.timed_motion import TimedMotion

ENGINES = ("native", "python")
"""Gradient projection is computed by one of these: C++, or the Python that is there to be read."""


@dataclass(frozen=True, eq=False)
class Planned:
    """A motion to the tasks of one problem, or as far as it got."""

    motion: Integration
    """Its times begin at 0."""
    found_by: str
    """What found its path; empty if nothing did."""
    search: Search | None = None
    """What `auto` did to find it."""
    explored: Array | None = None
    """Configurations (K, n) to which the sampling planner has paths where none leads to the targets."""
    timed: TimedMotion | None = None
    """The motion with a timing that a drive can follow; None for one that is linear between its samples."""
    optimisation: Optimisation | None = None
    """How it was optimised; None if it was not to be."""
    constraints: tuple[Task, ...] = ()
    """What holds along it."""
    taken: int = 0
    """The number of the choice, from 0, that it reaches or was to reach, of those of its problem."""


@runtime_checkable
class PlanningMethod(Method, Protocol):
    """What plans a problem: a frozen options object."""

    @property
    def gains(self) -> Gains:
        """Parameters of eq. 4.9."""
        ...

    @property
    def max_time(self) -> float:
        """Longest motion, s."""
        ...

    @property
    def engine(self) -> str:
        """What computes the motion, `native` or `python`."""
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

    def passing(self, planned: Sequence[Planned], problems: Sequence[Problem], spent: float = 0.0) -> Sequence[Planned]:
        """Return segments that follow each other, made to pass the targets of all but the last without stopping.

        Args:
            planned: The segments, which reach their targets and rest there, if their timing knows rests.
            problems: What each was planned for.
            spent: The time that planning took so far, s.

        Returns:
            As many segments, or those given if the targets cannot be passed: then what is said of the optimisation of
            the last one says why.
        """
        ...


@dataclass(frozen=True, kw_only=True)
class Options:
    """What all methods have in common.

    Raises:
        InvalidInput: If there is no such option, or one is not valid.
    """

    name: ClassVar[str]

    gain: float | Sequence[float] | Array = 1.0
    """Diagonal of K in 1/s: one number for all rows of the tasks, or one for each. Kept as a tuple."""
    c_mu: float | None = None
    """Gain of the manipulability's gradient, 0 or more. If not given it is 1 for the paper's robot, and has the same
    weight for other robots: it is the product of (2 m / reach)^3 over the arms that have targets."""
    c_kappa: float = 1.0
    """Gain of the penalties' gradient, 0 or more."""
    epsilon: float = 1.0
    """Activation distance of the penalty in m, 0 or more. The paper does not give it."""
    objectives: Sequence[Objective] = ()
    """Further secondary objectives: functions from a :class:`State` to a velocity (n,) in m/s and rad/s, which eq. 4.8
    adds to its own. See docs/objective.md."""
    tolerance: float = 0.01
    """The motion ends where the norm of e, all rows of all tasks together, falls to this, m. `auto` goes on to the
    exact targets where that is possible."""
    dt: float = 0.01
    """Time between samples, s."""
    max_time: float = 60.0
    """Longest motion, s."""
    max_deviation: float = 1e-3
    """The motion may leave a constraint of distances or places by at most this at any time, m; see docs/constraints.md.
    If it may leave it farther, it is not `reached`."""
    max_tilt: float = float(np.deg2rad(0.2))
    """The same of a constraint of directions or orientations, rad."""
    far_clearances: bool = False
    """Whether to measure at each sample also the clearances beyond the activation distance. If not, they are infinite,
    except for the smallest, so `min_clearance` is right in any case."""

    def __new__(cls, *_arguments: object, **options: object) -> Self:
        """Make a method whose options are all known; `__init__` checks their values."""
        known = [field.name for field in fields(cls)]
        for name, value in options.items():
            if name not in known:
                valid = f"one of the options of {cls.__name__}, {', '.join(known)}{did_you_mean(name, known)}"
                raise InvalidInput(name, value, valid)
        return super().__new__(cls)

    def __post_init__(self) -> None:
        gains = Gains(self.gain, self.c_mu, self.c_kappa, self.epsilon, self.objectives)
        for field in fields(Gains):
            object.__setattr__(self, field.name, getattr(gains, field.name))
        for name in ("tolerance", "dt", "max_time", "max_deviation", "max_tilt"):
            object.__setattr__(self, name, checked_number(name, getattr(self, name), above=0.0))
        if self.max_time / self.dt > MAX_SAMPLES:
            least = f"{told_apart(self.max_time / MAX_SAMPLES, self.dt)} s with max_time = {self.max_time:g} s"
            raise InvalidInput("dt", self.dt, f"at least {least}, for at most {MAX_SAMPLES} samples")
        if not isinstance(self.far_clearances, bool):
            raise InvalidInput("far_clearances", self.far_clearances, "True or False")

    @cached_property
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
        return {name: _plain(value) for name, value in plain.items()}

    def kinematics(self, problem: Problem) -> KinematicsModel:
        """Return the robot among the obstacles of a problem."""
        return problem.native

    def least_start(self) -> float:
        """Return 0: a start must not be in penetration, m."""
        return 0.0

    def check(self, scene: Scene) -> None:
        """Check that no hand has to be turned.

        Raises:
            InvalidInput: If one has to be.
        """
        check_no_turns(scene)

    def passing(self, planned: Sequence[Planned], problems: Sequence[Problem], spent: float = 0.0) -> Sequence[Planned]:
        """Return the segments as they are: motions whose accelerations have no limits need no rest at targets."""
        del problems, spent
        return planned

    def _settings(self, moved: float = 0.0, **more: float) -> Settings:
        given = {"rtol": 1.0, "atol": 1.0, **more}
        times = {"max_time": self.max_time - moved, "max_time_of_all": self.max_time, "begun": moved}
        return Settings(tolerance=self.tolerance, dt=self.dt, **times, **given)


@dataclass(frozen=True, kw_only=True)
class SafeOptions(Options):
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


def _plain(value: object) -> object:
    """Return the value of an option as plain data."""
    if isinstance(value, tuple):
        return [_plain(element) for element in value]
    if callable(value):
        return getattr(value, "__name__", type(value).__name__)
    return None if value == np.inf else value


def found_by(name: str, motion: Integration) -> str:
    """Return the name of what found a path, or nothing if a motion does not get there."""
    return name if motion.status is Status.REACHED else ""


def checked_whole(name: str, value: object, least: int, most: int) -> int:
    """Return an option that has to be a whole number.

    Raises:
        InvalidInput: If it is not.
    """
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= most:
        raise InvalidInput(name, value, f"a whole number from {least} to {most}")
    return int(value)


def check_no_turns(scene: Scene) -> None:
    """Check that no hand has to be turned.

    Raises:
        InvalidInput: If one has to be.
    """
    for number, step in enumerate(scene.steps):
        for hand, target in step.items():
            if isinstance(target, Pose | AnyOf) and is_oriented(target):
                valid = "a point: only auto turns hands, and only among obstacles at rest"
                field = f"{field_of_step(scene, number)}.{hand}"
                raise InvalidInput(field, target.model_dump(exclude_none=True), valid)
