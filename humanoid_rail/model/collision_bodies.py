"""The collision bodies of a robot: one for each `<collision>` of its URDF, of the size and where it is written."""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.errors import MISSING, InvalidInput
from humanoid_rail.model.urdf import Urdf
from humanoid_rail.model.urdf_link import MeshFile, UrdfBody

PRECISION = 1e-9
"""Bodies are of the size and where they are written to within this, m, or this share of it."""


def coal_placement(placement: pin.SE3) -> coal.Transform3s:
    """Return a placement of Pinocchio as coal has it."""
    return coal.Transform3s(placement.rotation, placement.translation)


def collision_bodies(model: pin.Model, urdf: Urdf) -> pin.GeometryModel:
    """Return the collision bodies that Pinocchio makes of a URDF, held against what is written.

    Raises:
        InvalidInput: If there are none, one is a mesh, or Pinocchio has others than are written.
    """
    if not any(link.collisions for link in urdf.links.values()):
        raise InvalidInput("urdf", MISSING, "at least one link with a collision body")
    for body in (body for link in urdf.links.values() for body in link.collisions):
        # coal sees only the surface of a mesh: a point wholly within one would count as free.
        if isinstance(body.shape, MeshFile):
            raise InvalidInput(f"{body.where}.geometry", f"mesh {body.shape.filename}", "a primitive shape, no mesh")
    try:
        bodies = pin.buildGeomFromUrdfString(model, urdf.text, pin.GeometryType.COLLISION)
    except (ValueError, RuntimeError) as error:
        raise InvalidInput("urdf", urdf.text, f"collision bodies that Pinocchio can load ({error})") from error
    _check(model, bodies, urdf)
    return bodies


def _check(model: pin.Model, bodies: pin.GeometryModel, urdf: Urdf) -> None:
    """Check that no body is missing or another than is written, whatever the libraries below think of the URDF."""
    found: dict[str, list[pin.GeometryObject]] = {name: [] for name in urdf.links}
    for body in bodies.geometryObjects:
        found[model.frames[body.parentFrame].name].append(body)
    for name, link in urdf.links.items():
        if len(found[name]) != len(link.collisions):
            valid = f"as many as the link has elements <collision>, {len(link.collisions)}"
            raise InvalidInput(f"collision bodies of link {name} in Pinocchio", len(found[name]), valid)
        for body, written in zip(found[name], link.collisions, strict=True):
            placement = model.frames[body.parentFrame].placement.actInv(body.placement)
            if not (_same(body.geometry, written) and _near(placement.homogeneous, written.placement.homogeneous)):
                raise InvalidInput(f"{written.where} in Pinocchio", body, "as it is written in the URDF")


def _same(shape: coal.CollisionGeometry, written: UrdfBody) -> bool:
    return type(shape) is type(written.shape) and _near(_sizes(shape), _sizes(written.shape))


def _sizes(shape: coal.ShapeBase) -> Array:
    match shape:
        case coal.Box():
            return np.array(shape.halfSide)
        case coal.Sphere():
            return np.array([shape.radius])
        case _:
            return np.array([shape.radius, shape.halfLength])


def _near(a: Array, b: Array) -> bool:
    return bool(np.allclose(a, b, rtol=PRECISION, atol=PRECISION))
