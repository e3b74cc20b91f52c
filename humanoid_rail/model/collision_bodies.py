"""The collision bodies of a robot: one for each primitive `<collision>` of its URDF, convex ones for each mesh."""

from __future__ import annotations

from collections.abc import Mapping

import coal
import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.errors import MISSING, InvalidInput
from humanoid_rail.geometry.convex_shape import convex_shape
from humanoid_rail.model.urdf import Urdf
from humanoid_rail.model.urdf_link import MeshFile

COLOUR = np.array([0.9, 0.9, 0.9, 1.0])
"""Bodies have this colour: red, green, blue and opacity from 0 to 1."""

Pieces = tuple[Array, ...]
"""Vertices (k, 3) of convex bodies that together contain a mesh, in its frame, m."""


def coal_placement(placement: pin.SE3) -> coal.Transform3s:
    """Return a placement of Pinocchio as coal has it."""
    return coal.Transform3s(placement.rotation, placement.translation)


def collision_bodies(model: pin.Model, urdf: Urdf, meshes: Mapping[str, Pieces]) -> pin.GeometryModel:
    """Return the collision bodies of a URDF, in the order of the model's links.

    They are named as Pinocchio's reader does: the link and the number of its `<collision>`; where a mesh has several
    pieces, also a dot and the number of the piece, so that no two have one name. That reader itself takes what it can
    read and leaves out the rest.

    Args:
        model: All joints.
        urdf: The robot.
        meshes: For each `<collision>` that is a mesh, by where it is in the URDF: its convex bodies.

    Raises:
        InvalidInput: If there are no bodies, or nothing is known of a mesh.
    """
    if not any(link.collisions for link in urdf.links.values()):
        raise InvalidInput("urdf", MISSING, "at least one link with a collision body")
    bodies = pin.GeometryModel()
    for index, frame in enumerate(model.frames):
        if frame.type != pin.FrameType.BODY or frame.name not in urdf.links:
            continue
        for i, body in enumerate(urdf.links[frame.name].collisions):
            placement, shapes = frame.placement * body.placement, [body.shape]
            if isinstance(body.shape, MeshFile):
                # coal sees only the surface of a mesh: a point wholly within one would count as free.
                if body.where not in meshes:
                    valid = "a primitive shape; load_robot makes convex bodies of meshes"
                    raise InvalidInput(f"{body.where}.geometry", f"mesh {body.shape.filename}", valid)
                # In one order, whatever file they come from: distances depend on it in their last digits.
                shapes = [convex_shape(np.unique(vertices + 0.0, axis=0)) for vertices in meshes[body.where]]
            for k, shape in enumerate(shapes):
                name = f"{frame.name}_{i}" if len(shapes) == 1 else f"{frame.name}_{i}.{k}"
                made = pin.GeometryObject(name, frame.parentJoint, index, placement, shape)
                made.meshColor = COLOUR
                bodies.addGeometryObject(made)
    in_model = {frame.name for frame in model.frames if frame.type == pin.FrameType.BODY}
    for name, link in urdf.links.items():
        if link.collisions and name not in in_model:
            raise InvalidInput(f"link {name} in Pinocchio", MISSING, "in the model, as the link has collision bodies")
    return bodies
