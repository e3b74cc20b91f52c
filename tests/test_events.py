"""What hands grasp and release along a motion travels with it, through resampling and files."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import plan
from ruamel.yaml import YAML

from humanoid_rail import Event, InvalidInput, Robot, Scene, Trajectory, export, read_plan, read_trajectory, write_plan
from humanoid_rail.io.motion_files import read_motion
from humanoid_rail.io.tables import csv_bytes, npz_bytes

PLACE: dict[str, Any] = {"position": (0.1, -0.2, 1 / 3), "quaternion": (0.8, 0.0, 0.0, 0.6)}


@pytest.fixture(scope="module")
def trajectory(robot: Robot, scene: Scene) -> Trajectory:
    return plan(robot, scene, "gradient-projection", dt=0.25)


@pytest.fixture(scope="module")
def with_events(trajectory: Trajectory) -> Trajectory:
    t = trajectory.t
    events = (
        Event(float(t[3]), "grasp", "part 1", ("left",), **PLACE),
        Event(float(t[3]), "grasp", "bar", ("left", "right"), **PLACE),
        Event(float(t[5]) + 0.1, "release", "part 1", ("left",), **PLACE),
    )
    return replace(trajectory, motion=replace(trajectory.motion, events=events))


def rows(trajectory: Trajectory) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(csv_bytes(trajectory).decode())))


def test_a_table_says_at_which_sample_what_happens(with_events: Trajectory) -> None:
    notes = [row["event"] for row in rows(with_events)]
    assert notes[3] == "grasp part 1 by left; grasp bar by left and right"
    assert notes[5] == f"release part 1 by left at {with_events.events[2].t!r} s"
    assert [i for i, note in enumerate(notes) if note] == [3, 5]


def test_files_of_motions_without_events_are_as_before(trajectory: Trajectory) -> None:
    assert "event" not in rows(trajectory)[0]
    assert "events" not in trajectory.summary()
    with np.load(io.BytesIO(npz_bytes(trajectory))) as arrays:
        assert not [name for name in arrays.files if "event" in name]


def test_arrays_have_times_and_poses_of_events(with_events: Trajectory) -> None:
    with np.load(io.BytesIO(npz_bytes(with_events))) as arrays:
        assert arrays["event"].tolist() == [str(event) for event in with_events.events]
        assert arrays["event_time"].tolist() == [event.t for event in with_events.events]
        assert arrays["event_pose"].tolist() == 3 * [[*PLACE["position"], *PLACE["quaternion"]]]


def test_events_are_read_back_without_loss(robot: Robot, scene: Scene, with_events: Trajectory, tmp_path: Path) -> None:
    write_plan(with_events, robot, scene, tmp_path)
    assert read_trajectory(tmp_path).events == with_events.events
    assert read_plan(tmp_path).trajectory.events == with_events.events
    assert json.loads((tmp_path / "summary.json").read_text())["events"][1]["hands"] == ["left", "right"]


def test_resampling_keeps_events(with_events: Trajectory) -> None:
    finer = with_events.resample(0.05)
    assert finer.events == with_events.events
    notes = [(row["t"], row["event"]) for row in rows(finer) if row["event"]]
    assert [float(t) for t, _ in notes] == pytest.approx([event.t for event in with_events.events[1:]])


@pytest.mark.parametrize("format", ["csv", "npz"])
def test_other_readers_say_that_they_do_not_read_events(
    robot: Robot, scene: Scene, with_events: Trajectory, format: str, tmp_path: Path
) -> None:
    (file,) = export(with_events, robot, scene, format, tmp_path / f"motion.{format}")
    motion = read_motion(file, robot)
    np.testing.assert_array_equal(motion.q, with_events.q)
    assert "event" in motion.ignored


@pytest.mark.parametrize("format", ["json", "yaml"])
def test_messages_of_ros_have_events_beside_them(
    robot: Robot, scene: Scene, with_events: Trajectory, trajectory: Trajectory, format: str, tmp_path: Path
) -> None:
    out = tmp_path / f"motion.{format}"
    written = export(with_events, robot, scene, f"ros-{format}", out)
    assert [path.name for path in written] == [out.name, f"motion.events.{format}"]
    message = out.read_bytes()
    for read in (json.loads, YAML(typ="safe").load):
        notes = read(written[1].read_text())
        assert [(note["kind"], note["object"], tuple(note["hands"])) for note in notes] == [
            (event.kind, event.object, event.hands) for event in with_events.events
        ]
        for note, event in zip(notes, with_events.events, strict=True):
            time = note["time_from_start"]
            assert time["sec"] + 1e-9 * time["nanosec"] == pytest.approx(event.t, abs=1e-9)
            assert tuple(note["pose"]["position"][x] for x in "xyz") == event.position
            assert tuple(note["pose"]["orientation"][x] for x in "wxyz") == event.quaternion
    assert export(trajectory, robot, scene, f"ros-{format}", out) == (out,)
    assert out.read_bytes() == message
    assert not written[1].exists(), "it is of another motion now"


@pytest.mark.parametrize(
    ("field", "wrong"),
    [
        ("kind", "take"),
        ("t", -1.0),
        ("t", float("nan")),
        ("hands", "left"),
        ("hands", ("left", "left")),
        ("position", (0.0, 0.0)),
        ("position", (0.0, 0.0, float("inf"))),
        ("quaternion", (0.0, 0.0, 0.0, 2.0)),
    ],
)
def test_what_is_wrong_with_an_event_is_said(field: str, wrong: object) -> None:
    right = {"t": 1.0, "kind": "grasp", "object": "part", "hands": ("left",), **PLACE}
    with pytest.raises(InvalidInput) as caught:
        Event(**{**right, field: wrong})
    assert caught.value.field == f"event.{field}"


def test_numbers_of_numpy_become_plain() -> None:
    event = Event(np.float64(1.5), "grasp", "part", ("left",), np.arange(3.0), np.array([1.0, 0.0, 0.0, 0.0]))
    assert repr(event) == (
        "Event(t=1.5, kind='grasp', object='part', hands=('left',), position=(0.0, 1.0, 2.0), "
        "quaternion=(1.0, 0.0, 0.0, 0.0), contacts=())"
    )
    assert hash(event) == hash(replace(event))


def test_a_file_with_a_wrong_event_is_refused(
    with_events: Trajectory, robot: Robot, scene: Scene, tmp_path: Path
) -> None:
    write_plan(with_events, robot, scene, tmp_path)
    summary = tmp_path / "summary.json"
    summary.write_text(summary.read_text().replace('"kind": "release"', '"kind": "drop"'))
    with pytest.raises(InvalidInput, match=r"event\.kind"):
        read_trajectory(tmp_path)
