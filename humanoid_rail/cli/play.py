"""The command that plays a plan back."""

from __future__ import annotations

import click

from humanoid_rail.cli.console import Command, console, has_display
from humanoid_rail.cli.plan_folder_options import GROUP, reads_a_plan
from humanoid_rail.cli.robot_options import RobotOptions
from humanoid_rail.io.plan_folder import Plan, read_plan
from humanoid_rail.viewer.playback import show


@click.command(
    cls=Command,
    examples={"humanoid-rail play out/case3": "What `humanoid-rail plan --case 3 --out out/case3` wrote."},
    groups=GROUP,
)
@reads_a_plan
def command(folder: str, scene_file: str | None, robot: RobotOptions) -> None:
    """Play the plan in FOLDER, as `plan --out` wrote it, in the browser until Ctrl-C.

    Without a display it is served all the same, at the address that it prints. FOLDER/playback.html shows the same and
    needs no server.
    """
    play_back(read_plan(folder, scene_file, **robot))


def play_back(plan: Plan) -> None:
    """Play a plan in the browser until Ctrl-C, and say where."""
    show(
        plan.robot,
        plan.scene,
        plan.trajectory,
        open_browser=has_display(),
        on_ready=say_where,
    )


def say_where(url: str) -> None:
    """Print where a page is served."""
    console().print(f"Playing at {url} until Ctrl-C.", soft_wrap=True)
