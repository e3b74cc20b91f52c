"""Ends a process with the one that started it, even if that is killed."""

from __future__ import annotations

import os
import threading
import time

INTERVAL = 0.2
"""A process looks this often whether its parent is still there, s."""


def end_with_parent(parent: int) -> None:
    """End this process as soon as it is no longer a child of a process: that has ended, however it did.

    A thread watches, so it works on all systems that have parents, and while the main thread computes without Python's
    lock.

    Args:
        parent: The number of the process that started this one.
    """

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(INTERVAL)
        os._exit(1)

    threading.Thread(target=watch, name="watch over the parent", daemon=True).start()
