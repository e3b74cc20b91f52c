"""Plan a motion of both hands to their targets, print what came of it and play it back."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import click
from rich.table import Table

from humanoid_rail import (
    Certificate,
    InvalidInput,
    Robot,
    Scene,
    Status,
    Trajectory,
    load_robot,
    load_scene,
    paper_scene,
    plan,
    plan_case,
    write_trajectory,
)
from humanoid_rail.cli import console, has_display, progress, run
from humanoid_rail.engines import ENGINES
from humanoid_rail.planner import METHODS
from humanoid_rail.scene import is_of_a_scene
from humanoid_rail.search import PathQuality
from humanoid_rail.trajectory import check_folder
from humanoid_rail.viewer import playback_html, show


def numbers(_context: click.Context, _option: click.Parameter, text: str | None) -> float | tuple[float, ...] | None:
    """Parse one number, or several separated by commas."""
    if text is None:
        return None
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        raise InvalidInput("gain", text, "a number greater than 0, or six of them separated by commas") from None
    return values[0] if len(values) == 1 else values


@click.command()
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
@click.option("--dt", type=float, help="Time between samples, s  [0.01]")
@click.option("--tolerance", type=float, help="Norm of the hands' error that ends the motion, m  [0.01]")
@click.option("--max-time", type=float, help="Longest motion, s  [60]")
@click.option("--link-radius", type=float, help="Radius of the collision capsules, m  [0.05]")
@click.option("--out", help="Folder for the trajectory and its playback page.")
@click.option("--view/--no-view", default=None, help="Play back in a browser  [if stdout is a terminal with a display]")
def main(
    scene_file: str | None,
    case: int | None,
    out: str | None,
    view: bool | None,
    link_radius: float | None,
    **settings: Any,
) -> int:
    """Plan a motion of both hands to the targets of SCENE (YAML or JSON; without one, scenes/paper.yaml).

    Exit code: 0 if the targets are reached, 1 if not, 2 after bad input.
    """
    if scene_file is not None and case is not None:
        raise InvalidInput("scene", scene_file, "no scene file beside --case, which has its own scene")
    if out is not None:
        check_folder(out)
    given = {name: value for name, value in settings.items() if value is not None}
    robot = load_robot() if link_radius is None else load_robot(link_radius=link_radius)
    scene = load_scene(scene_file) if scene_file is not None else paper_scene()
    try:
        with progress("planning"):
            trajectory = plan(robot, scene, **given) if case is None else plan_case(robot, case, **given)
    except InvalidInput as error:
        if is_of_a_scene(error):
            error.source = scene_file  # the scene is sound in itself but not one for this robot
        raise

    title = f"case {case} of the paper" if case is not None else scene.name
    report(title, trajectory)
    if out is not None:
        written = write_trajectory(trajectory, out, [("playback.html", playback_html(robot, scene, trajectory))])
        console.print(f"Written to {out}: {', '.join(path.name for path in written)}", soft_wrap=True)
    play(robot, scene, trajectory, view, out)
    return 0 if trajectory.status is Status.REACHED else 1


def report(title: str, trajectory: Trajectory) -> None:
    """Print a short table of what came of the plan."""
    table = Table(title=title, title_justify="left", show_header=False)
    clearance = trajectory.min_clearance
    table.add_row("status", f"{trajectory.status}: {trajectory.reason}")
    table.add_row("duration", f"{trajectory.duration:.4f} s")
    certificate = trajectory.certificate
    table.add_row("method", trajectory.method + _found_by(trajectory))
    table.add_row("certified", _certified(certificate, trajectory.duration))
    table.add_row("collision-free", f"{_yes(trajectory.collision_free)}, at the samples")
    table.add_row("least clearance", _clearance(clearance, "no obstacles"))
    table.add_row("between links", _clearance(certificate.min_clearance_self, "no pairs to check"))
    for i, violation in enumerate(trajectory.violations):
        what = f"{violation.joint} {violation.quantity} {violation.value:.3g}, limit {violation.limit:.3g}"
        table.add_row("" if i else "beyond limits", f"{what}, at {violation.t:.2f} s")
    if trajectory.limits_ok:
        table.add_row("within limits", "yes")
    table.add_row("manipulability", f"{trajectory.manipulability[0]:.3f} to {trajectory.manipulability[-1]:.3f}")
    table.add_row("path", _path(trajectory))
    table.add_row(
        "planning",
        f"{1e3 * trajectory.planning_time:.1f} ms ({trajectory.engine}), {trajectory.evaluations} evaluations of q_dot",
    )
    console.print(table)


def play(robot: Robot, scene: Scene, trajectory: Trajectory, view: bool | None, out: str | None) -> None:
    """Open the view if asked to, or if there is somebody to look; else say how to see it."""
    if view is None:
        view = sys.stdout.isatty() and has_display()
        if not view:
            page = f"open {Path(out) / 'playback.html'}, or " if out is not None else ""
            console.print(f"To see it: {page}run again with --view.", soft_wrap=True)
    if view:
        show(
            robot,
            scene,
            trajectory,
            open_browser=has_display(),
            on_ready=lambda url: console.print(f"Playing at {url} until Ctrl-C.", soft_wrap=True),
        )


def _certified(certificate: Certificate, end: float) -> str:
    if certificate.contact is not None:
        return f"NO: {certificate.contact}"
    bound = certificate.clearance_bound
    if not certificate.certified:
        return "NO: it could not be shown to be free of contact"
    nothing = "yes: there is nothing to touch"
    return nothing if bound is None else f"yes: no clearance below {bound:.4f} m until t = {end:.4g} s"


def _found_by(trajectory: Trajectory) -> str:
    return f": found by {trajectory.found_by}" if trajectory.method == "auto" and trajectory.found_by else ""


def _path(trajectory: Trajectory) -> str:
    """Say how long the path is and how sharply it turns, and what it was before it was smoothed."""
    path, raw = trajectory.path, trajectory.search.raw if trajectory.search else None
    said = f"length {path.length:.3g} s (joints in units of their speed limits), sharpest turn {_degrees(path)}"
    return said + (f"; as it was sampled {raw.length:.3g} s and {_degrees(raw)}" if raw else "")


def _degrees(path: PathQuality) -> str:
    return f"{round(math.degrees(path.sharpest_turn), 1):g} deg"


def _clearance(clearance: float | None, nothing: str) -> str:
    return nothing if clearance is None else f"{clearance:.4f} m"


def _yes(truth: bool) -> str:
    return "yes" if truth else "NO"


if __name__ == "__main__":
    run(main)
