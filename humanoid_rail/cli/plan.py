"""The command that plans."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from shlex import quote
from typing import Any

import click

from humanoid_rail._called import command as called_as
from humanoid_rail.cli.console import Command, console, files_said, has_display
from humanoid_rail.cli.plan_options import (
    GROUPS,
    RETIMING,
    case_method_name,
    has_method_options,
    method_of,
    method_options,
    retiming_options,
)
from humanoid_rail.cli.play import play_back
from humanoid_rail.cli.report import report_plan
from humanoid_rail.cli.robot_options import RobotOptions, asked_robot, takes_a_robot
from humanoid_rail.cli.urdf import numbers_by_name
from humanoid_rail.errors import MISSING, InvalidInput, checked_number
from humanoid_rail.io.carried_robot import is_papers
from humanoid_rail.io.plan_folder import Plan, check_plan_folder, write_plan
from humanoid_rail.model.library import PAPER, load_robot
from humanoid_rail.model.robot import Robot
from humanoid_rail.paper.cases import case_method, paper_scene
from humanoid_rail.planning.methods import METHODS, GradientProjection
from humanoid_rail.planning.options import PlanningMethod
from humanoid_rail.planning.planner import plan
from humanoid_rail.progress import progress
from humanoid_rail.result import Status
from humanoid_rail.retiming.retiming import LEAST_SPEED, retime
from humanoid_rail.scene.scene import Scene, is_of_a_scene, load_scene
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.viewer.playback import playback_html

PAGE = "playback.html"
"""The page that plays a plan back has this name in its folder."""


@click.command(
    cls=Command,
    examples={
        "humanoid-rail plan scenes/picks.yaml --retime --out out/picks": "Plan, time it for a drive, keep it.",
        "humanoid-rail plan scenes/dev/deep-500004.json --view": "Plan a scene and play it back.",
        "humanoid-rail plan --case 2 --epsilon 0.7": "A case of the paper by its own law: this one collides.",
        "humanoid-rail plan --case 2 --epsilon 0.7 --method qp": "The same within hard limits: this one does not.",
    },
    groups=GROUPS,
)
@click.argument("scene_file", metavar="[SCENE]", required=False)
@click.option("--case", "case", type=int, help="A case of the paper, 1, 2 or 3, instead of SCENE.")
@click.option("--method", help=f"One of {', '.join(METHODS)}.  [auto; of a case gradient-projection]")
@has_method_options
@click.option("--retime", "retimed", is_flag=True, help="Time the path for a drive: fastest, at rest at both ends.")
@click.option("--speed", type=float, help="Of --retime: share of the velocity limits; 0.5 takes twice as long  [1]")
@click.option("--jerk-limit", type=float, help="Of --retime, m/s^3 and rad/s^3  [the robot's]")
@click.option("--dwell", type=float, help="Of --retime: rest at each target before the next, s  [0]")
@takes_a_robot
@click.option("--link-radius", type=float, help="Of the paper's robot: radius of the collision capsules, m  [0.05]")
@click.option(
    "--set",
    "lengths",
    multiple=True,
    metavar="NAME=VALUE",
    help="Any argument of the paper's robot: see the command urdf.",
)
@click.option("--out", help="Folder for the trajectory, the scene, the robot and a page that plays it back.")
@click.option("--page/--no-page", default=True, help="Of --out: whether to write the page  [yes]")
@click.option("--view/--no-view", default=None, help="Play back in a browser  [if stdout is a terminal with a display]")
def command(
    scene_file: str | None,
    case: int | None,
    method: str | None,
    retimed: bool,
    robot: RobotOptions,
    link_radius: float | None,
    lengths: tuple[str, ...],
    out: str | None,
    page: bool,
    view: bool | None,
    **options: Any,
) -> int:
    """Plan a motion of all hands to the targets of SCENE (YAML or JSON; without one, scenes/paper.yaml).

    The robot is that of --robot, else the one that SCENE names, else the paper's.

    The result is printed, and played back if there is a display. --out keeps it in a folder for `play`, `verify` and
    `export`. By auto the motion is one of least time for a drive; --retime times its path anew. By other methods it has
    the method's own timing, which starts at full speed, and --retime gives it one for a drive.

    Exit code: 0 if the targets are reached, 1 if not, 2 after bad input, 130 if interrupted.
    """
    if scene_file is not None and case is not None:
        raise InvalidInput("scene", scene_file, "no scene file beside --case, which has its own scene")
    if out is not None:
        check_plan_folder(out, [PAGE] if page else [])
    retiming = _checked_retiming(retimed, {name: options.pop(name) for name in RETIMING})
    chosen = method_of(method, options) if case is None else _of_case(case, method, options)
    arguments = numbers_by_name([*lengths, *([] if link_radius is None else [f"link_radius={link_radius}"])])
    scene = load_scene(scene_file) if scene_file is not None else paper_scene()
    model = _robot(robot, scene, case, arguments)
    if scene_file is None and case is None and not is_papers(model):
        raise InvalidInput("scene", MISSING, "a SCENE for this robot; without one the paper's is planned")
    try:
        with progress("planning"):
            trajectory = plan(model, scene, chosen)
            if retimed:
                trajectory = retime(trajectory, model, scene, max_time=options["max_time"], **retiming)
    except InvalidInput as error:
        if is_of_a_scene(error):
            error.source = scene_file  # the scene is sound in itself but not one for this robot
        raise
    _show(model, scene, trajectory, _title(case, scene, chosen), out, page, view)
    return 0 if trajectory.status is Status.REACHED else 1


def _robot(asked: RobotOptions, scene: Scene, case: int | None, arguments: dict[str, float]) -> Robot:
    """Return the robot that is asked for, else that of the scene, else the paper's.

    Raises:
        InvalidInput: If it is not there, or arguments of the paper's robot are given for another one.
    """
    source = asked["robot_file"] if asked["robot_file"] is not None else scene.robot
    if case is not None and asked["robot_file"] is not None:
        raise InvalidInput("robot", source, "no robot beside --case, which is about the paper's")
    if source is None or (source == PAPER and asked["srdf"] is None and not asked["packages"]):
        return load_robot(**arguments)
    if arguments:
        name, value = next(iter(arguments.items()))
        raise InvalidInput(name, value, "no argument of the paper's robot, as --robot or the scene names another one")
    return asked_robot(asked, scene)


def _of_case(case: int, method: str | None, options: dict[str, Any]) -> PlanningMethod:
    name = case_method_name(method)
    return case_method(case, name, **method_options(name, options))


def _checked_retiming(retimed: bool, options: dict[str, float | None]) -> dict[str, float]:
    """Return the arguments of the retiming, checked before anything is planned."""
    given = retiming_options(retimed, options)
    if "jerk_limit" in given:
        checked_number("jerk_limit", given["jerk_limit"], above=0.0)
    if "speed" in given:
        checked_number("speed", given["speed"], least=LEAST_SPEED, most=1.0)
    if "dwell" in given:
        checked_number("dwell", given["dwell"], least=0.0)
    return given


def _title(case: int | None, scene: Scene, method: PlanningMethod) -> str:
    if case is None:
        return scene.name
    if method.name != GradientProjection.name:
        return f"case {case} of the paper by {method.name}"
    return (
        f"case {case} of the paper by its own law, gradient projection (eq. 4.9), "
        "which neither prevents collisions nor knows limits"
    )


def _show(
    robot: Robot, scene: Scene, trajectory: Trajectory, title: str, out: str | None, page: bool, view: bool | None
) -> None:
    """Keep a plan, print what came of it and play it back, as far as that is asked for."""
    # Kept before anything is printed: whoever reads that may be gone.
    written = [] if out is None else _keep(robot, scene, trajectory, out, page)
    report_plan(title, trajectory)
    if out is not None:
        console().print(f"Written to {out}: {files_said([Path(f.name) for f in written])}", soft_wrap=True)
    if view is None:
        view = sys.stdout.isatty() and has_display()
        if not view:
            console().print(f"To see it: {how_to_see(out, page)}.", soft_wrap=True)
    if view:
        play_back(Plan(robot, scene, trajectory))


def _keep(robot: Robot, scene: Scene, trajectory: Trajectory, out: str, page: bool) -> Sequence[Path]:
    """Write a plan to a folder and return its files; without its page, no page of an older plan stays there."""
    if page:
        return write_plan(trajectory, robot, scene, out, [(PAGE, playback_html(robot, scene, trajectory))])
    written = write_plan(trajectory, robot, scene, out)
    (Path(out) / PAGE).unlink(missing_ok=True)
    return written


def how_to_see(out: str | None, page: bool = True) -> str:
    """Return how to see a plan that is kept in a folder, with its page or without it, or nowhere."""
    if out is None:
        return "run again with --view"
    folder = f"./{out}" if out.startswith("-") else out  # or else it would be an option
    played = f"{called_as()} play {quote(folder)}"
    return f"open {Path(out) / PAGE}, or {played}" if page else played
