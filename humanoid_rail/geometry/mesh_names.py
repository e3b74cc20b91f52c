"""Where the mesh files are that URDFs name."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

from humanoid_rail.errors import InvalidInput

PACKAGES = "ROS_PACKAGE_PATH"
"""The environment variable with the folders of packages, or folders that hold them, of ROS 1."""
PREFIXES = "AMENT_PREFIX_PATH"
"""The environment variable with the folders in whose `share` the packages are, of ROS 2."""


def find_mesh(field: str, name: str, folder: Path | None = None) -> Path:
    """Return the file that a URDF names as a mesh.

    Args:
        field: What errors call the mesh.
        name: A path, a `file://` name, or a `package://` (or `model://`) name, whose package is looked for in the
            folders of `ROS_PACKAGE_PATH`, in those of `AMENT_PREFIX_PATH` and in `folder`.
        folder: The folder that relative paths begin at; the working directory if not given.

    Raises:
        InvalidInput: If there is no such file; the error names the places looked at.
    """
    places = list(_places(name, folder or Path.cwd()))
    try:
        return next(place for place in places if place.is_file())
    except (StopIteration, OSError, ValueError):  # not there, or no name that a file can have
        looked = ", ".join(map(str, places)) or "nowhere, as it is no name of a file"
        valid = f"a mesh file that is there; looked at: {looked}. {PACKAGES} can name further folders of packages"
        raise InvalidInput(field, name, valid) from None


def _places(name: str, folder: Path) -> Iterator[Path]:
    scheme, separator, rest = name.partition("://")
    match scheme if separator else "file":
        case "file":
            # What follows is a path or, in `file://`, a path with escapes.
            yield folder / (unquote(rest) if separator else name)
        case "package" | "model":
            package, _, path = rest.partition("/")
            if not package:
                yield Path("/") / path
                return
            for place in _listed(PACKAGES):
                yield place / package / path
                if place.name == package:
                    yield place / path
            yield from (prefix / "share" / package / path for prefix in _listed(PREFIXES))
            yield folder / package / path


def _listed(variable: str) -> list[Path]:
    return [Path(folder) for folder in os.environ.get(variable, "").split(os.pathsep) if folder]
