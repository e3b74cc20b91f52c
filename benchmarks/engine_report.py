"""The command that measures the engines."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from pathlib import Path

import click

from humanoid_rail.cli.console import Command, console, print_table, progress
from benchmarks.engine import measure_batch, measure_evaluation, measure_obstacles, measure_plan
from benchmarks.machine import machine
from benchmarks.stopwatch import Figure, Ratio
from humanoid_rail.planning.engines import why_not_native
from humanoid_rail.errors import HumanoidRailError, InvalidInput
from humanoid_rail.io.trajectory_files import check_folder

TIME_COLUMNS = ("measured", "median", "quartiles")
RATIO_COLUMNS = ("compared", "ratio", "quartiles", "wanted", "holds")


@dataclass(frozen=True)
class Report:
    """Everything measured."""

    machine: str
    figures: list[Figure]
    ratios: list[Ratio]


@click.command(
    cls=Command,
    examples={"humanoid-rail benchmark --no-pink --json figures.json": "Without Pink, and the figures as data."},
    groups={"What to measure": ("repeats", "plans", "pink"), "Results": ("json_file", "readme", "docs")},
)
@click.option("--json", "json_file", type=click.Path(dir_okay=False, path_type=Path), help="File for the figures.")
@click.option(
    "--readme", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file for the ratios."
)
@click.option(
    "--docs", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file for the times."
)
@click.option("--repeats", default=9, show_default=True, help="Repeats of each measurement.")
@click.option("--plans", default=2000, show_default=True, help="Plans for the measurement of plan_many.")
@click.option("--pink/--no-pink", default=True, show_default=True, help="Compare with Pink (extra `compare`).")
def command(
    json_file: Path | None, readme: Path | None, docs: Path | None, repeats: int, plans: int, pink: bool
) -> None:
    """Measure the engines and compare them with the bare library calls, with Pink and with each other.

    The first table has medians and quartiles, the second ratios within this run.
    """
    if (reason := why_not_native()) is not None:
        raise HumanoidRailError(f"there is no native engine to measure: {reason}")
    if pink and find_spec("pink") is None:
        raise HumanoidRailError("Pink is not installed: pip install 'humanoid_rail[compare]', or --no-pink")
    for name, value in (("repeats", repeats), ("plans", plans)):
        if value < 1:
            raise InvalidInput(name, value, "1 or more")
    if json_file is not None:
        check_folder(json_file.parent)
    measured_on = machine()
    figures: list[Figure] = []
    ratios: list[Ratio] = []
    for what, measured in (
        # First, while this process is as light as the workers.
        ("many plans", measure_batch(max(3, repeats // 2), plans)),
        ("an evaluation", measure_evaluation(repeats, pink)),
        ("a plan", measure_plan(repeats, pink)),
        ("many obstacles", measure_obstacles(repeats)),
    ):
        with progress(f"measuring {what}"):
            for found in measured:
                if isinstance(found, Figure):
                    figures.append(found)
                else:
                    ratios.append(found)
    report = Report(measured_on, figures, ratios)
    console.print(report.machine)
    rows = [[f.what, seconds(f.median), f"{seconds(f.low)} to {seconds(f.high)}"] for f in figures]
    print_table("times", "Times", TIME_COLUMNS, rows, docs)
    print_table("ratios", "Ratios and limits", RATIO_COLUMNS, [ratio_row(r) for r in ratios], readme)
    if json_file is not None:
        json_file.parent.mkdir(parents=True, exist_ok=True)
        json_file.write_text(json.dumps(asdict(report), indent=2) + "\n", encoding="utf-8")


def seconds(value: float) -> str:
    """Return a time with three digits and a unit."""
    for unit, factor in (("s", 1.0), ("ms", 1e3), ("us", 1e6)):
        if value * factor >= 1.0 or unit == "us":
            return f"{value * factor:.3g} {unit}"
    raise AssertionError


def ratio_row(r: Ratio) -> Sequence[str]:
    """Return a row of the table of ratios."""
    return [
        r.what,
        f"{r.median:.3g}",
        f"{r.low:.3g} to {r.high:.3g}",
        r.wanted,
        ("yes" if r.holds else "NO") if r.wanted else "",
    ]
