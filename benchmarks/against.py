"""Compare planning times and results of this checkout with those of another, built in its own `.venv`.

Each checkout has a process of its own. They are given the same scenes in turns, so that what slows the machine down
slows both.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

import click
import numpy as np

from benchmarks.evaluation import ALL, SUFFIXES, family_of
from benchmarks.machine import machine
from benchmarks.worker import ROOT, Checkout
from humanoid_rail.cli.console import Command, check_least, console, print_table, run
from humanoid_rail.errors import InvalidInput
from humanoid_rail.planning.methods import METHODS
from humanoid_rail.progress import progress_bar
from humanoid_rail.scene.scene import load_scene

WORKER = ROOT / "benchmarks" / "against_worker.py"
MOST = 1.05
"""Planning may take at most this many times as long as in the other checkout."""
COLUMNS = ("family", "method", "scenes", "time / other", "quartiles", "total / other", "reached", "certified")


@dataclass
class Comparison:
    """What a method made of a scene in this checkout and in the other."""

    family: str
    """The family of the scene."""
    scene: str
    """The name of the scene."""
    method: str
    """The name of the method."""
    times: list[float] = field(default_factory=list)
    """Planning times of this checkout, s."""
    others: list[float] = field(default_factory=list)
    """Planning times of the other, s."""
    result: tuple[str, bool] = ("", False)
    """The status, and whether the motion is certified."""
    other_result: tuple[str, bool] = ("", False)
    """The same of the other."""

    @property
    def ratio(self) -> float:
        """The planning time over the other's, of each the fastest of all repeats."""
        return min(self.times) / min(self.others)

    @property
    def same(self) -> bool:
        """Whether both have the same result."""
        return self.result == self.other_result


@click.command(
    cls=Command,
    examples={"python -m benchmarks.against ../base": "Compare with the checkout in ../base, where make plan was run."},
    groups={"What to compare": ("scenes", "methods", "wanted", "repeats", "most")},
)
@click.argument("base", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--scenes", default=str(ROOT / "scenes" / "dev"), help="Folder of the scenes.  [scenes/dev]")
@click.option("--method", "methods", multiple=True, help=f"One of {', '.join(METHODS)}; again for more.  [all]")
@click.option("--family", "wanted", multiple=True, help="Only the scenes of this family; again for more.")
@click.option("--repeats", default=5, show_default=True, help="How often each scene is planned by each.")
@click.option("--most", default=MOST, show_default=True, help="The largest ratio of planning times that is accepted.")
def main(base: Path, scenes: str, methods: tuple[str, ...], wanted: tuple[str, ...], repeats: int, most: float) -> int:
    """Plan scenes with this checkout and with the one in BASE in turns, and compare planning times and results.

    The ratio of a family is the median over its scenes, each the fastest of all repeats over the other's fastest; in
    total it is the sum of these over the other's.

    Exit code: 0 if the results are the same and no method takes longer than accepted over all scenes, else 1.
    """
    for method in methods:
        if method not in METHODS:
            raise InvalidInput("method", method, f"one of {', '.join(METHODS)}")
    check_least(1, repeats=repeats)
    files = sorted(file for file in Path(scenes).resolve().glob("*") if file.suffix in SUFFIXES)
    families = {file: family_of(load_scene(file)) for file in files}
    files = [file for file in files if not wanted or families[file] in wanted]
    if not files:
        raise InvalidInput("scenes", scenes, "a folder with scenes of these families")
    found = [Comparison(families[file], str(file), method) for file in files for method in methods or METHODS]
    measured_on = machine()
    with ExitStack() as stack:
        mine, other = Checkout(ROOT, WORKER), Checkout(base, WORKER)
        for one in (mine, other):
            stack.callback(one.close)
        compare(found, mine, other, repeats)
    console().print(measured_on)
    print_table("against", f"This checkout against {base}", COLUMNS, list(tabulate(found)))
    faults = list(faults_of(found, most))
    for fault in faults:
        console().print(fault, soft_wrap=True)
    return 1 if faults else 0


def compare(found: Sequence[Comparison], mine: Checkout, other: Checkout, repeats: int) -> None:
    """Plan each scene by both, which take turns in who is first, and enter what came of it."""
    for checkout in (mine, other):  # what is loaded and made once does not count
        for method in {comparison.method for comparison in found}:
            checkout.ask({"scene": found[0].scene, "method": method})
    with progress_bar("planning", len(found) * repeats) as advance:
        for one in found:
            for repeat in range(repeats):
                pair = (mine, other) if repeat % 2 == 0 else (other, mine)
                answers = {checkout: checkout.ask({"scene": one.scene, "method": one.method}) for checkout in pair}
                one.times.append(answers[mine]["planning_time"])
                one.others.append(answers[other]["planning_time"])
                one.result, one.other_result = (
                    (answers[checkout]["status"], answers[checkout]["certified"]) for checkout in (mine, other)
                )
                advance(1)


def tabulate(found: Sequence[Comparison]) -> Iterator[list[str]]:
    """Yield a line for each family and method, and one per method for all families."""
    for family in [*dict.fromkeys(one.family for one in found), ALL]:
        for method in dict.fromkeys(one.method for one in found):
            some = [one for one in found if one.method == method and family in (one.family, ALL)]
            low, median, high = np.quantile([one.ratio for one in some], [0.25, 0.5, 0.75])
            reached, before = (sum(r[0] == "reached" for r in results) for results in _results(some))
            certified, certified_before = (sum(r[1] for r in results) for results in _results(some))
            yield [
                family,
                method,
                str(len(some)),
                f"{median:.3f}",
                f"{low:.3f} to {high:.3f}",
                f"{sum(min(one.times) for one in some) / sum(min(one.others) for one in some):.3f}",
                f"{reached} and {before}" if reached != before else f"{reached} each",
                f"{certified} and {certified_before}" if certified != certified_before else f"{certified} each",
            ]


def _results(some: Sequence[Comparison]) -> tuple[list[tuple[str, bool]], list[tuple[str, bool]]]:
    return [one.result for one in some], [one.other_result for one in some]


def faults_of(found: Sequence[Comparison], most: float) -> Iterator[str]:
    """Say where results differ, and which methods take longer than is accepted."""
    for one in found:
        if not one.same:
            name = Path(one.scene).stem
            yield f"{name} by {one.method}: {_said(one.result)} here, {_said(one.other_result)} there."
    for method in dict.fromkeys(one.method for one in found):
        median = float(np.median([one.ratio for one in found if one.method == method]))
        if median > most:
            yield f"{method} takes {median:.3f} times as long as in the other checkout, more than {most:g}."


def _said(result: tuple[str, bool]) -> str:
    return f"{result[0]}, {'certified' if result[1] else 'not certified'}"


if __name__ == "__main__":
    run(main)
