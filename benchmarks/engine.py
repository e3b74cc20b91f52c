"""Measure the engine and compare it with the bare library calls, with Pink and with the reference in Python."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from pathlib import Path

import click

from benchmarks.engine_measurements import measure_all
from benchmarks.machine import machine
from benchmarks.stopwatch import Figure, Ratio
from humanoid_rail._native import engine
from humanoid_rail.cli.console import Command, console, print_table, run
from humanoid_rail.errors import HumanoidRailError, InvalidInput
from humanoid_rail.io.files import check_folder
from humanoid_rail.progress import progress

TIME_COLUMNS = ("measured", "median", "quartiles")
RATIO_COLUMNS = ("compared", "ratio", "quartiles")


@dataclass(frozen=True)
class Report:
    """Everything measured."""

    machine: str
    """What it was measured on."""
    figures: list[Figure]
    """How long things take."""
    ratios: list[Ratio]
    """How they compare."""


@click.command(
    cls=Command,
    examples={
        "python -m benchmarks.engine --check": "Whether the ratios are within their limits.",
        "python -m benchmarks.engine --no-pink --json figures.json": "Without Pink, and the figures as data.",
    },
    groups={"What to measure": ("repeats", "plans", "pink"), "Results": ("check", "json_file", "ratios", "times")},
)
@click.option("--check", is_flag=True, help="Exit with code 1 if a ratio is outside its limit, and say which.")
@click.option("--json", "json_file", type=click.Path(dir_okay=False, path_type=Path), help="File for the figures.")
@click.option(
    "--ratios", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file for the ratios."
)
@click.option(
    "--times", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file for the times."
)
@click.option("--repeats", default=9, show_default=True, help="Repeats of each measurement.")
@click.option("--plans", default=2000, show_default=True, help="Plans for the measurement of plan_many.")
@click.option("--pink/--no-pink", default=True, show_default=True, help="Compare with Pink (extra `compare`).")
def main(
    check: bool, json_file: Path | None, ratios: Path | None, times: Path | None, repeats: int, plans: int, pink: bool
) -> int:
    """Measure the engine and compare it with the bare library calls, with Pink and with the reference in Python.

    The first table has medians and quartiles, the second ratios within this run.
    """
    engine()  # says what to install where there is none
    if pink and find_spec("pink") is None:
        raise HumanoidRailError("Pink is not installed: pip install 'humanoid_rail[compare]', or --no-pink")
    for name, value in (("repeats", repeats), ("plans", plans)):
        if value < 1:
            raise InvalidInput(name, value, "1 or more")
    if json_file is not None:
        check_folder(json_file.parent)
    measured_on = machine()
    with progress("measuring"):
        found = list(measure_all(repeats, plans, pink))
    report = Report(
        measured_on, [f for f in found if isinstance(f, Figure)], [r for r in found if isinstance(r, Ratio)]
    )
    console().print(report.machine)
    print_table("times", "Times", TIME_COLUMNS, [time_row(figure) for figure in report.figures], times)
    print_table("ratios", "Ratios", RATIO_COLUMNS, [ratio_row(ratio) for ratio in report.ratios], ratios)
    if json_file is not None:
        json_file.parent.mkdir(parents=True, exist_ok=True)
        json_file.write_text(json.dumps(asdict(report), indent=2) + "\n", encoding="utf-8")
    return print_faults(report.ratios) if check else 0


def print_faults(ratios: Iterable[Ratio]) -> int:
    """Print which ratios are outside their limits, and return the exit code: 1 if there are some."""
    faults = [fault for ratio in ratios if (fault := ratio.fault) is not None]
    for fault in faults:
        console().print(f"Outside its limit: {fault}.", soft_wrap=True)
    if not faults:
        console().print("All ratios are within their limits.")
    return 1 if faults else 0


def seconds(value: float) -> str:
    """Return a time with three digits and a unit."""
    for unit, factor in (("s", 1.0), ("ms", 1e3), ("us", 1e6)):
        if value * factor >= 1.0 or unit == "us":
            return f"{value * factor:.3g} {unit}"
    raise AssertionError


def time_row(figure: Figure) -> Sequence[str]:
    """Return a row of the table of times."""
    return [figure.what, seconds(figure.median), f"{seconds(figure.low)} to {seconds(figure.high)}"]


def ratio_row(ratio: Ratio) -> Sequence[str]:
    """Return a row of the table of ratios."""
    return [ratio.what, f"{ratio.median:.3g}", f"{ratio.low:.3g} to {ratio.high:.3g}"]


if __name__ == "__main__":
    run(main)
