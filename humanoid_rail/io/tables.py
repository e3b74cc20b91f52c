"""Trajectories as tables: CSV, and the arrays of NumPy."""

from __future__ import annotations

import csv
from io import BytesIO, StringIO
from typing import Any

import numpy as np

from humanoid_rail.errors import InvalidInput
from humanoid_rail.events import notes_at
from humanoid_rail.trajectory import Trajectory

ARRAYS = ("t", "q", "clearance", "manipulability", "velocity", "acceleration", "event", "event_time", "event_pose")
"""The arrays of `trajectory.npz` beside those of the hands."""
_NUMPYS = ("file", "allow_pickle")
"""NumPy itself takes these names."""
EVENT = "event"
"""The column of a table that says what the hands grasp and release."""


def csv_bytes(trajectory: Trajectory) -> bytes:
    """Return what `trajectory.csv` holds: times, joints, hands, the timing of a retimed motion, and its events.

    A motion without events has no column for them.
    """
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    header = ["t", *trajectory.joint_names, *(f"{hand}_{axis}" for hand in trajectory.hand_names for axis in "xyz")]
    columns = [trajectory.t, trajectory.q, trajectory.hands.reshape(len(trajectory.t), -1)]
    if trajectory.timing is not None:
        for derivative in ("velocity", "acceleration"):
            header += [f"{joint}_{derivative}" for joint in trajectory.joint_names]
            columns.append(getattr(trajectory.timing, derivative))
    rows = np.column_stack(columns).tolist()
    if events := trajectory.motion.events:
        header.append(EVENT)
        rows = [[*row, note] for row, note in zip(rows, notes_at(trajectory.t, events), strict=True)]
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue().encode()


def npz_bytes(trajectory: Trajectory) -> bytes:
    """Return what `trajectory.npz` holds: times, joints, hands, clearances, manipulability, timing and events.

    Of an event there is what it is in words, its time, and the object's pose: position and quaternion w, x, y, z.

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
    if events := trajectory.motion.events:
        arrays["event"] = np.array([str(event) for event in events])
        arrays["event_time"] = np.array([event.t for event in events])
        arrays["event_pose"] = np.array([[*event.position, *event.quaternion] for event in events])
    np.savez_compressed(buffer, **arrays)
    return buffer.getvalue()
