"""What is kept in the user's cache folder, such as convex bodies: each file is whole or not there."""

from __future__ import annotations

import os
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from tempfile import NamedTemporaryFile

import numpy as np

from humanoid_rail._arrays import Array


def cache_folder(kind: str) -> Path:
    """Return the folder that results of a kind are kept in, below `$XDG_CACHE_HOME`, else `~/.cache`."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "humanoid_rail" / kind


def read_bodies(file: Path) -> list[Array]:
    """Return the vertices (k, 3) of bodies that were kept in a file.

    Raises:
        Exception: Of any kind, if it is not there or damaged.
    """
    with np.load(file, allow_pickle=False) as arrays:
        bodies = [arrays[f"arr_{i}"] for i in range(len(arrays.files))]
    if not bodies or not all(b.ndim == 2 and b.shape[1] == 3 and np.isfinite(b).all() for b in bodies):
        raise ValueError("no pieces")
    return bodies


def keep_bodies(bodies: Sequence[Array], file: Path) -> None:
    """Write bodies to a file that appears when it is whole."""
    content = BytesIO()
    np.savez(content, *bodies)
    write_whole(file, content.getvalue())


def write_whole(file: Path, content: bytes) -> None:
    """Write a file that appears when it is whole, and its folder.

    Raises:
        OSError: If it cannot be written.
    """
    file.parent.mkdir(parents=True, exist_ok=True)
    with NamedTemporaryFile(dir=file.parent, suffix=".unfinished", delete=False) as unfinished:
        try:
            unfinished.write(content)
            unfinished.close()
            Path(unfinished.name).replace(file)
        finally:
            Path(unfinished.name).unlink(missing_ok=True)
