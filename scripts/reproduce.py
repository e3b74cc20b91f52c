"""Reproduce section 5 of the paper: figures 2 to 10, its claims, and the activation distances at which they hold."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import click
import numpy as np
from matplotlib.figure import Figure

from humanoid_rail import HumanoidRailError, Status, load_robot
from humanoid_rail._files import check_file, check_folder, write_files
from humanoid_rail.cli.console import console, print_table, run
from humanoid_rail.paper.cases import (
    CASES,
    OPTIONS,
    SweepPoint,
    bisect_claims,
    claims,
    paper_scene,
    plan_case,
    sweep_point,
)
from humanoid_rail.paper.figures import clearance_figure, manipulability_figure, motion_figure, sweep_figure

ROBOTS = {"links 5 cm thick": 0.05, "links without thickness": 0.0}
GRID = [round(0.1 * i, 1) for i in range(1, 31)]
CLAIM_COLUMNS = ("claim", "paper", "computed", "holds")
SAFE_COLUMNS = ("robot", "method", "clears both spheres", "least clearance", "reached and certified")
RANGE_COLUMNS = ("robot", "from", "breaks below", "to", "breaks above")


@click.command()
@click.option("--out", "folder", default="out/paper", show_default=True, help="Folder for the figures.")
@click.option("--sweep/--no-sweep", default=True, help="Sweep the activation distance (about a minute).")
@click.option("--readme", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file to update.")
def main(folder: str, sweep: bool, readme: Path | None) -> None:
    """Reproduce section 5 of the paper: figures 2 to 10, its claims, the range of the activation distance."""
    robot, scene = load_robot(), paper_scene()
    check_folder(folder)
    if readme is not None:
        check_file(readme)
    out = Path(folder)
    cases = {i: plan_case(robot, i) for i in CASES}
    for i, trajectory in cases.items():
        first = 3 * i - 1
        save(motion_figure(robot, scene, trajectory, f"Fig. {first}: case {i}"), out, f"figure_{first:02d}_motion")
        save(clearance_figure(trajectory, f"Fig. {first + 1}: case {i}"), out, f"figure_{first + 1:02d}_clearance")
        figure = manipulability_figure(trajectory, f"Fig. {first + 2}: case {i}")
        save(figure, out, f"figure_{first + 2:02d}_manipulability")

    rows = [[c.statement, c.paper, c.computed, "yes" if c.holds else "NO"] for c in claims(robot, cases)]
    print_table("claims", f"Section 5, activation distance {OPTIONS['epsilon']:g} m", CLAIM_COLUMNS, rows, readme)
    if sweep:
        sweeps = find_ranges()
        save(sweep_figure([(s.robot, s.points, (s.low, s.high)) for s in sweeps]), out, "sweep_activation_distance")
        ranges = [
            [s.robot, f"{s.low:.3f} m", ", ".join(s.below), f"{s.high:.3f} m", ", ".join(s.above)] for s in sweeps
        ]
        print_table("ranges", "Activation distances at which all claims hold at once", RANGE_COLUMNS, ranges, readme)
        print_table("safe", "Case 2 at every activation distance of the sweep", SAFE_COLUMNS, safe_rows(sweeps), readme)
    console().print(f"Figures: {out}", soft_wrap=True)


def safe_rows(sweeps: Sequence[Sweep]) -> list[list[str]]:
    """Return how often case 2 clears both spheres, by eq. 4.9 and by qp."""
    rows = []
    for sweep in sweeps:
        certified = sum(p.safe.certified and p.safe.status is Status.REACHED for p in sweep.points)
        least = {"eq. 4.9": [p.clearance[1] for p in sweep.points]}
        least["qp"] = [float(p.safe.clearance.min()) for p in sweep.points]
        proven = {"eq. 4.9": "", "qp": f"{certified} of {len(sweep.points)}"}
        rows += [
            [sweep.robot, method, f"{np.sum(np.array(m) >= 0)} of {len(m)}", f"{min(m):.3f} m", proven[method]]
            for method, m in least.items()
        ]
    return rows


class Sweep(NamedTuple):
    """The range of activation distances in which all claims hold for a robot, and what breaks beyond its ends."""

    robot: str
    points: list[SweepPoint]
    low: float
    below: tuple[str, ...]
    high: float
    above: tuple[str, ...]


def find_ranges() -> list[Sweep]:
    """Find for each robot the activation distances at which all claims hold at once.

    Raises:
        HumanoidRailError: If they are not one range inside the sweep.
    """
    sweeps = []
    with ProcessPoolExecutor(2) as pool:
        robots = {name: load_robot(link_radius=radius) for name, radius in ROBOTS.items()}
        swept = {
            name: pool.map(partial(sweep_point, robot, first=plan_case(robot, 1)), GRID)
            for name, robot in robots.items()
        }
        for name, results in swept.items():
            points = list(results)
            good = [i for i, point in enumerate(points) if not point.broken_claims]
            if not good or good != list(range(max(good[0], 1), min(good[-1] + 1, len(GRID) - 1))):
                raise HumanoidRailError(f"{name}: the claims hold at {np.take(GRID, good)}, not one range in the sweep")
            starts, beyond = [GRID[good[0]], GRID[good[-1]]], [GRID[good[0] - 1], GRID[good[-1] + 1]]
            (low, below), (high, above) = pool.map(partial(bisect_claims, robots[name]), starts, beyond)
            sweeps.append(Sweep(name, points, low, below.broken_claims, high, above.broken_claims))
    return sweeps


def save(figure: Figure, folder: Path, name: str) -> None:
    """Save a figure as PNG and SVG."""
    files = {}
    for suffix in ("png", "svg"):
        buffer = BytesIO()
        figure.savefig(buffer, format=suffix, dpi=130)
        files[f"{name}.{suffix}"] = buffer.getvalue()
    write_files(folder, files)


if __name__ == "__main__":
    run(main)
