"""Meshes to convex pieces: coal sees no inside of a mesh, but it does of a convex body."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from humanoid_rail._arrays import Array, frozen
from humanoid_rail.geometry.coverage import farthest_outside, is_inside, points_in, points_on
from humanoid_rail.geometry.decomposition import decompose, forget
from humanoid_rail.geometry.enclosing_hull import enclosing_hull
from humanoid_rail.geometry.mesh_files import Triangles, read_triangles, stamps, warn_of_size
from humanoid_rail.geometry.solids import size_of, solids, volume

Pieces = tuple[Array, ...]
"""Vertices (k, 3) of convex bodies, in m."""

CONVEX = 1e-6
"""A solid is convex if its convex hull is larger by no more than this share of its volume."""
TOLERANCE = 1e-3
"""No point of a mesh may be farther outside of its pieces than this, relative to the size of the mesh."""
THINNEST = 1e-5
"""A solid that is thinner than this has no inside to speak of, m."""
LARGE = 100.0
"""A mesh that is larger than this is probably not in metres, m."""


def convex_pieces(file: str, scale: tuple[float, float, float]) -> Pieces:
    """Return convex bodies that together cover the solids inside a mesh, to within :data:`TOLERANCE` of its size.

    The solids are what the closed surfaces of the mesh enclose, whichever way their triangles face; a cavity counts as
    solid. A convex solid is one piece. The others are decomposed, each by itself, by CoACD (Wei, Liu, Ling, Su,
    "Approximate convex decomposition for 3D meshes with collision-aware concavity and tree search", 2022): it cuts
    them by planes and takes the convex hull of each part. Points on and in the mesh are then looked for in the pieces.

    Args:
        file: Path of a mesh all of whose parts are closed.
        scale: Factors along the axes, once z is up.

    Raises:
        ValueError: If the file is not a mesh, the mesh is not closed, or its pieces do not cover it; the message says
            what would be valid.
    """
    return _convex_pieces(file, scale, stamps(file))


@lru_cache(maxsize=64)
def _convex_pieces(file: str, scale: tuple[float, float, float], _stamps: object) -> Pieces:
    vertices, faces = read_triangles(file)
    triangles = Triangles(vertices * np.array(scale), faces)
    if _thickness(triangles.vertices[np.unique(faces)]) < THINNEST:
        raise ValueError(f"a mesh at least {THINNEST:g} m thick in every direction")
    size = size_of(triangles.vertices[np.unique(faces)])
    warn_of_size(file, size, LARGE)
    pieces = [piece for solid in _largest_first(solids(triangles)) for piece in _pieces_of(solid, size, file)]
    outer = [piece for i, piece in enumerate(pieces) if not is_inside(piece, pieces[:i])]
    # The whole mesh again: no part of it may have been lost, such as a sheet without an inside.
    missing = farthest_outside(points_on(triangles, np.random.default_rng(0)), outer)
    if missing > max(TOLERANCE * size, THINNEST):
        raise ValueError(
            f"a mesh whose parts are all {THINNEST:g} m thick at least: some of its surface is {missing:.3g} m "
            f"outside of all solids; the tolerance is {TOLERANCE * size:.3g} m"
        )
    return tuple(map(frozen, outer))


def _pieces_of(solid: Triangles, size: float, file: str) -> list[Array]:
    """Return convex bodies that cover a solid of a mesh of this size, m; none if it is too thin to have an inside."""
    if _thickness(solid.vertices) < THINNEST:
        return []
    try:
        if volume(solid.centred) >= (1.0 - CONVEX) * ConvexHull(solid.vertices).volume:
            return [enclosing_hull(solid.vertices)]
        found = decompose(solid, Path(file).name)
        # Where cuts run along faces, flakes without volume can be left over.
        pieces = [enclosing_hull(vertices) for vertices in found if _thickness(vertices) >= THINNEST]
    except QhullError as error:
        raise ValueError(f"a mesh that can be cut into convex pieces ({str(error).splitlines()[0]})") from error
    rng = np.random.default_rng(0)
    missing = farthest_outside(np.vstack([points_on(solid, rng), points_in(solid, rng)]), pieces)
    if missing > TOLERANCE * size:
        forget(solid)
        raise ValueError(
            f"a mesh that can be cut into convex pieces: they leave out points up to {missing:.3g} m deep, and the "
            f"tolerance is {TOLERANCE * size:.3g} m; one that consists of convex parts needs no cutting"
        )
    return pieces


def _largest_first(parts: list[Triangles]) -> list[Triangles]:
    return sorted(parts, key=lambda part: -volume(part.centred))


def _thickness(vertices: Array) -> float:
    """Return the smallest extent of points along their principal axes, m."""
    centred = vertices - vertices.mean(axis=0)
    axes = np.linalg.svd(centred, full_matrices=False)[2]
    return float(np.ptp(centred @ axes.T, axis=0).min())
