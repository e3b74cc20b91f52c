"""Where the mesh files are that URDFs name."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from urllib.parse import unquote

from humanoid_rail.errors import InvalidInput

PACKAGES = "ROS_PACKAGE_PATH"
"""The environment variable with the folders of packages, or folders that hold them, of ROS 1."""
PREFIXES = "AMENT_PREFIX_PATH"
"""The environment variable with the folders in whose `share` the packages are, of ROS 2."""


def find_mesh(field: str, name: str, folder: Path | None = None, packages: Sequence[Path] = ()) -> Path:
    """Return the file that a URDF names as a mesh.

    Args:
        field: What errors call the mesh.
        name: A path, a `file://` name, or a `package://` (or `model://`) name. Its package is looked for as
            :func:`package_folders` says.
        folder: The folder of the URDF, at which relative paths begin; the working directory if not given.
        packages: Folders of packages, or folders that hold them.

    Raises:
        InvalidInput: If there is no such file; the error names the places looked at.
    """
    places = list(dict.fromkeys(_places(name, folder or Path.cwd(), packages)))
    try:
        return next(place for place in places if place.is_file())
    except (StopIteration, OSError, ValueError):  # not there, or no name that a file can have
        looked = ", ".join(map(str, places)) or "nowhere, as it is no name of a file"
        more = f"packages (--packages) or {PACKAGES} can name further folders of packages"
        valid = f"a mesh file that is there; looked at: {looked}. {more}"
        raise InvalidInput(field, name, valid) from None


def package_folders(package: str, folder: Path, packages: Sequence[Path] = ()) -> Iterator[Path]:
    """Yield where a package of ROS may be.

    Looked at are the folders in `packages` and in `ROS_PACKAGE_PATH`, each as the package itself or as one that holds
    it; `share` of those in `AMENT_PREFIX_PATH`; and the folder of the URDF with all that it is in.

    Args:
        package: Name of the package.
        folder: The folder of the URDF.
        packages: Folders of packages, or folders that hold them.
    """
    for place in (*packages, *_listed(PACKAGES)):
        yield place / package
        if place.name == package:
            yield place
    yield from (prefix / "share" / package for prefix in _listed(PREFIXES))
    yield folder / package
    for place in (folder.absolute(), *folder.absolute().parents):
        if place.name == package:
            yield place
        yield place / package


def _places(name: str, folder: Path, packages: Sequence[Path]) -> Iterator[Path]:
    scheme, separator, rest = name.partition("://")
    match scheme if separator else "file":
        case "file":
            # What follows is a path or, in `file://`, a path with escapes.
            yield folder / (unquote(rest) if separator else name)
        case "package" | "model":
            if rest.startswith("/"):
                yield Path(rest)
            package, _, path = rest.lstrip("/").partition("/")
            yield from (place / path for place in package_folders(package, folder, packages))


def _listed(variable: str) -> list[Path]:
    return [Path(folder) for folder in os.environ.get(variable, "").split(os.pathsep) if folder]
