"""Plan a folder of scenes and tabulate where the time goes, stage by stage. docs/auto.md says what the stages are."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any
from unittest.mock import patch

import click
import numpy as np

from benchmarks.evaluation import family_of
from humanoid_rail import Auto, load_robot, load_scene, plan
from humanoid_rail.cli.console import print_table, run
from humanoid_rail.progress import progress_bar

STAGES = {
    "goals": (
        ("humanoid_rail.search.path_search:PathSearch", "go_to_nearest"),
        ("humanoid_rail.search.path_search:PathSearch", "choose_goals"),
    ),
    "sampling": (("humanoid_rail.search.path_search:PathSearch", "sample"),),
    "safe velocity": (("humanoid_rail.search.auto", "_follow_safely"),),
    "smoothing": (("humanoid_rail.search.auto", "_smoothed"), ("humanoid_rail.planning.methods", "follow")),
    "least time": (("humanoid_rail.planning.methods", "with_least_time"),),
    "certificate": (("humanoid_rail.planning.planner", "certify_motion"),),
}
"""The functions of each stage. No stage is called by another; what is in none of them is setting up and checking."""
REPEATS = 3
"""Of so many plans of a scene the fastest counts."""


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--readme", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file to update.")
def main(folder: Path, readme: Path | None) -> int:
    """Plan the scenes of FOLDER by `auto`, optimised and quick: medians of processor time, family by family, in ms."""
    robot, found = load_robot(), defaultdict[tuple[str, str], list[dict[str, float]]](list)
    files = sorted(folder.glob("*.json"))
    with progress_bar("planning", len(files)) as advance:
        for file in files:
            scene = load_scene(file)
            for name, method in (("quick", Auto(optimise=False)), ("optimised", Auto())):
                plan(robot, scene, method)
                spent = [stages_of(partial(plan, robot, scene, method)) for _ in range(REPEATS)]
                found[family_of(scene), name].append(min(spent, key=lambda one: one["all"]))
            advance(1)
    columns = (*STAGES, "rest", "all")
    rows = [
        [family, name, *(f"{1e3 * float(np.median([one[stage] for one in spent])):.1f}" for stage in columns)]
        for (family, name), spent in found.items()
    ]
    print_table(
        "stages", "Where the time goes", ("family", "plan", *(f"{name} [ms]" for name in columns)), rows, readme
    )
    return 0


def stages_of(work: Callable[[], object]) -> dict[str, float]:
    """Return the processor time of each stage of some work, of all of it, and of the rest, s."""
    spent = dict.fromkeys(STAGES, 0.0)
    with ExitStack() as watched:
        for stage, functions in STAGES.items():
            for place, name in functions:
                watched.enter_context(_watched(place, name, stage, spent))
        began = time.thread_time()
        work()
        everything = time.thread_time() - began
    return {**spent, "rest": everything - sum(spent.values()), "all": everything}


@contextmanager
def _watched(place: str, name: str, stage: str, spent: dict[str, float]) -> Iterator[None]:
    """Add what a function of a module, or a method of a class in it, takes to what a stage has spent."""
    module, _, owner = place.partition(":")
    where: Any = import_module(module)
    where = getattr(where, owner) if owner else where
    function = getattr(where, name)

    def timed(*arguments: Any, **options: Any) -> Any:
        began = time.thread_time()
        try:
            return function(*arguments, **options)
        finally:
            spent[stage] += time.thread_time() - began

    with patch.object(where, name, timed):
        yield


if __name__ == "__main__":
    run(main)
