"""The options of commands that take a robot."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, TypedDict

import click

from humanoid_rail.io.carried_robot import given_robot
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.scene import Scene, load_robot_of_scene


class RobotOptions(TypedDict):
    """What was asked for instead of the robot that is there."""

    robot_file: str | None
    """What `load_robot` takes."""
    srdf: str | None
    """Its SRDF."""
    packages: tuple[str, ...]
    """Folders of ROS packages."""


NAMES = ("robot_file", "srdf", "packages")
"""The options have these names."""


def asked_robot(asked: RobotOptions, scene: Scene) -> Robot:
    """Return the robot that is asked for, else that of the scene, else the paper's.

    Raises:
        InvalidInput: If there is no such robot, or it is not valid.
    """
    if asked["robot_file"] is None:
        return load_robot_of_scene(scene)
    return given_robot(asked["robot_file"], asked["srdf"], asked["packages"])


def takes_a_robot(function: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options that choose a robot, as an argument `robot`.

    Raises:
        click.UsageError: If there is no robot that an SRDF or packages are of.
    """

    @wraps(function)
    def command(robot_file: str | None, srdf: str | None, packages: tuple[str, ...], **arguments: Any) -> Any:
        if robot_file is None and (srdf is not None or packages):
            raise click.UsageError(f"{'--srdf' if srdf is not None else '--packages'} needs --robot")
        return function(robot=RobotOptions(robot_file=robot_file, srdf=srdf, packages=packages), **arguments)

    for decorate in (
        click.option("--packages", multiple=True, metavar="FOLDER", help="Of --robot: folder of ROS packages."),
        click.option("--srdf", metavar="FILE", help="Of --robot: its SRDF."),
        click.option(
            "--robot",
            "robot_file",
            metavar="SOURCE",
            help="URDF, xacro, robot file or its folder, PACKAGE:ROBOT, or a name.",
        ),
    ):
        command = decorate(command)
    return command
