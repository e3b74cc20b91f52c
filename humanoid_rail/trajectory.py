"""The result of planning: the motion, its samples, the verdict on it and where it comes from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from humanoid_rail._arrays import Array, FrozenArrays
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.kinematics.joint_limits import Violation
from humanoid_rail.kinematics.path_metric import PathQuality

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline

MAX_SAMPLES = 1_000_000
"""A trajectory has at most this many samples."""


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
    """No configuration within the joint limits has the hands at their targets, with or without obstacles."""
    STUCK = "stuck"
    """No path to the targets was found within the budget of edge checks."""
    PLANNING_TIMEOUT = "planning_timeout"
    """Planning was cut off by `max_planning_time`."""
    UNCERTIFIED = "uncertified"
    """The hands reach their targets, but the motion could not be proven free of contact."""


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
    """The timing that :func:`humanoid_rail.retime` gives a motion. N samples, n joints.

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
    """Times (N,) in s: 0, dt, 2 dt, ... and the end; with several segments, so from the start of each."""
    q: Array
    """Configurations (N, n), m and rad."""
    joint_names: tuple[str, ...]
    """The columns of q."""
    timing: Timing | None = None
    """The timing of a retimed motion; None for the timing of the method, which is linear in q between samples."""


@dataclass(frozen=True, eq=False)
class Samples(FrozenArrays):
    """What is true of the robot at each sample. N samples, h hands, O obstacles."""

    hands: Array
    """Positions of the hands (N, h, 3), m, in the base frame."""
    hand_names: tuple[str, ...]
    """The second axis of hands."""
    clearance: Array
    """Signed distance of the nearest link from each obstacle (N, O), m.

    Infinite where it is beyond the activation distance and was not asked for (`far_clearances`); the smallest of each
    sample is always there.
    """
    manipulability: Array
    """mu of eq. 3.4 (N,)."""


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
    """Time that planning took, including the certificate, s."""
    certification_time: float
    """Time that the certificate took, s."""
    retiming: Mapping[str, float] | None = None
    """The options of the retiming, `speed` and `dwell` (s); None if the motion was not retimed."""


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """A planned motion with the verdict on it. Arrays are read-only. N samples, n joints, h hands, O obstacles.

    What is used most is at hand without going through the parts: `t`, `q`, `status`, `reason`, `certified` and so on.
    """

    motion: Motion
    samples: Samples
    verdict: Verdict
    provenance: Provenance

    def __repr__(self) -> str:
        said = f"{self.status}, {self.duration:.4f} s, {len(self.t)} samples"
        return f"Trajectory({said}, certified={self.certified}, limits_ok={self.limits_ok})"

    @property
    def t(self) -> Array:
        """Times (N,), s."""
        return self.motion.t

    @property
    def q(self) -> Array:
        """Configurations (N, n), m and rad."""
        return self.motion.q

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The columns of q."""
        return self.motion.joint_names

    @property
    def timing(self) -> Timing | None:
        """The timing of a retimed motion; None for the timing of the method, which is linear in q between samples."""
        return self.motion.timing

    @property
    def hands(self) -> Array:
        """Positions of the hands (N, h, 3), m, in the base frame."""
        return self.samples.hands

    @property
    def hand_names(self) -> tuple[str, ...]:
        """The second axis of hands."""
        return self.samples.hand_names

    @property
    def clearance(self) -> Array:
        """Signed distance of the nearest link from each obstacle (N, O), m; see :class:`Samples`."""
        return self.samples.clearance

    @property
    def manipulability(self) -> Array:
        """Mu of eq. 3.4 (N,)."""
        return self.samples.manipulability

    @property
    def status(self) -> Status:
        """What became of the targets."""
        return self.verdict.status

    @property
    def reason(self) -> str:
        """The status in a sentence, with numbers."""
        return self.verdict.reason

    @property
    def certificate(self) -> Certificate | None:
        """What is proven of the motion; None where no native engine was there to prove it."""
        return self.verdict.certificate

    @property
    def violations(self) -> tuple[Violation, ...]:
        """For each joint the worst excess over each of its limits."""
        return self.verdict.violations

    @property
    def arrivals(self) -> tuple[float, ...]:
        """When the hands are at each of the scene's targets in turn, s."""
        return self.verdict.arrivals

    @property
    def scene(self) -> str:
        """Name of the scene."""
        return self.provenance.scene

    @property
    def method(self) -> Method:
        """The method with its options."""
        return self.provenance.method

    @property
    def engine(self) -> str:
        """What computed the motion, `native` or `python`."""
        return self.provenance.engine

    @property
    def found_by(self) -> str:
        """What found the path; empty if nothing did."""
        return self.provenance.found_by

    @property
    def path(self) -> PathQuality:
        """Length and sharpest turn of the path."""
        return self.provenance.path

    @property
    def search(self) -> Search | None:
        """What `auto` did to find the path; None for the other methods."""
        return self.provenance.search

    @property
    def evaluations(self) -> int:
        """Number of evaluations of q_dot."""
        return self.provenance.evaluations

    @property
    def planning_time(self) -> float:
        """Time that planning took, including the certificate, s."""
        return self.provenance.planning_time

    @property
    def certification_time(self) -> float:
        """Time that the certificate took, s."""
        return self.provenance.certification_time

    @property
    def duration(self) -> float:
        """T in s."""
        return float(self.t[-1])

    @property
    def collision_free(self) -> bool:
        """Whether every clearance from an obstacle is at least 0 (eq. 3.3) at every sample; see also `certified`."""
        return bool((self.clearance >= 0).all())

    @property
    def limits_ok(self) -> bool:
        """Whether positions and velocities keep the joint limits, and so do accelerations if it was retimed."""
        return not self.violations

    @property
    def min_clearance(self) -> float | None:
        """Smallest clearance of all samples in m; None without obstacles."""
        return float(self.clearance.min()) if self.clearance.size else None

    @property
    def certified(self) -> bool:
        """Whether it is proven that no link touches an obstacle or another link, including between samples."""
        return self.certificate is not None and self.certificate.certified

    @property
    def min_clearance_obstacles(self) -> float | None:
        """Smallest clearance from an obstacle that the certificate found in m; None without obstacles."""
        return None if self.certificate is None else self.certificate.min_clearance_obstacles

    @property
    def min_clearance_self(self) -> float | None:
        """Smallest clearance between two links that the certificate found in m; None without pairs to check."""
        return None if self.certificate is None else self.certificate.min_clearance_self

    @property
    def clearance_bound(self) -> float | None:
        """A lower bound of every clearance at all times, m; None where there is nothing to touch."""
        return None if self.certificate is None else self.certificate.clearance_bound

    def configuration(self, t: float) -> Array:
        """Return q (n,) at a time in s; outside the motion the first or the last one.

        Between samples it is linear, or a cubic if the motion was retimed.
        """
        if self.timing is None or len(self.t) == 1:
            return np.array([np.interp(t, self.t, column) for column in self.q.T])
        i = int(np.clip(np.searchsorted(self.t, t, side="right"), 1, len(self.t) - 1))
        spline = _spline(self.motion, slice(i - 1, i + 1))
        return np.asarray(spline(np.clip(t, self.t[0], self.t[-1])), float)

    def summary(self) -> dict[str, Any]:
        """Return the result without its samples, as plain data: what `summary.json` holds."""
        certificate = self.certificate
        return {
            "status": str(self.status),
            "reason": self.reason,
            "certified": self.certified,
            "collision_free": self.collision_free,
            "limits_ok": self.limits_ok,
            "duration": self.duration,
            "min_clearance": self.min_clearance,
            "certificate": None if certificate is None else asdict(certificate),
            "violations": [asdict(violation) for violation in self.violations],
            "arrivals": list(self.arrivals),
            "peaks": None if self.timing is None else [_finite(asdict(peak)) for peak in self.timing.peaks],
            "manipulability_final": float(self.manipulability[-1]),
            "scene": self.scene,
            "method": {"name": self.method.name, **self.method.options()},
            "engine": self.engine,
            "found_by": self.found_by,
            "path": asdict(self.path),
            "search": None if self.search is None else asdict(self.search),
            "evaluations": self.evaluations,
            "planning_time": self.planning_time,
            "certification_time": self.certification_time,
            "retiming": None if self.provenance.retiming is None else dict(self.provenance.retiming),
            "joint_names": list(self.joint_names),
            "hand_names": list(self.hand_names),
        }


def _spline(motion: Motion, piece: slice) -> CubicHermiteSpline:
    """Return the cubic spline through a piece of a retimed motion."""
    # Imported here: it takes longer than the whole package.
    from scipy.interpolate import CubicHermiteSpline

    assert motion.timing is not None
    return CubicHermiteSpline(motion.t[piece], motion.q[piece], motion.timing.velocity[piece])


def _finite(peak: Mapping[str, Any]) -> dict[str, Any]:
    """Return a peak as JSON has it, which knows no infinity."""
    return {name: None if value == np.inf else value for name, value in peak.items()}
