"""Trajectories as tables: CSV, and the arrays of NumPy."""

from __future__ import annotations

import csv
from io import BytesIO, StringIO
from typing import Any

import numpy as np

from humanoid_rail.errors import InvalidInput
from humanoid_rail.trajectory import Trajectory

ARRAYS = ("t", "q", "clearance", "manipulability", "velocity", "acceleration")
"""The arrays of `trajectory.npz` beside those of the hands."""
_NUMPYS = ("file", "allow_pickle")
"""NumPy itself takes these names."""


def csv_bytes(trajectory: Trajectory) -> bytes:
    """Return what `trajectory.csv` holds: times, joints, hands, and the timing of a retimed motion."""
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    header = ["t", *trajectory.joint_names, *(f"{hand}_{axis}" for hand in trajectory.hand_names for axis in "xyz")]
    columns = [trajectory.t, trajectory.q, trajectory.hands.reshape(len(trajectory.t), -1)]
    if trajectory.timing is not None:
        for derivative in ("velocity", "acceleration"):
            header += [f"{joint}_{derivative}" for joint in trajectory.joint_names]
            columns.append(getattr(trajectory.timing, derivative))
    writer.writerow(header)
    writer.writerows(np.column_stack(columns).tolist())
    return text.getvalue().encode()


def npz_bytes(trajectory: Trajectory) -> bytes:
    """Return what `trajectory.npz` holds: times, joints, each hand, clearances, manipulability and the timing.

    Raises:
        InvalidInput: If a hand is called as one of the other arrays.
    """
    for name in trajectory.hand_names:
        if name in (*ARRAYS, *_NUMPYS):
            raise InvalidInput("hands", name, f"names of hands other than {', '.join((*ARRAYS, *_NUMPYS))}")
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
