"""The closed surfaces that a mesh is made of, each turned outwards.

Whatever a closed surface encloses counts as solid, whichever way its triangles face. So a cavity counts as solid too.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components
from scipy.spatial import cKDTree

from humanoid_rail._arrays import Array
from humanoid_rail.geometry.mesh_files import Triangles

WELD = 1e-6
"""Vertices that are nearer to each other than this, relative to the size of the mesh, are one if that closes it."""
LINE = 1e-6
"""A triangle is a line if its height is less than this, relative to the size of the mesh; files in single precision
round."""
NO_VOLUME = 1e-12
"""A closed surface of less volume than this encloses nothing, relative to the cube of its size."""
MOST_PATCHES = 14
"""Of no more patches than this that close a surface together all ways to turn them are tried."""

Indices = NDArray[np.int64]


def solids(triangles: Triangles) -> list[Triangles]:
    """Return the closed surfaces of a mesh, their triangles counterclockwise as seen from outside.

    Formats keep a vertex several times, where normals or textures differ: vertices at the same place are one here.
    Triangles that were given twice count once, unless they are a wall between two solids.

    Args:
        triangles: All triangles of the mesh.

    Raises:
        ValueError: If a part is not closed; the message says how many edges are open, and where one is.
    """
    found, rest = _closed_parts(_welded(triangles, apart=True))
    for distance in (0.0, WELD * size_of(triangles.vertices)):
        if not len(rest.faces):
            return found
        rest = _welded(rest, distance)
        # Some come twice by mistake; others are walls between two solids, which are no walls of both together.
        for kept in (_all, _once, _odd):
            closed, left = _closed_parts(_without_lines(kept(rest)))
            if closed:
                found, rest = [*found, *closed], left
        rest = _without_lines(rest)
        if (joined := _closed_together(rest)) is not None:
            return [*found, *joined]
    flat, rest = _closed_parts(rest, flat=True)
    if not len(rest.faces):
        return [*found, *flat]
    raise ValueError(_what_is_open(rest))


def size_of(vertices: Array) -> float:
    """Return the longest edge of the box around vertices (n, 3), m."""
    return float(np.ptp(vertices, axis=0).max())


def volume(triangles: Triangles) -> float:
    """Return the volume that a closed surface encloses, m^3: negative if its triangles face inwards.

    A surface that is not closed encloses a volume together with the origin.
    """
    a, b, c = np.moveaxis(triangles.corners, 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def has_volume(solid: Triangles) -> bool:
    """Return whether a closed surface that faces outwards encloses more than rounding does."""
    return volume(solid.centred) > NO_VOLUME * size_of(solid.vertices) ** 3


def areas(triangles: Triangles) -> Array:
    """Return the areas of triangles (m,), m^2."""
    a, b, c = np.moveaxis(triangles.corners, 1, 0)
    area: Array = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0
    return area


def _welded(triangles: Triangles, distance: float = 0.0, apart: bool = False) -> Triangles:
    """Return triangles whose vertices are sorted, and one where they are no farther from each other than a distance.

    Args:
        triangles: The triangles.
        distance: In m.
        apart: Whether vertices are one only if triangles of the file connect them.
    """
    used, index = np.unique(triangles.faces, return_inverse=True)
    vertices, faces = triangles.vertices[used] + 0.0, index.reshape(-1, 3)
    if apart:
        _, group = _components(np.vstack([faces[:, :2], faces[:, 1:]]), len(vertices))
        vertices = np.column_stack([group, vertices])
    vertices, same = np.unique(vertices, axis=0, return_inverse=True)
    vertices, faces = vertices[:, -3:], same.ravel()[faces]
    if distance > 0.0:
        pairs = cKDTree(vertices).query_pairs(distance, output_type="ndarray")
        _, group = _components(pairs, len(vertices))
        _, first = np.unique(group, return_index=True)
        vertices, faces = vertices[first], group[faces]
    return Triangles(vertices, faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)])


def _all(mesh: Triangles) -> Triangles:
    return mesh


def _once(mesh: Triangles) -> Triangles:
    """Return each triangle once."""
    _, index = np.unique(np.sort(mesh.faces, axis=1), axis=0, return_index=True)
    return mesh._replace(faces=mesh.faces[np.sort(index)])


def _odd(mesh: Triangles) -> Triangles:
    """Return the triangles that are given once, three times, ..."""
    _, index, count = np.unique(np.sort(mesh.faces, axis=1), axis=0, return_index=True, return_counts=True)
    return mesh._replace(faces=mesh.faces[np.sort(index[count % 2 == 1])])


def _without_lines(mesh: Triangles) -> Triangles:
    """Return a mesh without those triangles of zero area that keep it open; others fill gaps that have no width."""
    if not len(mesh.faces):
        return mesh
    size = size_of(mesh.vertices)
    longest = np.linalg.norm(mesh.corners - np.roll(mesh.corners, 1, axis=1), axis=2).max(axis=1, initial=0.0)
    is_line = 2.0 * areas(mesh) <= LINE * size * longest
    faces = mesh.faces
    while is_line.any():
        _, edge, count = _edges(faces)
        drop = is_line & ((count[edge] % 2 == 1).sum(axis=1) >= 2)
        if not drop.any():
            break
        faces, is_line = faces[~drop], is_line[~drop]
    return Triangles(mesh.vertices, faces)


def _edges(faces: Indices) -> tuple[Indices, Indices, Indices]:
    """Return the edges (e, 2), for each triangle those of its sides (m, 3), and how many triangles each has (e,)."""
    sides = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2), axis=2)
    edges, index, count = np.unique(sides.reshape(-1, 2), axis=0, return_inverse=True, return_counts=True)
    return edges, index.reshape(-1, 3), count


def _closed_parts(mesh: Triangles, flat: bool = False) -> tuple[list[Triangles], Triangles]:
    """Return the parts that are closed by themselves, and the triangles of all others.

    A part is what hangs together by edges of two triangles: so parts that share an edge are two. Those without volume
    are among the others unless they are asked for: triangles that come twice look like them.
    """
    _, edge, count = _edges(mesh.faces)
    group = _groups(mesh.faces)
    is_open = (count[edge] == 1).any(axis=1)
    possible = np.bincount(group, is_open, minlength=len(group)) == 0
    if not flat:
        possible &= np.bincount(group, minlength=len(group)) >= 4
    # Most that cannot be closed are sorted out at once: there may be as many as triangles.
    found, rest = [], [mesh.faces[~possible[group]]]
    for faces in _by_group(mesh.faces[possible[group]], group[possible[group]]):
        closed = _outwards(Triangles(mesh.vertices, _turned(faces)))
        if closed is not None and (flat or has_volume(closed)):
            found.append(closed)
        else:
            rest.append(faces)
    return found, Triangles(mesh.vertices, np.vstack(rest))


def _closed_together(mesh: Triangles) -> list[Triangles] | None:
    """Return the closed surface of patches that meet at edges of four triangles or more, each turned as it has to be.

    Of all ways to turn them that close the surface, it is the one that encloses most: nothing is cancelled by its
    neighbour.
    """
    if not len(mesh.faces):
        return []
    patches = [_turned(faces) for faces in _by_group(mesh.faces, _groups(mesh.faces))]
    if len(patches) > MOST_PATCHES:
        return None
    edges, index, _ = _edges(np.vstack(patches))
    of_patch = np.repeat(np.arange(len(patches)), [3 * len(faces) for faces in patches])
    ends = np.zeros((len(patches), len(edges)))
    np.add.at(ends, (of_patch, index.ravel()), np.concatenate([_ahead(faces).ravel() for faces in patches]))
    signs = np.array(list(product((1.0, -1.0), repeat=len(patches))))
    closing = signs[~(signs @ np.unique(ends, axis=1)).any(axis=1)]
    if not len(closing):
        return None
    middle = mesh.vertices.mean(axis=0)
    enclosed = closing @ [volume(Triangles(mesh.vertices - middle, faces)) for faces in patches]
    best = closing[enclosed.argmax()]
    faces = np.vstack([patch if sign > 0 else patch[:, ::-1] for patch, sign in zip(patches, best, strict=True)])
    whole = _outwards(Triangles(mesh.vertices, faces))
    return None if whole is None or not has_volume(whole) else [whole]


def _by_group(faces: Indices, group: Indices) -> Iterator[Indices]:
    """Yield the triangles of each part, given the number of the part (m,) that each is in."""
    order = np.argsort(group, kind="stable")
    begins = np.flatnonzero(np.diff(group[order], prepend=-1))
    for rows in np.split(order, begins[1:]) if len(faces) else ():
        yield faces[rows]


def _groups(faces: Indices) -> Indices:
    """Return the number of the part (m,) that each triangle is in."""
    return _components(_neighbours(faces)[0], len(faces))[1] if len(faces) else np.zeros(0, np.int64)


def _neighbours(faces: Indices) -> tuple[Indices, NDArray[np.bool_]]:
    """Return pairs of triangles (k, 2) that have an edge for themselves, and whether both go along it the same way."""
    _, index, count = _edges(faces)
    sides = index.ravel()
    order = np.argsort(sides, kind="stable")
    pairs = order[np.repeat(count == 2, count)].reshape(-1, 2)
    ahead = _ahead(faces).ravel()
    return pairs // 3, ahead[pairs[:, 0]] == ahead[pairs[:, 1]]


def _components(pairs: Indices, number: int) -> tuple[int, Indices]:
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(number, number))
    found, group = connected_components(graph, directed=False)
    return int(found), group.astype(np.int64)


def _turned(faces: Indices) -> Indices:
    """Return connected triangles, each turned as its neighbours are, as far as they can be."""
    pairs, differ = _neighbours(faces)
    pairs, first = np.unique(pairs, axis=0, return_index=True)  # two triangles can share all their edges
    differ, n = differ[first], len(faces)
    graph = coo_array((np.where(differ, 2.0, 1.0), (pairs[:, 0], pairs[:, 1])), shape=(n, n)).tocsr()
    graph = graph.maximum(graph.T)
    order, before = breadth_first_order(graph, 0, directed=False)
    steps = np.asarray(graph[order[1:], before[order[1:]]]).ravel() if n > 1 else np.zeros(0)
    turned = np.zeros(n, bool)
    for triangle, step in zip(order[1:].tolist(), steps.tolist(), strict=True):
        turned[triangle] = turned[before[triangle]] ^ (step == 2.0)
    return np.where(turned[:, None], faces[:, ::-1], faces)


def _ahead(faces: Indices) -> Array:
    """Return for the sides of triangles (m, 3) whether they go to the vertex of the higher number, 1, or not, -1."""
    return np.where(faces < np.roll(faces, -1, axis=1), 1.0, -1.0)


def _outwards(part: Triangles) -> Triangles | None:
    """Return a surface turned outwards as a whole; None if some edge does not go forth as often as back."""
    edges, index, _ = _edges(part.faces)
    if np.bincount(index.ravel(), _ahead(part.faces).ravel(), minlength=len(edges)).any():
        return None
    used, faces = np.unique(part.faces, return_inverse=True)
    closed = Triangles(part.vertices[used], faces.reshape(-1, 3))
    return closed if volume(closed.centred) >= 0.0 else closed._replace(faces=closed.faces[:, ::-1])


def _what_is_open(mesh: Triangles) -> str:
    edges, _, count = _edges(mesh.faces)
    if not (open_edges := edges[count % 2 == 1]).size:
        return "a mesh whose parts each have an inside and an outside: this one's triangles face both ways"
    x, y, z = mesh.vertices[open_edges[0]].mean(axis=0)
    where = f"{len(open_edges)} edges are open, one of them at ({x:.6g}, {y:.6g}, {z:.6g})"
    return f"a closed (watertight) mesh: an open one has no inside, and {where}"
