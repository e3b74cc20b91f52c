"""The visual bodies of a robot, also those that are meshes, with the colours of their files."""

from __future__ import annotations

import base64
import time
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import coal
import meshcat
import numpy as np
import pinocchio as pin

from humanoid_rail.errors import InvalidInput
from humanoid_rail.geometry.mesh_names import find_mesh
from humanoid_rail.model import cache
from humanoid_rail.model.robot import Robot
from humanoid_rail.model.urdf import Urdf, read_urdf
from humanoid_rail.model.urdf_link import MeshFile
from humanoid_rail.viewer.colours import PLAIN
from humanoid_rail.viewer.drawing import draw_body, node_name
from humanoid_rail.viewer.painted import Coloured, Painted, draw_painted, painted, read_coloured
from humanoid_rail.viewer.simplified import cell_size

MOST_TRIANGLES = 120_000
"""A robot is drawn with at most this many triangles: about 3 MB of a page."""
SLOW = 0.2
"""Pictures that take longer than this to make are kept in the user's cache folder, s."""
_Mesh = tuple[str, tuple[float, ...]]
"""A mesh by its file and its scale."""


class Visual(NamedTuple):
    """A body of a link that is drawn."""

    joint: str
    """The joint that moves it."""
    name: str
    placement: pin.SE3
    """Where it is in the frame of the joint, m."""
    shape: coal.ShapeBase | Sequence[Painted]
    rgba: tuple[float, ...] | None
    """Red, green, blue and opacity from 0 to 1; None for a mesh that has colours of its own, or none."""


def robot_visuals(robot: Robot) -> list[Visual]:
    """Return the visual bodies of a robot.

    Meshes have the unit that their file says; its up axis is ignored, as everywhere in ROS. Their colour is that of the
    URDF or, if it has none, of the file. All of a robot together have at most `MOST_TRIANGLES` triangles: where there
    are more, points that are near each other become one. A warning names meshes that are not there or cannot be read;
    instead of these the collision bodies of their link are drawn, and those of links whose bodies are hulls of meshes.
    """
    urdf = read_urdf(robot.urdf)
    frames = [frame for frame in robot.model.frames if frame.type == pin.FrameType.BODY and frame.name in urdf.links]
    files, missing = _files(urdf, robot)
    meshes, unread = _painted(files, 2 * max(robot.arm_reaches, default=1.0))
    found = []
    for frame in frames:
        link, joint, failed = urdf.links[frame.name], robot.model.names[frame.parentJoint], list[InvalidInput]()
        for i, body in enumerate(link.visuals):
            placement, name, shape = frame.placement * body.placement, f"{link.name}_{i}", body.shape
            if not isinstance(shape, MeshFile):
                found.append(Visual(joint, name, placement, shape, body.rgba))
            elif body.where in missing:
                failed.append(missing[body.where])
            elif (mesh := files[body.where]) in meshes:
                found.append(Visual(joint, name, placement, meshes[mesh], body.rgba))
            else:
                failed.append(InvalidInput(body.where, mesh[0], unread[mesh]))
        if failed:
            found += _instead(robot, frame, len(link.visuals))
        for reason in failed:
            warnings.warn(f"{reason}; the collision bodies of the link are drawn", stacklevel=2)
    return found


def draw_visuals(view: meshcat.Visualizer, visuals: Sequence[Visual]) -> None:
    """Draw visual bodies, each joint's under a node of its own, which the animation moves."""
    for visual in visuals:
        node = view[node_name(visual.joint)][node_name(visual.name)]
        if not isinstance(visual.shape, Sequence):
            rgba = PLAIN if visual.rgba is None else visual.rgba
            draw_body(node, visual.shape, visual.placement, np.array(rgba))
            continue
        for i, part in enumerate(visual.shape):
            draw_painted(node[str(i)], part, visual.rgba)
        node.set_transform(visual.placement.homogeneous)


def _files(urdf: Urdf, robot: Robot) -> tuple[dict[str, _Mesh], dict[str, InvalidInput]]:
    """Return the meshes that are drawn and those that are not there, by where they are in the URDF."""
    files: dict[str, _Mesh] = {}
    missing: dict[str, InvalidInput] = {}
    for body in (body for link in urdf.links.values() for body in link.visuals):
        if isinstance(body.shape, MeshFile):
            try:
                file = robot.meshes.get(body.shape.filename) or find_mesh(body.where, body.shape.filename)
                files[body.where] = str(file), body.shape.scale
            except InvalidInput as error:
                missing[body.where] = error
    return files, missing


def _instead(robot: Robot, frame: pin.Frame, number: int) -> list[Visual]:
    """Return the collision bodies of a link."""
    joint, bodies = robot.model.names[frame.parentJoint], robot.collision_model.geometryObjects
    own = [body for body in bodies if robot.model.frames[body.parentFrame].name == frame.name]
    return [
        Visual(joint, f"{frame.name}_{i}", body.placement, body.geometry, None)
        for i, body in enumerate(own, start=number)
    ]


def _painted(files: Mapping[str, _Mesh], size: float) -> tuple[dict[_Mesh, list[Painted]], dict[_Mesh, str]]:
    """Return pictures of meshes, and why others have none."""
    wanted = list(files.values())
    begun = time.perf_counter()
    key = _key(wanted, size)
    if key is not None and (known := cache.kept(key)) is not None:
        return {mesh: [_unpacked(part) for part in known[_name(mesh)]] for mesh in set(wanted)}, {}
    coloured: dict[_Mesh, list[Coloured]] = {}
    unread: dict[_Mesh, str] = {}
    for mesh in dict.fromkeys(wanted):
        try:
            coloured[mesh] = read_coloured(*mesh)
        except ValueError as error:
            unread[mesh] = str(error)
    cell = cell_size([part.mesh for mesh in wanted for part in coloured.get(mesh, ())], MOST_TRIANGLES, size)
    made = {mesh: [painted(part, cell) for part in parts] for mesh, parts in coloured.items()}
    if key is not None and not unread and time.perf_counter() - begun > SLOW:
        cache.keep(key, {_name(mesh): [_packed(part) for part in parts] for mesh, parts in made.items()})
    return made, unread


def _key(wanted: Sequence[_Mesh], size: float) -> str | None:
    """Return what pictures are kept by: the content of their files, and of the materials beside these."""
    files = [Path(file) for file, _ in dict.fromkeys(wanted)]
    files += [beside for file in files if (beside := file.with_suffix(".mtl")).is_file()]
    try:
        return cache.key_of(["picture 1", str(MOST_TRIANGLES), repr(size), *map(_name, wanted)], files)
    except OSError:
        return None


def _name(mesh: _Mesh) -> str:
    return f"{mesh[0]} {mesh[1]}"


def _packed(part: Painted) -> list[list[Any]]:
    """Return arrays as data that JSON can hold."""
    kinds = (np.float32, np.float32, np.int32, np.uint8)
    arrays = [np.ascontiguousarray(array, kind) for array, kind in zip(part, kinds, strict=True)]
    return [[array.dtype.str, list(array.shape), base64.b64encode(array.tobytes()).decode()] for array in arrays]


def _unpacked(data: Sequence[Sequence[Any]]) -> Painted:
    arrays: list[Any] = [np.frombuffer(base64.b64decode(content), kind).reshape(shape) for kind, shape, content in data]
    return Painted(*arrays)
