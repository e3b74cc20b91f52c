"""The command that lets a user move targets and obstacles in the browser."""

from __future__ import annotations

import webbrowser

import click

from humanoid_rail.cli.console import Command, console, has_display
from humanoid_rail.cli.robot_options import RobotOptions, asked_robot, takes_a_robot
from humanoid_rail.paper.cases import paper_scene
from humanoid_rail.scene.scene import load_scene


@click.command(
    cls=Command,
    examples={
        "humanoid-rail live": "The paper's scene.",
        "humanoid-rail live scenes/picks.yaml": "A scene file.",
        "humanoid-rail live scene.yaml --robot example-robot-data:baxter": "With another robot.",
    },
)
@click.argument("scene", required=False)
@takes_a_robot
@click.option("--host", default="127.0.0.1", show_default=True, help="Address to listen at; others may reach the page.")
@click.option("--port", default=8080, show_default=True, type=click.IntRange(1, 65535), help="Port to listen at.")
@click.option("--view/--no-view", default=None, help="Whether the page is opened; by default if there is a display.")
def command(scene: str | None, robot: RobotOptions, host: str, port: int, view: bool | None) -> None:
    """Drag targets and obstacles in the browser, and see what is planned or how the robot follows.

    SCENE is a scene file; the paper's scene without it. Each change is planned, retimed and certified. Needs
    `python -m pip install 'humanoid_rail[live]'`.
    """
    # Imported here: the help needs nothing of it.
    from humanoid_rail.live.server import serve

    world = paper_scene() if scene is None else load_scene(scene)
    loaded = asked_robot(robot, world)

    def ready(url: str) -> None:
        console().print(f"Live at {url} until Ctrl-C.", soft_wrap=True)
        if has_display() if view is None else view:
            webbrowser.open(url, new=2)

    serve(loaded, world, host=host, port=port, on_ready=ready)
