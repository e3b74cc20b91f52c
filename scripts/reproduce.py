"""Reproduce section 5 of the paper: figures 2 to 10, its claims, and the activation distances at which they hold."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import click
import numpy as np
from matplotlib.figure import Figure
from rich.table import Table

from humanoid_rail import load_robot
from humanoid_rail.cli import console, run
from humanoid_rail.figures import clearance_figure, manipulability_figure, motion_figure, sweep_figure
from humanoid_rail.paper import CASES, SETTINGS, SweepPoint, bisect_claims, claims, paper_scene, plan_case, sweep_point

ROBOTS = {"links 5 cm thick": 0.05, "links without thickness": 0.0}
GRID = np.round(np.arange(0.1, 3.01, 0.1), 3)


@click.command()
@click.option(
    "--out", type=click.Path(file_okay=False, path_type=Path), default="out/paper", help="Folder for the figures."
)
@click.option("--sweep/--no-sweep", default=True, help="Sweep the activation distance (half a minute).")
def main(out: Path, sweep: bool) -> None:
    """Reproduce section 5 of the paper: figures 2 to 10, its claims, the range of the activation distance."""
    robot, scene = load_robot(), paper_scene()
    out.mkdir(parents=True, exist_ok=True)
    cases = {i: plan_case(robot, i) for i in CASES}
    for i, trajectory in cases.items():
        first = 3 * i - 1
        save(motion_figure(robot, scene, trajectory, f"Fig. {first}: case {i}"), out, f"figure_{first:02d}_motion")
        save(clearance_figure(trajectory, f"Fig. {first + 1}: case {i}"), out, f"figure_{first + 1:02d}_clearance")
        figure = manipulability_figure(trajectory, f"Fig. {first + 2}: case {i}")
        save(figure, out, f"figure_{first + 2:02d}_manipulability")

    table = Table(title=f"Section 5, activation distance {SETTINGS['epsilon']:g} m", title_justify="left")
    for column in ("claim", "paper", "computed", "holds"):
        table.add_column(column)
    for claim in claims(robot, cases):
        table.add_row(claim.statement, claim.paper, claim.computed, "yes" if claim.holds else "NO")
    console.print(table)
    if sweep:
        print_sweep(out)
    console.print(f"Figures: {out}", soft_wrap=True)


def print_sweep(out: Path) -> None:
    """Find, print and draw the activation distances at which all claims hold at once."""
    table = Table(title="Activation distances at which all claims hold at once", title_justify="left")
    for column in ("robot", "from", "below it", "to", "above it"):
        table.add_column(column)
    sweeps = []
    with ProcessPoolExecutor(2) as pool:
        swept = {name: pool.map(partial(point_of, radius), GRID) for name, radius in ROBOTS.items()}
        for name, results in swept.items():
            points = list(results)
            good = [i for i, point in enumerate(points) if not point.broken_claims]
            if not good:
                table.add_row(name, "nowhere", "", "", "")
                continue
            if good != list(range(good[0], good[-1] + 1)) or good[0] == 0 or good[-1] == len(GRID) - 1:
                raise RuntimeError(f"the claims hold at {GRID[good]}: not one range inside the sweep")
            ends = [(GRID[good[0]], GRID[good[0] - 1]), (GRID[good[-1]], GRID[good[-1] + 1])]
            (low, below), (high, above) = pool.map(end_of, [ROBOTS[name]] * 2, *zip(*ends, strict=True))
            table.add_row(
                name, f"{low:.3f} m", ", ".join(below.broken_claims), f"{high:.3f} m", ", ".join(above.broken_claims)
            )
            sweeps.append((name, points, (low, high)))
    console.print(table)
    if sweeps:
        save(sweep_figure(sweeps), out, "sweep_activation_distance")


def point_of(radius: float, epsilon: float) -> SweepPoint:
    """Return the three cases at an activation distance, for links of a radius."""
    return sweep_point(load_robot(link_radius=radius), float(epsilon))


def end_of(radius: float, good: float, bad: float) -> tuple[float, SweepPoint]:
    """Return an end of the range and what breaks beyond it, for links of a radius."""
    return bisect_claims(load_robot(link_radius=radius), float(good), float(bad))


def save(figure: Figure, folder: Path, name: str) -> None:
    """Save a figure as PNG and SVG."""
    for suffix in ("png", "svg"):
        figure.savefig(folder / f"{name}.{suffix}", dpi=130)


if __name__ == "__main__":
    run(main)
