"""Meshes to convex pieces: coal sees no inside of a mesh, but it does of a convex body."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np

from humanoid_rail._arrays import Array, frozen

Pieces = tuple[Array, ...]
"""Vertices (k, 3) of convex bodies, in m."""

CONCAVITY = 0.05
"""CoACD leaves at most this concavity in a piece, relative to the size of the mesh."""
THINNEST = 1e-5
"""A mesh that is thinner than this has no inside to speak of, m."""


def convex_pieces(file: str, scale: tuple[float, float, float]) -> Pieces:
    """Return convex bodies that together cover the solid inside a mesh, to within about 1e-4 of its size.

    The decomposition is CoACD's (Wei, Liu, Ling, Su, "Approximate convex decomposition for 3D meshes with
    collision-aware concavity and tree search", 2022): it cuts the mesh by planes and takes the convex hull of each
    part. A convex mesh stays one piece.

    Args:
        file: Path of a closed triangle mesh.
        scale: Factors along the mesh's axes.

    Raises:
        ValueError: If the file is not a mesh or the mesh is not closed; the message says what would be valid.
    """
    return _decompose(file, scale, Path(file).stat().st_mtime_ns)


@lru_cache(maxsize=64)
def _decompose(file: str, scale: tuple[float, float, float], _modified: int) -> Pieces:
    # Here, not above: they take a second to import and few scenes hold a mesh.
    import coacd
    import trimesh

    try:
        mesh = trimesh.load_mesh(file)
    except Exception as error:  # trimesh's readers raise whatever their formats make them raise
        raise ValueError(f"a mesh file that trimesh can read ({error})") from error
    if not isinstance(mesh, trimesh.Trimesh) or len(mesh.faces) == 0:
        raise ValueError("a file that holds a triangle mesh")
    mesh.apply_transform(np.diag([*scale, 1.0]))
    if not np.isfinite(mesh.vertices).all():
        raise ValueError("a mesh with finite vertices")
    if not mesh.is_watertight:
        raise ValueError("a closed (watertight) mesh: an open one has no inside")
    if _thickness(mesh.vertices) < THINNEST:
        raise ValueError(f"a mesh at least {THINNEST:g} m thick in every direction")
    try:
        if mesh.is_convex:
            return (frozen(mesh.convex_hull.vertices),)
        coacd.set_log_level("error")
        parts = coacd.run_coacd(coacd.Mesh(mesh.vertices, mesh.faces), threshold=CONCAVITY, seed=0)
    except Exception as error:
        raise ValueError(f"a mesh that can be cut into convex pieces ({error})") from error
    # Where cuts run along faces, flakes without volume can be left over.
    return tuple(frozen(vertices) for vertices, _ in parts if _thickness(vertices) >= THINNEST)


def _thickness(vertices: Array) -> float:
    """Return the smallest extent of points along their principal axes, m."""
    centred = vertices - vertices.mean(axis=0)
    axes = np.linalg.svd(centred, full_matrices=False)[2]
    return float(np.ptp(centred @ axes.T, axis=0).min())
