"""The command that writes a plan for other tools."""

from __future__ import annotations

from collections.abc import Iterator

import click

from humanoid_rail.cli.console import Command, console, files_said
from humanoid_rail.cli.plan_folder_options import GROUP, reads_a_plan
from humanoid_rail.cli.report import NO_ENGINE, why_not_certified
from humanoid_rail.cli.robot_options import RobotOptions
from humanoid_rail.errors import EngineMissing, checked_number
from humanoid_rail.io.export import FORMATS, check_out, export
from humanoid_rail.io.plan_folder import Plan, read_plan
from humanoid_rail.planning.verification import verify
from humanoid_rail.resampling import is_evenly_spaced
from humanoid_rail.result import Status

UNEVEN = (
    "the samples are not evenly spaced: those of the plan are kept between the ones asked for, as without them it "
    "would be another motion. A rate that is a multiple of the plan's gives even ones; so does retime(dt=...)."
)
"""This is said of a rate that does not go with the samples of a plan."""


class _Export(Command):
    """Lists the formats in its help."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Formats"):
            formatter.write_dl([(name, format.description) for name, format in FORMATS.items()])


@click.command(
    cls=_Export,
    examples={
        "humanoid-rail export out/case3 --format csv -o case3.csv": "A table of times, joints and hands.",
        "humanoid-rail export out/case3 --format csv --rate 1000 -o case3.csv": "The same motion at 1 kHz.",
        "humanoid-rail export out/case3 --format ros-yaml -o case3.yaml": "A message for ROS 2.",
        "humanoid-rail export out/picks --format mujoco -o picks": "A folder for MuJoCo, of a motion that was retimed.",
    },
    groups=GROUP,
)
@reads_a_plan
@click.option("--format", required=True, metavar="FORMAT", help="One of those below.")
@click.option("--out", "-o", required=True, metavar="PATH", help="File to write; for mujoco a folder.")
@click.option("--rate", type=float, metavar="HZ", help="Samples a second, of the same motion  [as it was planned]")
@click.option(
    "--passive/--no-passive", default=False, help="Passive joints too, in the formats of ROS.", show_default=True
)
def command(
    folder: str,
    scene_file: str | None,
    robot: RobotOptions,
    format: str,
    out: str,
    rate: float | None,
    passive: bool,
) -> None:
    """Write the plan in FOLDER, as `plan --out` wrote it, in a format of other tools."""
    check_out(format, out)
    if rate is not None:
        checked_number("rate", rate, above=0.0)
    plan = read_plan(folder, scene_file, **robot)
    motion = plan.trajectory if rate is None else plan.trajectory.resample(1.0 / rate)
    written = export(motion, plan.robot, plan.scene, format, out, passive=passive)
    if rate is not None and not is_evenly_spaced(motion.t):
        console().print(f"Warning: {UNEVEN}", soft_wrap=True)
    for fault in _faults(plan):
        console().print(f"Warning: {fault}", soft_wrap=True)
    console().print(f"Written: {files_said(written, f' in {out}')}", soft_wrap=True)


def _faults(plan: Plan) -> Iterator[str]:
    """Say why a robot should not run a motion."""
    trajectory = plan.trajectory
    try:
        certificate = verify(plan.robot, plan.scene, trajectory)
    except EngineMissing:
        yield f"the motion is not certified: {NO_ENGINE}."
    else:
        if not certificate.certified:
            yield f"the motion is not certified: {why_not_certified(certificate)}."
    if trajectory.violations:
        joints = ", ".join(dict.fromkeys(violation.joint for violation in trajectory.violations))
        yield f"the motion exceeds limits of {joints}."
    if trajectory.status is not Status.REACHED:
        yield f"{trajectory.status}, {trajectory.reason}."
    if trajectory.timing is None:
        yield "the motion starts at full speed; plan with --retime for a drive."
