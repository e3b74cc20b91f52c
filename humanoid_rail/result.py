"""The parts of a result of planning: the motion, the verdict on it and where it comes from."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Protocol

from humanoid_rail._arrays import Array, FrozenArrays
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.diagnosis import Diagnosis
from humanoid_rail.events import Event
from humanoid_rail.kinematics.joint_limits import Violation
from humanoid_rail.kinematics.path_metric import PathQuality

MAX_SAMPLES = 1_000_000
"""A trajectory has at most this many samples."""
SO_FAR = ", as far as the motion goes"
"""This is added to what is proven of a motion that ends before its targets."""


class Status(StrEnum):
    """What became of the targets."""

    REACHED = "reached"
    """The norm of the task error fell to the tolerance."""
    STALLED = "stalled"
    """The local method could not go on, although the hands could still move towards their targets."""
    TIME_LIMIT = "time_limit"
    """The motion takes longer than `max_time`."""
    SINGULAR = "singular"
    """An arm is stretched so that its hand cannot get nearer to its target; other hands may not have arrived."""
    OVERRUN = "overrun"
    """A moving obstacle runs into the robot, and even standing still does not avoid it."""
    TARGET_IN_COLLISION = "target_in_collision"
    """A hand at its target would touch an obstacle or the other hand, or be nearer than the safety distance."""
    TARGET_OUT_OF_REACH = "target_out_of_reach"
    """No configuration within the joint limits was found with the hands at their targets, even without obstacles."""
    STUCK = "stuck"
    """No path to the targets was found within the budget of edge checks."""
    PLANNING_TIMEOUT = "planning_timeout"
    """Planning was cut off by `max_planning_time`."""
    UNCERTIFIED = "uncertified"
    """The hands reach their targets, but the motion could not be proven free of contact, or leaves a constraint."""


class Method(Protocol):
    """What a result needs to know of the method that made it; see :mod:`humanoid_rail.planning.methods`."""

    @property
    def name(self) -> str:
        """The name by which :func:`humanoid_rail.plan` knows the method."""
        ...

    @property
    def dt(self) -> float:
        """Time between samples, s."""
        ...

    @property
    def tolerance(self) -> float:
        """The norm of the tasks' errors within which targets are reached, m."""
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
    def kept_distance(self) -> float | None:
        """The safety distance that the method keeps, m; None for a method that keeps none."""
        ...

    @property
    def max_deviation(self) -> float:
        """How far its motion may leave constraints of distances and places, m."""
        ...

    @property
    def max_tilt(self) -> float:
        """How far its motion may leave constraints of directions and orientations, rad."""
        ...

    def options(self) -> dict[str, Any]:
        """Return all options as plain data."""
        ...


@dataclass(frozen=True)
class Peak:
    """The largest velocity, acceleration and jerk of a joint in size, and their limits; m or rad, and s."""

    joint: str
    velocity: float
    velocity_limit: float
    """Infinite where there is no limit, as are the other limits."""
    acceleration: float
    acceleration_limit: float
    jerk: float
    jerk_limit: float


@dataclass(frozen=True, eq=False, repr=False)
class Timing(FrozenArrays):
    """The timing of a motion that a drive can follow: of an optimised or retimed one. N samples, n joints.

    Between samples the motion is the cubic spline through positions and velocities. Its accelerations are continuous
    and linear between samples, so a controller that interpolates positions, velocities and accelerations by a spline of
    degree five follows the same motion.
    """

    velocity: Array
    """Velocities at the samples (N, n), m/s and rad/s; 0 at both ends."""
    acceleration: Array
    """Accelerations at the samples (N, n), m/s^2 and rad/s^2; 0 at both ends."""
    peaks: tuple[Peak, ...]
    """The peaks of each joint at all times, including between samples."""

    def __repr__(self) -> str:
        n, joints = self.velocity.shape
        shares = [peak.velocity / peak.velocity_limit for peak in self.peaks if peak.velocity_limit > 0]
        fastest = f", up to {max(shares):.0%} of the velocity limits" if shares else ""
        return f"Timing({n} samples, {joints} joints{fastest})"


@dataclass(frozen=True, eq=False)
class Motion(FrozenArrays):
    """Where the joints are over time. N samples, n joints."""

    t: Array
    """Times (N,) in s: 0, dt, 2 dt, ... and the end; with several segments, so from the start of each. Where a target
    is passed without stopping there is one sample more."""
    q: Array
    """Configurations (N, n), m and rad."""
    joint_names: tuple[str, ...]
    """The columns of q."""
    timing: Timing | None = None
    """The timing of an optimised or retimed motion; None for one that is linear in q between samples."""
    events: tuple[Event, ...] = ()
    """What happens to objects along it, in order."""
    ends: tuple[float, ...] = ()
    """When each of its moves ends, s: a step is one, and so is each straight approach and retreat. Empty where that is
    not known."""


@dataclass(frozen=True)
class Verdict:
    """What came of a plan."""

    status: Status
    """What became of the targets."""
    reason: str
    """The status in a sentence, with numbers."""
    certificate: Certificate | None
    """What is proven of the motion, including between samples; None where no native engine was there to prove it."""
    violations: tuple[Violation, ...]
    """For each joint the worst excess over each of its limits."""
    arrivals: tuple[float, ...] = ()
    """When the hands are at each of the scene's targets in turn, s; those that were not reached are missing."""
    least_duration: float | None = None
    """A lower bound of the duration, s: how long each joint alone would take to the same configurations within its
    limits, from rest to rest at targets, but for those that the motion passes; for a motion without a timing within
    those of velocity alone. None unless all targets are reached."""
    diagnosis: Diagnosis | None = None
    """Why the plan failed and what would help; None where it did not fail, or no native engine could look into it."""


@dataclass(frozen=True)
class Search:
    """What `auto` did to find a path."""

    seed: int
    """The seed of the random numbers."""
    goals: int
    """The number of goal configurations there were to choose from."""
    searches: int
    """The number of times the sampling planner was started."""
    checks: int
    """The number of edges that were checked."""
    raw: PathQuality | None
    """The first path of the sampling planner, before shortcutting and smoothing; None if no segment, or not every one,
    needed it."""


@dataclass(frozen=True)
class Optimisation:
    """How `auto` came to a motion of least time; docs/least_time.md."""

    steps: int
    """The number of quadratic programs that were solved, for all segments together."""
    optimised: int
    """The number of segments that are optimised. The others follow their paths, as fast as the limits allow."""
    reason: str = ""
    """Why the motion has a timing that no drive can follow; empty if it has not."""
    passed: int = 0
    """The number of targets that it passes without stopping, as their steps ask (`stop: false`)."""
    stopped: str = ""
    """Why it rests at targets that were to be passed; empty if it does not."""


@dataclass(frozen=True)
class Retiming:
    """How a motion was retimed; the limits it was given are in its peaks."""

    dt: float
    """Time between samples, s."""
    speed: float
    """Share of the velocity limits that was used."""
    dwell: float
    """How long the motion rests at each target before the next, s."""


@dataclass(frozen=True)
class Provenance:
    """Where a motion comes from."""

    scene: str
    """Name of the scene."""
    method: Method
    """The method with its options."""
    engine: str
    """What computed the motion, `native` or `python`."""
    found_by: str
    """What found the path: the method, or with `auto` `qp`, `straight line` or `rrt-connect`; empty if nothing did."""
    path: PathQuality
    """Length and sharpest turn of the path."""
    search: Search | None
    """What `auto` did to find the path; None for the other methods."""
    evaluations: int
    """Number of evaluations of q_dot."""
    planning_time: float
    """Time that planning took, including the certificate, without the samples and the diagnosis of a failure, s."""
    certification_time: float
    """Time that the certificate took, s."""
    retiming: Retiming | None = None
    """How the motion was retimed; None if it was not."""
    optimisation: Optimisation | None = None
    """How the motion was optimised; None if it was not to be."""
    c_mu: float | None = None
    """Gain of the manipulability's gradient for all hands together, also where the method leaves it to the robot."""
