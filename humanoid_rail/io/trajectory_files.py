"""Reading and writing trajectories; writing files that appear when they are whole."""

from __future__ import annotations

import csv
import json
import os
import zlib
from collections.abc import Mapping
from io import BytesIO, StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import Any
from zipfile import BadZipFile

import numpy as np

from humanoid_rail._arrays import frozen
from humanoid_rail.collision.certificate import Certificate, Contact
from humanoid_rail.errors import InvalidInput
from humanoid_rail.kinematics.joint_limits import Violation
from humanoid_rail.search.effort import PathQuality, Search
from humanoid_rail.timing import Peak, Timing
from humanoid_rail.result import Status
from humanoid_rail.trajectory import Trajectory

DAMAGED = (BadZipFile, RuntimeError, zlib.error)
"""What zipfile raises for files that are damaged; RuntimeError where they seem to be encrypted."""
SUMMARY = "summary.json"
"""The file by which the folder of a plan is known."""


def write_trajectory(
    trajectory: Trajectory, folder: str | Path, extra: Mapping[str, bytes] = MappingProxyType({})
) -> tuple[Path, ...]:
    """Write `trajectory.npz`, `trajectory.csv` and `summary.json` to a folder, which is made if need be.

    Every file is written before the first appears; files of the same names are replaced.

    Args:
        trajectory: What to write.
        folder: Where to.
        extra: Further files: their contents by name.

    Returns:
        The files written.

    Raises:
        InvalidInput: If the folder cannot be written to.
    """
    return write_files(
        folder,
        {
            "trajectory.npz": npz_bytes(trajectory),
            "trajectory.csv": csv_bytes(trajectory),
            **extra,
            SUMMARY: (json.dumps(trajectory.summary(), indent=2) + "\n").encode(),
        },
    )


def write_files(folder: str | Path, files: Mapping[str, bytes]) -> tuple[Path, ...]:
    """Write files to a folder, which is made if need be. Every file is written before the first appears.

    Args:
        folder: Where to.
        files: What is in the files, by name; files of these names are replaced.

    Returns:
        The files written.

    Raises:
        InvalidInput: If the folder cannot be written to.
    """
    check_folder(folder)
    folder = Path(folder)
    made = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # Replaced when all of them are written.
        with TemporaryDirectory(prefix=".unfinished-", dir=folder) as unfinished:
            for name, content in files.items():
                (Path(unfinished) / name).write_bytes(content)
            for name in files:
                (Path(unfinished) / name).replace(folder / name)
    except OSError as error:
        if made and folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()
        raise InvalidInput("out", str(folder), f"a folder that can be written to ({error})") from error
    return tuple(folder / name for name in files)


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
        summary = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
        with np.load(folder / "trajectory.npz") as arrays:
            trajectory = Trajectory(
                t=frozen(arrays["t"]),
                q=frozen(arrays["q"]),
                hands=frozen(np.stack([arrays[name] for name in summary["hand_names"]], axis=1)),
                clearance=frozen(arrays["clearance"]),
                manipulability=frozen(arrays["manipulability"]),
                status=Status(summary["status"]),
                reason=summary["reason"],
                violations=tuple(Violation(**violation) for violation in summary["violations"]),
                certificate=_certificate(summary),
                timing=_timing(summary["peaks"], arrays),
                arrivals=tuple(summary["arrivals"]),
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
        _check_shapes(trajectory)
    except (OSError, EOFError, LookupError, TypeError, ValueError, AttributeError, *DAMAGED) as error:
        why = f"{error} is missing" if isinstance(error, KeyError) else error
        valid = f"a folder with trajectory.npz and summary.json, as write_trajectory writes them ({why})"
        raise InvalidInput("trajectory", str(folder), valid) from error
    return trajectory


def _check_shapes(trajectory: Trajectory) -> None:
    """Check that there is something for each sample, each joint and each hand.

    Raises:
        ValueError: If there is not.
    """
    N, n, h = len(trajectory.t), len(trajectory.joint_names), len(trajectory.hand_names)
    shapes = {"t": (N,), "q": (N, n), "hands": (N, h, 3), "manipulability": (N,)}
    found = {name: getattr(trajectory, name) for name in shapes}
    if trajectory.timing is not None:
        shapes |= {"velocity": (N, n), "acceleration": (N, n)}
        found |= {"velocity": trajectory.timing.velocity, "acceleration": trajectory.timing.acceleration}
    for name, shape in shapes.items():
        if found[name].shape != shape or N == 0:
            raise ValueError(f"{name} is of shape {found[name].shape}, not {shape} with 1 or more samples")
    if trajectory.clearance.ndim != 2 or len(trajectory.clearance) != N:
        raise ValueError(f"clearance is of shape {trajectory.clearance.shape}, not ({N}, obstacles)")


def _certificate(summary: Mapping[str, Any]) -> Certificate:
    contact = summary["contact"]
    if contact is not None:
        contact = Contact(**{**contact, "point": tuple(contact["point"])})
    numbers = {name: summary[name] for name in ("min_clearance_obstacles", "min_clearance_self", "clearance_bound")}
    return Certificate(certified=summary["certified"], contact=contact, **numbers)


def _timing(peaks: list[dict[str, Any]] | None, arrays: Mapping[str, Any]) -> Timing | None:
    if peaks is None:
        return None
    found: list[dict[str, Any]] = [{k: np.inf if v is None else v for k, v in peak.items()} for peak in peaks]
    return Timing(frozen(arrays["velocity"]), frozen(arrays["acceleration"]), tuple(Peak(**peak) for peak in found))


def _search(summary: Mapping[str, Any] | None) -> Search | None:
    if summary is None:
        return None
    raw = summary["raw"]
    return Search(**{**summary, "raw": None if raw is None else PathQuality(**raw)})


def npz_bytes(trajectory: Trajectory) -> bytes:
    """Return what `trajectory.npz` holds."""
    buffer = BytesIO()
    arrays: dict[str, Any] = {
        "t": trajectory.t,
        "q": trajectory.q,
        **{name: trajectory.hands[:, i] for i, name in enumerate(trajectory.hand_names)},
        "clearance": trajectory.clearance,
        "manipulability": trajectory.manipulability,
    }
    if trajectory.timing is not None:
        arrays |= {"velocity": trajectory.timing.velocity, "acceleration": trajectory.timing.acceleration}
    np.savez_compressed(buffer, **arrays)
    return buffer.getvalue()


def csv_bytes(trajectory: Trajectory) -> bytes:
    """Return what `trajectory.csv` holds: times, joints, hands, and velocities of the joints if it was retimed."""
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    header = ["t", *trajectory.joint_names, *(f"{hand}_{axis}" for hand in trajectory.hand_names for axis in "xyz")]
    columns = [trajectory.t, trajectory.q, trajectory.hands.reshape(len(trajectory.t), -1)]
    if trajectory.timing is not None:
        header += [f"{joint}_velocity" for joint in trajectory.joint_names]
        columns.append(trajectory.timing.velocity)
    writer.writerow(header)
    writer.writerows(np.column_stack(columns).tolist())
    return text.getvalue().encode()
