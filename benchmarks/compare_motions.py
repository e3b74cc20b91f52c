"""The command that compares motions: this checkout's, those of the commit before, roboplan's and Drake's."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import click

from benchmarks.evaluate import WIDTH
from benchmarks.evaluation import family_of, load_files
from benchmarks.machine import machine
from benchmarks.motions import (
    BEFORE,
    DRAKE,
    DRAKE_STRAIGHT,
    EVERY,
    OPTIMISED,
    QUICK,
    ROBOPLAN,
    Outcome,
    Row,
    judge,
    make_rows,
)
from benchmarks.worker import ROOT, Checkout, Worker
from humanoid_rail._files import check_folder
from humanoid_rail.cli.console import Command, check_least, console, print_table, run
from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.library import load_robot
from humanoid_rail.model.robot import Robot
from humanoid_rail.progress import progress, progress_bar
from humanoid_rail.scene.scene import Scene

SCRIPT = ROOT / "benchmarks" / "motions_worker.py"
INSTALLED = {ROBOPLAN: ("roboplan", "compare"), **dict.fromkeys(DRAKE, ("drake", "tools"))}
"""The package that a method needs, and the extra that has it."""
COLUMNS = (
    "family",
    "method",
    "reached",
    "certified",
    "touched",
    "beyond limits",
    "planning [ms]",
    "95 % [ms]",
    "planning / before",
    "planning by scene",
    "95 % / before",
    "until timed [ms]",
    "motion [s]",
    "motion / bound",
    "motion / before",
    "motion by scene",
    "longest / before",
    "motion / drake",
)

Answer = Mapping[str, Any]
Planner = Callable[[Path, int, Answer], Answer]
"""Returns a worker's answer for the file of a scene, a seed and the answer of `quick`."""


@click.command(
    cls=Command,
    examples={
        "python -m benchmarks.compare_motions scenes/dev --base ../base": "Everything that is installed, 75 scenes.",
        "python -m benchmarks.compare_motions scenes/dev --family deep --method optimised": "Two methods on 15 scenes.",
    },
    groups={
        "What to compare": ("base", "methods", "wanted", "seeds", "repeats"),
        "Results": ("json_file", "table"),
    },
)
@click.argument("folder", metavar="DIR")
@click.option(
    "--base",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Another checkout in which `make plan` was run: the commit before.",
)
@click.option("--method", "methods", multiple=True, help=f"One of {', '.join(EVERY)}; again for more.  [all there are]")
@click.option("--family", "wanted", multiple=True, help="Only the scenes of this family, `shelf` say; again for more.")
@click.option("--seed", "seeds", multiple=True, type=int, help="Seed of the random numbers; again for more.  [0]")
@click.option("--repeats", default=3, show_default=True, help="How often each plans; the fastest counts. Drake: once.")
@click.option("--json", "json_file", type=click.Path(dir_okay=False, path_type=Path), help="File for the figures.")
@click.option(
    "--table", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file for the table."
)
def command(
    folder: str,
    base: Path | None,
    methods: tuple[str, ...],
    wanted: tuple[str, ...],
    seeds: tuple[int, ...],
    repeats: int,
    json_file: Path | None,
    table: Path | None,
) -> None:
    """Plan every scene in DIR by several planners in turns, and print how long planning and the motions take.

    Each planner has a process of its own, and its time is the processor time of that process. All motions are judged by
    this checkout: certified as the splines that they are, held against the limits at 1 ms, and compared with the least
    time that each joint would need by itself. docs/benchmarks.md says what each method is. `quick` is always there.
    """
    check_least(1, repeats=repeats)
    if json_file is not None:
        check_folder(json_file.parent)
    robot, measured_on = load_robot(), machine()
    with progress("reading scenes"):
        scenes = load_files(robot, folder, wanted)
    with ExitStack() as stack:
        planners = start(methods, base, stack)
        names = dict.fromkeys(seeds or (0,))
        with progress("warming up"):
            warm_up(next(iter(scenes)), planners)
        with progress_bar("planning", len(scenes) * len(names)) as advance:
            outcomes = []
            for file, scene in scenes.items():
                for seed in names:
                    outcomes += compare(robot, scene, file, seed, planners, repeats)
                    advance(1)
    rows = make_rows(outcomes)
    if json_file is not None:
        json_file.parent.mkdir(parents=True, exist_ok=True)
        report = {"machine": measured_on, "rows": rows, "outcomes": outcomes}
        json_file.write_text(json.dumps(report, default=asdict, indent=2) + "\n", encoding="utf-8")
    if not console().is_terminal:
        console().width = max(console().width, WIDTH)
    console().print(", ".join([measured_on, *versions(planners)]))
    for outcome in outcomes:
        if outcome.duration is None:
            said = f"{outcome.scene}, seed {outcome.seed}, by {outcome.method}: {outcome.reason}"
            console().print(said, soft_wrap=True)
    print_table("motions", "Motions", COLUMNS, [cells(row) for row in rows], table)


def start(methods: Sequence[str], base: Path | None, stack: ExitStack) -> dict[str, Planner]:
    """Start what plans by the methods that were asked for, or by all that are there, until the stack is left.

    Raises:
        InvalidInput: If one was asked for that does not exist or is not there.
    """
    own = Checkout(ROOT, SCRIPT)
    stack.callback(own.close)
    optimises = "optimise" in own.about["options"]
    missing = dict(_missing(base, optimises))
    for method in methods:
        if method not in EVERY:
            raise InvalidInput("method", method, f"one of {', '.join(EVERY)}")
        if method in missing:
            raise InvalidInput("method", method, missing[method])
    wanted = [name for name in EVERY if name not in missing and (name == QUICK or not methods or name in methods)]
    planners = {QUICK: _by_package(own, {"optimise": False} if optimises else {})}
    if OPTIMISED in wanted:
        planners[OPTIMISED] = _by_package(own, {})
    if BEFORE in wanted:
        assert base is not None
        before = Checkout(base, SCRIPT)
        stack.callback(before.close)
        planners[BEFORE] = _by_package(before, {})
    if ROBOPLAN in wanted:
        roboplan = _own_worker("roboplan_worker", stack)
        planners[ROBOPLAN] = lambda file, seed, quick: roboplan.ask({"scene": str(file), "seed": seed})
    if any(name in wanted for name in DRAKE):
        drake = _own_worker("drake_worker", stack)
        planners |= {name: _by_drake(drake, name == DRAKE_STRAIGHT) for name in DRAKE if name in wanted}
    return planners


def _missing(base: Path | None, optimises: bool) -> Iterator[tuple[str, str]]:
    """Yield the methods that are not there, and what would be right."""
    if not optimises:
        yield OPTIMISED, "one of a checkout whose Auto has the option `optimise`"
    if base is None:
        yield BEFORE, "one with another checkout: --base"
    for method, (package, extra) in INSTALLED.items():
        if _version(package) is None:
            yield method, f"an installed one: pip install 'humanoid_rail[{extra}]'"


def _own_worker(module: str, stack: ExitStack) -> Worker:
    worker = Worker([sys.executable, "-m", f"benchmarks.{module}"])
    stack.callback(worker.close)
    return worker


def _by_package(checkout: Checkout, options: Mapping[str, Any]) -> Planner:
    return lambda file, seed, quick: checkout.ask({"scene": str(file), "options": {**options, "seed": seed}})


def _by_drake(worker: Worker, straight: bool) -> Planner:
    def ask(file: Path, seed: int, quick: Answer) -> Answer:
        if "failed" in quick:
            return {"failed": "there is no plan to begin with", "planning_time": 0.0}
        return worker.ask(
            {"scene": str(file), "straight": straight, **{name: quick[name] for name in ("t", "q", "velocity")}}
        )

    return ask


def warm_up(file: Path, planners: Mapping[str, Planner]) -> None:
    """Plan a scene by each: what is loaded and made once does not count."""
    quick: Answer = {}
    for planner in planners.values():
        answer = planner(file, 0, quick)
        quick = quick or answer


def compare(
    robot: Robot, scene: Scene, file: Path, seed: int, planners: Mapping[str, Planner], repeats: int
) -> list[Outcome]:
    """Return what comes of a scene by each planner. They take turns in who is first; of each the fastest counts."""
    answers: dict[str, list[Answer]] = {name: [] for name in planners}
    turns = [name for name in planners if name not in DRAKE]
    for repeat in range(repeats):
        first = repeat % len(turns)
        for name in (*turns[first:], *turns[:first]):
            answers[name].append(planners[name](file, seed, {}))
    for name in planners:
        if name in DRAKE:
            answers[name].append(planners[name](file, seed, answers[QUICK][0]))
    outcomes = []
    for name, some in answers.items():
        fastest = min(some, key=lambda answer: float(answer.get("time", answer["planning_time"])))
        known = {"scene": scene.name, "family": family_of(scene), "seed": seed, "method": name}
        outcomes.append(judge(robot, scene, known, fastest))
    return outcomes


def cells(row: Row) -> list[str]:
    """Return a row of the table."""
    return [
        row.family,
        row.method,
        *(f"{count}/{row.motions}" for count in (row.reached, row.certified)),
        *(str(count) for count in (row.touched, row.beyond_limits)),
        *(_milliseconds(seconds) for seconds in (row.median_time, row.p95_time)),
        *(_said(ratio) for ratio in (row.median_to_before, row.by_scene_to_before, row.p95_to_before)),
        _milliseconds(row.total_time),
        _said(row.duration),
        *(_said(ratio, 3) for ratio in (row.to_bound, row.duration_to_before, row.duration_by_scene)),
        *(_said(ratio, 3) for ratio in (row.longest_to_before, row.to_drake)),
    ]


def _milliseconds(seconds: float) -> str:
    return f"{1e3 * seconds:.{0 if seconds >= 0.1 else 1}f}"


def _said(value: float | None, digits: int = 2) -> str:
    return "" if value is None else f"{value:.{digits}f}"


def versions(planners: Mapping[str, Planner]) -> list[str]:
    """Return what else took part, with its version."""
    packages = dict.fromkeys(INSTALLED[name][0] for name in planners if name in INSTALLED)
    return [f"{package} {_version(package)}" for package in packages]


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


if __name__ == "__main__":
    run(command)
