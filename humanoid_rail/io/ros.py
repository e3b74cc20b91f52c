"""Trajectories as messages of ROS 2."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput
from humanoid_rail.events import Event
from humanoid_rail.io.robot_motion import all_joints, check_motion
from humanoid_rail.model.robot import Robot
from humanoid_rail.trajectory import Trajectory

_NANOSECONDS = 10**9
_LAST_SECOND = 2**31 - 1
"""The seconds of a ROS duration are a 32-bit integer."""


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
    check_motion(trajectory, robot)
    columns: list[Array] = [trajectory.q]
    if trajectory.timing is not None:
        columns += [trajectory.timing.velocity, trajectory.timing.acceleration]
    if passive:
        columns = all_joints(robot, columns)
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


def event_notes(events: Sequence[Event]) -> list[dict[str, Any]]:
    """Return events as plain data: the time as a ROS duration, the object's pose as `geometry_msgs/msg/Pose` has it.

    Times are rounded to nanoseconds.
    """
    return [
        {
            "time_from_start": _duration(round(event.t * _NANOSECONDS)),
            "kind": event.kind,
            "object": event.object,
            "hands": list(event.hands),
            "contacts": list(event.contacts),
            "pose": {
                "position": dict(zip("xyz", event.position, strict=True)),
                "orientation": dict(zip("wxyz", event.quaternion, strict=True)),
            },
        }
        for event in events
    ]


def notes_text(events: Sequence[Event]) -> str:
    """Return events as JSON, which is YAML too, an event a line."""
    return "[\n" + ",\n".join(f"  {_flow(note)}" for note in event_notes(events)) + "\n]\n"


def _duration(nanoseconds: int) -> dict[str, int]:
    return {"sec": nanoseconds // _NANOSECONDS, "nanosec": nanoseconds % _NANOSECONDS}


def _durations(t: Array) -> list[dict[str, int]]:
    """Return times (N,) in s as ROS has them."""
    nanoseconds = [round(time * _NANOSECONDS) for time in t.tolist()]
    if nanoseconds[0] < 0 or nanoseconds[-1] > _LAST_SECOND * _NANOSECONDS or (np.diff(nanoseconds) <= 0).any():
        raise InvalidInput("trajectory.t", t, "times from 0 to 68 years that increase by a nanosecond or more")
    return [_duration(time) for time in nanoseconds]


def json_text(message: Mapping[str, Any]) -> str:
    """Return a JointTrajectory as JSON, a point a line."""
    points = ",\n".join(f"  {_flow(point)}" for point in message["points"])
    header, joints = _flow(message["header"]), _flow(message["joint_names"])
    return f'{{\n"header": {header},\n"joint_names": {joints},\n"points": [\n{points}\n]\n}}\n'


def yaml_text(message: Mapping[str, Any]) -> str:
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
        case str() | int():
            return json.dumps(value, ensure_ascii=False)
        case _:
            raise TypeError(f"a message of ROS has no {type(value).__name__}")
