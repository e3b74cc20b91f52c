"""The frozen result of planning; reading and writing it."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from humanoid_rail.arrays import Array, FrozenArrays, frozen
from humanoid_rail.certificate import Certificate, Contact
from humanoid_rail.errors import InvalidInput
from humanoid_rail.limits import Violation
from humanoid_rail.search import PathQuality, Search


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
    """Time (N,) in s: 0, dt, 2 dt, ... and the end."""
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
    settings: Mapping[str, float | Sequence[float]]
    """The arguments of :func:`plan`: gains, tolerances and times."""

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
        """Whether positions and velocities keep within the joints' limits."""
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
        """Return q (n,) at a time in s: linear between samples, the first or last one outside."""
        return np.array([np.interp(t, self.t, column) for column in self.q.T])

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
            "manipulability_final": float(self.manipulability[-1]),
            "violations": [asdict(violation) for violation in self.violations],
            "scene": self.scene,
            "method": self.method,
            "engine": self.engine,
            "settings": dict(self.settings),
            "joint_names": list(self.joint_names),
            "hand_names": list(self.hand_names),
        }


def write_trajectory(
    trajectory: Trajectory, folder: str | Path, extra: Iterable[tuple[str, str]] = ()
) -> tuple[Path, ...]:
    """Write `trajectory.npz`, `trajectory.csv` and `summary.json` to a folder, which is made if need be.

    The files appear whole and together, or none of them; files of the same names are replaced.

    Args:
        trajectory: What to write.
        folder: Where to.
        extra: Further text files, by name and content.

    Returns:
        The files written.

    Raises:
        InvalidInput: If the folder cannot be written to.
    """
    files = {
        "trajectory.npz": _npz(trajectory),
        "trajectory.csv": _csv(trajectory).encode(),
        **{name: text.encode() for name, text in extra},
        "summary.json": (json.dumps(trajectory.summary(), indent=2) + "\n").encode(),
    }
    check_folder(folder)
    folder = Path(folder)
    made = not folder.exists()
    unfinished = {folder / name: folder / f".{name}.{os.getpid()}" for name in files}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for path, part in unfinished.items():
            part.write_bytes(files[path.name])
        for path, part in unfinished.items():
            part.replace(path)
    except OSError as error:
        for part in unfinished.values():
            part.unlink(missing_ok=True)
        if made and folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()
        raise InvalidInput("out", str(folder), f"a folder that can be written to ({error})") from error
    return tuple(unfinished)


def check_folder(folder: str | Path) -> None:
    """Check, without making it, that a folder can be written to or made.

    Raises:
        InvalidInput: If it cannot.
    """
    path = Path(folder)
    try:
        above = next(p for p in (path, *path.resolve().parents) if p.exists())
    except OSError as error:
        raise InvalidInput("out", str(folder), f"a folder that can be written to ({error})") from error
    if not str(folder) or not above.is_dir() or not os.access(above, os.W_OK | os.X_OK):
        raise InvalidInput("out", str(folder), f"a folder that can be written to; {above} is none")


def read_trajectory(folder: str | Path) -> Trajectory:
    """Return the trajectory that :func:`write_trajectory` wrote to a folder.

    Raises:
        InvalidInput: If the folder does not hold one.
    """
    folder = Path(folder)
    try:
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        with np.load(folder / "trajectory.npz") as arrays:
            return Trajectory(
                t=frozen(arrays["t"]),
                q=frozen(arrays["q"]),
                hands=frozen(np.stack([arrays[name] for name in summary["hand_names"]], axis=1)),
                clearance=frozen(arrays["clearance"]),
                manipulability=frozen(arrays["manipulability"]),
                status=Status(summary["status"]),
                reason=summary["reason"],
                violations=tuple(Violation(**violation) for violation in summary["violations"]),
                certificate=_certificate(summary),
                planning_time=summary["planning_time"],
                certification_time=summary["certification_time"],
                evaluations=summary["evaluations"],
                found_by=summary["found_by"],
                path=PathQuality(**summary["path"]),
                search=_search(summary["search"]),
                joint_names=tuple(summary["joint_names"]),
                hand_names=tuple(summary["hand_names"]),
                scene=summary["scene"],
                method=summary["method"],
                engine=summary["engine"],
                settings=summary["settings"],
            )
    except (OSError, ValueError, KeyError, TypeError, BadZipFile) as error:
        valid = f"a folder with trajectory.npz and summary.json ({error})"
        raise InvalidInput("trajectory", str(folder), valid) from error


def _certificate(summary: Mapping[str, Any]) -> Certificate:
    contact = summary["contact"]
    if contact is not None:
        contact = Contact(**{**contact, "point": tuple(contact["point"])})
    numbers = {name: summary[name] for name in ("min_clearance_obstacles", "min_clearance_self", "clearance_bound")}
    return Certificate(certified=summary["certified"], contact=contact, **numbers)


def _search(summary: Mapping[str, Any] | None) -> Search | None:
    if summary is None:
        return None
    raw = summary["raw"]
    return Search(**{**summary, "raw": None if raw is None else PathQuality(**raw)})


def _npz(trajectory: Trajectory) -> bytes:
    buffer = BytesIO()
    arrays: dict[str, Any] = {
        "t": trajectory.t,
        "q": trajectory.q,
        **{name: trajectory.hands[:, i] for i, name in enumerate(trajectory.hand_names)},
        "clearance": trajectory.clearance,
        "manipulability": trajectory.manipulability,
    }
    np.savez_compressed(buffer, **arrays)
    return buffer.getvalue()


def _csv(trajectory: Trajectory) -> str:
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    coordinates = [f"{hand}_{axis}" for hand in trajectory.hand_names for axis in "xyz"]
    writer.writerow(["t", *trajectory.joint_names, *coordinates])
    hands = trajectory.hands.reshape(len(trajectory.t), -1)
    writer.writerows(np.column_stack([trajectory.t, trajectory.q, hands]).tolist())
    return text.getvalue()
