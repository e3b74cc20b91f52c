"""The visual bodies of a robot, also those that are meshes, with the colours of their files."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import suppress
from typing import Any, NamedTuple

import meshcat
import meshcat.geometry as mg
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput
from humanoid_rail.geometry.mesh_files import load, unit
from humanoid_rail.geometry.mesh_names import find_mesh
from humanoid_rail.model.robot import Robot
from humanoid_rail.model.urdf import read_urdf
from humanoid_rail.model.urdf_link import MeshFile, UrdfBody
from humanoid_rail.viewer.colours import PLAIN, colour_of
from humanoid_rail.viewer.drawing import draw_body


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
    URDF or, if it has none, of the file. A warning names meshes that are not there or cannot be read; instead of these
    the collision bodies of their link are drawn.
    """
    links = read_urdf(robot.urdf).links
    for frame in robot.model.frames:
        if frame.type != pin.FrameType.BODY:
            continue
        link, joint, failed = links[frame.name], view[robot.model.names[frame.parentJoint]], list[InvalidInput]()
        for i, body in enumerate(link.visuals):
            try:
                _draw(joint[f"{link.name}_{i}"], body, frame.placement)
            except InvalidInput as error:
                failed.append(error)
        for i, body in enumerate(link.collisions if failed else (), start=len(link.visuals)):
            _draw(joint[f"{link.name}_{i}"], body, frame.placement)
        for reason in failed:
            warnings.warn(f"{reason}; the collision bodies of the link are drawn", stacklevel=2)


def _draw(view: meshcat.Visualizer, body: UrdfBody, link: pin.SE3) -> None:
    """Draw a body of a link that is at a placement in the frame of its joint.

    Raises:
        InvalidInput: If it is a mesh that is not there or cannot be read.
    """
    placement = link * body.placement
    if isinstance(body.shape, MeshFile):
        _draw_mesh(view, body.shape, body.rgba, body.where)
        view.set_transform(placement.homogeneous)
    else:
        draw_body(view, body.shape, placement, np.array(PLAIN if body.rgba is None else body.rgba))


def _draw_mesh(view: meshcat.Visualizer, mesh: MeshFile, rgba: tuple[float, ...] | None, field: str) -> None:
    file = str(find_mesh(field, mesh.filename))
    try:
        scene, factor = load(file), unit(file)
    except ValueError as error:
        raise InvalidInput(field, file, str(error)) from error
    painted = list(_painted(scene))
    if not painted:
        raise InvalidInput(field, file, "a file that holds a triangle mesh")
    for i, part in enumerate(painted):
        colours = part.colours if rgba is None else np.array(rgba)
        by_vertex = None if colours.ndim == 1 else colours[:, :3]
        geometry = mg.TriangularMeshGeometry(factor * part.vertices * mesh.scale, part.faces, by_vertex)
        colour = colour_of(colours if by_vertex is None else np.ones(3))
        opacity = float(colours[..., 3].mean())
        material = mg.MeshPhongMaterial(color=colour, opacity=opacity, vertexColors=by_vertex is not None)
        view[str(i)].set_object(geometry, material)


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
