"""Writing files that appear when they are whole."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile

from humanoid_rail.errors import InvalidInput

_PROBE = bytes(4096)
"""This much is written to see whether a disk takes anything."""


def write_files(folder: str | Path, files: Mapping[str, bytes]) -> tuple[Path, ...]:
    """Write files to a folder, which is made if need be. Every file is written before the first appears.

    Args:
        folder: Where to.
        files: What is in the files, by name, with slashes for folders in it; files of these names are replaced.

    Returns:
        The files written.

    Raises:
        InvalidInput: If the folder cannot be written to.
    """
    check_folder(folder, files)
    folder = Path(folder)
    made = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # Replaced when all of them are written.
        with TemporaryDirectory(prefix=".unfinished-", dir=folder) as unfinished:
            for name, content in files.items():
                (Path(unfinished) / name).parent.mkdir(parents=True, exist_ok=True)
                (Path(unfinished) / name).write_bytes(content)
            for name in files:
                inner = (folder / name).parent
                made = [*(path for path in (inner, *inner.parents) if not path.exists()), *made]
                inner.mkdir(parents=True, exist_ok=True)
                (Path(unfinished) / name).replace(folder / name)
    except BaseException as error:  # an interrupt leaves nothing behind either
        _remove_empty(made)
        if isinstance(error, OSError):
            raise _unwritable(folder, f"a folder that can be written to ({error})") from error
        raise
    return tuple(folder / name for name in files)


def write_file(path: str | Path, content: bytes) -> Path:
    """Write a file that appears when it is whole, and return its path; folders are made if need be.

    A device or a pipe is written to as it is.

    Raises:
        InvalidInput: If it cannot be written.
    """
    check_file(path)
    path = Path(path)
    if path.exists() and not path.is_file():
        try:
            path.write_bytes(content)
        except OSError as error:
            raise _unwritable(path, f"a file that can be written to ({error})") from error
        return path
    target = path.resolve()  # a link stays a link
    write_files(target.parent, {target.name: content})
    return path


def check_file(path: str | Path) -> None:
    """Check, without making it, that a file can be written.

    Raises:
        InvalidInput: If it cannot.
    """
    try:
        target = Path(path).resolve()
        is_folder, is_special = target.is_dir(), target.exists() and not target.is_file()
    except (OSError, ValueError, RuntimeError) as error:  # a name too long, a NUL, links in a circle
        raise _unwritable(path, f"the name of a file to write ({error})") from error
    if not Path(path).name or is_folder:
        raise _unwritable(path, "the name of a file to write, not of a folder")
    if is_special:
        return
    try:
        check_folder(target.parent, [target.name])
    except InvalidInput as error:
        raise _unwritable(path, error.valid) from error


def check_folder(folder: str | Path, names: Iterable[str] = ()) -> None:
    """Check, without making it, that a folder can be made or written to: something is written and removed again.

    Args:
        folder: The folder.
        names: The files to be written there.

    Raises:
        InvalidInput: If it cannot, or a folder is where a file is to be.
    """
    path = Path(folder)
    try:
        above = next(p for p in (path, *path.resolve().parents) if p.exists())
        in_the_way = path if path.is_symlink() and not path.exists() else above
        is_folder = bool(str(folder)) and in_the_way.is_dir()
        taken = [name for name in names if (path / name).is_dir()]
        if is_folder and not taken:
            with TemporaryFile(dir=above) as probe:
                probe.write(_PROBE)
    except (OSError, ValueError, RuntimeError) as error:  # also for a NUL, and links in a circle
        raise _unwritable(folder, f"a folder that can be written to ({error})") from error
    if not is_folder:
        raise _unwritable(folder, f"a folder that can be written to; {in_the_way} is none")
    if taken:
        raise _unwritable(folder, f"a folder in which {taken[0]} is a file or missing; it is a folder there")


def _remove_empty(folders: Iterable[Path]) -> None:
    """Remove folders, the deepest first, as far as they are there and empty."""
    for folder in folders:
        if folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()


def _unwritable(path: str | Path, valid: str) -> InvalidInput:
    return InvalidInput("out", str(path), valid)
