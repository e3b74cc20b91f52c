"""Plan a folder of scenes with and without the optimisation; tabulate how long motions and planning take."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from scipy.interpolate import CubicHermiteSpline

from benchmarks.evaluation import family_of
from humanoid_rail import Auto, Robot, Scene, Status, Trajectory, load_robot, load_scene, plan, retime
from humanoid_rail.cli.console import console, print_table, run
from humanoid_rail.progress import progress_bar

MILLISECOND = 1e-3
EXCESS = 1e-6
"""An excess over a limit of 1 counts from this on."""
QUICK = Auto(optimise=False)
COLUMNS = (
    "family",
    "certified",
    "optimised",
    "limits",
    "retimed [s]",
    "least time [s]",
    "ratio",
    "largest",
    "to the bound",
    "quick [ms]",
    "optimised [ms]",
)


@dataclass(frozen=True)
class Row:
    """What became of one scene."""

    family: str
    certified: bool
    """Whether the motion reaches its targets, is certified and rests at both ends."""
    optimised: bool
    """Whether it is the optimised one, in all its segments."""
    limits: float
    """The largest velocity or acceleration at 1 ms sampling, in units of its limit."""
    retimed: float
    """The duration of the quick plan, retimed, s."""
    least: float
    """The duration of the motion of least time, s."""
    bound: float
    """How long each joint alone would take to the same configurations, s."""
    quick_time: float
    """Processor time of the quick plan, s."""
    optimised_time: float
    """The same with the optimisation, s."""


def measure(robot: Robot, scene: Scene) -> Row:
    """Plan in turn without and with the optimisation, and hold the result against the limits, sampled by SciPy."""
    (quick, quick_time), (motion, optimised_time) = (_timed(robot, scene, method) for method in (QUICK, Auto()))
    assert motion.timing is not None
    assert motion.least_duration is not None
    spline = CubicHermiteSpline(motion.t, motion.q, motion.timing.velocity)
    t = np.arange(0.0, motion.duration, MILLISECOND)
    shares = [
        float((abs(spline(t, order)) / limit).max())
        for order, limit in ((1, robot.velocity_limit), (2, robot.acceleration_limit))
    ]
    ends = np.vstack([motion.timing.velocity[[0, -1]], motion.timing.acceleration[[0, -1]]])
    done = motion.provenance.optimisation
    return Row(
        family_of(scene),
        motion.status is Status.REACHED and motion.certified and not ends.any(),
        done is not None and done.optimised == len(scene.steps),
        max(shares),
        retime(quick).duration,
        motion.duration,
        motion.least_duration,
        quick_time,
        optimised_time,
    )


def _timed(robot: Robot, scene: Scene, method: Auto) -> tuple[Trajectory, float]:
    """Return a plan and the processor time that it takes, in s."""
    began = time.process_time()
    found = plan(robot, scene, method)
    return found, time.process_time() - began


def tabulate(rows: Sequence[Row]) -> Iterable[list[str]]:
    """Yield a line for each family, and one for all. Medians, but for what is largest."""
    families = list(dict.fromkeys(row.family for row in rows))
    for family in [*families, "all"]:
        some = [row for row in rows if family in (row.family, "all")]
        ratios = [row.least / row.retimed for row in some]
        yield [
            family,
            f"{sum(row.certified for row in some)}/{len(some)}",
            f"{sum(row.optimised for row in some)}/{len(some)}",
            f"{max(row.limits for row in some):.6f}",
            f"{np.median([row.retimed for row in some]):.2f}",
            f"{np.median([row.least for row in some]):.2f}",
            f"{np.median(ratios):.2f}",
            f"{max(ratios):.2f}",
            f"{np.median([row.least / row.bound for row in some]):.3f}",
            f"{1e3 * float(np.median([row.quick_time for row in some])):.0f}",
            f"{1e3 * float(np.median([row.optimised_time for row in some])):.0f}",
        ]


@click.command()
@click.argument("folder", default="scenes/dev", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--readme", type=click.Path(exists=True, path_type=Path), help="Markdown file whose table is replaced.")
def main(folder: Path, readme: Path | None) -> int:
    """Plan every scene of FOLDER quickly, retime it, and plan it in the least time. One thread; medians.

    Exit code 1 if a motion is not certified, beyond a limit or longer than the retimed one.
    """
    robot = load_robot()
    scenes = [load_scene(path) for path in sorted(folder.glob("*.json"))]
    measure(robot, scenes[0])  # what is imported and built once is not measured
    with progress_bar("planning", len(scenes)) as advance:
        rows = []
        for scene in scenes:
            rows.append(measure(robot, scene))
            advance(1)
    print_table("least-time", "Plans by auto, retimed and in the least time", COLUMNS, list(tabulate(rows)), readme)
    sound = [row.certified and row.limits <= 1.0 + EXCESS and row.least <= row.retimed for row in rows]
    if not all(sound):
        console().print(f"{sound.count(False)} of {len(sound)} do not hold.")
    return 0 if all(sound) else 1


if __name__ == "__main__":
    run(main)
