"""The command that compares methods on the scenes of a folder."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path

import click
import numpy as np

from benchmarks.evaluation import (
    ALL,
    Evaluation,
    Outcome,
    Row,
    attempt,
    evaluate,
    least,
    load_families,
    make_rows,
)
from benchmarks.machine import machine
from benchmarks.planners import EVERY, FAILED, make_planner
from humanoid_rail._files import check_folder
from humanoid_rail.cli.console import Command, console, print_table, run
from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.library import load_robot
from humanoid_rail.planning.methods import METHODS
from humanoid_rail.progress import progress, progress_bar

PICTURES = (".png", ".svg")
"""The figure has one of these suffixes."""
WIDTH = 200
"""The table has at least this width where there is no terminal whose width it has to keep to, in characters."""
COLUMNS = (
    "family",
    "method",
    "reached",
    "certified",
    "both",
    "touched",
    "beyond limits",
    "median [ms]",
    "95 % [ms]",
    "least clearance [m]",
    "path [s]",
    "turn [deg]",
    "sampled path [s]",
    "sampled turn [deg]",
)

RESULT_COLUMNS = ("method", "reached and certified", "median planning time [ms]", "path [s]")
RESULTS = ("auto", "qp", "gradient-projection", "ik + rrt-connect")
"""The README has a row for each of these."""


@click.command(
    cls=Command,
    examples={
        "python -m benchmarks.evaluate scenes/dev": "The planner's methods, on 75 scenes.",
        "python -m benchmarks.evaluate scenes/dev --family deep --method auto --method pink": "Two methods on 15.",
    },
    groups={"What to compare": ("methods", "wanted"), "Results": ("json_file", "figure", "table", "results")},
)
@click.argument("folder", metavar="DIR")
@click.option("--method", "methods", multiple=True, help=f"One of {', '.join(EVERY)}; again for more.")
@click.option("--family", "wanted", multiple=True, help="Only the scenes of this family, `shelf` say; again for more.")
@click.option("--json", "json_file", type=click.Path(dir_okay=False, path_type=Path), help="File for the figures.")
@click.option("--figure", type=click.Path(dir_okay=False, path_type=Path), help="File for the picture, PNG or SVG.")
@click.option(
    "--table", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file for the table."
)
@click.option(
    "--results",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="Markdown file for the table of four methods over all scenes.",
)
def command(
    folder: str,
    methods: tuple[str, ...],
    wanted: tuple[str, ...],
    json_file: Path | None,
    figure: Path | None,
    table: Path | None,
    results: Path | None,
) -> None:
    """Plan every scene in DIR, one at a time, and print the results per family of scenes.

    The family is a scene's name up to its number: shelf-900000 is one of `shelf`. The times, median and 95th percentile
    over all scenes, are of planning and certifying. The least clearance is from obstacles or between links. The path is
    the median length of those that reached their targets, in joint coordinates, each divided by its speed limit, and
    the turn the sharpest of them between two samples; then the same of the paths as sampling planners found them first.

    Without --method each of the planner's is tried. `pink` (extra `compare`) is Pink with limits of position and speed
    and with barriers for all that `qp` keeps clear of; it plans nothing by itself, so its motion is rolled out.
    `ik + rrt-connect` is a textbook combination of inverse kinematics and OMPL.
    """
    planners = {method: make_planner(method) for method in dict.fromkeys(methods or METHODS)}
    if figure is not None:
        check_figure(figure)
    for file in (json_file, figure):
        if file is not None:
            check_folder(file.parent)
    robot, measured_on = load_robot(), machine()
    with progress("reading scenes"):
        scenes = load_families(robot, folder, wanted)
    with progress("warming up"):
        for planner in planners.values():
            attempt(planner, robot, scenes[0])
    with progress_bar("planning", len(scenes) * len(planners)) as advance:
        outcomes = evaluate(robot, scenes, planners, advance)
    evaluation = Evaluation(measured_on, make_rows(outcomes), outcomes)

    if json_file is not None:
        json_file.parent.mkdir(parents=True, exist_ok=True)
        json_file.write_text(json.dumps(asdict(evaluation), indent=2) + "\n", encoding="utf-8")
    if figure is not None:
        save_figure(outcomes, figure)
    if not console().is_terminal:
        console().width = max(console().width, WIDTH)
    console().print(evaluation.machine)
    for outcome in outcomes:
        if outcome.status == FAILED:
            console().print(f"{outcome.scene} by {outcome.method} failed: {outcome.reason}", soft_wrap=True)
    print_table("evaluation", "Evaluation", COLUMNS, [cells(row) for row in evaluation.rows], table)
    if results is not None:
        print_table("results", "Results", RESULT_COLUMNS, result_rows(evaluation.rows), results)


def check_figure(figure: Path) -> None:
    """Check that a picture can be drawn, and of this kind.

    Raises:
        InvalidInput: If it cannot.
    """
    if figure.suffix not in PICTURES:
        raise InvalidInput("figure", str(figure), f"a file name that ends in {' or '.join(PICTURES)}")
    if find_spec("matplotlib") is None:
        raise InvalidInput("figure", str(figure), "none without matplotlib: pip install 'humanoid_rail[figures]'")


def cells(row: Row) -> Sequence[str]:
    """Return a row of the table."""
    clearance = least([row.min_clearance_obstacles, row.min_clearance_self])
    return [
        row.family,
        row.method,
        f"{row.reached}/{row.scenes}",
        *(str(count) for count in (row.certified, row.reached_and_certified, row.touched, row.beyond_limits)),
        *(f"{1e3 * seconds:.{0 if seconds >= 0.1 else 1}f}" for seconds in (row.median_time, row.p95_time)),
        "" if clearance is None else f"{clearance:.4f}",
        *(_said(row.path_length, row.sharpest_turn)),
        *(_said(row.sampled_length, row.sampled_turn)),
    ]


def result_rows(rows: Sequence[Row]) -> list[list[str]]:
    """Return the rows of the README: what came of all scenes by each method."""
    found = {row.method: row for row in rows if row.family == ALL}
    return [
        [
            method,
            f"{found[method].reached_and_certified}/{found[method].scenes}",
            f"{1e3 * found[method].median_time:.1f}",
            _said(found[method].path_length, 0.0)[0],
        ]
        for method in RESULTS
        if method in found
    ]


def _said(length: float | None, turn: float | None) -> tuple[str, str]:
    if length is None or turn is None:
        return "", ""
    return f"{length:.2f}", f"{np.rad2deg(turn):.0f}"


def save_figure(outcomes: Sequence[Outcome], file: Path) -> None:
    """Draw how long planning takes."""
    from humanoid_rail.paper.figures import planning_time_figure

    families: dict[str, dict[str, list[float]]] = {}
    for o in outcomes:
        times = families.setdefault(o.family, {}).setdefault(o.method, [])
        times.append(o.planning_time if o.good else np.inf)
    file.parent.mkdir(parents=True, exist_ok=True)
    planning_time_figure(families).savefig(file, dpi=130)


if __name__ == "__main__":
    run(command)
