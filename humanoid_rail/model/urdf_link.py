"""Links of a URDF: their bodies and inertias."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array, triple
from humanoid_rail.errors import MISSING, InvalidInput
from humanoid_rail.model.urdf_elements import Node

_SIZES = {"sphere": ("radius",), "box": ("size",), "cylinder": ("radius", "length"), "capsule": ("radius", "length")}
_SHAPES = {**_SIZES, "mesh": ("filename", "scale")}
"""The shapes of URDF and their attributes."""


@dataclass(frozen=True)
class MeshFile:
    """A mesh that a URDF names."""

    filename: str
    """As it is written, for example `package://cell/gripper.stl`."""
    scale: tuple[float, float, float]
    """Factors along its axes."""


@dataclass(frozen=True, eq=False)
class UrdfBody:
    """A `<visual>` or `<collision>` of a link."""

    where: str
    """Path of the element, for errors."""
    shape: coal.ShapeBase | MeshFile
    placement: pin.SE3
    """Where it is in the frame of its link, m."""
    rgba: tuple[float, ...] | None = None
    """Colour, each from 0 to 1; numbers outside are clipped. None if it has none."""


@dataclass(frozen=True, eq=False)
class Inertial:
    """Mass and inertia of a link."""

    mass: float
    """kg."""
    placement: pin.SE3
    """The centre of mass, and the axes of the inertia, in the frame of the link, m."""
    inertia: Array
    """(3, 3) about the centre of mass, kg m^2."""


@dataclass(frozen=True, eq=False)
class Link:
    """A link."""

    name: str
    inertial: Inertial | None
    visuals: tuple[UrdfBody, ...]
    collisions: tuple[UrdfBody, ...]


def read_colour(material: Node) -> tuple[float, ...] | None:
    """Return the colour of a material; None if it has none of its own. One that cannot be read is warned of."""
    colour = material.child("color")
    try:
        return None if colour is None else tuple(np.clip(colour.numbers("rgba", 4), 0.0, 1.0).tolist())
    except InvalidInput as error:
        warnings.warn(f"{error}; it is shown without", stacklevel=2)
        return None


def read_link(node: Node, colours: Mapping[str, tuple[float, ...] | None]) -> Link:
    """Return a link; `colours` are those of the materials that the URDF defines by their names.

    Raises:
        InvalidInput: If an element or attribute is missing, cannot be read or has a value that it cannot have.
    """
    node.check_children(("inertial", "visual", "collision"))
    capsules = _capsules(node)
    collisions = tuple(_body(child, {}, capsules) for child in node.children("collision"))
    inertial = node.child("inertial")
    return Link(
        node.text("name"),
        None if inertial is None else _inertial(inertial),
        tuple(_body(child, colours, ()) for child in node.children("visual")),
        collisions,
    )


def _capsules(link: Node) -> tuple[str, ...]:
    """Return the collisions that `<collision_checking>`, an extension of Pinocchio, makes capsules of cylinders."""
    checking = link.child("collision_checking")
    if checking is None:
        return ()
    checking.check_children(("capsule",))
    names = tuple(capsule.text("name") for capsule in checking.children("capsule"))
    cylinders = [c.get("name") for c in link.element.findall("collision") if c.find("geometry/cylinder") is not None]
    for i, name in enumerate(names):
        if name not in cylinders:
            raise InvalidInput(f"{checking.where}.capsule[{i}].name", name, "the name of a <collision> with a cylinder")
    return names


def _body(node: Node, colours: Mapping[str, tuple[float, ...] | None], capsules: Sequence[str]) -> UrdfBody:
    node.check_children(("origin", "geometry", "material"))
    geometry = node.needed("geometry")
    shapes = list(geometry.element)
    if len(shapes) != 1 or shapes[0].tag not in _SHAPES:
        tags = [shape.tag for shape in shapes]
        raise InvalidInput(geometry.where, tags or MISSING, f"one element, {', '.join(_SHAPES)}")
    shape = geometry.needed(shapes[0].tag)
    shape.check_attributes(_SHAPES[shape.tag])
    rgba = None
    if node.tag == "visual" and (material := node.child("material")) is not None:
        name = material.text("name")  # readers drop the whole link without it
        rgba = read_colour(material) or colours.get(name)
    is_capsule = node.element.get("name", "") in capsules
    return UrdfBody(node.where, _shape(shape, is_capsule), node.origin(), rgba)


def _shape(node: Node, is_capsule: bool) -> coal.ShapeBase | MeshFile:
    match node.tag:
        case "sphere":
            return coal.Sphere(node.number("radius", above=0.0))
        case "box":
            size = node.numbers("size", 3)
            if not size.min() > 0:
                raise InvalidInput(f"{node.where}.size", node.text("size"), "three lengths greater than 0, m")
            return coal.Box(size)
        case "cylinder" if not is_capsule:
            return coal.Cylinder(node.number("radius", above=0.0), node.number("length", above=0.0))
        case "cylinder":  # a bone without thickness is still a body
            return coal.Capsule(node.number("radius", least=0.0), node.number("length", above=0.0))
        case "capsule":
            node.need_version(1.1, "<capsule>")
            return coal.Capsule(node.number("radius", least=0.0), node.number("length", above=0.0))
        case _:
            return MeshFile(node.text("filename"), triple(node.numbers("scale", 3, (1.0, 1.0, 1.0))))


def _inertial(node: Node) -> Inertial:
    node.check_children(("origin", "mass", "inertia"))
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    xx, xy, xz, yy, yz, zz = (node.needed("inertia").number(name, least=-np.inf, most=np.inf) for name in names)
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Inertial(node.needed("mass").number("value", least=0.0, most=np.inf), node.origin(), inertia)
