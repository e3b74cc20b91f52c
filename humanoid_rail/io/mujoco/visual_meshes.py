"""The visual meshes of a robot as files that MuJoCo reads: binary STL, each of one colour."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput
from humanoid_rail.geometry.mesh_files import load, unit
from humanoid_rail.geometry.mesh_names import find_mesh
from humanoid_rail.model.robot import Robot
from humanoid_rail.model.urdf import read_urdf
from humanoid_rail.model.urdf_link import MeshFile, UrdfBody
from humanoid_rail.viewer.mesh_colours import coloured_triangles

FOLDER = "meshes"
"""The files are in this folder of an export."""
MOST_FACES = 200_000
"""MuJoCo takes no STL file with more triangles."""
MOST_COLOURS = 8
"""A mesh with more colours has their mean."""
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])


class MeshPart(NamedTuple):
    """A part of a visual mesh, of one colour."""

    name: str
    """Of its file in `FOLDER`, without the ending."""
    rgba: tuple[float, ...] | None
    """Its colour in the mesh file, each from 0 to 1; None if it has none of its own."""
    corners: Array
    """The corners of its triangles (m, 3, 3) in the frame of the visual body, m."""


@dataclass(frozen=True, eq=False)
class VisualMeshes:
    """The visual meshes of a robot."""

    parts: Mapping[MeshFile, tuple[MeshPart, ...]]
    """By mesh and scale. Those that are not there are not in it."""

    @property
    def files(self) -> dict[str, bytes]:
        """What is in the files, by name in the export."""
        return {file_of(part): _stl_bytes(part.corners) for parts in self.parts.values() for part in parts}

    def of(self, body: UrdfBody) -> tuple[MeshPart, ...]:
        """Return the parts of a visual body; none of a primitive."""
        return self.parts.get(body.shape, ()) if isinstance(body.shape, MeshFile) else ()


NO_MESHES = VisualMeshes({})
"""Those of a robot that is shown without meshes."""


def file_of(part: MeshPart) -> str:
    """Return the name of a part's file in an export."""
    return f"{FOLDER}/{part.name}.stl"


def visual_meshes(robot: Robot) -> VisualMeshes:
    """Return the visual meshes of a robot, once for each file and scale.

    They have the unit that their file says; its up axis is ignored, as everywhere in ROS. A warning names the meshes
    that are not there or cannot be read; they are left out.
    """
    found: dict[MeshFile, tuple[MeshPart, ...]] = {}
    taken: set[str] = set()
    for link in read_urdf(robot.urdf).links.values():
        for body in link.visuals:
            if isinstance(body.shape, MeshFile) and body.shape not in found:
                try:
                    found[body.shape] = tuple(_parts(body.shape, body.where, robot, taken))
                except InvalidInput as error:
                    found[body.shape] = ()
                    warnings.warn(f"{error}; it is left out of the export", stacklevel=2)
    return VisualMeshes(found)


def _parts(mesh: MeshFile, where: str, robot: Robot, taken: set[str]) -> Iterator[MeshPart]:
    """Yield the parts of a mesh under names that are not taken, and take them.

    Raises:
        InvalidInput: If its file is not there or cannot be read.
    """
    field = f"{where}.geometry.mesh.filename"
    file = str(robot.meshes.get(mesh.filename) or find_mesh(field, mesh.filename))
    try:
        scene, factors = load(file), unit(file) * np.array(mesh.scale)
    except ValueError as error:
        raise InvalidInput(field, file, str(error)) from error
    coloured = list(_coloured(scene))
    if not coloured:
        raise InvalidInput(field, file, "a file that holds a triangle mesh")
    stem = re.sub(r"[^\w.-]+", "_", Path(file).stem, flags=re.ASCII) or "mesh"
    for rgba, corners in coloured:
        scaled = corners * factors
        if factors.prod() < 0:  # mirrored: the corners go round the other way
            scaled = scaled[:, ::-1]
        for k in range(0, len(scaled), MOST_FACES):
            if len(piece := _with_area(scaled[k : k + MOST_FACES])):
                yield MeshPart(_new_name(stem, taken), rgba, piece)


def _new_name(stem: str, taken: set[str]) -> str:
    # Some file systems take names that differ in case as the same.
    name, number = stem, 1
    while name.lower() in taken:
        number += 1
        name = f"{stem}-{number}"
    taken.add(name.lower())
    return name


def _with_area(corners: Array) -> Array:
    """Return triangles (k, 3, 3) as MuJoCo takes them: only those with an area, with four points or more in all."""
    single = corners.astype(np.float32).astype(float)
    a, b, c = single.transpose(1, 0, 2)
    corners = corners[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0]
    if len(corners) and len(np.unique(corners.astype(np.float32).reshape(-1, 3), axis=0)) < 4:
        (a, b, c), middle = corners[0], corners[0].mean(axis=0)
        corners = np.array([[a, b, middle], [b, c, middle], [c, a, middle], *corners[1:]])
    return corners


def _coloured(scene: Any) -> Iterator[tuple[tuple[float, ...] | None, Array]]:
    """Yield the triangles (m, 3, 3) of a mesh file, placed as it says, by colour."""
    by_colour: dict[tuple[float, ...] | None, list[Array]] = {}
    for vertices, faces, of_corners in coloured_triangles(scene):
        corners = vertices[faces]
        if of_corners is None:
            by_colour.setdefault(None, []).append(corners)
            continue
        colours = of_corners.mean(axis=1)
        distinct, which = np.unique(colours.round(3), axis=0, return_inverse=True)
        if len(distinct) > MOST_COLOURS:
            areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
            mean = np.average(colours, axis=0, weights=areas if areas.sum() > 0 else None)
            distinct, which = mean.round(3)[None], np.zeros(len(colours), int)
        for k, colour in enumerate(distinct):
            by_colour.setdefault(tuple(colour.tolist()), []).append(corners[which.ravel() == k])
    for rgba, parts in by_colour.items():
        yield rgba, np.concatenate(parts)


def _stl_bytes(corners: Array) -> bytes:
    """Return triangles (m, 3, 3) as a binary STL file."""
    triangles = np.zeros(len(corners), _TRIANGLE)
    triangles["corners"] = corners
    return bytes(80) + len(corners).to_bytes(4, "little") + triangles.tobytes()
