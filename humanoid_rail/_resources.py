"""Where the files that come with the package are, in a checkout and in an installed wheel."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def resource(folder: str, name: str) -> Path:
    """Return the path of a file of `robots/` or `scenes/`.

    A wheel holds these folders inside the package; a checkout, editable installs included, beside it.

    Raises:
        FileNotFoundError: If the installation is incomplete.
    """
    for root in (_PACKAGE, _PACKAGE.parent):
        path = root / folder / name
        if path.is_file():
            return path
    raise FileNotFoundError(f"{folder}/{name} is missing from this installation of humanoid_rail in {_PACKAGE}")
