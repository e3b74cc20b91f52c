"""The command that proves a plan free of contact."""

from __future__ import annotations

import click

from humanoid_rail.cli.console import Command
from humanoid_rail.cli.plan_folder_options import GROUP, reads_a_plan
from humanoid_rail.cli.report import report_certificate
from humanoid_rail.cli.robot_options import RobotOptions
from humanoid_rail.io.plan_folder import read_plan
from humanoid_rail.planning.verification import verify
from humanoid_rail.progress import progress


@click.command(
    cls=Command,
    examples={
        "humanoid-rail verify out/case3": "Whether the plan in out/case3 touches anything.",
        "humanoid-rail verify out/case3 --scene changed.yaml": "Whether it would among other obstacles.",
    },
    groups=GROUP,
)
@reads_a_plan
@click.option("--max-checks", type=int, help="How many distances may be measured  [two million]")
def command(folder: str, scene_file: str | None, robot: RobotOptions, max_checks: int | None) -> int:
    """Prove again that the plan in FOLDER, as `plan --out` wrote it, touches nothing, or find the first contact.

    Only its times and configurations are believed, and its velocities if it was retimed. The proof covers all times,
    including between samples; it says nothing about joint limits or whether the targets are reached. docs/safety.md
    says what it means.

    Exit code: 0 if it is certified, 1 if not, 2 after bad input, 130 if interrupted.
    """
    plan = read_plan(folder, scene_file, **robot)
    with progress("proving"):
        certificate = verify(plan.robot, plan.scene, plan.trajectory, max_checks=max_checks)
    report_certificate(plan.scene.name, certificate, plan.trajectory.duration)
    return 0 if certificate.certified else 1
