"""How this process's Python and the console command are called, for messages that say what to do next."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from shlex import quote

_COMMAND = "humanoid-rail"


def python() -> str:
    """Return how to call this Python: from the folder at hand where it is in there."""
    return quote(_from_here(Path(sys.executable)))


def command() -> str:
    """Return how to call the console command: by its name only where the shell finds this one by it."""
    own = Path(sys.executable).parent / _COMMAND
    found = shutil.which(_COMMAND)
    if found is not None and own.exists() and own.samefile(found):
        return _COMMAND
    return quote(_from_here(own)) if own.is_file() else f"{python()} -m humanoid_rail"


def pip_install(what: str) -> str:
    """Return the command that installs a package or an extra; nothing is compiled for an extra."""
    return f"{python()} -m pip install {quote(what)}"


def _from_here(file: Path) -> str:
    try:
        return str(file.relative_to(Path.cwd()))
    except (ValueError, OSError):  # OSError: the folder at hand is gone
        return str(file)
