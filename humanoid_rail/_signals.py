"""Signals that ask this process to end."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

END_ASKED = threading.Event()
"""Set by handlers of signals before they raise: Python ignores what is raised while an object is taken apart, and what
runs without an end would go on."""


@contextmanager
def interruptible() -> Iterator[None]:
    """Let INT, TERM and HUP raise KeyboardInterrupt, INT also where a shell has it ignored, as for background jobs."""

    def interrupt(_signal: int, _frame: FrameType | None) -> None:
        END_ASKED.set()
        raise KeyboardInterrupt

    signals = {signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)}
    if threading.current_thread() is not threading.main_thread():
        signals = set()  # Python lets only the main thread handle them
    before = {s: signal.signal(s, interrupt) for s in signals}
    try:
        yield
    finally:
        END_ASKED.clear()
        for s, handler in before.items():
            signal.signal(s, handler)
