"""What the scripts share: how they print and fail."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext

import click
from rich.console import Console

from humanoid_rail.errors import HumanoidRailError

# Names of scenes and folders are printed as they are, whatever brackets or colons they hold.
console = Console(highlight=False, markup=False, emoji=False)

BAD_INPUT = 2
"""Exit code after bad input."""


def run(command: click.Command, arguments: Sequence[str] | None = None) -> None:
    """Run a command and exit: bad input is one line of stderr and exit code 2, an interrupt exit code 130.

    Args:
        command: What to run.
        arguments: Its arguments; those of this process if not given.
    """
    try:
        code = command.main(arguments, standalone_mode=False)
    except (HumanoidRailError, click.ClickException) as error:
        message = error.format_message() if isinstance(error, click.ClickException) else str(error)
        click.echo(f"error: {' '.join(message.split())}", err=True)
        code = BAD_INPUT
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        code = 130
    sys.exit(code if isinstance(code, int) else 0)


def progress(what: str) -> AbstractContextManager[object]:
    """Show that something is going on, on stderr if that is a terminal."""
    return Console(stderr=True).status(f"{what} ...") if sys.stderr.isatty() else nullcontext()


def has_display() -> bool:
    """Whether a browser window can be opened."""
    if sys.platform in ("darwin", "win32"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
