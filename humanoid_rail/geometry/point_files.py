"""Files of points and of heights, NPZ and PLY."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from humanoid_rail._arrays import Array, frozen

LARGEST = 100.0
"""What is larger than this, in m, is taken to be in another unit."""


class Grid(NamedTuple):
    """Heights over a regular grid in the xy plane."""

    heights: Array
    """(ny, nx), m: those of a row have the same y, and x grows along it."""
    spacing: tuple[float, float]
    """How far columns, and rows, are from each other, m."""
    origin: tuple[float, float]
    """Where the first height of the first row is: x, y, m."""

    @property
    def x(self) -> Array:
        """Where the columns are (nx,), m."""
        return np.asarray(self.origin[0] + self.spacing[0] * np.arange(self.heights.shape[1]))

    @property
    def y(self) -> Array:
        """Where the rows are (ny,), m."""
        return np.asarray(self.origin[1] + self.spacing[1] * np.arange(self.heights.shape[0]))


def read_points(file: str, scale: float) -> Array:
    """Return the points (n, 3) of a file, times a scale, m.

    An NPZ file has them as the array `points` (n, 3); a PLY file, in text or binary, as its vertices.

    Raises:
        ValueError: If the file is neither, has no points or some that are not finite, has triangles, or is as large as
            if it was in another unit; the message says what would be valid.
    """
    suffix = Path(file).suffix.lower()
    if suffix == ".npz":
        points = _numbers(_arrays(file, ("points",), ()), "points")
    elif suffix == ".ply":
        points = _ply_points(file)
    else:
        raise ValueError("a file that ends in .npz or .ply")
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise ValueError(f"points of the shape (n, 3), not {points.shape}")
    if bad := np.flatnonzero(~np.isfinite(points).all(axis=1)).tolist():
        raise ValueError(f"finite points; {len(bad)} are not, the first is number {bad[0]}: leave them out")
    points = scale * points
    _check_unit(float(np.ptp(points, axis=0).max()))
    return frozen(points)


def read_heights(file: str, scale: float) -> Grid:
    """Return the heights of a file, all of its numbers times a scale, in m.

    It is an NPZ file with the arrays `heights` (ny, nx), `spacing`, which is one number or two for x and y, and
    optionally `origin` (2,), where `heights[0, 0]` is; (0, 0) if it is not there.

    Raises:
        ValueError: If it is no such file, a height is not finite, or it is as large as if it was in another unit; the
            message says what would be valid.
    """
    if Path(file).suffix.lower() != ".npz":
        raise ValueError("a file that ends in .npz")
    arrays = _arrays(file, ("heights", "spacing"), ("origin",))
    heights = _numbers(arrays, "heights")
    if heights.ndim != 2 or min(heights.shape) < 2:
        raise ValueError(f"heights of the shape (ny, nx), 2 or more each, not {heights.shape}")
    if len(bad := np.argwhere(~np.isfinite(heights))):
        (row, column), count = bad[0].tolist(), len(bad)
        raise ValueError(f"finite heights; {count} are not, the first is heights[{row}, {column}]: fill the holes")
    spacing, origin = _numbers(arrays, "spacing"), _numbers(arrays, "origin") if "origin" in arrays else np.zeros(2)
    if spacing.shape not in ((), (2,)) or not (np.isfinite(spacing) & (spacing > 0.0)).all():
        raise ValueError(f"spacing: a number greater than 0, or two of them for x and y, not {spacing.tolist()}")
    if origin.shape != (2,) or not np.isfinite(origin).all():
        raise ValueError(f"origin: two numbers x and y, not {origin.tolist()}")
    (dx, dy), (x, y) = (scale * np.broadcast_to(spacing, 2)).tolist(), (scale * origin).tolist()
    grid = Grid(frozen(scale * heights), (dx, dy), (x, y))
    _check_unit(max(np.ptp(grid.heights), np.ptp(grid.x), np.ptp(grid.y)))
    return grid


def _check_unit(size: float) -> None:
    if size > LARGEST:
        raise ValueError(f"at most {LARGEST:g} m large, not {size:.6g} m; given in millimetres? (scale: 0.001)")


def _arrays(file: str, required: tuple[str, ...], optional: tuple[str, ...]) -> dict[str, np.ndarray]:
    try:
        with np.load(file, allow_pickle=False) as opened:
            arrays = {name: opened[name] for name in opened.files}
    except (OSError, ValueError, zipfile.BadZipFile, EOFError, AttributeError) as error:
        raise ValueError(f"an NPZ file that numpy can read ({error})") from error
    known = (*required, *optional)
    if missing := [name for name in required if name not in arrays]:
        has = ", ".join(arrays) or "none"
        raise ValueError(f"an NPZ file with the arrays {', '.join(required)}; {missing[0]} is missing, it has {has}")
    if unknown := [name for name in arrays if name not in known]:
        raise ValueError(f"an NPZ file with no other arrays than {', '.join(known)}; it has {', '.join(unknown)}")
    return arrays


def _numbers(arrays: dict[str, np.ndarray], name: str) -> Array:
    array = arrays[name]
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name} that are numbers, not {array.dtype}")
    return np.asarray(array, float)


def _ply_points(file: str) -> Array:
    """Return the vertices (n, 3) of a PLY file, as many as its header says."""
    # Imported here: it takes long, and few scenes have a point cloud.
    import trimesh

    said = _ply_elements(file)
    if said.get("face"):
        raise ValueError(f"a point cloud without triangles; this has {said['face']}: use the type mesh for solids")
    if not said.get("vertex"):
        raise ValueError("a PLY file with vertices; its header names none")
    try:
        loaded = trimesh.load(file, process=False)
        points = np.asarray(loaded.vertices, float).reshape(-1, 3)
    except Exception as error:  # trimesh's readers raise whatever a format makes them raise
        raise ValueError(f"a PLY file that trimesh can read ({type(error).__name__}: {error})") from error
    if len(points) != said["vertex"]:
        raise ValueError(f"a whole PLY file: its header says {said['vertex']} vertices, {len(points)} are read")
    return points


def _ply_elements(file: str) -> dict[str, int]:
    """Return how many of each element the header of a PLY file says there are."""
    with Path(file).open("rb") as opened:
        header = opened.read(65536).partition(b"end_header")[0].decode("ascii", errors="replace")
    if not header.startswith("ply"):
        raise ValueError("a PLY file, which begins with `ply`")
    return {name: int(count) for name, count in re.findall(r"^element (\w+) (\d+)", header, re.MULTILINE)}
