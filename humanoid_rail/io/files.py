"""Writing files that appear when they are whole."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

from humanoid_rail.errors import InvalidInput


def write_files(folder: str | Path, files: Mapping[str, bytes]) -> tuple[Path, ...]:
    """Write files to a folder, which is made if need be. Every file is written before the first appears.

    Args:
        folder: Where to.
        files: What is in the files, by name; files of these names are replaced.

    Returns:
        The files written.

    Raises:
        InvalidInput: If the folder cannot be written to.
    """
    check_folder(folder)
    folder = Path(folder)
    made = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # Replaced when all of them are written.
        with TemporaryDirectory(prefix=".unfinished-", dir=folder) as unfinished:
            for name, content in files.items():
                (Path(unfinished) / name).write_bytes(content)
            for name in files:
                (Path(unfinished) / name).replace(folder / name)
    except BaseException as error:  # an interrupt among them
        if made and folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()
        if not isinstance(error, OSError):
            raise
        raise InvalidInput("out", str(folder), f"a folder that can be written to ({error})") from error
    return tuple(folder / name for name in files)


def check_folder(folder: str | Path) -> None:
    """Check, without making it, that a folder can be written to or made.

    Raises:
        InvalidInput: If it cannot.
    """
    path = Path(folder)
    try:
        above = next(p for p in (path, *path.resolve().parents) if p.exists())
    except OSError as error:
        raise InvalidInput("out", str(folder), f"a folder that can be written to ({error})") from error
    if not str(folder) or not above.is_dir() or not os.access(above, os.W_OK | os.X_OK):
        raise InvalidInput("out", str(folder), f"a folder that can be written to; {above} is none")
