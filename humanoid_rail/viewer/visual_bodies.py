"""The bodies that a robot is drawn with."""

from __future__ import annotations

import warnings

import numpy as np
import pinocchio as pin

from humanoid_rail.model.robot import Robot
from humanoid_rail.model.urdf import read_urdf
from humanoid_rail.model.urdf_link import MeshFile

PLAIN = (0.7, 0.7, 0.7, 1.0)
"""Colour of what has none, from 0 to 1."""


def visual_bodies(robot: Robot) -> pin.GeometryModel:
    """Return the primitive visual bodies of a robot; of links with meshes also the collision bodies.

    Meshes are not drawn, so their files need not be there. A warning names them.
    """
    bodies, links, meshes = pin.GeometryModel(), read_urdf(robot.urdf).links, list[str]()
    for index, frame in enumerate(robot.model.frames):
        if frame.type != pin.FrameType.BODY:
            continue
        link = links[frame.name]
        files = [body.shape.filename for body in link.visuals if isinstance(body.shape, MeshFile)]
        shown = [body for body in link.visuals if not isinstance(body.shape, MeshFile)]
        for i, body in enumerate([*shown, *(link.collisions if files else ())]):
            placement = frame.placement * body.placement
            drawn = pin.GeometryObject(f"{frame.name}_{i}", frame.parentJoint, index, placement, body.shape)
            drawn.meshColor = np.array(PLAIN if body.rgba is None else body.rgba)
            bodies.addGeometryObject(drawn)
        meshes += files
    if meshes:
        names = ", ".join(dict.fromkeys(meshes))
        warnings.warn(f"meshes are not drawn, but the collision bodies of their links: {names}", stacklevel=2)
    return bodies
