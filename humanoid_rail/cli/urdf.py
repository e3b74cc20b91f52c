"""The command that prints the robot."""

from __future__ import annotations

from collections.abc import Sequence

import click

from humanoid_rail._files import check_file, write_file
from humanoid_rail._resources import resource
from humanoid_rail.cli.console import Command
from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.humanoid import build_urdf, xacro_arguments


class _Urdf(Command):
    """Lists the arguments of the robot in its help."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Arguments of the robot, with their defaults"):
            defaults = {name: value.strip("${}") for name, value in xacro_arguments().items()}
            formatter.write_text(", ".join(f"{name}={value}" for name, value in defaults.items()))


@click.command(
    cls=_Urdf,
    examples={
        "humanoid-rail urdf -o robot.urdf": "The robot as the planner has it.",
        "humanoid-rail urdf link_radius=0.08 beta=1.0": "With thicker links, and the shoulders at another angle.",
        "humanoid-rail urdf --srdf -o robot.srdf": "The pairs of links that are not checked against each other.",
    },
)
@click.argument("settings", nargs=-1, metavar="[NAME=VALUE]...")
@click.option("--link-radius", metavar="R", help="The same as link_radius=R, m.")
@click.option("--srdf", is_flag=True, help="The SRDF instead.")
@click.option("--out", "-o", help="File to write instead of printing.")
def command(settings: Sequence[str], link_radius: str | None, srdf: bool, out: str | None) -> None:
    """Print the URDF of the robot, built with arguments of robots/humanoid_rail.urdf.xacro: m, rad, s and kg.

    docs/robot.md says how other tools load it.
    """
    if out is not None:
        check_file(out)
    pairs = [*settings, *([] if link_radius is None else [f"link_radius={link_radius}"])]
    if srdf and pairs:
        raise InvalidInput("srdf", pairs[0], "no arguments of the robot beside --srdf, which does not depend on them")
    if srdf:
        text = resource("robots", "humanoid_rail.srdf").read_text(encoding="utf-8")
    else:
        text = build_urdf(**numbers_by_name(pairs))
    if out is None:
        click.echo(text, nl=False)
        return
    write_file(out, text.encode())


def numbers_by_name(pairs: Sequence[str]) -> dict[str, float]:
    """Return the numbers in texts such as ``beta=1.0``, by their names.

    Raises:
        InvalidInput: If a text is not like that, or a name comes twice.
    """
    values: dict[str, float] = {}
    for pair in pairs:
        name, _, text = pair.partition("=")
        if name in values:
            raise InvalidInput(name, text, "given once")
        try:
            values[name] = float(text)
        except ValueError:
            raise InvalidInput("argument", pair, "NAME=VALUE with a number, such as link_radius=0.08") from None
    return values
