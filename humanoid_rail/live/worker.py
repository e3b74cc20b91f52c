"""A thread that does the latest of what it was asked for."""

from __future__ import annotations

import threading
from collections.abc import Callable


class Worker:
    """Does one thing after the other in a thread of its own; of those that wait only the latest is done."""

    def __init__(self, on_error: Callable[[Exception], None]) -> None:
        self._on_error = on_error
        self._changed = threading.Condition()
        self._next: Callable[[], None] | None = None
        self._ends = False
        self._thread = threading.Thread(target=self._run, name="humanoid_rail live worker", daemon=True)
        self._thread.start()

    def ask(self, work: Callable[[], None]) -> None:
        """Have something done as soon as what is at hand is done, instead of what was asked for before."""
        with self._changed:
            self._next = work
            self._changed.notify()

    def close(self) -> None:
        """End when what is at hand is done, and wait for that."""
        with self._changed:
            self._ends = True
            self._changed.notify()
        self._thread.join()

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._ends or self._next is not None)
                if self._ends:
                    return
                work, self._next = self._next, None
            assert work is not None
            try:
                work()
            except Exception as error:  # shown to the user, who may change what led to it
                self._on_error(error)
