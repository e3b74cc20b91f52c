"""The robot that a scene names."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, Discriminator, Tag, ValidationInfo

from humanoid_rail.model.library import FILES, load_robot, robots
from humanoid_rail.model.loading import robot_of
from humanoid_rail.model.robot import Robot
from humanoid_rail.model.robot_file import RobotFile
from humanoid_rail.model.sources import SUFFIXES


def _placed(value: object, info: ValidationInfo) -> object:
    """Return a robot whose relative paths begin at the folder of the scene."""
    folder = Path((info.context or {}).get("folder", Path.cwd()))
    match value:
        case str():
            return _path(folder, value)
        case Mapping() if value.get("package") is None:
            named = {name: _path(folder, value[name]) for name in ("urdf", "srdf") if name in value}
            places = value.get("packages")
            more = {"packages": [_path(folder, place) for place in places]} if isinstance(places, list | tuple) else {}
            return {**value, **named, **more}
    return value


def _path(folder: Path, said: Any) -> Any:
    """Return a path in the folder, unless something else is meant: a name, or the text of a URDF."""
    if not isinstance(said, str) or "<" in said or said in robots():
        return said
    is_there = False
    with suppress(OSError, ValueError):  # a name too long, a NUL
        is_there = (folder / said).exists()
    return str(folder / said) if is_there or Path(said).suffix in (*SUFFIXES, *FILES, ".srdf") else said


def _kind_of_robot(value: object) -> str:
    return "<name>" if isinstance(value, str) else "<robot file>"


SceneRobot = Annotated[
    Annotated[Annotated[str, Tag("<name>")] | Annotated[RobotFile, Tag("<robot file>")], Discriminator(_kind_of_robot)],
    BeforeValidator(_placed),
]
"""What a scene says of its robot."""


def load_named_robot(robot: str | RobotFile | None) -> Robot:
    """Return the robot that a scene names by its `robot`; the paper's if it names none.

    Raises:
        InvalidInput: If there is no such robot, or it cannot be loaded.
    """
    if isinstance(robot, RobotFile):
        return robot_of(robot, Path.cwd())
    return load_robot() if robot is None else load_robot(robot)
