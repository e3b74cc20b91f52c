"""Reading and writing trajectories."""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any
from zipfile import BadZipFile

import numpy as np

from humanoid_rail._arrays import frozen
from humanoid_rail._files import write_files
from humanoid_rail.collision.certificate import Certificate, Contact
from humanoid_rail.diagnosis import read_diagnosis
from humanoid_rail.errors import InvalidInput
from humanoid_rail.events import read_events
from humanoid_rail.io.tables import csv_bytes, npz_bytes
from humanoid_rail.kinematics.deviation import deviation_of
from humanoid_rail.kinematics.joint_limits import Violation
from humanoid_rail.kinematics.path_metric import PathQuality
from humanoid_rail.kinematics.state import Course
from humanoid_rail.model.pairs import UncheckedPair
from humanoid_rail.planning.methods import METHODS
from humanoid_rail.planning.options import PlanningMethod
from humanoid_rail.result import Motion, Optimisation, Peak, Provenance, Retiming, Search, Status, Timing, Verdict
from humanoid_rail.samples import Samples, known_samples
from humanoid_rail.scene.covers import Cover
from humanoid_rail.trajectory import Trajectory

DAMAGED = (BadZipFile, RuntimeError, zlib.error)
"""What zipfile raises for files that are damaged; RuntimeError where they seem to be encrypted."""
SUMMARY = "summary.json"
"""The file by which the folder of a plan is known."""
SAMPLES, TABLE = "trajectory.npz", "trajectory.csv"
"""The files with the samples, as arrays and as a table."""
LEFT_TO_THE_ROBOT = ("c_mu",)
"""Options that say nothing where they are null, and not infinity."""
TRAJECTORY_FILES = (SAMPLES, TABLE, SUMMARY)
"""A trajectory is written to these files."""


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
            SAMPLES: npz_bytes(trajectory),
            TABLE: csv_bytes(trajectory),
            **extra,
            SUMMARY: (json.dumps(trajectory.summary(), indent=2) + "\n").encode(),
        },
    )


def read_trajectory(folder: str | Path) -> Trajectory:
    """Return the trajectory that :func:`write_trajectory` wrote to a folder.

    Functions among the options of its method, objectives and equalities, are not in the files: the method of the
    trajectory has none.

    Raises:
        InvalidInput: If the folder does not hold one.
    """
    folder = Path(folder)
    try:
        summary = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
        with np.load(folder / SAMPLES) as arrays:
            trajectory = Trajectory(
                _motion(summary, arrays), _samples(summary, arrays), _verdict(summary), _provenance(summary)
            )
        _check_shapes(trajectory)
    except (OSError, EOFError, LookupError, TypeError, ValueError, AttributeError, *DAMAGED) as error:
        why = f"{error} is missing" if isinstance(error, KeyError) else error
        valid = f"a folder with trajectory.npz and summary.json, as write_trajectory writes them ({why})"
        raise InvalidInput("trajectory", str(folder), valid) from error
    return trajectory


def _motion(summary: Mapping[str, Any], arrays: Mapping[str, Any]) -> Motion:
    timing = None
    if summary["peaks"] is not None:
        # JSON knows no infinity.
        peaks: list[dict[str, Any]] = [
            {name: np.inf if value is None else value for name, value in peak.items()} for peak in summary["peaks"]
        ]
        derivatives = frozen(arrays["velocity"]), frozen(arrays["acceleration"])
        timing = Timing(*derivatives, tuple(Peak(**peak) for peak in peaks))
    events = read_events(summary.get("events", ()))
    ends = tuple(summary.get("ends", ()))
    return Motion(frozen(arrays["t"]), frozen(arrays["q"]), tuple(summary["joint_names"]), timing, events, ends)


def _samples(summary: Mapping[str, Any], arrays: Mapping[str, Any]) -> Samples:
    course = Course(
        hands=frozen(np.stack([arrays[name] for name in summary["hand_names"]], axis=1)),
        manipulability=frozen(arrays["manipulability"]),
        clearance=frozen(arrays["clearance"]),
    )
    return known_samples(tuple(summary["hand_names"]), course)


def _verdict(summary: Mapping[str, Any]) -> Verdict:
    return Verdict(
        status=Status(summary["status"]),
        reason=summary["reason"],
        certificate=_certificate(summary["certificate"]),
        violations=tuple(Violation(**violation) for violation in summary["violations"]),
        arrivals=tuple(summary["arrivals"]),
        least_duration=summary.get("least_duration"),
        diagnosis=read_diagnosis(summary.get("diagnosis")),
    )


def _certificate(certificate: Mapping[str, Any] | None) -> Certificate | None:
    if certificate is None:
        return None
    contact = certificate["contact"]
    if contact is not None:
        contact = Contact(**{**contact, "point": tuple(contact["point"])})
    pairs = tuple(UncheckedPair(**pair) for pair in certificate["unchecked_pairs"])
    bare = tuple(certificate["links_without_body"])
    given = {
        "contact": contact,
        "unchecked_pairs": pairs,
        "links_without_body": bare,
        # Files of before have none of these.
        "deviations": tuple(deviation_of(deviation) for deviation in certificate.get("deviations", ())),
        "covers": tuple(Cover(**cover) for cover in certificate.get("covers", ())),
    }
    return Certificate(**{**certificate, **given})


def _provenance(summary: Mapping[str, Any]) -> Provenance:
    return Provenance(
        scene=summary["scene"],
        method=_method(summary["method"]),
        engine=summary["engine"],
        found_by=summary["found_by"],
        path=PathQuality(**summary["path"]),
        search=_search(summary["search"]),
        evaluations=summary["evaluations"],
        planning_time=summary["planning_time"],
        certification_time=summary["certification_time"],
        c_mu=summary.get("c_mu"),
        optimisation=None if (done := summary.get("optimisation")) is None else Optimisation(**done),
        retiming=None if summary["retiming"] is None else Retiming(**summary["retiming"]),
    )


def _method(method: Mapping[str, Any]) -> PlanningMethod:
    """Return a method from its name and its options.

    Raises:
        ValueError: If there is no method of that name, it does not have one of the options, or one is not valid.
    """
    if method["name"] not in METHODS:
        raise ValueError(f"the method is {method['name']!r}, not one of {', '.join(METHODS)}")
    # JSON knows no infinity, which is written as null, and of functions only their names were written.
    options: dict[str, Any] = {
        name: value if value is not None or name in LEFT_TO_THE_ROBOT else np.inf
        for name, value in method.items()
        if name != "name" and not (isinstance(value, list) and any(isinstance(element, str) for element in value))
    }
    return METHODS[method["name"]](**options)


def _search(search: Mapping[str, Any] | None) -> Search | None:
    if search is None:
        return None
    raw = search["raw"]
    return Search(**{**search, "raw": None if raw is None else PathQuality(**raw)})


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
