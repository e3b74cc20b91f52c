"""What is going on and how much of it is done, shown on stderr."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Timer
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress, ProgressColumn

PATIENCE = 1.0
"""What takes less time than this shows nothing, s."""


@contextmanager
def progress(what: str) -> Iterator[None]:
    """Show that something is going on and for how long, on stderr if that is a terminal, once it takes `PATIENCE`.

    What is done has to let other threads run, as the native engine does.
    """
    if not sys.stderr.isatty():
        yield
        return
    # Imported here: it is needed only where somebody looks.
    from rich.progress import SpinnerColumn, TextColumn, TimeElapsedColumn

    bar = _shown(SpinnerColumn(), TextColumn("{task.description} ..."), TimeElapsedColumn(), transient=True)
    bar.add_task(what, total=None)
    timer = Timer(PATIENCE, bar.start)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        timer.join()  # it may be starting the display right now
        if bar.live.is_started:
            bar.stop()


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
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn

    with _shown(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()) as bar:
        task = bar.add_task(what, total=total)
        yield lambda more: bar.advance(task, more)


def _shown(*columns: ProgressColumn, transient: bool = False) -> Progress:
    """Return a display on stderr. It leaves `sys.stdout` and `sys.stderr` alone, which belong to all threads."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    return Progress(*columns, console=console, transient=transient, redirect_stdout=False, redirect_stderr=False)
