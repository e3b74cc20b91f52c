"""Random closed meshes of several parts, as files of many formats hold them, and what is inside of them.

The seed and a mesh's number determine the mesh. What is inside is known from the parts, not from the mesh.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from humanoid_rail._arrays import Array

Inside = NDArray[np.bool_]
"""Whether each of some points (n,) is inside."""
FORMATS = ("stl", "obj", "ply", "glb", "dae", "off")
"""The formats of the files, by turns."""
SPLIT, LINES, FLIPPED, SPECKS = "split vertices", "triangles without area", "turned triangles", "given twice"
TROUBLES = (SPLIT, LINES, FLIPPED, SPECKS)
"""What can be done to the triangles of a file without a change of what they enclose."""
FINENESS = (5, 12, 40, 300)
"""Round parts have one of these numbers of sides."""


@dataclass(frozen=True, eq=False)
class Part:
    """A solid that is simple enough to say by a formula what is inside."""

    mesh: trimesh.Trimesh
    """In its own frame, m."""
    inside: Callable[[Array], Inside]
    """Whether points (n, 3) in its own frame are inside of it, or of a cavity in it."""
    placement: Array
    """Transform (4, 4) from its own frame."""

    def contains(self, points: Array) -> Inside:
        """Return whether points (n, 3) are inside."""
        return self.inside((points - self.placement[:3, 3]) @ self.placement[:3, :3])

    def placed(self) -> trimesh.Trimesh:
        """Return the mesh where it is."""
        return self.mesh.copy().apply_transform(self.placement)


@dataclass(frozen=True, eq=False)
class RandomMesh:
    """A mesh of several parts."""

    parts: tuple[Part, ...]
    suffix: str
    troubles: tuple[str, ...]
    triangles: trimesh.Trimesh
    """What the file holds, with z up."""

    @property
    def size(self) -> float:
        """The longest edge of the box around the mesh, m."""
        return float(self.triangles.extents.max())

    def contains(self, points: Array) -> Inside:
        """Return whether points (n, 3) are inside of a part."""
        inside: Inside = np.any([part.contains(points) for part in self.parts], axis=0)
        return inside

    def write(self, folder: Path) -> Path:
        """Write the mesh to a folder, in its format, and return the file."""
        written, file = self.triangles.copy(), folder / f"mesh.{self.suffix}"
        if self.suffix in ("glb", "dae"):  # in which y is up
            written.apply_transform(np.linalg.inv(Y_TO_Z))
        options: dict[str, dict[str, Any]] = {"obj": {"include_normals": True, "digits": 12}, "off": {"digits": 12}}
        written.export(file, **options.get(self.suffix, {}))
        return file


Y_TO_Z = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""The transform (4, 4) that glTF and COLLADA files with y up need."""


def make_mesh(seed: int, index: int) -> RandomMesh:
    """Return the mesh of a number, its format by turns."""
    rng = np.random.default_rng([seed, index])
    parts = [_random_part(rng) for _ in range(rng.integers(1, 5))]
    if rng.random() < 0.3:  # one inside another
        parts.append(_shrunk(parts[0], rng.uniform(0.2, 0.6)))
    meshes = [part.placed() for part in parts]
    for mesh in meshes:
        if rng.random() < 0.4:
            mesh.invert()
    troubles = tuple(name for name in TROUBLES if rng.random() < 0.4)
    triangles = trimesh.util.concatenate([_troubled(mesh, troubles, rng) for mesh in meshes])
    return RandomMesh(tuple(parts), FORMATS[index % len(FORMATS)], troubles, triangles)


def _random_part(rng: np.random.Generator) -> Part:
    size, sides = rng.uniform(0.1, 0.6, 3), int(rng.choice(FINENESS))
    placement = trimesh.transformations.euler_matrix(*rng.uniform(-pi, pi, 3))
    placement[:3, 3] = rng.uniform(-0.6, 0.6, 3)
    match rng.choice(["box", "cylinder", "cone", "ball", "angle"], p=[0.35, 0.2, 0.2, 0.15, 0.1]):
        case "box":
            return _box(size, placement)
        case "cylinder":
            return _prism(size, sides, placement, top=1.0)
        case "cone":
            return _prism(size, sides, placement, top=0.0)
        case "ball":
            return _ball(size, int(rng.integers(1, 5)), placement)
        case _:
            return _angle(size, placement)


def _box(size: Array, placement: Array) -> Part:
    return Part(trimesh.creation.box(size), lambda p: np.asarray((abs(p) < size / 2).all(axis=1)), placement)


def _prism(size: Array, sides: int, placement: Array, top: float) -> Part:
    """Return a regular pyramid or prism on the plane z = 0, as CAD writes cones and cylinders."""
    radius, height = float(size[0]), float(size[2])
    make = trimesh.creation.cylinder if top else trimesh.creation.cone
    mesh = make(radius, height, sections=sides)
    mesh.apply_translation([0.0, 0.0, -mesh.bounds[0][2]])
    corner = mesh.vertices[np.hypot(*mesh.vertices[:, :2].T) > radius / 2][0]
    begin = np.arctan2(corner[1], corner[0])

    def inside(p: Array) -> Inside:
        sector = 2.0 * pi / sides
        angle = (np.arctan2(p[:, 1], p[:, 0]) - begin) % sector - sector / 2
        across = np.hypot(p[:, 0], p[:, 1]) * np.cos(angle) / np.cos(sector / 2)
        share = p[:, 2] / height
        result: Inside = (share > 0) & (share < 1) & (across < radius * (1.0 - (1.0 - top) * share))
        return result

    return Part(mesh, inside, placement)


def _ball(size: Array, subdivisions: int, placement: Array) -> Part:
    """Return an ellipsoid of triangles, which is inside all of their planes."""
    mesh = trimesh.creation.icosphere(subdivisions).apply_scale(size / 2)
    normals, offsets = mesh.face_normals, np.einsum("fx,fx->f", mesh.face_normals, mesh.triangles[:, 0])
    return Part(mesh, lambda p: np.asarray((p @ normals.T < offsets).all(axis=1)), placement)


def _angle(size: Array, placement: Array) -> Part:
    """Return two plates at a right angle: a solid that is not convex."""
    x, y, z = size
    outline = np.array([[0, 0], [x, 0], [x, z / 4], [x / 4, z / 4], [x / 4, z], [0, z]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]])
    mesh = trimesh.creation.extrude_triangulation(outline, faces, height=y)

    def inside(p: Array) -> Inside:
        a, b, c = p.T
        result: Inside = ((c > 0) & (c < y)) & ((a > 0) & (b > 0)) & ((a < x) & (b < z / 4) | (a < x / 4) & (b < z))
        return result

    return Part(mesh, inside, placement)


def _shrunk(part: Part, factor: float) -> Part:
    """Return a part inside of another one."""
    middle = part.mesh.center_mass
    mesh = part.mesh.copy()
    mesh.vertices = middle + factor * (mesh.vertices - middle)
    return Part(mesh, lambda p: part.inside(middle + (p - middle) / factor), part.placement)


def _troubled(mesh: trimesh.Trimesh, troubles: tuple[str, ...], rng: np.random.Generator) -> trimesh.Trimesh:
    """Return a part as careless programs write it; what it encloses is the same."""
    vertices, faces = np.array(mesh.vertices), np.array(mesh.faces)
    chosen = rng.integers(len(faces), size=3)
    if FLIPPED in troubles:
        faces[chosen] = faces[chosen, ::-1]
    if SPECKS in troubles:
        faces = np.vstack([faces, faces[chosen]])
    if LINES in troubles:
        middle = vertices[faces[chosen, :2]].mean(axis=1)
        lines = np.column_stack([faces[chosen, 0], len(vertices) + np.arange(3), faces[chosen, 1]])
        vertices, faces = np.vstack([vertices, middle]), np.vstack([faces, lines, faces[chosen][:, [0, 0, 1]]])
    if SPLIT in troubles:
        vertices, faces = vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)
    return trimesh.Trimesh(vertices, faces, process=False)
