"""The command that plays two plans back at the same time."""

from __future__ import annotations

from pathlib import Path

import click

from humanoid_rail._files import check_file, write_file
from humanoid_rail.cli.console import Command, console, has_display
from humanoid_rail.cli.play import say_where
from humanoid_rail.errors import InvalidInput
from humanoid_rail.io.plan_folder import Plan, read_plan
from humanoid_rail.viewer.playback import motions_html, show_page


@click.command(
    cls=Command,
    examples={
        "humanoid-rail compare out/qp out/auto": "Two plans, in the browser until Ctrl-C.",
        "humanoid-rail compare out/qp out/auto -o out/both.html --no-view": "The page as a file.",
    },
)
@click.argument("first", metavar="A")
@click.argument("second", metavar="B")
@click.option("--out", "-o", metavar="FILE", help="HTML file to write the page to; it needs no server.")
@click.option("--view/--no-view", default=None, help="Play back in the browser  [unless --out is given]")
def command(first: str, second: str, out: str | None, view: bool | None) -> None:
    """Play two plans back at the same time: the folders A and B, as `plan --out` wrote them.

    Both are of the same robot. Plots and verdicts of both are in one page with one timeline; the robot of B is
    translucent. Obstacles and targets are those of A: the page says so if B was planned for
    others.
    """
    if out is not None:
        check_file(out)
    plans = read_plan(first), read_plan(second)
    page = compare_html(*plans, (first, second))
    if out is not None:
        write_file(Path(out), page.encode())
        console().print(f"The page is {out}.", soft_wrap=True)
    if out is None if view is None else view:
        show_page(page, open_browser=has_display(), on_ready=say_where)


def compare_html(one: Plan, two: Plan, folders: tuple[str, str]) -> str:
    """Return the page of two plans.

    Args:
        one: The plan that is drawn with its obstacles.
        two: The other one.
        folders: Where they are: by these they are called.

    Raises:
        InvalidInput: If they are not of the same robot.
    """
    if one.robot.urdf != two.robot.urdf or one.robot.hands != two.robot.hands:
        raise InvalidInput(
            "robot", two.robot.name, f"the robot of {folders[0]}, the same in all of its URDF and its hands", folders[1]
        )
    names = [Path(folder).resolve().name for folder in folders]
    if names[0] == names[1]:
        names = list(folders)
    plans = zip(names, (one, two), strict=True)
    return motions_html(one.robot, [(name, plan.scene, plan.trajectory) for name, plan in plans])
