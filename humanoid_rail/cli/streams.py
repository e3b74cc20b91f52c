"""The streams of a console command: what is done where they are closed, full, or cannot hold a character."""

from __future__ import annotations

import errno
import io
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

UNWRITTEN = 1
"""This is the exit code where stdout could not be written to."""

_WRITING = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EBADF}
"""These errors come of writing, and those of writing files are raised as `InvalidInput`: only stdout is left."""


def set_up_process() -> None:
    """Have this process end as Unix tools do when nobody reads its output, and see to streams that are closed."""
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    # A file that is opened later would get the number of a closed stream, and whatever a library prints.
    while (number := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(number)
    if sys.stderr is None:
        sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115
    if sys.stdout is None:
        sys.exit(_unwritten("it is closed"))


@contextmanager
def checked_output() -> Iterator[None]:
    """Write what stdout cannot hold with backslashes, and exit with one line on stderr if it cannot be written to."""
    errors = {stream: stream.errors for stream in (sys.stdout, sys.stderr) if isinstance(stream, io.TextIOWrapper)}
    for stream in errors:
        stream.reconfigure(errors="backslashreplace")
    try:
        yield
        sys.stdout.flush()
    except OSError as error:
        if error.errno not in _WRITING:
            raise
        # What is left in the buffer would be an error again when Python exits.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(_unwritten(str(error)))
    finally:
        for stream, before in errors.items():
            stream.reconfigure(errors=before)


def _unwritten(why: str) -> int:
    """Say that stdout could not be written to, and return the exit code."""
    print(f"error: stdout cannot be written to: {why}", file=sys.stderr)
    return UNWRITTEN
