"""What commands and scripts share: how they show help, print and fail."""

from __future__ import annotations

import os
import signal
import sys
import threading
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import FrameType, MappingProxyType
from typing import TYPE_CHECKING, Any

import click

from humanoid_rail._signals import END_ASKED
from humanoid_rail.cli.streams import checked_output, set_up_process
from humanoid_rail.errors import HumanoidRailError, InvalidInput

if TYPE_CHECKING:
    from rich.console import Console

MOST_FILES = 4
"""Of more files than this it is said how many there are, not what they are called."""
INDENT = 2
"""What an example does is indented by this, in characters."""
BAD_INPUT = 2
"""This is the exit code after bad input."""
INTERRUPTED = 130
"""This is the exit code after Ctrl-C."""
ENDED_BY_SIGNAL = 128
"""The exit code after another signal is its number and this, as shells have it."""


@cache
def console() -> Console:
    """Return where commands print to."""
    # Imported here: the help needs nothing of it.
    from rich.console import Console

    # Names of scenes and folders are printed as they are, whatever brackets or colons they hold.
    return Console(highlight=False, markup=False, emoji=False)


class Command(click.Command):
    """A command whose help has examples, and its options in groups."""

    def __init__(
        self,
        *arguments: Any,
        examples: Mapping[str, str],
        groups: Mapping[str, Sequence[str]] = MappingProxyType({}),
        **settings: Any,
    ) -> None:
        """Make a command.

        Args:
            *arguments: Those of :class:`click.Command`.
            examples: What a command line does, by command line.
            groups: Names of options by the heading of their group; the others have the last one, Options.
            **settings: Those of :class:`click.Command`.
        """
        super().__init__(*arguments, **settings)
        self.examples = examples
        self.groups = groups

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples, and the options group by group."""
        with formatter.section("Examples"):
            formatter.write_dl(list(self.examples.items()), col_max=INDENT)
        parameters = [p for p in self.get_params(ctx) if isinstance(p, click.Option)]
        options = {p.name: record for p in parameters if (record := p.get_help_record(ctx)) is not None}
        groups = {heading: [options.pop(name) for name in names] for heading, names in self.groups.items()}
        width = max(len(written) for records in [*groups.values(), options.values()] for written, _ in records)
        for heading, records in {**groups, "Options": list(options.values())}.items():
            # As wide in each group, so that the texts stand below each other.
            with formatter.section(heading):
                formatter.write_dl([(written.ljust(width), said) for written, said in records], col_max=width)


class _Warnings:
    """Says each warning for users once, in a line of stderr, without where in the package it is raised."""

    def __init__(self) -> None:
        self._said: set[str] = set()
        self._others = warnings.showwarning

    def show(self, message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
        if not issubclass(category, UserWarning):
            self._others(message, category, *where, **more)
            return
        text = " ".join(str(message).split())
        if text not in self._said:
            click.echo(f"Warning: {text}", err=True)
        self._said.add(text)


class _Terminated(BaseException):
    """A signal asks the process to end. It is no Exception, so that nobody takes it for an error of the work."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


@contextmanager
def _terminable() -> Iterator[None]:
    """Let the signals TERM and HUP raise, so that what is half done is cleared away. One that is ignored stays so."""

    def terminate(number: int, _frame: FrameType | None) -> None:
        END_ASKED.set()
        raise _Terminated(number)

    signals = [s for s in (signal.SIGTERM, signal.SIGHUP) if signal.getsignal(s) is signal.SIG_DFL]
    if threading.current_thread() is not threading.main_thread():
        signals = []  # Python lets only the main thread handle them
    for s in signals:
        signal.signal(s, terminate)
    try:
        yield
    finally:
        END_ASKED.clear()
        for s in signals:
            signal.signal(s, signal.SIG_DFL)


def run(command: click.Command, arguments: Sequence[str] | None = None) -> None:
    """Run a command and exit: bad input is one line of stderr and exit code 2, an interrupt exit code 130.

    The exit code after the signal TERM is 143, after HUP 129.

    Args:
        command: What to run.
        arguments: Its arguments; if not given those of this process, which is then the command's own.
    """
    if arguments is None:
        set_up_process()
        warnings.showwarning = _Warnings().show
    with checked_output():
        code = _code(command, arguments)
    sys.exit(code)


def _code(command: click.Command, arguments: Sequence[str] | None) -> int:
    """Return the exit code of a command that is run."""
    try:
        with _terminable():
            code = command.main(arguments, standalone_mode=False)
    except (HumanoidRailError, click.ClickException) as error:
        message = error.format_message() if isinstance(error, click.ClickException) else str(error)
        click.echo(f"error: {' '.join(message.split())}", err=True)
        return BAD_INPUT
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        return INTERRUPTED
    except _Terminated as end:
        click.echo("terminated", err=True)
        return ENDED_BY_SIGNAL + end.number
    return code if isinstance(code, int) else 0


def print_table(
    name: str, title: str, columns: Sequence[str], rows: Sequence[Sequence[str]], page: Path | None = None
) -> None:
    """Print a table, and write it between the marks of its name in a Markdown file, if one is given.

    Raises:
        InvalidInput: If the file does not have the marks.
    """
    from rich.table import Table

    table = Table(*columns, title=title, title_justify="left")
    for row in rows:
        table.add_row(*row)
    console().print(table)
    if page is not None:
        write_table(name, columns, rows, page)


def write_table(name: str, columns: Sequence[str], rows: Sequence[Sequence[str]], page: Path) -> None:
    """Write a table between the marks of its name in a Markdown file.

    Raises:
        InvalidInput: If the file does not have the marks.
    """
    # Imported here: the help needs nothing of it.
    from humanoid_rail._files import write_file

    lines = [columns, ["---"] * len(columns), *rows]
    markdown = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    begin, end = f"<!-- {name} -->", f"<!-- /{name} -->"
    before, begun, rest = page.read_text(encoding="utf-8").partition(begin)
    _, ended, after = rest.partition(end)
    if not (begun and ended):
        raise InvalidInput("page", str(page), f"a file with the marks {begin} and {end}")
    write_file(page, f"{before}{begin}\n{markdown}\n{end}{after}".encode())


def files_said(files: Sequence[Path], where: str = "") -> str:
    """Return files that were written in words: a few by their names, many as how many there are, and where."""
    return ", ".join(map(str, files)) if len(files) <= MOST_FILES else f"{len(files)} files{where}"


def check_least(least: int, **values: int) -> None:
    """Raise an InvalidInput if an option's value is smaller than the least that makes sense."""
    for name, value in values.items():
        if value < least:
            raise InvalidInput(name, value, f"{least} or more")


def has_display() -> bool:
    """Whether a browser window can be opened."""
    if sys.platform in ("darwin", "win32"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
