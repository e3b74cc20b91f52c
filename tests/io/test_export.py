"""Trajectories in the formats of other tools, read back as those read them."""

from __future__ import annotations

import csv
import json
import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from conftest import ROOT, changed, rest_to_rest
from ruamel.yaml import YAML

from humanoid_rail import (
    Hand,
    InvalidInput,
    Robot,
    Scene,
    Timing,
    Trajectory,
    plan_case,
    read_trajectory,
    robot_from_urdf,
    write_trajectory,
)
from humanoid_rail._files import write_files
from humanoid_rail.io.export import FORMATS, Format, Job, export
from humanoid_rail.io.ros import joint_trajectory


@pytest.fixture(scope="module")
def raw(robot: Robot) -> Trajectory:
    return plan_case(robot, 3, dt=0.05)


@pytest.fixture(scope="module")
def motion(robot: Robot, raw: Trajectory) -> Trajectory:
    """A retimed motion with numbers that have no decimal point in Python's own notation."""
    motion = rest_to_rest(robot, raw, duration=4.0)
    q = motion.q.copy()
    q[1, :4] = 1e-5, -2e-7, 1e16, 3e-310
    return changed(motion, q=q)


def points(message: dict, name: str) -> np.ndarray:
    return np.array([point[name] for point in message["points"]])


def seconds(message: dict) -> np.ndarray:
    return np.array([p["time_from_start"]["sec"] + 1e-9 * p["time_from_start"]["nanosec"] for p in message["points"]])


def read_json(path: Path) -> dict:
    return json.loads(path.read_text(encoding="utf-8"))


def read_yaml_1_1(path: Path) -> dict:
    """As ros2 topic pub does."""
    return pytest.importorskip("yaml").safe_load(path.read_text(encoding="utf-8"))


def read_yaml_1_2(path: Path) -> dict:
    return YAML(typ="safe", pure=True).load(path)


@pytest.mark.parametrize(
    ("format", "read"),
    [
        ("ros-json", read_json),
        ("ros-json", read_yaml_1_1),
        ("ros-json", read_yaml_1_2),
        ("ros-yaml", read_yaml_1_1),
        ("ros-yaml", read_yaml_1_2),
    ],
)
def test_the_message_is_read_back_exactly(
    motion: Trajectory, robot: Robot, scene: Scene, format: str, read: Callable[[Path], dict], tmp_path: Path
) -> None:
    path = tmp_path / "new" / "message"
    assert export(motion, robot, scene, format, path) == (path,)
    assert [file.name for file in path.parent.iterdir()] == ["message"]
    message = read(path)
    assert message["header"] == {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    assert message["joint_names"] == list(robot.joint_names)
    np.testing.assert_array_equal(points(message, "positions"), motion.q)
    np.testing.assert_array_equal(points(message, "velocities"), motion.timing.velocity)
    np.testing.assert_array_equal(points(message, "accelerations"), motion.timing.acceleration)
    np.testing.assert_allclose(seconds(message), motion.t, rtol=0, atol=0.5e-9)
    assert all(point["effort"] == [] for point in message["points"])


@pytest.mark.parametrize("passive", [False, True])
def test_the_message_is_one_of_ros(motion: Trajectory, robot: Robot, passive: bool) -> None:
    """Through the message definition of ROS 2, to bytes and back."""
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    types = store.types
    plain = joint_trajectory(motion, robot, passive=passive)
    duration = types["builtin_interfaces/msg/Duration"]
    time = types["builtin_interfaces/msg/Time"]

    def point(fields: dict) -> object:
        assert fields.keys() == {"positions", "velocities", "accelerations", "effort", "time_from_start"}
        arrays = {name: np.array(value) for name, value in fields.items() if name != "time_from_start"}
        return types["trajectory_msgs/msg/JointTrajectoryPoint"](
            **arrays, time_from_start=duration(**fields["time_from_start"])
        )

    header = types["std_msgs/msg/Header"](time(**plain["header"]["stamp"]), plain["header"]["frame_id"])
    name = "trajectory_msgs/msg/JointTrajectory"
    message = types[name](header, plain["joint_names"], [point(fields) for fields in plain["points"]])
    again = store.deserialize_cdr(store.serialize_cdr(message, name), name)
    assert again.joint_names == plain["joint_names"]
    np.testing.assert_array_equal([p.positions for p in again.points], points(plain, "positions"))
    np.testing.assert_array_equal([p.velocities for p in again.points], points(plain, "velocities"))
    np.testing.assert_array_equal([p.accelerations for p in again.points], points(plain, "accelerations"))
    nanoseconds = [p.time_from_start.sec * 10**9 + p.time_from_start.nanosec for p in again.points]
    np.testing.assert_allclose(1e-9 * np.array(nanoseconds), motion.t, rtol=0, atol=0.5e-9)


def test_passive_joints_follow_their_leaders(motion: Trajectory, robot: Robot) -> None:
    """Against how the paper has the chest: upright, q* = pi/2 - q3 - q4."""
    message = joint_trajectory(motion, robot, passive=True)
    names = message["joint_names"]
    assert names == list(robot.model.names)[1:]
    column = {name: i for i, name in enumerate(names)}
    for what, start in (("positions", np.pi / 2), ("velocities", 0.0), ("accelerations", 0.0)):
        values = points(message, what)[2:]
        chest = values[:, column["chest_level_waist"]] + values[:, column["chest_level_spine"]]
        leaders = values[:, column["waist_pitch"]] + values[:, column["spine_pitch"]]
        np.testing.assert_allclose(chest, start - leaders, atol=1e-12)
    actuated = [column[name] for name in robot.joint_names]
    np.testing.assert_array_equal(points(message, "velocities")[:, actuated], motion.timing.velocity)


def test_the_goal_of_an_action_is_made_as_the_page_says(
    motion: Trajectory, robot: Robot, scene: Scene, tmp_path: Path
) -> None:
    yaml = pytest.importorskip("yaml")
    page = (ROOT / "docs" / "export.md").read_text(encoding="utf-8")
    (goal,) = re.findall(r"^(\(echo trajectory:.*\)) > goal\.yaml$", page, re.MULTILINE)
    export(motion, robot, scene, "ros-yaml", tmp_path / "case3.yaml")
    made = subprocess.run(goal, shell=True, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert yaml.safe_load(made) == {"trajectory": read_yaml_1_1(tmp_path / "case3.yaml")}


def test_a_plan_without_a_timing_has_positions_alone(raw: Trajectory, robot: Robot) -> None:
    message = joint_trajectory(raw, robot)
    np.testing.assert_array_equal(points(message, "positions"), raw.q)
    assert all(point["velocities"] == point["accelerations"] == [] for point in message["points"])


def test_nanoseconds_of_a_full_second_carry(raw: Trajectory, robot: Robot) -> None:
    t = np.linspace(0.0, 2.0 - 1e-11, len(raw.t))
    assert joint_trajectory(changed(raw, t=t), robot)["points"][-1]["time_from_start"] == {"sec": 2, "nanosec": 0}


@pytest.mark.parametrize("bad", [-1.0, 1e-10, 3e9])
def test_times_that_ros_cannot_tell_apart_or_hold_are_refused(raw: Trajectory, robot: Robot, bad: float) -> None:
    t = np.array([0.0, 0.05, 0.05 + bad]) if bad < 1e9 else np.array([0.0, 1.0, bad])
    with pytest.raises(InvalidInput, match=r"trajectory\.t .*nanosecond"):
        joint_trajectory(changed(raw, t=t, q=raw.q[:3]), robot)


def test_csv_and_npz_are_what_a_plan_is_kept_as(motion: Trajectory, robot: Robot, scene: Scene, tmp_path: Path) -> None:
    export(motion, robot, scene, "csv", tmp_path / "a.csv")
    with (tmp_path / "a.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    assert header[:13] == ["t", *robot.joint_names]
    kinds = ("velocity", "acceleration")
    assert header[19:] == [f"{joint}_{kind}" for kind in kinds for joint in robot.joint_names]
    table = np.array(rows, float)
    np.testing.assert_array_equal(table[:, 1:13], motion.q)
    np.testing.assert_array_equal(table[:, 13:19], motion.hands.reshape(-1, 6))
    np.testing.assert_array_equal(table[:, 19:31], motion.timing.velocity)
    np.testing.assert_array_equal(table[:, 31:], motion.timing.acceleration)
    export(motion, robot, scene, "npz", tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz") as arrays:
        np.testing.assert_array_equal(arrays["q"], motion.q)
        np.testing.assert_array_equal(arrays["velocity"], motion.timing.velocity)


def test_what_cannot_be_exported_is_refused(
    raw: Trajectory, motion: Trajectory, robot: Robot, scene: Scene, tmp_path: Path
) -> None:
    hand = Hand("tip", "left_hand", robot.hands[0].arm)
    other = robot_from_urdf(robot.urdf, None, [hand])
    q = motion.q.copy()
    q[3, 2] = np.nan
    for trajectory, of, format, out, field in (
        (motion, robot, "xml", "a", "format"),
        (motion, robot, ["csv"], "a", "format"),
        (motion.q, robot, "csv", "a", "trajectory"),
        (motion, "robot", "csv", "a", "robot"),
        (motion, robot, "csv", "", "out"),  # the folder itself
        (motion, other, "csv", "a", r"trajectory\.hand_names"),
        (changed(motion, joint_names=robot.joint_names[::-1]), robot, "ros-yaml", "a", r"trajectory\.joint_names"),
        (changed(motion, q=q), robot, "ros-json", "a", r"trajectory\.q"),
        (changed(motion, timing=Timing(q, q, ())), robot, "mujoco", "a", r"trajectory\.velocity"),
        (changed(motion, t=motion.t[:1], q=motion.q[:1]), robot, "mujoco", "a", r"trajectory\.t .*two samples"),
        (raw, robot, "mujoco", "a", r"trajectory\.timing .*retimed"),
        (motion, robot, "ros-json", "x" * 300, "out"),
        (motion, robot, "mujoco", "x" * 300, "out"),
    ):
        with pytest.raises(InvalidInput, match=f"^{field}"):
            export(trajectory, of, scene, format, tmp_path / out)
    assert not any(tmp_path.iterdir())


def test_an_older_file_is_replaced_and_kept_if_the_new_one_cannot_be_written(
    motion: Trajectory, raw: Trajectory, robot: Robot, scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.yaml"
    path.write_text("old")
    write = Path.write_bytes

    def full_disk(path: Path, content: bytes) -> int:
        write(path, content[:10])
        raise OSError("no space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", full_disk)
        with pytest.raises(InvalidInput, match="no space left"):
            export(motion, robot, scene, "ros-yaml", path)
    assert [(file.name, file.read_text()) for file in tmp_path.iterdir()] == [("a.yaml", "old")]
    export(raw, robot, scene, "ros-yaml", path)
    assert path.read_text().startswith("header:")


def test_an_export_does_not_replace_a_plan(motion: Trajectory, robot: Robot, scene: Scene, tmp_path: Path) -> None:
    """Both can be in one folder, whichever comes first."""
    finite = changed(motion, q=np.clip(motion.q, robot.lower, robot.upper))
    for folder, order in ((tmp_path / "a", (1, -1)), (tmp_path / "b", (-1, 1))):
        for which in order:
            if which > 0:
                write_trajectory(finite, folder)
            else:
                export(finite, robot, scene, "mujoco", folder)
        np.testing.assert_array_equal(read_trajectory(folder).q, finite.q)
        with np.load(folder / "motion.npz") as arrays:
            np.testing.assert_array_equal(arrays["time"], finite.t)
        with pytest.raises(InvalidInput, match=r"out .*a new name"):
            export(finite, robot, scene, "csv", folder / "trajectory.csv")


def test_every_format_can_be_written(motion: Trajectory, robot: Robot, scene: Scene, tmp_path: Path) -> None:
    finite = changed(motion, q=np.clip(motion.q, robot.lower, robot.upper))
    for format in FORMATS:
        for path in export(finite, robot, scene, format, tmp_path / format):
            assert path.stat().st_size > 1000


def test_a_format_is_registered_in_one_place(
    motion: Trajectory, robot: Robot, scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def write(job: Job) -> tuple[Path, ...]:
        return write_files(job.out, {"name.txt": f"{job.scene.name} {len(job.trajectory.t)} {job.passive}".encode()})

    monkeypatch.setattr(
        "humanoid_rail.io.export.FORMATS", {**FORMATS, "names": Format("names", write, has_passive=True)}
    )
    (path,) = export(motion, robot, scene, "names", tmp_path, passive=True)
    assert path.read_text() == f"{scene.name} {len(motion.t)} True"


def test_the_test_motion_is_at_rest_at_both_ends_and_its_derivatives_are_right(robot: Robot, raw: Trajectory) -> None:
    motion = rest_to_rest(robot, raw, duration=4.0, dt=0.001)
    for end in (0, -1):
        np.testing.assert_allclose(motion.timing.velocity[end], 0.0, atol=1e-12)
        np.testing.assert_allclose(motion.q[end], raw.q[end], atol=1e-12)
    h = motion.t[1] - motion.t[0]
    for values, derivative in (
        (motion.q, motion.timing.velocity),
        (motion.timing.velocity, motion.timing.acceleration),
    ):
        np.testing.assert_allclose((values[2:] - values[:-2]) / (2 * h), derivative[1:-1], atol=0.05)
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.full_configuration(motion.q[7]))
    frames = [data.oMf[robot.model.getFrameId(hand.frame)].translation for hand in robot.hands]
    np.testing.assert_allclose(motion.hands[7], frames, atol=1e-12)
