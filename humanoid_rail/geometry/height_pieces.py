"""Height fields as convex pieces that contain all that is below their surface."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from humanoid_rail._arrays import Array, frozen
from humanoid_rail.geometry.point_files import Grid

ROUNDING = 1e-9
"""Tops of pieces that stand for several cells are higher by this, m, so that rounding leaves no point out."""
_CORNERS = ((0, 0), (0, -1), (-1, 0), (-1, -1))


class HeightPieces(NamedTuple):
    """Convex pieces that contain the solid below a height field."""

    pieces: tuple[Array, ...]
    """Their corners (8, 3), m."""
    swelling: float
    """Nowhere are they higher than the surface by more than this, m."""


def height_pieces(grid: Grid, base: float, tolerance: float) -> HeightPieces:
    """Return convex pieces that contain the solid between a base and the surface of a height field.

    The surface has two triangles in each cell of the grid. The piece of a cell is the hull of its four heights, so it
    contains both ways of cutting the cell into triangles. Where heights are within a tolerance of a plane, a rectangle
    of cells is one piece, with the plane as its top, raised until none of them is above it.

    Args:
        grid: The heights.
        base: The solid goes down to this height, m.
        tolerance: Rectangles of several cells are higher than the surface by no more than this, m.
    """
    blocks = [*_blocks(grid, (0, len(grid.y) - 1, 0, len(grid.x) - 1), tolerance)]
    pieces = []
    for rows, columns, top, _ in blocks:
        x, y = grid.x[columns], grid.y[rows]
        flat = [(x[j], y[i]) for i, j in _CORNERS]
        over = [(*at, height) for at, height in zip(flat, top, strict=True)]
        pieces.append(frozen([*over, *((*at, base) for at in flat)]))
    return HeightPieces(tuple(pieces), max(block.swelling for block in blocks))


class _Block(NamedTuple):
    rows: slice
    columns: slice
    top: Array
    swelling: float


def _blocks(grid: Grid, cells: tuple[int, int, int, int], tolerance: float) -> Iterator[_Block]:
    """Yield the rectangles of cells that are one piece each; of those that are not, one half after the other."""
    first_row, last_row, first_column, last_column = cells
    rows, columns = slice(first_row, last_row + 1), slice(first_column, last_column + 1)
    heights = grid.heights[rows, columns]
    corners = np.array([heights[i, j] for i, j in _CORNERS])
    if heights.shape == (2, 2):
        yield _Block(rows, columns, corners, abs(corners[0] + corners[3] - corners[1] - corners[2]) / 2.0)
        return
    # The plane with the least squares over a full grid: a mean, and a slope along each axis by itself.
    along_y, along_x = (np.arange(n) - (n - 1) / 2.0 for n in heights.shape)
    mean = heights.mean()
    slope_y = along_y @ (heights.mean(axis=1) - mean) / (along_y @ along_y)
    slope_x = along_x @ (heights.mean(axis=0) - mean) / (along_x @ along_x)
    plane = mean + slope_y * along_y[:, None] + slope_x * along_x[None, :]
    above, below = float((heights - plane).max()), float((plane - heights).max())
    if above + below <= tolerance:
        top = np.array([plane[i, j] for i, j in _CORNERS]) + above + ROUNDING
        yield _Block(rows, columns, top, above + below + ROUNDING)
        return
    middle_row, middle_column = (first_row + last_row) // 2, (first_column + last_column) // 2
    if last_row - first_row >= last_column - first_column:
        yield from _blocks(grid, (first_row, middle_row, first_column, last_column), tolerance)
        yield from _blocks(grid, (middle_row, last_row, first_column, last_column), tolerance)
    else:
        yield from _blocks(grid, (first_row, last_row, first_column, middle_column), tolerance)
        yield from _blocks(grid, (first_row, last_row, middle_column, last_column), tolerance)
