"""Plan scenes with several targets so that motions stop at them, and so that they pass them; tabulate both."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np

from benchmarks.evaluation import family_of
from humanoid_rail import (
    Kinematics,
    Robot,
    Scene,
    Status,
    Trajectory,
    load_robot,
    load_robot_of_scene,
    load_scene,
    plan,
)
from humanoid_rail.cli.console import console, print_table, run
from humanoid_rail.progress import progress_bar
from humanoid_rail.scene.scene import start_of_scene

COLUMNS = (
    "scenes",
    "certified",
    "passed",
    "stopping [s]",
    "passing [s]",
    "ratio",
    "largest",
    "to the bound",
    "stopping [ms]",
    "passing [ms]",
)
SEVERAL = ("scenes/passing.yaml", "scenes/picks.yaml")
"""These scenes have several targets each."""


@dataclass(frozen=True)
class Row:
    """What became of one scene."""

    family: str
    certified: bool
    """Whether the motion reaches its targets and is certified."""
    passed: bool
    """Whether it passes all targets but the last."""
    stopping: float
    """How long the motion takes that stops, s."""
    passing: float
    """How long the one takes that passes, s."""
    bound: float
    """The lower bound of that, s."""
    stopping_time: float
    """Processor time of the plan that stops, s."""
    passing_time: float
    """Of the one that passes, s."""


def there_and_back(robot: Robot, scene: Scene) -> Scene:
    """Return a scene with the same targets, and after them the places where the hands are at the start."""
    hands = Kinematics(robot, ()).state(start_of_scene(robot, scene)).hands
    back = dict(zip(robot.hand_names, (tuple(map(float, hand)) for hand in hands), strict=True))
    return scene.model_copy(update={"targets": (*scene.steps, back)})


def measure(family: str, robot: Robot, scene: Scene) -> Row:
    """Plan in turn with stops and without them."""
    timed = list[tuple[Trajectory, float]]()
    for stop in (True, False):
        steps = tuple({**step.hands, "stop": stop} for step in scene.steps)
        began = time.process_time()
        timed.append((plan(robot, scene.model_copy(update={"targets": steps})), time.process_time() - began))
    (stopping, stopping_time), (passing, passing_time) = timed
    done = passing.provenance.optimisation
    return Row(
        family,
        passing.status is Status.REACHED and passing.certified,
        done is not None and done.passed == len(scene.steps) - 1,
        stopping.duration,
        passing.duration,
        passing.least_duration or np.inf,
        stopping_time,
        passing_time,
    )


def tabulate(rows: Sequence[Row]) -> Iterable[list[str]]:
    """Yield a line for each family. Medians, but for what is largest."""
    for family in dict.fromkeys(row.family for row in rows):
        some = [row for row in rows if row.family == family]
        ratios = [row.passing / row.stopping for row in some]
        yield [
            family,
            f"{sum(row.certified for row in some)}/{len(some)}",
            f"{sum(row.passed for row in some)}/{len(some)}",
            f"{np.median([row.stopping for row in some]):.2f}",
            f"{np.median([row.passing for row in some]):.2f}",
            f"{np.median(ratios):.2f}",
            f"{max(ratios):.2f}",
            f"{np.median([row.passing / row.bound for row in some]):.3f}",
            f"{1e3 * float(np.median([row.stopping_time for row in some])):.0f}",
            f"{1e3 * float(np.median([row.passing_time for row in some])):.0f}",
        ]


@click.command()
@click.argument("folder", default="scenes/dev", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--readme", type=click.Path(exists=True, path_type=Path), help="Markdown file whose table is replaced.")
def main(folder: Path, readme: Path | None) -> int:
    """Plan scenes with several targets, and those of FOLDER there and back, with stops and without. One thread.

    Exit code 1 if a motion is not certified, or longer without stops.
    """
    robot = load_robot()
    scenes = [(path, load_robot_of_scene(scene), scene) for path in SEVERAL for scene in (load_scene(path),)]
    single = [load_scene(path) for path in sorted(folder.glob("*.json"))]
    scenes += [(f"{family_of(scene)}, and back", robot, there_and_back(robot, scene)) for scene in single]
    measure(*scenes[0])  # what is imported and built once is not measured
    rows = []
    with progress_bar("planning", len(scenes)) as advance:
        for asked in scenes:
            rows.append(measure(*asked))
            advance(1)
    print_table(
        "passing", "Plans by auto that stop at targets, and that pass them", COLUMNS, list(tabulate(rows)), readme
    )
    sound = [row.certified and row.passing <= row.stopping for row in rows]
    if not all(sound):
        console().print(f"{sound.count(False)} of {len(sound)} do not hold.")
    return 0 if all(sound) else 1


if __name__ == "__main__":
    run(main)
