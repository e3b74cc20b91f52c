"""The console command `humanoid-rail`: a module for each of its commands, imported when that is called."""

from __future__ import annotations

from importlib import import_module

import click

from humanoid_rail import __version__
from humanoid_rail.cli.console import run
from humanoid_rail.errors import InvalidInput, did_you_mean

COMMANDS = {
    "plan": "Plan a motion of all hands to their targets.",
    "play": "Play back a plan in the browser.",
    "compare": "Play back two plans at the same time.",
    "live": "Plan and follow while targets and obstacles are dragged.",
    "verify": "Prove a plan free of contact again.",
    "export": "Write a plan for other tools: CSV, NumPy, ROS 2, MuJoCo.",
    "robot": "Show a robot: its report, and a page to move it.",
    "urdf": "Print the URDF of the paper's robot, or its SRDF.",
}
"""What each command does, by its name and in the order of the help."""


class _Commands(click.Group):
    """Imports a command when it is called, because the list of commands needs none of the libraries they load."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command:
        if name not in COMMANDS:
            raise InvalidInput("command", name, f"one of {', '.join(COMMANDS)}{did_you_mean(name, COMMANDS)}")
        command: click.Command = import_module(f"{__name__}.{name}").command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.command(
    cls=_Commands,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 120},
    epilog="Exit code: 0 on success, 1 if targets are not reached or a motion is not certified, 2 after bad input.",
)
@click.version_option(__version__, package_name="humanoid_rail", message="humanoid_rail %(version)s")
@click.pass_context
def commands(ctx: click.Context) -> None:
    """Collision-free motion planning for robots with one arm or two; the default one has two, on a rail.

    Begin with `humanoid-rail plan scenes/picks.yaml --retime --out out/picks`, then `humanoid-rail play out/picks`.
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


def main() -> None:
    """Run the command with the arguments of this process, and exit."""
    run(commands)
