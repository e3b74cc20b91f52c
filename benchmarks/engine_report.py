"""Measures the engine and compares it with the bare library calls, with Pink and with the Python reference.

python -m benchmarks.engine_report --no-pink --json figures.json
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from pathlib import Path

import click

from benchmarks.engine import measure_batch, measure_evaluation, measure_obstacles, measure_plan
from benchmarks.following import Following, measure_following
from benchmarks.limits import broken
from benchmarks.machine import machine
from benchmarks.stopwatch import Figure, Ratio
from humanoid_rail._files import check_folder
from humanoid_rail._native import engine
from humanoid_rail.cli.console import check_least, console, print_table, run
from humanoid_rail.errors import HumanoidRailError
from humanoid_rail.progress import progress

TIME_COLUMNS = ("measured", "median", "quartiles")
RATIO_COLUMNS = ("compared", "ratio", "quartiles")
FOLLOWING_COLUMNS = ("followed", "time", "cycles", "median", "99 %", "longest", "late", "not proven", "touching")

PAGE = click.Path(exists=True, dir_okay=False, path_type=Path)
"""A Markdown file with the marks of a table."""


@dataclass(frozen=True)
class Report:
    """Everything measured."""

    machine: str
    figures: list[Figure]
    ratios: list[Ratio]
    followings: list[Following]


@click.command()
@click.option("--json", "json_file", type=click.Path(dir_okay=False, path_type=Path), help="File for the figures.")
@click.option("--ratios", "ratios_page", type=PAGE, help="Markdown file for the table of ratios.")
@click.option("--times", "times_page", type=PAGE, help="Markdown file for the table of times.")
@click.option("--following", "following_page", type=PAGE, help="Markdown file for the table of following.")
@click.option("--repeats", default=9, show_default=True, help="Repeats of each measurement.")
@click.option("--plans", default=2000, show_default=True, help="Plans for the measurement of plan_many.")
@click.option("--follow", default=60, show_default=True, help="Seconds of following.")
@click.option("--pink/--no-pink", default=True, show_default=True, help="Compare with Pink (extra `compare`).")
@click.option("--check", is_flag=True, help="Exit code 1 if a ratio is beyond its limit in benchmarks/limits.py.")
def main(
    json_file: Path | None,
    ratios_page: Path | None,
    times_page: Path | None,
    following_page: Path | None,
    repeats: int,
    plans: int,
    follow: int,
    pink: bool,
    check: bool,
) -> int:
    """Measure the engine. The first table has medians and quartiles, the second ratios within this run."""
    engine()  # or say what to install
    if pink and find_spec("pink") is None:
        raise HumanoidRailError("Pink is not installed: pip install 'humanoid_rail[compare]', or --no-pink")
    check_least(1, repeats=repeats, plans=plans, follow=follow)
    if json_file is not None:
        check_folder(json_file.parent)
    report = measure(repeats, plans, follow, pink)
    console().print(report.machine)
    rows = [[f.what, seconds(f.median), f"{seconds(f.low)} to {seconds(f.high)}"] for f in report.figures]
    print_table("times", "Times", TIME_COLUMNS, rows, times_page)
    print_table("ratios", "Ratios", RATIO_COLUMNS, [ratio_row(r) for r in report.ratios], ratios_page)
    rows = [list(following_row(f)) for f in report.followings]
    print_table("following", "Following at 1 kHz", FOLLOWING_COLUMNS, rows, following_page)
    if json_file is not None:
        json_file.parent.mkdir(parents=True, exist_ok=True)
        json_file.write_text(json.dumps(asdict(report), indent=2) + "\n", encoding="utf-8")
    faults = broken(report.ratios) if check else []
    for fault in faults:
        click.echo(f"error: {fault}", err=True)
    return 1 if faults else 0


def measure(repeats: int, plans: int, follow: int, pink: bool) -> Report:
    """Measure everything."""
    report = Report(machine(), [], [], [])
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
                    report.figures.append(found)
                else:
                    report.ratios.append(found)
    with progress("measuring following"):
        report.followings.extend(measure_following(follow))
    return report


def seconds(value: float) -> str:
    """Return a time with three digits and a unit."""
    for unit, factor in (("s", 1.0), ("ms", 1e3), ("us", 1e6)):
        if value * factor >= 1.0 or unit == "us":
            return f"{value * factor:.3g} {unit}"
    raise AssertionError


def ratio_row(r: Ratio) -> Sequence[str]:
    """Return a row of the table of ratios."""
    return [r.what, f"{r.median:.3g}", f"{r.low:.3g} to {r.high:.3g}"]


def following_row(f: Following) -> Sequence[str]:
    """Return a row of the table of following."""
    times = f.times
    return [
        f.what,
        f"{f.seconds:g} s",
        f"{times.cycles:,}",
        seconds(times.median),
        seconds(times.percentile_99),
        seconds(times.longest),
        f"{times.overruns:,}",
        f"{f.unproven} of {f.looked}",
        f"{f.touching} of {f.looked}",
    ]


if __name__ == "__main__":
    run(main)
