"""The argument and the options of commands that read a plan from its folder."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

GROUP = {"Instead of what is in FOLDER": ("scene_file", "robot_file")}
"""The options have this heading as a group."""


def reads_a_plan(function: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the arguments of :func:`humanoid_rail.io.plan_folder.read_plan`."""
    for decorate in (
        click.option(
            "--robot", "robot_file", metavar="FILE", help="URDF of the robot, as `humanoid-rail urdf` has it."
        ),
        click.option("--scene", "scene_file", metavar="FILE", help="Scene file, YAML or JSON."),
        click.argument("folder"),
    ):
        function = decorate(function)
    return function
