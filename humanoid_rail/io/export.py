"""Trajectories in the formats of other tools. A format is added by an entry of `FORMATS`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from humanoid_rail._files import check_file, check_folder, write_file, write_files
from humanoid_rail.errors import InvalidInput, check_kind, did_you_mean
from humanoid_rail.io.robot_motion import check_motion
from humanoid_rail.io.ros import joint_trajectory, json_text, notes_text, yaml_text
from humanoid_rail.io.tables import csv_bytes, npz_bytes
from humanoid_rail.io.trajectory_files import SUMMARY
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.scene import Scene
from humanoid_rail.trajectory import Trajectory


@dataclass(frozen=True)
class Job:
    """What is to be exported, and where to."""

    trajectory: Trajectory
    robot: Robot
    scene: Scene
    out: Path
    """The file, or the folder, to write."""
    passive: bool
    """Whether the passive joints were asked for; only in formats that take the question."""


@dataclass(frozen=True)
class Format:
    """A format of another tool."""

    description: str
    """What it is, in a few words."""
    write: Callable[[Job], tuple[Path, ...]]
    """Writes what is to be exported and returns the files written."""
    has_passive: bool = False
    """Whether there is a choice to have the passive joints too."""
    is_file: bool = False
    """Whether it is one file instead of a folder."""


def export(
    trajectory: Trajectory, robot: Robot, scene: Scene, format: str, out: str | Path, *, passive: bool = False
) -> tuple[Path, ...]:
    """Write a motion in a format of another tool. A file appears when it is whole, and replaces an older one.

    Args:
        trajectory: The motion.
        robot: The robot that it was planned for.
        scene: The scene that it was planned in; only `mujoco` uses it.
        format: One of `FORMATS`.
        out: The file to write, by `mujoco` the folder; folders are made if need be.
        passive: Whether the two ROS formats have the passive joints too; the other formats are always the same.

    Returns:
        The files written; of a motion with events the two ROS formats write them to a file beside the message, such as
        `motion.events.yaml`.

    Raises:
        InvalidInput: If there is no such format, the motion is not one of this robot or cannot be had in this format,
            or `out` cannot be written to.
    """
    check_out(format, out)
    check_motion(trajectory, robot)
    check_kind("scene", scene, Scene)
    if passive and not FORMATS[format].has_passive:
        raise InvalidInput("passive", passive, f"False with {format}, which has no passive joints to choose")
    return FORMATS[format].write(Job(trajectory, robot, scene, Path(out), passive))


def check_out(format: str, out: str | Path) -> None:
    """Check, before anything is computed, that an export can be written.

    Args:
        format: One of `FORMATS`.
        out: The file to write, by `mujoco` the folder.

    Raises:
        InvalidInput: If there is no such format, or `out` is no such name, may be part of a plan, or cannot be written.
    """
    if not isinstance(format, str) or format not in FORMATS:
        raise InvalidInput("format", format, f"one of {', '.join(FORMATS)}{did_you_mean(format, FORMATS)}")
    if not isinstance(out, str | Path):
        raise InvalidInput("out", out, "the name of a file, or of a folder for mujoco")
    if not FORMATS[format].is_file:
        check_folder(out)
        return
    check_file(out)
    path = Path(out)
    if path.exists() and (path.parent / SUMMARY).exists():
        raise InvalidInput("out", str(out), "a new name: this file may be of the plan in that folder")


def _write_file(out: Path, content: bytes) -> tuple[Path, ...]:
    return (write_file(out, content),)


def _write_csv(job: Job) -> tuple[Path, ...]:
    return _write_file(job.out, csv_bytes(job.trajectory))


def _write_npz(job: Job) -> tuple[Path, ...]:
    return _write_file(job.out, npz_bytes(job.trajectory))


def _write_ros_json(job: Job) -> tuple[Path, ...]:
    message = joint_trajectory(job.trajectory, job.robot, passive=job.passive)
    return _write_message(job, json_text(message))


def _write_ros_yaml(job: Job) -> tuple[Path, ...]:
    message = joint_trajectory(job.trajectory, job.robot, passive=job.passive)
    return _write_message(job, yaml_text(message))


def _write_message(job: Job, text: str) -> tuple[Path, ...]:
    """Write a message and, as it has no place for events, a file beside it with these if there are any."""
    beside = events_file(job.out)
    if job.trajectory.events:
        return (write_file(job.out, text.encode()), write_file(beside, notes_text(job.trajectory.events).encode()))
    if beside.is_file():  # of a motion that was exported there before
        beside.unlink()
    return _write_file(job.out, text.encode())


def events_file(out: Path) -> Path:
    """Return the file beside a message of ROS that has the events."""
    return out.with_name(f"{out.stem}.events{out.suffix}")


def _write_mujoco(job: Job) -> tuple[Path, ...]:
    # Only this format needs what draws and simulates.
    from humanoid_rail.io.mujoco.folder import mujoco_files

    return write_files(job.out, mujoco_files(job.trajectory, job.robot, job.scene))


FORMATS: Mapping[str, Format] = {
    "csv": Format("a table: times, joints, hands", _write_csv, is_file=True),
    "npz": Format("NumPy arrays", _write_npz, is_file=True),
    "ros-json": Format(
        "ROS 2 trajectory_msgs/JointTrajectory as JSON", _write_ros_json, has_passive=True, is_file=True
    ),
    "ros-yaml": Format(
        "ROS 2 trajectory_msgs/JointTrajectory as YAML, for ros2 topic pub",
        _write_ros_yaml,
        has_passive=True,
        is_file=True,
    ),
    "mujoco": Format("a folder with a MuJoCo model of robot and scene, the motion and a player", _write_mujoco),
}
"""What :func:`export` can write, by name."""
