"""What is going on and how much of it is done, shown on stderr."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext


def progress(what: str) -> AbstractContextManager[object]:
    """Show that something is going on, on stderr if that is a terminal."""
    if not sys.stderr.isatty():
        return nullcontext()
    # Imported here: it is needed only where somebody looks.
    from rich.console import Console

    return Console(stderr=True).status(f"{what} ...")


@contextmanager
def progress_bar(what: str, total: int, shown: bool | None = None) -> Iterator[Callable[[int], None]]:
    """Show on stderr how much of something is done.

    Args:
        what: What is going on.
        total: How much there is to do.
        shown: Whether to show it; by default if stderr is a terminal.

    Yields:
        A function to be told how much more is done.
    """
    if not (sys.stderr.isatty() if shown is None else shown):
        yield lambda more: None
        return
    # Imported here: most who plan never see a bar.
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task(what, total=total)
        yield lambda more: bar.advance(task, more)
