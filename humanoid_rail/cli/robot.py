"""The command that shows a robot before anything is planned."""

from __future__ import annotations

import tempfile
import webbrowser
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from humanoid_rail._files import check_file, write_file
from humanoid_rail.cli.console import Command, console, has_display
from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.library import load_robot


@click.command(
    cls=Command,
    examples={
        "humanoid-rail robot": "The paper's robot.",
        "humanoid-rail robot baxter.urdf --srdf baxter.srdf --packages share --out baxter.html": "Any URDF or xacro.",
        "humanoid-rail robot example-robot-data:panda": "A model of an installed Python package.",
        "humanoid-rail robot arm.urdf --hands tool=tool0": "With a hand that is named, not found.",
    },
)
@click.argument("source", required=False)
@click.option("--srdf", metavar="FILE", help="SRDF of the robot.")
@click.option("--packages", multiple=True, metavar="FOLDER", help="Folder of ROS packages; can be given again.")
@click.option("--hands", multiple=True, metavar="NAME=FRAME", help="A hand and its frame; can be given again.")
@click.option("--out", "-o", metavar="FILE", help="HTML file to write the page to.")
@click.option("--view/--no-view", default=None, help="Whether the page is opened; by default if there is a display.")
def command(
    source: str | None,
    srdf: str | None,
    packages: Sequence[str],
    hands: Sequence[str],
    out: str | None,
    view: bool | None,
) -> None:
    """Show a robot: print what is known and what was assumed of it, and write a page to look at it.

    SOURCE is a URDF, a xacro, a robot file or the name of a robot; the paper's robot without it. The page shows meshes
    and collision bodies, has a slider for each joint, and marks pairs in contact. It needs no server.
    """
    if out is not None:
        check_file(out)
    given: dict[str, Any] = {"srdf": srdf, "packages": list(packages), "hands": frames_by_name(hands)}
    given = {name: value for name, value in given.items() if value}
    if source is None and given:
        raise InvalidInput(next(iter(given)), next(iter(given.values())), "beside a SOURCE")
    robot = load_robot() if source is None else load_robot(source, **given)
    console().print(robot.report(), soft_wrap=True)
    is_shown = has_display() if view is None else view
    if out is None and not is_shown:
        if view is None:
            console().print("There is no display: --out FILE writes the page to look at it.", soft_wrap=True)
        return
    # Imported here: it takes long, and the report needs nothing of it.
    from humanoid_rail.viewer.robot_page import robot_html

    page = robot_html(robot).encode()
    path = Path(out) if out is not None else Path(tempfile.mkdtemp(prefix="humanoid_rail-")) / "robot.html"
    write_file(path, page)
    console().print(f"The page is {path}.", soft_wrap=True)
    if is_shown:
        webbrowser.open(path.resolve().as_uri(), new=2)


def frames_by_name(pairs: Sequence[str]) -> dict[str, str]:
    """Return the frames in texts such as ``left=l_tool``, by the names of hands.

    Raises:
        InvalidInput: If a text is not like that, or a name comes twice.
    """
    frames: dict[str, str] = {}
    for pair in pairs:
        name, equals, frame = pair.partition("=")
        if not (name and equals and frame) or name in frames:
            raise InvalidInput("hands", pair, "NAME=FRAME, each name once, such as left=l_gripper_tool_frame")
        frames[name] = frame
    return frames
