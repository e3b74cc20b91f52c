"""The command that plans."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from shlex import quote
from typing import Any

import click

from humanoid_rail.cli.console import Command, console, has_display, progress
from humanoid_rail.cli.play import play_back
from humanoid_rail.cli.report import report_plan
from humanoid_rail.cli.urdf import numbers_by_name
from humanoid_rail.errors import InvalidInput, checked_number
from humanoid_rail.io.plan_folder import Plan, write_plan
from humanoid_rail.io.trajectory_files import check_folder
from humanoid_rail.model.robot import load_robot
from humanoid_rail.paper.cases import paper_scene, plan_case
from humanoid_rail.planning.engines import ENGINES
from humanoid_rail.planning.planner import METHODS, plan
from humanoid_rail.retiming.retiming import LEAST_SPEED, retime
from humanoid_rail.scene.obstacles import at_rest
from humanoid_rail.scene.scene import is_of_a_scene, load_scene
from humanoid_rail.result import Status
from humanoid_rail.viewer.playback import playback_html

PAGE = "playback.html"
"""What plays a plan back, in its folder."""
FASTEST = "fastest"
TIMINGS = (FASTEST, "paper")
"""How a path is timed."""


def numbers(_context: click.Context, _option: click.Parameter, text: str | None) -> float | tuple[float, ...] | None:
    """Parse one number, or several separated by commas."""
    if text is None:
        return None
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        raise InvalidInput("gain", text, "a number greater than 0, or six of them separated by commas") from None
    return values[0] if len(values) == 1 else values


@click.command(
    cls=Command,
    examples={
        "humanoid-rail plan scenes/dev/deep-500004.json --out out/deep": "Plan a scene, keep the result, play it back.",
        "humanoid-rail plan --case 2 --epsilon 0.7 --view": "A case of the paper; its penalty is soft: this collides.",
        "humanoid-rail plan --case 2 --epsilon 0.7 --method qp": "And this does not.",
        "humanoid-rail plan --case 3 --timing fastest --jerk-limit 100": "The paper's motion, for a drive.",
    },
    groups={
        "What to plan": ("case", "link_radius", "lengths"),
        "How to plan": ("method", "engine", "max_planning_time", "seed", "safety_distance", "damper_gain"),
        "Equation 4.9": ("epsilon", "c_mu", "c_kappa", "gain"),
        "How fast": ("timing", "speed", "jerk_limit", "dwell"),
        "Samples, and when to stop": ("dt", "tolerance", "max_time"),
        "Results": ("out", "view"),
    },
)
@click.argument("scene_file", metavar="[SCENE]", required=False)
@click.option("--case", "case", type=int, help="A case of the paper, 1, 2 or 3, instead of SCENE.")
@click.option("--method", help=f"One of {', '.join(METHODS)}.  [auto; of a case gradient-projection]")
@click.option("--engine", default="native", help=f"One of {', '.join(ENGINES)}.", show_default=True)
@click.option("--epsilon", type=float, help="Activation distance of the obstacle penalty, m  [1.0]")
@click.option("--c-mu", type=float, help="Gain of the manipulability's gradient  [1.0]")
@click.option("--c-kappa", type=float, help="Gain of the obstacle penalty's gradient  [1.0]")
@click.option("--gain", callback=numbers, help="K in 1/s: a number, or six separated by commas  [1.0]")
@click.option("--safety-distance", type=float, help="Clearance that qp and auto keep, m  [0.01]")
@click.option("--damper-gain", type=float, help="How fast qp lets clearances fall to it, 1/s  [1.4]")
@click.option("--max-planning-time", type=float, help="How long auto may look for a way, s  [10]")
@click.option("--seed", type=int, help="Of the random numbers of auto  [0]")
@click.option(
    "--timing", help=f"{' or '.join(TIMINGS)}, see above  [fastest for what auto reaches among obstacles at rest]"
)
@click.option(
    "--speed",
    type=float,
    help="Of fastest: share of the speed limits, its square of the accelerations'; 0.5 takes twice as long  [1]",
)
@click.option("--jerk-limit", type=float, help="Of fastest, m/s^3 and rad/s^3  [none]")
@click.option("--dwell", type=float, help="Of fastest: rest at each target before the next, s  [0]")
@click.option("--dt", type=float, help="Time between samples, s  [0.01]")
@click.option("--tolerance", type=float, help="Norm of the hands' error that ends the motion, m  [0.01]")
@click.option("--max-time", type=float, help="Longest motion, s  [60]")
@click.option("--link-radius", type=float, help="Radius of the collision capsules, m  [0.05]")
@click.option(
    "--set",
    "lengths",
    multiple=True,
    metavar="NAME=VALUE",
    help="Any argument of the robot: see humanoid-rail urdf -h.",
)
@click.option("--out", help="Folder for the trajectory, the scene, the robot and a page that plays it back.")
@click.option("--view/--no-view", default=None, help="Play back in a browser  [if stdout is a terminal with a display]")
def command(
    scene_file: str | None,
    case: int | None,
    out: str | None,
    view: bool | None,
    link_radius: float | None,
    lengths: tuple[str, ...],
    timing: str | None,
    speed: float | None,
    jerk_limit: float | None,
    dwell: float | None,
    **settings: Any,
) -> int:
    """Plan a motion of both hands to the targets of SCENE (YAML or JSON; without one, scenes/paper.yaml).

    It prints what came of it, and plays it back if there is somebody to look. --out keeps it in a folder for `play`,
    `verify` and `export`.

    With --timing fastest the path is followed as fast as the limits of velocity and acceleration allow, at rest at both
    ends, and is certified afresh; with --timing paper as the method has it: at full speed from the start, by eq. 4.9
    and qp with an exponential creep at the end.

    Exit code: 0 if the targets are reached, 1 if not, 2 after bad input, 130 if interrupted.
    """
    if scene_file is not None and case is not None:
        raise InvalidInput("scene", scene_file, "no scene file beside --case, which has its own scene")
    if out is not None:
        check_folder(out)
    given = {name: value for name, value in settings.items() if value is not None}
    robot = load_robot(**numbers_by_name([*lengths, *([] if link_radius is None else [f"link_radius={link_radius}"])]))
    scene = load_scene(scene_file) if scene_file is not None else paper_scene()
    by_auto = given.get("method", "auto" if case is None else None) == "auto"
    retimed = timing == FASTEST or (timing is None and by_auto and at_rest(scene.obstacles))
    retiming = _retiming(timing, retimed, {"speed": speed, "jerk_limit": jerk_limit, "dwell": dwell})
    try:
        with progress("planning"):
            trajectory = plan(robot, scene, **given) if case is None else plan_case(robot, case, **given)
            # What does not get there may be a standstill that trembles: it is retimed if that was asked for.
            if retimed and (timing == FASTEST or retiming or trajectory.status is Status.REACHED):
                longest = given.get("max_time")
                trajectory = retime(trajectory, robot, scene, max_time=longest, engine=trajectory.engine, **retiming)
    except InvalidInput as error:
        if is_of_a_scene(error):
            error.source = scene_file  # the scene is sound in itself but not one for this robot
        raise

    made = Plan(robot, scene, trajectory)
    report_plan(f"case {case} of the paper" if case is not None else scene.name, trajectory)
    if out is not None:
        written = write_plan(made, out, [(PAGE, playback_html(robot, scene, trajectory))])
        console.print(f"Written to {out}: {', '.join(path.name for path in written)}", soft_wrap=True)
    if view is None:
        view = sys.stdout.isatty() and has_display()
        if not view:
            console.print(f"To see it: {how_to_see(out)}.", soft_wrap=True)
    if view:
        play_back(made)
    return 0 if trajectory.status is Status.REACHED else 1


def _retiming(timing: str | None, retimed: bool, options: Mapping[str, float | None]) -> dict[str, Any]:
    """Return the arguments of the retiming, from the options that were given."""
    if timing is not None and timing not in TIMINGS:
        raise InvalidInput("timing", timing, f"one of {', '.join(TIMINGS)}")
    given: dict[str, Any] = {name: value for name, value in options.items() if value is not None}
    if given and not retimed:
        field, value = next(iter(given.items()))
        raise InvalidInput(field, value, f"none but with --timing {FASTEST}")
    # What retime would say too, but after the planning.
    if "jerk_limit" in given:
        checked_number("jerk_limit", given["jerk_limit"], above=0.0)
    if "speed" in given:
        checked_number("speed", given["speed"], least=LEAST_SPEED, most=1.0)
    return given


def how_to_see(out: str | None) -> str:
    """Return how to see a plan that is kept in a folder, or nowhere."""
    return "run again with --view" if out is None else f"open {Path(out) / PAGE}, or humanoid-rail play {quote(out)}"
