"""The command that proves a motion free of contact: a plan, or a file of another tool."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import click

from humanoid_rail.cli.console import Command
from humanoid_rail.cli.plan_folder_options import GROUP, reads_a_plan
from humanoid_rail.cli.report import beyond_limits, report_certificate
from humanoid_rail.cli.robot_options import RobotOptions, asked_robot
from humanoid_rail.errors import MISSING, InvalidInput
from humanoid_rail.io.motion_files import SUFFIXES, ForeignMotion, departure, limits_exceeded, read_motion
from humanoid_rail.io.plan_folder import read_plan
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.verification import verify
from humanoid_rail.progress import progress
from humanoid_rail.scene.scene import load_scene

SMALL = 1e-6
"""A controller that departs from what is proven by no more than this follows it, m and rad."""


@click.command(
    cls=Command,
    examples={
        "humanoid-rail verify out/case3": "Whether the plan in out/case3 touches anything.",
        "humanoid-rail verify out/case3 --scene changed.yaml": "Whether it would among other obstacles.",
        "humanoid-rail verify moveit.yaml --scene cell.yaml --robot arm.urdf": "A motion that another tool made.",
    },
    groups=GROUP,
)
@reads_a_plan
@click.option("--max-checks", type=int, help="How many distances may be measured  [two million]")
@click.option("--linear", is_flag=True, help="Of a file: straight between the samples, whatever velocities it has.")
def command(folder: str, scene_file: str | None, robot: RobotOptions, max_checks: int | None, linear: bool) -> int:
    """Prove that the plan in FOLDER, as `plan --out` wrote it, touches nothing, or find the first contact.

    Instead of a folder it can be a file of another tool, with --scene and perhaps --robot: CSV with a column for each
    joint, NPZ, or a JointTrajectory of ROS as JSON or YAML. docs/verify.md describes them.

    Only times and configurations are believed, and velocities if there are any. The proof covers all times, including
    between samples; it says nothing about whether the targets are reached. docs/safety.md says what it means.

    Exit code: 0 if it is certified, 1 if not, 2 after bad input, 130 if interrupted.
    """
    if Path(folder).suffix.lower() in SUFFIXES and not Path(folder).is_dir():
        return _verify_file(folder, scene_file, robot, max_checks, linear)
    if Path(folder).is_file():
        raise InvalidInput("file", folder, f"a folder of a plan, or a file that ends in {', '.join(SUFFIXES)}")
    if linear:
        raise InvalidInput("linear", linear, "only beside the file of another tool")
    plan = read_plan(folder, scene_file, **robot)
    with progress("proving"):
        certificate = verify(plan.robot, plan.scene, plan.trajectory, max_checks=max_checks)
    report_certificate(plan.scene.name, certificate, plan.trajectory.t, events=plan.trajectory.events)
    return 0 if certificate.certified else 1


def _verify_file(file: str, scene_file: str | None, asked: RobotOptions, max_checks: int | None, linear: bool) -> int:
    """Prove the motion in a file of another tool free of contact, and return the exit code."""
    if scene_file is None:
        raise InvalidInput("scene", MISSING, f"a scene with the obstacles, by --scene, as {file} has none")
    scene = load_scene(scene_file)
    robot = asked_robot(asked, scene)
    motion = read_motion(file, robot, linear=linear)
    with progress("proving"):
        certificate = verify(robot, scene, motion, max_checks=max_checks)
    report_certificate(scene.name, certificate, motion.t, _rows(robot, motion))
    return 0 if certificate.certified else 1


def _rows(robot: Robot, motion: ForeignMotion) -> Iterator[tuple[str, str]]:
    """Say how a file was read, and which limits its motion exceeds."""
    how = "straight" if motion.timing is None else "the cubic through positions and velocities"
    yield "between samples", how
    if (away := departure(motion)) > SMALL:
        yield "", f"a controller that uses the accelerations of the file departs from this by up to {away:.2g} (m, rad)"
    exceeded = limits_exceeded(robot, motion)
    if not exceeded:
        yield "limits", "kept: position, velocity and, of a cubic, acceleration"
    yield from beyond_limits(exceeded)
    if motion.ignored:
        yield "not read", ", ".join(motion.ignored)
