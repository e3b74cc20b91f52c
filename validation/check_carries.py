"""Carry a level tray through an aisle of boards, and measure tilt and clearance between samples. docs/constraints.md.

The robot in the size of a human takes a tray from one bay to another in its left hand, an axis of which points up all
the way. Each motion is planned by `auto` and retimed; its tilt is then measured every millisecond by Pinocchio alone,
and compared with the bound that the certificate states.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import NamedTuple

import click
import numpy as np
import pinocchio as pin

from humanoid_rail import Auto, AxisTask, Box, PointTask, Robot, Scene, Trajectory, load_robot, plan, retime
from humanoid_rail._arrays import Array
from humanoid_rail.cli.console import check_least, print_table, run
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.progress import progress_bar
from humanoid_rail.resampling import evaluate
from humanoid_rail.result import Status
from humanoid_rail.scene.keep import Keep, Upright
from humanoid_rail.scene.targets import Step

RACKS = (-1.1, 1.1)
"""Where the racks are along x, m; the rail is between them."""
BOARDS = (0.49, 0.94, 1.39, 1.84, 2.29)
"""Heights of their boards, m."""
WALLS = (-2.0, 0.0, 2.0, 4.0)
"""Where walls are between bays along y, m."""
HEIGHTS = (1.13, 1.58)
"""How high the tray is in a bay, m."""
AXES = ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0), (0.0, -1.0, 0.0))
"""The axes of the hand along which a tray may be mounted."""
STARTS = 60
"""A configuration in a bay is looked for from this many random ones."""
APART = 0.015
"""At its ends a motion keeps at least this from everything, m."""


class Carry(NamedTuple):
    """What became of a carry."""

    status: Status
    duration: float
    bound: float
    tilt: float


def racks() -> tuple[Box, ...]:
    """Return the boards and walls of the aisle."""
    middle, length = (WALLS[0] + WALLS[-1]) / 2, WALLS[-1] - WALLS[0]
    boards = [Box(center=(x, middle, z), size=(0.5, length, 0.02)) for x in RACKS for z in BOARDS]
    walls = [Box(center=(x, y, 1.05), size=(0.5, 0.03, 2.5)) for x in RACKS for y in WALLS]
    return (*boards, *walls)


def random_carry(robot: Robot, solver: InverseKinematics, rng: np.random.Generator) -> Scene:
    """Return a scene with a tray in one bay, to be carried to another."""
    while True:
        axis = AXES[int(rng.integers(len(AXES)))]
        ends = [(float(rng.choice(RACKS)), float(rng.uniform(-1.6, 3.6)), float(rng.choice(HEIGHTS))) for _ in range(2)]
        found = [_posture(robot, solver, place, axis, rng) for place in ends]
        if found[0] is not None and found[1] is not None:
            keep = (Keep(upright=Upright(hand="left", axis=axis)),)
            step = Step(left=ends[1], right=None, keep=keep)
            return Scene(name="carry", initial=tuple(found[0].tolist()), targets=step, obstacles=racks())


def _posture(
    robot: Robot,
    solver: InverseKinematics,
    place: tuple[float, float, float],
    axis: tuple[float, float, float],
    rng: np.random.Generator,
) -> Array | None:
    tasks = PointTask("left", place), AxisTask("left", axis)
    found = (solver.solve(rng.uniform(robot.lower, robot.upper), tasks, APART) for _ in range(STARTS))
    return next((posture.q for posture in found if posture.reached), None)


def largest_tilt(robot: Robot, trajectory: Trajectory, axis: tuple[float, float, float]) -> float:
    """Return how far an axis of the left hand gets from up, every millisecond, rad."""
    t = np.append(np.arange(0.0, trajectory.duration, 1e-3), trajectory.duration)
    q, _, _ = evaluate(trajectory.motion, t)
    data, frame, largest = robot.model.createData(), robot.model.getFrameId(robot.hands[0].frame), 0.0
    for row in q:
        pin.framesForwardKinematics(robot.model, data, robot.full_configuration(row))
        up = data.oMf[frame].rotation @ np.array(axis)
        largest = max(largest, float(np.arctan2(np.hypot(up[0], up[1]), up[2])))
    return largest


def carry(robot: Robot, scene: Scene) -> Carry:
    """Plan and retime a carry, and measure it."""
    planned = plan(robot, scene, Auto())
    if planned.status is not Status.REACHED:
        return Carry(planned.status, planned.duration, np.nan, np.nan)
    retimed = retime(planned, speed=0.5)
    (kept,) = scene.steps[0].keep
    assert kept.upright is not None
    assert kept.upright.axis is not None
    bounds, tilts = list[float](), list[float]()
    for trajectory in (planned, retimed):
        assert trajectory.certificate is not None
        bounds.append(trajectory.certificate.deviations[0].bound)
        tilts.append(largest_tilt(robot, trajectory, kept.upright.axis))
    if any(tilt > bound for tilt, bound in zip(tilts, bounds, strict=True)):
        raise AssertionError(f"a tilt of {max(tilts)} rad is beyond its bound")
    return Carry(retimed.status, retimed.duration, max(bounds), max(tilts))


@click.command()
@click.option("--count", type=int, default=20, show_default=True, help="The number of carries")
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("--readme", "page", type=click.Path(path_type=Path), help="A Markdown file to write the table to")
def main(count: int, seed: int, page: Path | None) -> None:
    """Carry a level tray through an aisle."""
    check_least(1, count=count)
    warnings.simplefilter("ignore")
    robot = load_robot("human-sized")
    solver, rng, found = InverseKinematics(robot, racks()), np.random.default_rng(seed), list[Carry]()
    with progress_bar("carrying", count) as advance:
        for _ in range(count):
            found.append(carry(robot, random_carry(robot, solver, rng)))
            advance(1)
    reached = [one for one in found if one.status is Status.REACHED]
    row = [
        str(count),
        str(len(reached)),
        f"{np.median([one.duration for one in reached]):.2f}",
        f"{np.rad2deg(max(one.bound for one in reached)):.4f}",
        f"{np.rad2deg(max(one.tilt for one in reached)):.4f}",
    ]
    columns = ("carries", "reached", "duration, median [s]", "bound of tilt [deg]", "measured [deg]")
    print_table("carries", "Level trays through an aisle", columns, [row], page)


if __name__ == "__main__":
    run(main)
