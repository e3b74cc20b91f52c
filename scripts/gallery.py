"""Plan the scenes of the gallery by several seeds, and write the table of its robots into the documents."""

from __future__ import annotations

import statistics
import time
import warnings
from pathlib import Path

import click
import numpy as np

from humanoid_rail import Auto, Robot, Scene, Status, load_robot, load_scene, plan
from humanoid_rail._resources import resource
from humanoid_rail.cli.console import check_least, console, print_table, run
from humanoid_rail.collision.certifier import certify
from humanoid_rail.model.library import OWN, robots
from humanoid_rail.model.robot_file import read_robot_file
from humanoid_rail.progress import progress_bar

BOUND = 0.008
"""Every certificate has to have at least this bound, m."""
COLUMNS = ("robot", "hands", "joints", "package", "plans", "least bound, mm", "median processor time, s")


@click.command()
@click.option("--seeds", default=5, show_default=True, help="Plans of each scene, by seeds from 0 on.")
@click.option("--readme", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file to update.")
def main(seeds: int, readme: Path | None) -> int:
    """Plan the scenes of the gallery; exit code 1 if one is not solved, or if nothing is in the way in it."""
    check_least(1, seeds=seeds)
    names, rows, broken = [name for name in robots() if name not in OWN], [], []
    with progress_bar("planning", len(names)) as advance:
        for name in names:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of limits and links without bodies
                robot = load_robot(name)
            bounds, times, wrong = plans_of(name, robot, seeds)
            package = read_robot_file(resource("robots", f"{name}/robot.yaml")).package
            hands = ", ".join(robot.hand_names)
            bound, median = f"{1e3 * min(bounds, default=0.0):.1f}", f"{statistics.median(times):.2f}"
            rows.append([name, hands, str(robot.n), f"`{package}`", f"{len(bounds)} of {len(times)}", bound, median])
            broken += wrong
            advance(1)
    rows.sort(key=lambda row: -len(row[1].split(",")))  # those with two arms first
    print_table("gallery", f"{seeds} seeds for each of the two scenes", COLUMNS, rows, readme)
    for line in broken:
        console().print(line, soft_wrap=True)
    return 1 if broken else 0


def plans_of(name: str, robot: Robot, seeds: int) -> tuple[list[float], list[float], list[str]]:
    """Return the bounds of good plans of a robot's scenes (m), the times of all plans (s), and what is wrong."""
    bounds, times, wrong = [], [], []
    home = resource("scenes", "paper.yaml").parent / "robots"
    for file in sorted(home.glob(f"{name.replace('_', '-')}-*.json")):
        scene = load_scene(file)
        for seed in range(seeds):
            began = time.process_time()
            motion = plan(robot, scene, Auto(seed=seed, optimise=False))
            times.append(time.process_time() - began)
            proof = motion.certificate
            bound = 0.0 if proof is None or not proof.certified else proof.clearance_bound or 0.0
            if motion.status is not Status.REACHED or bound < BOUND:
                wrong.append(f"{scene.name}, seed {seed}: {motion.status}, bound {bound:.4f} m, {motion.reason}")
            elif not touches(robot, scene, motion.q[[0, -1]]):
                wrong.append(f"{scene.name}, seed {seed}: the straight motion to the end of the plan is free")
            else:
                bounds.append(bound)
    return bounds, times, wrong


def touches(robot: Robot, scene: Scene, ends: np.ndarray) -> bool:
    """Return whether the straight motion of the joints between two configurations (2, n) touches something."""
    return certify(robot, scene.obstacles, np.array([0.0, 1.0]), ends).contact is not None


if __name__ == "__main__":
    run(main)
