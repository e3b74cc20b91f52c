"""The result of planning, in one object; `result.py` and `samples.py` have its parts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.diagnosis import Diagnosis
from humanoid_rail.errors import MISSING, InvalidInput
from humanoid_rail.events import Event, events_data
from humanoid_rail.holding.phases import samples_of
from humanoid_rail.kinematics.joint_limits import Violation
from humanoid_rail.kinematics.path_metric import PathQuality
from humanoid_rail.model.robot import Robot
from humanoid_rail.resampling import evaluate, resampled
from humanoid_rail.result import Method, Motion, Provenance, Search, Status, Timing, Verdict
from humanoid_rail.samples import Samples, interleaved
from humanoid_rail.scene.scene import Scene
from humanoid_rail.trajectory_html import table_of


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """A planned motion with the verdict on it. Arrays are read-only. N samples, n joints, h hands, O obstacles.

    `hands`, `clearance` and `manipulability` are computed when one of them is first asked for; see :class:`Samples`.
    What is used most is at hand without going through the parts: `t`, `q`, `status`, `reason`, `certified` and so on.
    """

    motion: Motion
    samples: Samples
    verdict: Verdict
    provenance: Provenance
    robot: Robot | None = None
    """The robot that it was planned for; None if it is not known, as where only a trajectory was read."""
    scene: Scene | None = None
    """The scene that it was planned in; None if it is not known."""

    def __repr__(self) -> str:
        said = f"{self.status}, {self.duration:.4f} s, {len(self.t)} samples"
        return f"Trajectory({said}, certified={self.certified}, limits_ok={self.limits_ok})"

    def _repr_html_(self) -> str:
        """Return a table of what came of the plan, which notebooks show."""
        return table_of(self.provenance, self.verdict, (self.duration, self.least_duration), len(self.t))

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
        """The timing of an optimised or retimed motion; None for one that is linear in q between samples."""
        return self.motion.timing

    @property
    def events(self) -> tuple[Event, ...]:
        """What happens to objects along it, in order: grasps, releases and what may touch meanwhile."""
        return self.motion.events

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
    def diagnosis(self) -> Diagnosis | None:
        """Why the plan failed: the nearest miss, what blocks there, and what would help; None if it did not."""
        return self.verdict.diagnosis

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
        """Time that planning took, including the certificate, without the samples and the diagnosis of a failure, s."""
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
    def least_duration(self) -> float | None:
        """A lower bound of the duration, s; None if it is not known. See :class:`Verdict`."""
        return self.verdict.least_duration

    @property
    def collision_free(self) -> bool:
        """Whether every clearance from an obstacle is at least 0 (eq. 3.3) at every sample; see also `certified`."""
        return bool((self.clearance >= 0).all())

    @property
    def limits_ok(self) -> bool:
        """Whether positions and velocities keep the joint limits, and so do accelerations if it has a timing."""
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

        Between samples it is linear, or a cubic if the motion has a timing.
        """
        q, _, _ = evaluate(self.motion, np.array([t], float))
        there: Array = q[0]
        return there

    def planned_for(self, robot: Robot | None = None, scene: Scene | None = None) -> tuple[Robot, Scene]:
        """Return the robot and the scene it was planned for, or those that are given instead.

        Raises:
            InvalidInput: If one is neither given nor known.
        """
        robot, scene = robot if robot is not None else self.robot, scene if scene is not None else self.scene
        if robot is None or scene is None:
            valid = "given, or known as in what plan() returns and in read_plan(folder).trajectory"
            raise InvalidInput("trajectory.robot" if robot is None else "trajectory.scene", MISSING, valid)
        return robot, scene

    def resample(self, dt: float) -> Trajectory:
        """Return the same motion with a sample every dt in s, and at the samples that it has.

        Positions, velocities and accelerations are those of the motion at these times. Between its samples it is what
        it was before, up to rounding, which is far below the 1 um that proofs keep. So status, certificate and
        violations stay as they are. For samples at other times only, which make it another motion, use :func:`retime`.

        Args:
            dt: Time between samples, s. They are evenly spaced if that between the motion's own is a multiple of it.

        Raises:
            InvalidInput: If dt is no number greater than 0 or so small that there are more than a million samples, or
                the trajectory does not know its robot and scene.
        """
        robot, scene = self.planned_for()
        motion, own = resampled(self.motion, dt)
        between = samples_of(robot, scene, motion, self.method, chosen=~own)
        return replace(self, motion=motion, samples=interleaved(own, self.samples, between))

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
            "least_duration": self.least_duration,
            "min_clearance": self.min_clearance,
            "diagnosis": None if self.diagnosis is None else self.diagnosis.summary(),
            "certificate": None if certificate is None else _certificate_data(certificate),
            "violations": [asdict(violation) for violation in self.violations],
            "arrivals": list(self.arrivals),
            **({"events": events_data(self.events)} if self.events else {}),
            **({"ends": list(self.motion.ends)} if self.motion.ends else {}),
            "peaks": None if self.timing is None else [_finite(asdict(peak)) for peak in self.timing.peaks],
            "manipulability_final": float(self.manipulability[-1]),
            "scene": self.provenance.scene,
            "method": {"name": self.method.name, **self.method.options()},
            "c_mu": self.provenance.c_mu,
            "engine": self.engine,
            "found_by": self.found_by,
            "path": asdict(self.path),
            "search": None if self.search is None else asdict(self.search),
            "evaluations": self.evaluations,
            "planning_time": self.planning_time,
            "certification_time": self.certification_time,
            "optimisation": None if self.provenance.optimisation is None else asdict(self.provenance.optimisation),
            "retiming": None if self.provenance.retiming is None else asdict(self.provenance.retiming),
            "joint_names": list(self.joint_names),
            "hand_names": list(self.hand_names),
        }


def _finite(peak: Mapping[str, Any]) -> dict[str, Any]:
    """Return a peak as JSON has it, which knows no infinity."""
    return {name: None if value == np.inf else value for name, value in peak.items()}


def _certificate_data(certificate: Certificate) -> dict[str, Any]:
    return {**asdict(certificate), "deviations": [deviation.data() for deviation in certificate.deviations]}
