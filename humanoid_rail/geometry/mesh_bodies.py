"""Convex bodies for the collision meshes of a robot, which are often open, of many parts, or flat."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from humanoid_rail._arrays import Array, frozen
from humanoid_rail.geometry.coverage import is_inside
from humanoid_rail.geometry.kept import cache_folder, keep_bodies, read_bodies
from humanoid_rail.geometry.mesh_files import Triangles, files_of, read_triangles
from humanoid_rail.geometry.ordered_mesh import enclosed_volume, in_order
from humanoid_rail.geometry.plane_cuts import LEAST_SAVED, MOST, plane_cuts
from humanoid_rail.geometry.simple_hull import SimpleHull, simple_hull
from humanoid_rail.geometry.solids import size_of

VERSION = 3
"""Of what is kept on disk: higher whenever the same mesh gives other bodies."""
MOST_SWELLING = 2e-3
"""A hull reaches out of the true one by no more than this, m."""
SWELLING = 0.01
"""Nor by more than this, relative to its size..."""
FINE = 0.25
"""Finely cut meshes swell by this share of what others may."""
LEAST_SWELLING = 1e-4
"""...unless that is less than this, m."""
THINNEST = 1e-5
"""A mesh that is thinner than this along one of its principal axes is flat, m."""
THICKENED = 5e-5
"""A flat mesh gets this much on both sides, m."""
CONVEX = 0.99
"""A closed mesh that fills this share of its hull is convex enough to be one piece."""


@dataclass(frozen=True, eq=False)
class MeshBodies:
    """Convex bodies that together contain every triangle of a mesh."""

    pieces: tuple[Array, ...]
    """Vertices (k, 3) of each, in the frame of the mesh, scale applied, m."""
    swelling: float
    """No point of a piece is farther than this outside of the convex hull of what it stands for, m."""
    hull_share: float
    """The volume of the mesh divided by that of its convex hull; 1 where it is unknown, as that of an open mesh."""


def mesh_hull(file: str | Path, scale: float | Sequence[float] | Array) -> MeshBodies:
    """Return the convex hull of a mesh as one body, of few vertices.

    It contains the mesh and reaches out of its hull by :data:`MOST_SWELLING` and :data:`SWELLING` of its size at most.
    It is the hull itself if that has no more than 64 vertices. A flat mesh is thickened by :data:`THICKENED`. The
    result depends neither on the order of vertices nor on that of triangles, and is kept in the user's cache folder.

    Args:
        file: Path of a mesh, in any format that trimesh and assimp read. The unit of COLLADA files counts, their up
            axis does not, as everywhere in ROS.
        scale: A factor or those along the axes of the file. Negative ones mirror it.

    Raises:
        ValueError: If the file is not a mesh, or the scale not one; the message says what would be valid.
    """
    factors = _factors(scale)
    kept = cache_folder("mesh_bodies") / f"{_key(file, factors)}.npz"
    return _kept(kept) or _keep(_hull_of(_read(file, factors)), kept)


def saved_hull(file: str | Path, scale: float | Sequence[float] | Array) -> MeshBodies:
    """Return the convex hull of a mesh with all its vertices, as of a body that was made before and saved.

    Args:
        file: As of :func:`mesh_hull`.
        scale: As of :func:`mesh_hull`.

    Raises:
        ValueError: If the file is not a mesh that is thicker than a plane, or the scale not one.
    """
    mesh = _read(file, _factors(scale))
    if _is_flat(mesh.vertices):
        raise ValueError("a mesh that is not flat, as it was saved")
    return MeshBodies((frozen(mesh.vertices[np.sort(ConvexHull(mesh.vertices).vertices)]),), 0.0, 1.0)


def mesh_pieces(file: str | Path, scale: float | Sequence[float] | Array, fine: bool = False) -> MeshBodies:
    """Return a mesh cut into convex bodies of few vertices each.

    Planes cut it where the hulls of both sides are smallest; each triangle of the mesh is in the pieces by construction
    (see :func:`~humanoid_rail.geometry.plane_cuts.plane_cuts`), and each piece is simplified as a hull is by
    :func:`mesh_hull`, to less swelling if they are fine. A convex or flat mesh is one piece. The result is kept in the
    user's cache folder.

    Args:
        file: As of :func:`mesh_hull`.
        scale: As of :func:`mesh_hull`.
        fine: Whether it is cut into more pieces.

    Raises:
        ValueError: If the file is not a mesh, or the scale not one; the message says what would be valid.
    """
    factors = _factors(scale)
    kept = cache_folder("mesh_bodies") / f"{_key(file, factors, (MOST[fine], LEAST_SAVED[fine]))}.npz"
    if (found := _kept(kept)) is not None:
        return found
    mesh = _read(file, factors)
    swelling = FINE if fine else 1.0
    whole = _hull_of(mesh, swelling)
    volume = enclosed_volume(mesh)
    if _is_flat(mesh.vertices) or (volume is not None and whole.hull_share >= CONVEX):
        return _keep(whole, kept)
    hulls = [_hull_around(points, swelling) for points in plane_cuts(mesh, fine)]
    hulls.sort(key=lambda hull: -float(ConvexHull(hull.vertices).volume))
    outer = [hull for i, hull in enumerate(hulls) if not is_inside(hull.vertices, [h.vertices for h in hulls[:i]])]
    pieces = tuple(frozen(hull.vertices) for hull in outer)
    return _keep(MeshBodies(pieces, max(hull.swelling for hull in outer), whole.hull_share), kept)


def _hull_of(mesh: Triangles, swelling: float = 1.0) -> MeshBodies:
    """Return the simple hull of a mesh that is in order."""
    hull = _hull_around(mesh.vertices, swelling)
    share, volume = 1.0, None if _is_flat(mesh.vertices) else enclosed_volume(mesh)
    if volume is not None:
        with suppress(QhullError):  # flat in relation to its size
            share = min(1.0, volume / float(ConvexHull(mesh.vertices).volume))
    return MeshBodies((frozen(hull.vertices),), hull.swelling, share)


def _hull_around(points: Array, swelling: float) -> SimpleHull:
    """Return the simple hull of points (n, 3), thickened where they are flat.

    Args:
        points: In m.
        swelling: The share of the usual swelling that is allowed.
    """
    most = swelling * min(MOST_SWELLING, max(LEAST_SWELLING, SWELLING * size_of(points)))
    extents, axes = _extents(points)
    flat = extents < THINNEST
    if not flat.any():
        try:
            return simple_hull(points, most)
        except QhullError:  # flat in relation to their size
            flat[extents.argmin()] = True
    for axis in axes[flat]:
        points = np.vstack([points - THICKENED * axis, points + THICKENED * axis])
    hull = simple_hull(points, most)
    return hull._replace(swelling=hull.swelling + THICKENED * float(np.sqrt(flat.sum())))


def _extents(points: Array) -> tuple[Array, Array]:
    """Return how far points (n, 3) extend along their principal axes (3,), m, and these axes (3, 3), one a row."""
    centred = points - points.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1].T
    return np.ptp(centred @ axes.T, axis=0), axes


def _is_flat(points: Array) -> bool:
    return bool((_extents(points)[0] < THINNEST).any())


def _read(file: str | Path, factors: Array) -> Triangles:
    """Return the triangles of a file, scaled and in order: facing outwards if they did before they were mirrored."""
    vertices, faces = read_triangles(str(file), z_up=False)
    return in_order(Triangles(vertices * factors, faces if np.prod(factors) > 0.0 else faces[:, ::-1]))


def _factors(scale: float | Sequence[float] | Array) -> Array:
    try:
        factors = np.array(np.broadcast_to(np.asarray(scale, float), 3))
    except (TypeError, ValueError):
        factors = np.zeros(3)
    if not np.isfinite(factors).all() or not factors.all():
        raise ValueError(f"a scale of one or three finite numbers other than 0, not {scale}")
    return factors


def _key(file: str | Path, factors: Array, options: Sequence[float] = ()) -> str:
    """Return a name for the bodies of a mesh, by all bytes of its files; nothing is made of them."""
    numbers = [SWELLING, MOST_SWELLING, LEAST_SWELLING, THICKENED]
    said = json.dumps([VERSION, Path(file).suffix.lower(), factors.tolist(), list(options), numbers])
    content = hashlib.sha256(said.encode())
    try:
        content.update(Path(file).read_bytes())
    except (OSError, ValueError) as error:
        raise ValueError(f"a mesh file that can be read ({type(error).__name__}: {error})") from error
    for other in files_of(str(file))[1:]:
        with suppress(OSError):  # who reads the mesh says what is missing
            content.update(other.read_bytes())
    return content.hexdigest()


def _keep(bodies: MeshBodies, file: Path) -> MeshBodies:
    """Write bodies to a file, their numbers first; without a cache everything works, and takes longer."""
    numbers = np.array([[bodies.swelling, bodies.hull_share, 0.0]])
    with suppress(OSError):
        keep_bodies([numbers, *bodies.pieces], file)
    return bodies


def _kept(file: Path) -> MeshBodies | None:
    """Return the bodies that a file holds, or None if it is not there or damaged."""
    try:
        numbers, *pieces = read_bodies(file)
        swelling, hull_share, _ = map(float, numbers[0])
        for piece in pieces:
            ConvexHull(piece)  # fails where all points are in a plane
    except Exception:  # a damaged archive may raise anything
        return None
    if not pieces or swelling < 0.0 or not 0.0 <= hull_share <= 1.0:
        return None
    return MeshBodies(tuple(map(frozen, pieces)), swelling, hull_share)
