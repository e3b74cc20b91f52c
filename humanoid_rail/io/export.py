"""Trajectories in the formats of other tools."""

from __future__ import annotations

import json
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.io.mujoco.actuators import drives, gravity_load
from humanoid_rail.errors import InvalidInput, check_kind
from humanoid_rail.io.trajectory_files import SUMMARY, csv_bytes, npz_bytes, write_files
from humanoid_rail.io.mujoco.mjcf import mjcf
from humanoid_rail.scene.obstacles import is_moving
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.scene import Scene
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.planning.verification import check_robot

FORMATS: Mapping[str, str] = {
    "csv": "a table: times, joints, hands",
    "npz": "NumPy arrays",
    "ros-json": "ROS 2 trajectory_msgs/JointTrajectory as JSON",
    "ros-yaml": "ROS 2 trajectory_msgs/JointTrajectory as YAML, for ros2 topic pub",
    "mujoco": "a folder with a MuJoCo model of robot and scene, the motion and a player",
}
"""What :func:`export` can write, by name."""

_NANOSECONDS = 10**9
_LAST_SECOND = 2**31 - 1


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
        The files written.

    Raises:
        InvalidInput: If there is no such format, the motion is not one of this robot or cannot be had in this format,
            or `out` cannot be written to.
    """
    if not isinstance(format, str) or format not in FORMATS:
        raise InvalidInput("format", format, f"one of {', '.join(FORMATS)}")
    _check(trajectory, robot)
    check_kind("scene", scene, Scene)
    if not isinstance(out, str | Path):
        raise InvalidInput("out", out, "the name of a file, or of a folder for mujoco")
    if passive and not format.startswith("ros"):
        raise InvalidInput("passive", passive, f"False with {format}, which has no passive joints to choose")
    out = Path(out)
    if format == "mujoco":
        return write_files(out, _mujoco(trajectory, robot, scene))
    if not out.name or _is_folder(out):
        raise InvalidInput("out", str(out), "the name of a file to write, not of a folder")
    if (out.parent / SUMMARY).exists() and out.exists():
        raise InvalidInput("out", str(out), "a new name: this file may be of the plan in that folder")
    match format:
        case "csv":
            content = csv_bytes(trajectory)
        case "npz":
            content = npz_bytes(trajectory)
        case "ros-json":
            content = _json(joint_trajectory(trajectory, robot, passive=passive)).encode()
        case _:
            content = _yaml(joint_trajectory(trajectory, robot, passive=passive)).encode()
    return write_files(out.parent, {out.name: content})


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except OSError:  # as where its name is too long
        return False


def joint_trajectory(trajectory: Trajectory, robot: Robot, *, passive: bool = False) -> dict[str, Any]:
    """Return a motion as plain data with the fields of ROS 2's `trajectory_msgs/msg/JointTrajectory`.

    Velocities and accelerations are those of the timing, and empty without one. Times are rounded to nanoseconds.

    Args:
        trajectory: The motion.
        robot: The robot that it was planned for.
        passive: Whether the joints that follow others are there too, in Pinocchio's order.

    Raises:
        InvalidInput: If the motion is not one of this robot, or its times in nanoseconds do not increase.
    """
    _check(trajectory, robot)
    columns: list[Array] = [trajectory.q]
    if trajectory.timing is not None:
        columns += [trajectory.timing.velocity, trajectory.timing.acceleration]
    if passive:
        columns = _full(robot, columns)
    rows = zip(_durations(trajectory.t), *(column.tolist() for column in columns), strict=True)
    points = []
    for time, positions, *derivatives in rows:
        velocities, accelerations = derivatives or ([], [])
        points.append(
            {
                "positions": positions,
                "velocities": velocities,
                "accelerations": accelerations,
                "effort": [],
                "time_from_start": time,
            }
        )
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
        "joint_names": list(robot.model.names)[1:] if passive else list(robot.joint_names),
        "points": points,
    }


def _check(trajectory: Trajectory, robot: Robot) -> None:
    """Check that a motion is one of a robot, in finite numbers.

    Raises:
        InvalidInput: If it is not.
    """
    check_robot(robot, trajectory)
    arrays = {"t": trajectory.t, "q": trajectory.q}
    if trajectory.timing is not None:
        arrays |= {"velocity": trajectory.timing.velocity, "acceleration": trajectory.timing.acceleration}
    for field, array in arrays.items():
        if not np.isfinite(array).all():
            raise InvalidInput(f"trajectory.{field}", array, "finite numbers")


def _full(robot: Robot, columns: list[Array]) -> list[Array]:
    """Return positions and derivatives (N, n) of the actuated joints as those of all joints (N, nq)."""
    positions, *derivatives = columns
    return [positions @ robot.coupling.T + robot.offset, *(column @ robot.coupling.T for column in derivatives)]


def _durations(t: Array) -> list[dict[str, int]]:
    """Return times in s as ROS has them."""
    nanoseconds = [round(time * _NANOSECONDS) for time in t.tolist()]
    if nanoseconds[0] < 0 or nanoseconds[-1] > _LAST_SECOND * _NANOSECONDS or (np.diff(nanoseconds) <= 0).any():
        raise InvalidInput("trajectory.t", t, "times from 0 to 68 years that increase by a nanosecond or more")
    return [{"sec": time // _NANOSECONDS, "nanosec": time % _NANOSECONDS} for time in nanoseconds]


def _json(message: Mapping[str, Any]) -> str:
    """Return a JointTrajectory as JSON, a point a line."""
    points = ",\n".join(f"  {_flow(point)}" for point in message["points"])
    header, joints = _flow(message["header"]), _flow(message["joint_names"])
    return f'{{\n"header": {header},\n"joint_names": {joints},\n"points": [\n{points}\n]\n}}\n'


def _yaml(message: Mapping[str, Any]) -> str:
    """Return a JointTrajectory as YAML."""
    lines = [f"header: {_flow(message['header'])}", f"joint_names: {_flow(message['joint_names'])}", "points:"]
    for point in message["points"]:
        entries = [f"{name}: {_flow(value)}" for name, value in point.items()]
        lines += [f"- {entries[0]}", *(f"  {entry}" for entry in entries[1:])]
    return "\n".join(lines) + "\n"


def _flow(value: object) -> str:
    """Return plain data as text that JSON, YAML 1.1 and YAML 1.2 read alike and without loss."""
    match value:
        case dict():
            return "{" + ", ".join(f"{json.dumps(name)}: {_flow(item)}" for name, item in value.items()) + "}"
        case list():
            return f"[{', '.join(map(_flow, value))}]"
        case float():
            # To YAML 1.1, and so to ros2 topic pub, 1e-05 is a string.
            text = repr(value)
            return text if "." in text else text.replace("e", ".0e")
        case _:
            return json.dumps(value, ensure_ascii=False)


def _mujoco(trajectory: Trajectory, robot: Robot, scene: Scene) -> dict[str, bytes]:
    """Return the files of an export to MuJoCo."""
    if trajectory.timing is None:
        valid = (
            "a retimed motion, by retime() or plan --timing fastest: drives cannot follow one that starts at full speed"
        )
        raise InvalidInput("trajectory.timing", None, valid)
    if len(trajectory.t) < 2:
        raise InvalidInput("trajectory.t", trajectory.t, "a motion of two samples or more")
    gains, load = drives(robot, trajectory.q), gravity_load(robot, trajectory.q)
    kp, kv = (np.array([getattr(drive, gain) for drive in gains]) for gain in ("kp", "kv"))
    ctrl = trajectory.q + (kv * trajectory.timing.velocity + load) / kp
    qpos, qvel = _full(robot, [trajectory.q, trajectory.timing.velocity])
    velocities = np.array([obstacle.velocity for obstacle in scene.obstacles if is_moving(obstacle)]).reshape(-1, 3)
    arrays = {
        "time": trajectory.t,
        "qpos": qpos,
        "qvel": qvel,
        "load": load,
        "ctrl": ctrl,
        "hands": trajectory.hands,
        "mocap": trajectory.t[:, None, None] * velocities,
    }
    buffer = BytesIO()
    np.savez_compressed(buffer, **arrays)
    player = Path(__file__).with_name("mujoco_player.py").read_bytes()
    model = mjcf(robot, scene, trajectory, gains, ctrl[0])
    return {"scene.xml": model.encode(), "motion.npz": buffer.getvalue(), "play.py": player}
