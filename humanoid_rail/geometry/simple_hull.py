"""Convex hulls of few vertices that contain all points, and how much larger than their true hull they are.

For 99 collision meshes of nine robots (Panda, UR5, Baxter, PR2, Talos, TIAGo, TIAGo Pro, Kinova, Stretch) whose hulls
have more than 64 vertices, three kinds of simple hulls were compared at the same swelling. Vertices at the median:
some vertices, enlarged about their middle, 110; planes that touch the mesh, 129; some vertices, each moved out by
itself, 67. The last took the fewest on all of them, and is what is here.
"""

from __future__ import annotations

from typing import NamedTuple

import daqp
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from humanoid_rail._arrays import Array
from humanoid_rail.geometry.solids import size_of

FEW = 64
"""A hull of no more vertices than this is taken as it is."""
MOST_VERTICES = 500
"""No hull has more, whatever its swelling. None that is made for 2 mm has a vertex of 255 neighbours, which coal does
not take: a disc of 1 m radius needs 50 corners."""
AT_ONCE = 6
"""One of so many vertices gets a neighbour before all are moved again."""
MANY = 4000
"""Of a hull of more vertices than this, so many are looked at before all are."""
NUMBERS = 2**22
"""So many numbers at once are in memory, besides those of the points."""
PLANES = 64
"""So many planes at once are given to the solver, those that a point is in front of most."""
ROUNDING = 1e-12
"""What counts as zero, relative to the size of the points."""
MEASURED_TO = 1e-9
"""This is added to distances that were measured, m."""

DIRECTIONS = np.array([[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if x or y or z], float)
"""The first vertices to take are extreme in these directions (26, 3)."""

Indices = NDArray[np.int64]


class SimpleHull(NamedTuple):
    """A convex body that contains points."""

    vertices: Array
    """(k, 3), m, all of them on the hull and sorted."""
    swelling: float
    """How far it reaches out of the hull of the points at most, m."""


class _Hull:
    """A convex hull by its planes, of which those of the same face are one."""

    def __init__(self, hull: ConvexHull) -> None:
        planes = hull.equations
        _, first = np.unique(np.round(planes, 11), axis=0, return_index=True)
        self.normals: Array = np.ascontiguousarray(planes[np.sort(first), :3])
        self.offsets: Array = np.ascontiguousarray(-planes[np.sort(first), 3])

    def distances(self, points: Array, inside: Array, enough: float) -> Array:
        """Return how far points (k, 3) are outside at most, m.

        Args:
            points: In m.
            inside: Points (k, 3) of the hull. No distance is more than that to these.
            enough: Where this distance is no more than this, it is not looked for a nearer point, m.
        """
        found: Array = np.linalg.norm(points - inside, axis=1)
        for i in np.flatnonzero(found > enough):
            in_front: Array = self.normals @ points[i] - self.offsets
            if in_front.max() <= 0.0:
                found[i] = 0.0
            elif (near := self._nearest(points[i], in_front)) is not None:
                found[i] = np.linalg.norm(points[i] - near)
        return found

    def _nearest(self, point: Array, in_front: Array) -> Array | None:
        """Return the nearest point of the hull, from the planes that others are in front of most: few matter."""
        near, planes, nothing = point, np.zeros(0, np.int64), ROUNDING * float(np.abs(self.offsets).max())
        while (more := np.flatnonzero(in_front > nothing)).size:
            if more.size > PLANES:
                more = more[np.argpartition(-in_front[more], PLANES)[:PLANES]]
            before, planes = planes.size, np.union1d(planes, more)
            if planes.size == before:  # the solver's rounding
                break
            found = nearest_behind(point, self.normals[planes], self.offsets[planes])
            if found is None:
                return None
            near, in_front = found, self.normals @ found - self.offsets
        return near


def simple_hull(points: Array, most_swelling: float) -> SimpleHull:
    """Return a convex body that contains points (n, 3) and reaches out of their hull by a given length at most.

    It is their hull if that has no more than :data:`FEW` vertices. Otherwise it begins as the hull of those vertices
    that are extreme in 26 directions. All its planes move out until no point is in front of them, and each vertex to
    the nearest place that is not behind one of its planes: a star around its middle whose triangles are all outside
    of the points. Where a vertex reaches out too far, the point that has pushed it is taken, too.

    Of a hull of more than :data:`MANY` vertices, this is done with some of them first, so that few rounds are needed
    with all. The result depends on the set of points only.

    Args:
        points: In m, not all in a plane.
        most_swelling: In m; it is exceeded only if :data:`MOST_VERTICES` are too few.

    Raises:
        scipy.spatial.QhullError: If all points are in a plane.
    """
    # The middle of the box depends on vertices of the hull only, so that the hull of the hull is the same again.
    points = np.unique(points + 0.0, axis=0)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    corners = points - middle
    while len(on_hull := np.sort((whole := ConvexHull(corners)).vertices)) < len(corners):
        points, corners = points[on_hull], corners[on_hull]
    if len(points) <= FEW:
        return SimpleHull(points, 0.0)
    taken: Indices = np.unique(farthest(corners, DIRECTIONS)[0])
    if len(points) > MANY:
        some = _spread(corners)
        first = _Hull(ConvexHull(corners[some]))
        taken = some[_fitted(corners[some], first, np.searchsorted(some, taken), most_swelling)[1]]
    hull = _Hull(whole)
    moved, taken = _fitted(corners, hull, taken, most_swelling)
    swelling = float(hull.distances(moved, corners[taken], 0.0).max())
    if swelling == 0.0:  # nothing was left out
        return SimpleHull(points, 0.0)
    simple = moved[np.sort(ConvexHull(moved).vertices)] + middle
    return SimpleHull(np.unique(simple, axis=0), swelling + MEASURED_TO)


def _fitted(corners: Array, hull: _Hull, taken: Indices, most_swelling: float) -> tuple[Array, Indices]:
    """Return vertices (k, 3) whose hull contains all corners of a hull, and the corners (k,) that they were.

    Args:
        corners: In m, around the origin.
        hull: Their hull.
        taken: The first corners to take.
        most_swelling: Further corners are taken while a vertex reaches out more, m.
    """
    while True:
        moved, pushed_by = _moved_out(corners, taken)
        swellings = hull.distances(moved, corners[taken], most_swelling)
        room = MOST_VERTICES - len(taken)
        more = _more(swellings, pushed_by, taken, most_swelling)[: max(room, 0)]
        if not more.size:
            return moved, taken
        taken = np.union1d(taken, more)


def _spread(corners: Array) -> Indices:
    """Return the indices of at most about :data:`MANY` corners: those that are extreme in directions all around."""
    # A spiral from pole to pole whose points are as far from each other everywhere; it turns by the golden angle.
    step = np.arange(MANY)
    z, angle = 1.0 - (2.0 * step + 1.0) / MANY, np.pi * (3.0 - np.sqrt(5.0)) * step
    spiral = np.column_stack([np.cos(angle) * np.sqrt(1.0 - z * z), np.sin(angle) * np.sqrt(1.0 - z * z), z])
    return np.unique(np.concatenate([farthest(corners, spiral)[0], farthest(corners, DIRECTIONS)[0]]))


def farthest(points: Array, directions: Array) -> tuple[Indices, Array]:
    """Return which of some points (n, 3) is the farthest along each direction (m, 3), and how far it is (m,), m.

    The memory that it takes does not grow with n times m.
    """
    index, height = np.empty(len(directions), np.int64), np.empty(len(directions))
    at_once = max(1, NUMBERS // len(points))
    for begin in range(0, len(directions), at_once):
        along = directions[begin : begin + at_once] @ points.T
        first = along.argmax(axis=1)
        index[begin : begin + at_once] = first
        height[begin : begin + at_once] = along[np.arange(len(along)), first]
    return index, height


def nearest_behind(point: Array, normals: Array, offsets: Array) -> Array | None:
    """Return the point nearest to another that is behind planes: normals (k, 3) times it <= offsets (k,), m.

    It is None if it was not found.
    """
    none, kinds = np.full(len(offsets), -1e30), np.zeros(len(offsets), np.int32)
    found, _, flag, _ = daqp.solve(np.eye(3), -point, normals, offsets, none, kinds, primal_tol=1e-11)
    return found if flag == 1 else None


def _moved_out(corners: Array, taken: Indices) -> tuple[Array, Indices]:
    """Return corners that were taken (k, 3), moved until their hull contains all, and which have pushed each (k,).

    A corner that has not moved was pushed by itself.
    """
    inner = corners[taken]
    hull = ConvexHull(inner)
    normals = np.ascontiguousarray(hull.equations[:, :3])
    first, offsets = farthest(corners, normals)
    depths = offsets + hull.equations[:, 3]
    nothing = ROUNDING * size_of(corners)
    moved, pushed_by = inner.copy(), taken.copy()
    order = np.argsort(hull.simplices.ravel(), kind="stable")
    begins = np.searchsorted(hull.simplices.ravel()[order], np.arange(len(taken) + 1))
    for i in range(len(taken)):
        around = order[begins[i] : begins[i + 1]] // 3
        if not around.size or depths[around].max() <= nothing:
            continue
        found = nearest_behind(inner[i], -normals[around], -offsets[around])
        moved[i] = inner[i] if found is None else found
        pushed_by[i] = first[around[depths[around].argmax()]]
    return _enlarged(moved, corners), pushed_by


def _enlarged(body: Array, points: Array) -> Array:
    """Return a convex body (k, 3), enlarged about its middle to contain points: by rounding, most of the time."""
    middle = body.mean(axis=0)
    planes = ConvexHull(body - middle).equations
    factor = float((farthest(points - middle, planes[:, :3])[1] / -planes[:, 3]).max())
    return body if factor <= 1.0 else middle + factor * (1.0 + ROUNDING) * (body - middle)


def _more(swellings: Array, pushed_by: Indices, taken: Indices, most: float) -> Indices:
    """Return the corners to take as well: those that pushed the vertices that reach out most."""
    worst = np.argsort(-swellings, kind="stable")[: max(1, len(taken) // AT_ONCE)]
    if swellings[worst[0]] <= most:
        return np.zeros(0, np.int64)
    more = np.setdiff1d(pushed_by[worst[swellings[worst] > most]], taken)
    return more if more.size else np.setdiff1d(pushed_by, taken)
