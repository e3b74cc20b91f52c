"""Robots as their makers wrote them: the whole URDF with its meshes, loaded by Pinocchio alone. It is an oracle."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from io import StringIO
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import xacro

from humanoid_rail._arrays import Array

Pair = tuple[int, int]
"""Two bodies of the original, by index."""


@dataclass(frozen=True, eq=False)
class Original:
    """A URDF with nothing changed: all joints free, meshes as surfaces."""

    path: Path
    model: pin.Model
    bodies: pin.GeometryModel

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names of the bodies: LINK_i."""
        return tuple(body.name for body in self.bodies.geometryObjects)

    @cached_property
    def shapes(self) -> tuple[coal.CollisionGeometry, ...]:
        """The shapes of the bodies."""
        shapes = tuple(body.geometry for body in self.bodies.geometryObjects)
        for shape in shapes:
            shape.computeLocalAABB()
        return shapes

    def places(self, positions: Mapping[str, float]) -> list[pin.SE3]:
        """Return where the bodies are, given the positions of all joints by name, m and rad."""
        data = self.model.createData()
        pin.forwardKinematics(self.model, data, configuration(self.model, positions))
        return [data.oMi[body.parentJoint] * body.placement for body in self.bodies.geometryObjects]

    def touching(self, places: Sequence[pin.SE3], pairs: Iterable[Pair]) -> set[Pair]:
        """Return which of the pairs touch."""
        return {(i, j) for i, j in pairs if collide(self.shapes[i], places[i], self.shapes[j], places[j])}

    def apart(self, places: Sequence[pin.SE3], pairs: Sequence[Pair], within: float) -> float:
        """Return the least distance of the pairs, m; infinite if it is more than `within`."""
        middles = np.array([place.act(s.aabb_center) for place, s in zip(places, self.shapes, strict=True)])
        radii = np.array([shape.aabb_radius for shape in self.shapes])
        found = np.inf
        for i, j in pairs:
            if np.linalg.norm(middles[i] - middles[j]) - radii[i] - radii[j] <= min(within, found):
                found = min(found, distance(self.shapes[i], places[i], self.shapes[j], places[j]))
        return float(found) if found <= within else np.inf

    def touches_box(self, places: Sequence[pin.SE3], size: Sequence[float], at: pin.SE3) -> list[str]:
        """Return the bodies that touch a box with these edges, m."""
        box = coal.Box(*size)
        return [self.names[i] for i, shape in enumerate(self.shapes) if collide(shape, places[i], box, at)]


def load_original(path: Path, packages: Sequence[Path]) -> Original:
    """Return a robot by its URDF, with the folders in which its packages are.

    Raises:
        ValueError: If it has no bodies, as Pinocchio says nothing of a xacro that it cannot read.
    """
    text = urdf_text(path)
    model = pin.buildModelFromXML(text)
    places = list(map(str, packages))
    bodies = pin.buildGeomFromUrdfString(model, text, pin.GeometryType.COLLISION, package_dirs=places)
    if not bodies.ngeoms:
        raise ValueError(f"{path} has no bodies")
    return Original(path, model, bodies)


def urdf_text(path: Path) -> str:
    """Return the text of a URDF; what xacro makes of it if it is one, whatever its name."""
    text = path.read_text(encoding="utf-8")
    return str(xacro.process_file(str(path)).toxml()) if "<xacro:" in text else text


def configuration(model: pin.Model, positions: Mapping[str, float]) -> Array:
    """Return a configuration (nq,) of all joints; one without end has cosine and sine.

    Raises:
        KeyError: If a joint has no position.
    """
    q: Array = pin.neutral(model)
    for index in range(1, model.njoints):
        joint, name = model.joints[index], model.names[index]
        if joint.nq == 0 or joint.shortname() == "JointModelMimic":
            continue
        x = positions[name]
        q[joint.idx_q : joint.idx_q + joint.nq] = [np.cos(x), np.sin(x)] if joint.nq == 2 else [x]
    return q


def frames_of(path: Path, positions: Mapping[str, float]) -> dict[str, pin.SE3]:
    """Return where all links are, given the joints by name: by Pinocchio's own mimic joints, else by yourdfpy."""
    text = urdf_text(path)
    try:
        model = pin.buildModelFromXML(text, mimic=True)
    except (ValueError, RuntimeError):  # a follower on a branch before its leader
        return _frames_by_yourdfpy(text, positions)
    data = model.createData()
    pin.framesForwardKinematics(model, data, configuration(model, positions))
    return {f.name: data.oMf[i].copy() for i, f in enumerate(model.frames) if f.type == pin.FrameType.BODY}


def _frames_by_yourdfpy(text: str, positions: Mapping[str, float]) -> dict[str, pin.SE3]:
    import yourdfpy  # type: ignore[import-untyped]

    urdf = yourdfpy.URDF.load(StringIO(text), load_meshes=False, build_scene_graph=True)
    urdf.update_cfg({name: positions[name] for name in urdf.actuated_joint_names})
    return {name: pin.SE3(urdf.get_transform(name)) for name in urdf.link_map}


def collide(one: coal.CollisionGeometry, here: pin.SE3, other: coal.CollisionGeometry, there: pin.SE3) -> bool:
    """Return whether two shapes touch."""
    result = coal.CollisionResult()
    coal.collide(one, _placed(here), other, _placed(there), coal.CollisionRequest(), result)
    return bool(result.isCollision())


def distance(one: coal.CollisionGeometry, here: pin.SE3, other: coal.CollisionGeometry, there: pin.SE3) -> float:
    """Return how far two shapes are from each other, m; 0 or less where they touch."""
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    return float(coal.distance(one, _placed(here), other, _placed(there), request, result))


def _placed(place: pin.SE3) -> coal.Transform3s:
    return coal.Transform3s(place.rotation, place.translation)
