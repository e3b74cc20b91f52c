"""What convex bodies cost in freedom: postures that are free by the meshes and not by the bodies."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from humanoid_rail.geometry.mesh_surface import mesh_surface
from humanoid_rail.model.building import Mechanism
from humanoid_rail.model.collision_bodies import coal_placement
from humanoid_rail.model.survey import POSTURES, Survey
from humanoid_rail.model.urdf import Urdf
from humanoid_rail.model.urdf_link import MeshFile, UrdfBody

DEVIATIONS = 2.0
"""A share is bounded by so many standard deviations."""


@dataclass(frozen=True)
class Lost:
    """Postures that are free by the meshes, and what convex bodies make of them."""

    free: int
    """How many are free by the meshes."""
    lost: int
    """How many of these are not by the bodies."""
    postures: int
    """How many were looked at."""
    blamed: Mapping[str, int]
    """How often each `<collision>`, by where it is in the URDF, is why."""

    @property
    def share(self) -> float:
        """The share that is lost."""
        return self.lost / self.free if self.free else 0.0

    @property
    def most(self) -> float:
        """The share that other random postures, :data:`POSTURES` of them, lose at most in 39 of 40 cases.

        It is the estimate and two standard deviations of the difference of two estimates, normally distributed.
        """
        if not self.free:
            return 0.0
        likely, others = (self.lost + 1.0) / (self.free + 2.0), self.free * POSTURES / self.postures
        return self.share + DEVIATIONS * sqrt(likely * (1.0 - likely) * (1.0 / self.free + 1.0 / others))


class Originals:
    """The shapes that bodies stand for, as they are in the files. What was looked at once is known."""

    def __init__(self, mechanism: Mechanism, meshes: Mapping[str, Path]) -> None:
        self._mechanism = mechanism
        self._meshes = meshes
        self._surfaces: dict[tuple[str, tuple[float, float, float]], coal.CollisionGeometry] = {}
        self._touch: dict[tuple[bytes, str, str], bool] = {}

    def lost(self, bodies: pin.GeometryModel, left_out: Mapping[frozenset[str], str], seen: Survey) -> Lost:
        """Return what bodies cost.

        Args:
            bodies: The convex bodies.
            left_out: The pairs of links that are not checked.
            seen: Which bodies touch in random postures.
        """
        mechanism, objects = self._mechanism, list(bodies.geometryObjects)
        links = [mechanism.model.frames[body.parentFrame].name for body in objects]
        checked: NDArray[np.bool_] = np.array(
            [frozenset((links[i], links[j])) not in left_out for i, j in seen.pairs], bool
        )
        sources, data = _sources(mechanism.urdf, objects, links), mechanism.model.createData()
        free, lost, blamed = 0, 0, Counter[str]()
        for q, touches in zip(seen.postures, seen.touching() & checked, strict=True):
            touching = [seen.pairs[k] for k in np.flatnonzero(touches)]
            if touching:
                pin.forwardKinematics(mechanism.model, data, mechanism.full_configuration(q))
                posture = _Posture(q.tobytes(), data, objects, sources)
                if any(self._meshes_touch(posture, i, j) for i, j in touching):
                    continue
                lost += 1
                blamed.update({where for pair in touching for where in self._at_fault(posture, *pair)})
            free += 1
        return Lost(free, lost, len(seen.postures), blamed)

    def _meshes_touch(self, posture: _Posture, i: int, j: int) -> bool:
        key = (posture.name, posture.sources[i].where, posture.sources[j].where)
        if key not in self._touch:
            self._touch[key] = posture.touch(i, self._surface(posture, i), j, self._surface(posture, j))
        return self._touch[key]

    def _at_fault(self, posture: _Posture, i: int, j: int) -> list[str]:
        """Return of two bodies that touch, and whose meshes do not, those without which they would not."""
        found = []
        for one, other in ((i, j), (j, i)):
            surface, body = self._surface(posture, one), posture.objects[other].geometry
            if not posture.touch(one, surface, other, body):
                found.append(posture.sources[one].where)
        return found or [posture.sources[i].where, posture.sources[j].where]

    def _surface(self, posture: _Posture, index: int) -> coal.CollisionGeometry:
        """Return the shape that a body stands for: a mesh, or a primitive, which is the body itself."""
        shape = posture.sources[index].shape
        if not isinstance(shape, MeshFile):
            return posture.objects[index].geometry
        key = (shape.filename, shape.scale)
        if key not in self._surfaces:
            self._surfaces[key] = mesh_surface(self._meshes[shape.filename], shape.scale)
        return self._surfaces[key]


@dataclass(frozen=True, eq=False)
class _Posture:
    """Bodies in a posture."""

    name: bytes
    data: pin.Data
    objects: Sequence[pin.GeometryObject]
    sources: Sequence[UrdfBody]

    def touch(self, i: int, shape: coal.CollisionGeometry, j: int, other: coal.CollisionGeometry) -> bool:
        """Return whether two shapes touch where two bodies are."""
        here, there = (self.data.oMi[b.parentJoint] * b.placement for b in (self.objects[i], self.objects[j]))
        result = coal.CollisionResult()
        coal.collide(shape, coal_placement(here), other, coal_placement(there), coal.CollisionRequest(), result)
        return bool(result.isCollision())


def _sources(urdf: Urdf, bodies: Sequence[pin.GeometryObject], links: Sequence[str]) -> list[UrdfBody]:
    """Return for each body the element of the URDF that it stands for."""
    found = []
    for body, link in zip(bodies, links, strict=True):
        number = body.name.removeprefix(f"{link}_").partition(".")[0]
        found.append(urdf.links[link].collisions[int(number)])
    return found
