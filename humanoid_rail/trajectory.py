"""The frozen result of planning."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from humanoid_rail._arrays import Array, FrozenArrays
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.kinematics.joint_limits import Violation
from humanoid_rail.search.effort import PathQuality, Search
from humanoid_rail.timing import Timing

MAX_SAMPLES = 1_000_000
"""The most samples that a trajectory may have."""


class Status(StrEnum):
    """What became of the targets."""

    REACHED = "reached"
    """|e| came down to the tolerance."""
    STALLED = "stalled"
    """The integration could not go on although the hands could still move towards their targets."""
    TIME_LIMIT = "time_limit"
    """The motion lasts longer than it was allowed to."""
    SINGULAR = "singular"
    """An arm is stretched so that its hand cannot get nearer to its target; the others may not have arrived."""
    OVERRUN = "overrun"
    """A moving obstacle runs into the robot, and not even standing still avoids it."""
    TARGET_IN_COLLISION = "target_in_collision"
    """A hand at its target would touch an obstacle or the other hand, or be nearer than the safety distance."""
    TARGET_OUT_OF_REACH = "target_out_of_reach"
    """No configuration within the limits has the hands at their targets, obstacles or not."""
    STUCK = "stuck"
    """No way to the targets was found within the time for planning."""
    UNCERTIFIED = "uncertified"
    """The hands are at their targets, but the way there could not be proven free of contact."""


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(FrozenArrays):
    """A planned motion, sampled. Arrays are read-only. N samples, n joints, h hands, O obstacles."""

    t: Array
    """Time (N,) in s: 0, dt, 2 dt, ... and the end; of several legs so from the beginning of each."""
    q: Array
    """Configurations (N, n), m and rad."""
    hands: Array
    """Positions of the hands (N, h, 3), m, in the base frame."""
    clearance: Array
    """Signed distance of the nearest link from each obstacle (N, O), m.

    Infinite where it is beyond the activation distance and was not asked for (`far_clearances` of :func:`plan`); the
    smallest of each sample is always there.
    """
    manipulability: Array
    """mu of eq. 3.4 (N,)."""
    status: Status
    """What became of the targets."""
    reason: str
    """The status in a sentence, with numbers."""
    violations: tuple[Violation, ...]
    """For each joint the worst excess over each of its limits."""
    certificate: Certificate
    """What is proven of the motion between its samples, for the obstacles and between the links."""
    timing: Timing | None
    """How the motion was retimed; None for the timing of the method, which is linear in q between samples."""
    arrivals: tuple[float, ...]
    """When the hands are at each of the scene's targets in turn, s; those that were not reached are missing."""
    planning_time: float
    """s, the certificate included."""
    certification_time: float
    """s, of the certificate alone."""
    evaluations: int
    """Number of evaluations of q_dot."""
    found_by: str
    """What found the path: the method, or by `auto` `qp`, `straight line` or `rrt-connect`; empty if nothing did."""
    path: PathQuality
    """Length and sharpest turn of the path."""
    search: Search | None
    """What `auto` did to find it; None for the other methods."""
    joint_names: tuple[str, ...]
    """Columns of q."""
    hand_names: tuple[str, ...]
    """Rows of hands."""
    scene: str
    """Name of the scene."""
    method: str
    """How q_dot was found."""
    engine: str
    """What computed it, `native` or `python`."""
    settings: Mapping[str, float | Sequence[float] | Sequence[str]]
    """The arguments of :func:`plan`: gains, tolerances and times, and the names of objectives."""

    def __repr__(self) -> str:
        said = f"{self.status}, {self.duration:.4f} s, {len(self.t)} samples"
        return f"Trajectory({said}, certified={self.certified}, limits_ok={self.limits_ok})"

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
        """Whether positions and velocities keep within the joints' limits, and accelerations if it was retimed."""
        return not self.violations

    @property
    def min_clearance(self) -> float | None:
        """Smallest clearance of all samples in m; None without obstacles."""
        return float(self.clearance.min()) if self.clearance.size else None

    @property
    def certified(self) -> bool:
        """Whether no link touches an obstacle or another link at any time, between samples neither."""
        return self.certificate.certified

    @property
    def min_clearance_obstacles(self) -> float | None:
        """Smallest clearance from an obstacle that was found in m; None without obstacles."""
        return self.certificate.min_clearance_obstacles

    @property
    def min_clearance_self(self) -> float | None:
        """Smallest clearance between two links that was found in m; None without pairs to check."""
        return self.certificate.min_clearance_self

    @property
    def clearance_bound(self) -> float | None:
        """No clearance is smaller at any time, m; None where there is nothing to touch."""
        return self.certificate.clearance_bound

    def configuration(self, t: float) -> Array:
        """Return q (n,) at a time in s, the first or last one outside the motion.

        Between samples it is linear, or a cubic if the motion was retimed.
        """
        if self.timing is None or len(self.t) == 1:
            return np.array([np.interp(t, self.t, column) for column in self.q.T])
        i = int(np.clip(np.searchsorted(self.t, t, side="right"), 1, len(self.t) - 1))
        piece = slice(i - 1, i + 1)
        spline = CubicHermiteSpline(self.t[piece], self.q[piece], self.timing.velocity[piece])
        return np.asarray(spline(np.clip(t, self.t[0], self.t[-1])), float)

    def summary(self) -> dict[str, Any]:
        """Return the result without its samples, as plain data: what `summary.json` holds."""
        return {
            "status": str(self.status),
            "reason": self.reason,
            "certified": self.certified,
            "collision_free": self.collision_free,
            "limits_ok": self.limits_ok,
            "duration": self.duration,
            "planning_time": self.planning_time,
            "certification_time": self.certification_time,
            "evaluations": self.evaluations,
            "found_by": self.found_by,
            "path": asdict(self.path),
            "search": None if self.search is None else asdict(self.search),
            "min_clearance": self.min_clearance,
            "min_clearance_obstacles": self.min_clearance_obstacles,
            "min_clearance_self": self.min_clearance_self,
            "clearance_bound": self.clearance_bound,
            "contact": None if self.certificate.contact is None else asdict(self.certificate.contact),
            "arrivals": list(self.arrivals),
            "peaks": None if self.timing is None else [_finite(asdict(peak)) for peak in self.timing.peaks],
            "manipulability_final": float(self.manipulability[-1]),
            "violations": [asdict(violation) for violation in self.violations],
            "scene": self.scene,
            "method": self.method,
            "engine": self.engine,
            "settings": dict(self.settings),
            "joint_names": list(self.joint_names),
            "hand_names": list(self.hand_names),
        }


def _finite(peak: Mapping[str, Any]) -> dict[str, Any]:
    """Return a peak as JSON has it, which knows no infinity."""
    return {name: None if value == np.inf else value for name, value in peak.items()}
