"""Retime the plans of a folder of scenes and tabulate how long they take and how near the limits they come."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np

from benchmarks.evaluation import family_of
from benchmarks.motions import largest_rates
from humanoid_rail import (
    Auto,
    Robot,
    Status,
    Trajectory,
    load_robot,
    load_scene,
    paper_scene,
    plan,
    plan_case,
    retime,
)
from humanoid_rail.cli.console import console, print_table, run
from humanoid_rail.paper.cases import closed_form_duration
from humanoid_rail.paper.figures import timing_figure
from humanoid_rail.progress import progress_bar

JERK_LIMIT = 100.0
"""The plans are also retimed within this limit, m/s^3 and rad/s^3."""
EXCESS = 1e-6
"""An excess over a limit of 1 counts from this on."""
COLUMNS = (
    "family",
    "certified",
    "at rest",
    "velocity",
    "acceleration",
    "exponential [s]",
    "planned [s]",
    "retimed [s]",
    f"jerk {JERK_LIMIT:g} [s]",
    "retiming [ms]",
)


@dataclass(frozen=True)
class Row:
    """What became of one scene."""

    family: str
    certified: bool
    at_rest: bool
    velocity: float
    """The largest at 1 ms sampling, in units of the limit, as the next."""
    acceleration: float
    exponential: float
    """How long eq. 4.9 takes with K = 1 if there are no obstacles, s."""
    planned: float
    retimed: float
    limited_jerk: float
    seconds: float
    """What retiming took, the certificate included."""


def measure(robot: Robot, path: Path) -> Row:
    """Plan, retime and hold the result against the limits, sampled by SciPy."""
    scene = load_scene(path)
    planned = plan(robot, scene, Auto(optimise=False))
    started = time.perf_counter()
    motion = retime(planned, robot, scene)
    seconds = time.perf_counter() - started
    assert motion.timing is not None
    velocity, acceleration = largest_rates(robot, motion.t, motion.q, motion.timing.velocity)
    ends = np.vstack([motion.timing.velocity[[0, -1]], motion.timing.acceleration[[0, -1]]])
    slower = retime(planned, robot, scene, jerk_limit=JERK_LIMIT)
    return Row(
        family_of(scene),
        both_certified(motion, slower),
        not ends.any(),
        velocity,
        acceleration,
        closed_form_duration(robot, scene),
        planned.duration,
        motion.duration,
        slower.duration,
        seconds,
    )


def both_certified(*motions: Trajectory) -> bool:
    """Return whether motions reach their targets and are certified."""
    return all(motion.status is Status.REACHED and motion.certified for motion in motions)


def timings(robot: Robot) -> dict[str, Trajectory]:
    """Return case 3 of the paper in its own timing and retimed, by name."""
    scene, case = paper_scene(), plan_case(robot, 3)
    return {
        "eq. 4.9": case,
        "retimed": retime(case, robot, scene),
        f"jerk at most {JERK_LIMIT:g}": retime(case, robot, scene, jerk_limit=JERK_LIMIT),
    }


def tabulate(rows: Sequence[Row]) -> Iterable[list[str]]:
    """Yield a line for each family, and one for all."""
    families = list(dict.fromkeys(row.family for row in rows))
    for family in [*families, "all"]:
        some = [row for row in rows if family in (row.family, "all")]
        medians = [
            float(np.median([getattr(row, name) for row in some]))
            for name in ("exponential", "planned", "retimed", "limited_jerk")
        ]
        yield [
            family,
            f"{sum(row.certified for row in some)}/{len(some)}",
            f"{sum(row.at_rest for row in some)}/{len(some)}",
            *(f"{max(getattr(row, name) for row in some):.6f}" for name in ("velocity", "acceleration")),
            *(f"{median:.2f}" for median in medians),
            f"{1e3 * float(np.median([row.seconds for row in some])):.0f}",
        ]


@click.command()
@click.argument("folder", default="scenes/dev", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--figure", type=click.Path(dir_okay=False, path_type=Path), help="Picture to write of case 3's timings.")
@click.option("--readme", type=click.Path(exists=True, path_type=Path), help="Markdown file whose table is replaced.")
def main(folder: Path, figure: Path | None, readme: Path | None) -> int:
    """Retime every plan of FOLDER. Medians; largest in units of the limits, at 1 ms sampling.

    Exit code 1 if a motion is not certified, not at rest at its ends or beyond a limit.
    """
    robot = load_robot()
    paths = sorted(folder.glob("*.json"))
    with progress_bar("retiming", len(paths)) as advance:
        rows = []
        for path in paths:
            rows.append(measure(robot, path))
            advance(1)
    print_table("retiming", "Plans by auto, retimed", COLUMNS, list(tabulate(rows)), readme)
    if figure is not None:
        timing_figure(robot, timings(robot)).savefig(figure, dpi=130)
    sound = [row.certified and row.at_rest and max(row.velocity, row.acceleration) <= 1.0 + EXCESS for row in rows]
    if not all(sound):
        console().print(f"{sound.count(False)} of {len(sound)} do not hold.")
    return 0 if all(sound) else 1


if __name__ == "__main__":
    run(main)
