"""Simulate retimed plans in MuJoCo and tabulate how well the robot follows them and what it touches."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import click

from benchmarks.evaluation import family_of
from humanoid_rail import Robot, Scene, Trajectory, load_robot, load_scene, paper_scene, plan, plan_case, retime
from humanoid_rail.cli.console import print_table, run
from humanoid_rail.io.export import export
from humanoid_rail.io.mujoco.player import Tracking, track
from humanoid_rail.progress import progress_bar

CASE = "case 3 of the paper"
LARGEST_ERROR, LARGEST_FINAL_ERROR = 0.02, 0.01
"""The errors of a hand during the motion and at the end may be at most these, m."""
COLUMNS = (
    "motions",
    "simulated",
    "error of a hand [mm]",
    "at the end [mm]",
    "with contacts",
    "rail [N]",
    "joints [N m]",
)


@dataclass(frozen=True)
class Run:
    """One motion and what came of it."""

    family: str
    tracking: Tracking


def simulate(robot: Robot, scene: Scene, trajectory: Trajectory) -> Tracking:
    """Export a retimed motion and have MuJoCo drive the robot along it."""
    with TemporaryDirectory() as folder:
        export(retime(trajectory, robot, scene), robot, scene, "mujoco", folder)
        return track(folder)


def tabulate(runs: Sequence[Run]) -> Iterator[list[str]]:
    """Yield a line for each family, with the worst of its motions."""
    for family in dict.fromkeys(each.family for each in runs):
        some = [each.tracking for each in runs if each.family == family]
        forces = [tracking.largest_forces for tracking in some]
        yield [
            family,
            str(len(some)),
            f"{1e3 * max(tracking.largest_hand_error for tracking in some):.1f}",
            f"{1e3 * max(tracking.final_hand_error for tracking in some):.1f}",
            str(sum(bool(tracking.contacts) for tracking in some)),
            f"{max(force['rail'] for force in forces):.0f}",
            f"{max(value for force in forces for joint, value in force.items() if joint != 'rail'):.0f}",
        ]


@click.command()
@click.argument("folder", default="scenes/dev", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--readme", type=click.Path(exists=True, path_type=Path), help="Markdown file whose table is replaced.")
def main(folder: Path, readme: Path | None) -> int:
    """Simulate case 3 of the paper and the plans by auto for every scene of FOLDER. The worst of each family.

    Exit code 1 if a motion touches anything, or a hand is more than 2 cm off, or 1 cm at the end.
    """
    robot = load_robot()
    paths = sorted(folder.glob("*.json"))
    runs = [Run(CASE, simulate(robot, paper_scene(), plan_case(robot, 3)))]
    with progress_bar("simulating", len(paths)) as advance:
        for path in paths:
            scene = load_scene(path)
            runs.append(Run(family_of(scene), simulate(robot, scene, plan(robot, scene))))
            advance(1)
    print_table("tracking", "Retimed motions in MuJoCo", COLUMNS, list(tabulate(runs)), readme)
    return 0 if all(follows(each.tracking) for each in runs) else 1


def follows(tracking: Tracking) -> bool:
    """Return whether the robot follows as closely as it has to, and touches nothing."""
    close = tracking.largest_hand_error <= LARGEST_ERROR and tracking.final_hand_error <= LARGEST_FINAL_ERROR
    return close and not tracking.contacts


if __name__ == "__main__":
    run(main)
