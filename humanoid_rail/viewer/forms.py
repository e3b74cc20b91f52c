"""What shapes look like: forms of size 1 that a transform makes as large as they are.

Any number of shapes of a form are one object in the browser, with 64 bytes for each.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import repeat
from typing import Any, NamedTuple

import coal
import meshcat.geometry as mg
import meshcat.transformations as mt
import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.scene.shapes import PlacedShape
from humanoid_rail.viewer.meshes import hull_mesh, line_mesh

EDGES = "edges"
"""The name of the form that shows the edges of a box."""
WALL = (20.0, 20.0, 0.01)
"""Half-spaces are drawn as plates of this size, m."""
MANY = 2000
"""Where there are more bodies than this, those that are round have fewer corners."""
COARSER = 2
"""Round bodies among many have fewer corners around by this factor."""
_CORNERS = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
_BOX_EDGES = np.array([(a, a + step) for step in (1, 2, 4) for a in range(8) if not a & step])
# meshcat's cylinders and the poles of its spheres lie along y, those of coal and URDF along z.
_Y_TO_Z = mt.rotation_matrix(np.pi / 2, [1, 0, 0])
_UPSIDE_DOWN = mt.rotation_matrix(np.pi, [1, 0, 0])


class Form(NamedTuple):
    """A form of size 1, and the transform that makes a shape, or a part of it, of it."""

    name: str
    """What shapes of the same form have in common."""
    geometry: mg.Geometry
    transform: Array
    """From the form to the base frame (4, 4)."""
    owner: int = 0
    """The number of what it is a part of; the browser knows it."""


class _HalfSphere(mg.Sphere):  # type: ignore[misc]  # meshcat has no types
    """The half of a sphere of radius 1 where y > 0."""

    def __init__(self) -> None:
        super().__init__(1.0)

    def lower(self, object_data: dict[str, Any]) -> dict[str, Any]:
        return {**super().lower(object_data), "thetaLength": np.pi / 2, "heightSegments": 10}


class _Tube(mg.Cylinder):  # type: ignore[misc]
    """A cylinder of radius 1 from y = -1 to 1, without its ends."""

    def __init__(self) -> None:
        super().__init__(2.0)
        self.radialSegments = 20

    def lower(self, object_data: dict[str, Any]) -> dict[str, Any]:
        return {**super().lower(object_data), "openEnded": True}


class _Instances(mg.Mesh):  # type: ignore[misc]
    """Many bodies of one geometry and one material, each with a transform of its own (k, 4, 4)."""

    _type = "InstancedMesh"

    def __init__(self, geometry: mg.Geometry, material: mg.Material, forms: Sequence[Form], order: int) -> None:
        super().__init__(geometry, material)
        self._transforms, self._order = np.array([form.transform for form in forms]), order
        self._owners = [form.owner for form in forms]

    def lower(self) -> dict[str, Any]:
        data: dict[str, Any] = super().lower()
        columns = self._transforms.transpose(0, 2, 1).ravel()
        data["object"] |= {
            "renderOrder": self._order,
            "count": len(self._transforms),
            "instanceMatrix": mg.pack_numpy_array(columns),
            # The browser would judge by the geometry alone whether the bodies are in view.
            "frustumCulled": False,
            "userData": {"owners": self._owners},
        }
        return data


def forms_of(placed: PlacedShape) -> list[Form]:
    """Return the forms that make up a coal shape where it is.

    Raises:
        TypeError: If the shape is none of those that a URDF or a scene can hold.
    """
    T, shape = np.eye(4), placed.shape
    T[:3, :3], T[:3, 3] = placed.placement.getRotation(), placed.placement.getTranslation()
    match shape:
        case coal.Sphere():
            return [Form("sphere", _SPHERE, T @ _scaling([shape.radius] * 3))]
        case coal.Box():
            sized = T @ _scaling(2 * shape.halfSide)
            return [Form("box", _BOX, sized), Form(EDGES, _EDGES, sized)]
        case coal.Cylinder():
            turned = T @ _Y_TO_Z @ _scaling([shape.radius, 2 * shape.halfLength, shape.radius])
            return [Form("cylinder", _CYLINDER, turned)]
        case coal.Capsule():
            return _capsule(T @ _Y_TO_Z, shape.radius, shape.halfLength)
        case coal.Halfspace():
            return [Form("wall", _BOX, _surface(shape) @ _scaling(WALL))]
        case coal.ConvexBase():
            return [_hull(T, np.array(shape.points()))]
        case _:
            raise TypeError(f"no picture of a {type(shape).__name__}")


def instances(
    shapes: Iterable[PlacedShape], colour: int, opacity: float, order: int = 0, owners: Iterable[int] | None = None
) -> list[mg.Object]:
    """Return objects that show shapes where they are, one for all shapes of the same form.

    Args:
        shapes: What to show.
        colour: The colour of all of them.
        opacity: From 0 to 1. Boxes that can be looked through are shown with their edges.
        order: Of what can be looked through, that with the smallest number is drawn first and is behind the rest.
        owners: For each shape the number of what it is a part of; 0 if not given.

    Raises:
        TypeError: If a shape is none of those that a URDF or a scene can hold.
    """
    see_through = opacity < 1
    grouped: dict[str, list[Form]] = {}
    for placed, owner in zip(shapes, repeat(0) if owners is None else owners, strict=False):
        for form in forms_of(placed):
            if form.name != EDGES or see_through:
                grouped.setdefault(form.name, []).append(form._replace(owner=owner))
    # Bodies that can be looked through must not hide each other, in whatever order they are drawn.
    body = mg.MeshPhongMaterial(color=colour, opacity=opacity, transparent=see_through, depthWrite=not see_through)
    line = mg.MeshBasicMaterial(color=colour, wireframe=True)
    return [
        _Instances(forms[0].geometry, line if name == EDGES else body, forms, order) for name, forms in grouped.items()
    ]


class Group(mg.Object):  # type: ignore[misc]
    """Objects in groups of their own, each of which the animation can move by its name.

    They are one node to meshcat; thousands of its nodes would keep the browser busy for a minute.
    """

    def __init__(self, groups: Mapping[str, Sequence[mg.Object]]) -> None:
        super().__init__(None, None)
        self._groups = groups

    def lower(self) -> dict[str, Any]:
        """Return what the browser makes the objects of; what they share is there once."""
        geometries: dict[str, Any] = {}
        materials: dict[str, Any] = {}
        children, count = [], 0
        for name, objects in self._groups.items():
            lowered = [each.lower() for each in objects]
            for data in lowered:
                geometries |= {geometry["uuid"]: geometry for geometry in data["geometries"]}
                materials |= {material["uuid"]: material for material in data["materials"]}
            count += sum(data["object"]["count"] for data in lowered)
            children.append({"type": "Group", "name": name, "children": [data["object"] for data in lowered]})
        if count > MANY:
            for geometry in geometries.values():
                geometry |= {key: geometry[key] // COARSER for key in geometry if key.endswith("Segments")}
        return {
            "metadata": {"version": 4.5, "type": "Object"},
            "geometries": [*geometries.values()],
            "materials": [*materials.values()],
            "object": {"uuid": self.uuid, "type": "Group", "children": children},
        }


def _scaling(factors: Iterable[float]) -> Array:
    return np.diag([*factors, 1.0])


def _capsule(T: Array, radius: float, half_length: float) -> list[Form]:
    """Return the forms of a capsule along y."""
    half, up = _scaling([radius] * 3), mt.translation_matrix([0.0, half_length, 0.0])
    return [
        Form("tube", _TUBE, T @ _scaling([radius, half_length, radius])),
        Form("end", _HALF_SPHERE, T @ up @ half),
        Form("end", _HALF_SPHERE, T @ _UPSIDE_DOWN @ up @ half),
    ]


def _hull(T: Array, points: Array) -> Form:
    """Return the form of a convex body. It fills the cube from 0 to 1: copies of any size have the same form."""
    low, size = points.min(axis=0), np.ptp(points, axis=0)
    normal = ((points - low) / size).round(6)
    return Form(f"hull {normal.tobytes().hex()}", hull_mesh(normal), T @ mt.translation_matrix(low) @ _scaling(size))


def _surface(shape: coal.Halfspace) -> Array:
    """Return the transform (4, 4) of a plate in the xy plane to the surface of a half-space."""
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), np.array(shape.n))
    T: Array = pin.SE3(turn, shape.d * np.array(shape.n)).homogeneous
    return T


_SPHERE, _BOX, _CYLINDER = mg.Sphere(1.0), mg.Box([1.0, 1.0, 1.0]), mg.Cylinder(1.0)
_EDGES, _TUBE, _HALF_SPHERE = line_mesh(_CORNERS, _BOX_EDGES), _Tube(), _HalfSphere()
