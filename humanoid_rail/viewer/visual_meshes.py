"""The visual bodies of a robot, also those that are meshes, with the colours of their files."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import Any, NamedTuple
from xml.etree import ElementTree

import meshcat
import meshcat.geometry as mg
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.mesh_files import load, unit
from humanoid_rail.viewer.drawing import draw_bodies
from humanoid_rail.viewer.mesh_names import find_mesh

PLAIN = (0.7, 0.7, 0.7, 1.0)
"""The colour (red, green, blue, opacity) of meshes without one."""


class _Mesh(NamedTuple):
    name: str
    scale: Array
    """(3,)."""
    has_colour: bool
    """Whether the URDF gives it one."""


class _Painted(NamedTuple):
    """A mesh of one colour, or one with a colour for each vertex."""

    vertices: Array
    """(n, 3), m."""
    faces: NDArray[np.int64]
    """(m, 3)."""
    colours: Array
    """Red, green, blue and opacity from 0 to 1: (4,) or (n, 4)."""


def draw_visuals(view: meshcat.Visualizer, robot: Robot) -> None:
    """Draw the visual bodies of a robot, each joint's under a node of its own, which the animation moves.

    Meshes have the unit that their file says; its up axis is ignored, as everywhere in ROS. Their colour is that of the
    URDF or, if it has none, of the file.

    Raises:
        InvalidInput: If a mesh file is not there or cannot be read.
    """
    urdf, meshes = _without_meshes(robot.urdf)
    visual = pin.buildGeomFromUrdfString(robot.model, urdf, pin.GeometryType.VISUAL)
    primitive = visual.copy()
    for body in visual.geometryObjects:
        if body.name in meshes:
            primitive.removeGeometryObject(body.name)
            joint = robot.model.names[body.parentJoint]
            _draw_mesh(view[f"{joint}/{body.name}"], body, meshes[body.name])
    draw_bodies(view, robot, primitive)


def _without_meshes(urdf: str) -> tuple[str, dict[str, _Mesh]]:
    """Return a URDF with spheres instead of its visual meshes, and these by the name of their body.

    Pinocchio would look for the files itself, and keeps no colours.
    """
    robot = ElementTree.fromstring(urdf)
    meshes = {}
    for link in robot.findall("link"):
        for number, visual in enumerate(link.findall("visual")):
            geometry = visual.find("geometry")
            if geometry is None or (mesh := geometry.find("mesh")) is None:
                continue
            name, scale = mesh.get("filename", ""), np.array(mesh.get("scale", "1 1 1").split(), float)
            meshes[f"{link.get('name')}_{number}"] = _Mesh(name, scale, visual.find("material") is not None)
            geometry.remove(mesh)
            ElementTree.SubElement(geometry, "sphere", radius="1")
    return ElementTree.tostring(robot, encoding="unicode") if meshes else urdf, meshes


def _draw_mesh(view: meshcat.Visualizer, body: pin.GeometryObject, mesh: _Mesh) -> None:
    field = f"visual body {body.name}"
    file = str(find_mesh(field, mesh.name))
    try:
        scene, factor = load(file), unit(file)
    except ValueError as error:
        raise InvalidInput(field, file, str(error)) from error
    painted = list(_painted(scene))
    if not painted:
        raise InvalidInput(field, file, "a file that holds a triangle mesh")
    for i, part in enumerate(painted):
        colours = np.array(body.meshColor) if mesh.has_colour else part.colours
        by_vertex = None if colours.ndim == 1 else colours[:, :3]
        geometry = mg.TriangularMeshGeometry(factor * part.vertices * mesh.scale, part.faces, by_vertex)
        red, green, blue = (255 * np.clip(colours[:3], 0, 1)).round().astype(int) if by_vertex is None else 3 * (255,)
        opacity = float(colours[..., 3].mean())
        colour = int(red) << 16 | int(green) << 8 | int(blue)
        material = mg.MeshPhongMaterial(color=colour, opacity=opacity, vertexColors=by_vertex is not None)
        view[str(i)].set_object(geometry, material)
    view.set_transform(body.placement.homogeneous)


def _painted(scene: Any) -> Iterator[_Painted]:
    """Yield the meshes of a file, placed as it says."""
    for node in scene.graph.nodes_geometry:
        T, name = scene.graph[node]
        geometry = scene.geometry[name]
        if not len(getattr(geometry, "faces", ())):
            continue
        vertices, faces = np.asarray(geometry.vertices) @ T[:3, :3].T + T[:3, 3], np.asarray(geometry.faces)
        colours = _corner_colours(geometry)
        if (colours == colours[0, 0]).all():
            yield _Painted(vertices, faces, colours[0, 0])
        else:
            apart = np.arange(faces.size).reshape(-1, 3)
            yield _Painted(vertices[faces].reshape(-1, 3), apart, colours.reshape(-1, 4))


def _corner_colours(geometry: Any) -> Array:
    """Return the colours (m, 3, 4) of the corners of triangles, from 0 to 1."""
    visual, faces = geometry.visual, np.asarray(geometry.faces)
    colours: Array = np.array(PLAIN)
    if visual.kind == "face":
        colours = np.asarray(visual.face_colors)[:, None] / 255.0
    elif visual.kind == "vertex":
        colours = np.asarray(visual.vertex_colors)[faces] / 255.0
    elif visual.kind == "texture":
        colours = np.asarray(visual.material.main_color) / 255.0
        # Without the picture or coordinates in it, the colour of the material is what there is.
        with suppress(Exception):
            colours = np.asarray(visual.to_color().vertex_colors).reshape(-1, 4)[faces] / 255.0
    return np.broadcast_to(colours, (*faces.shape, 4))
