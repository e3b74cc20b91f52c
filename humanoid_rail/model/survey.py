"""What bodies of a robot do in random postures: which touch, and which are always near each other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from humanoid_rail._arrays import Array
from humanoid_rail.model.collision_bodies import coal_placement

POSTURES = 400
"""This many random postures are looked at."""
SEED = 0
"""Of the random postures: the same robot has the same ones."""
NEAR = 0.02
"""Distances are measured up to this, m."""
ALWAYS_NEAR = 0.01
"""Two bodies that are nearer than this in each posture are always near each other, m: the safety distance of
:class:`humanoid_rail.Safety` unless another is asked for."""


@dataclass(frozen=True, eq=False)
class Survey:
    """Distances of pairs of bodies in postures."""

    postures: Array
    """Configurations (N, n) of the actuated joints, m and rad."""
    pairs: tuple[tuple[int, int], ...]
    """Bodies by index."""
    distances: Array
    """(N, pairs), m: 0 or less where they touch, infinite where they are not near."""

    def touching(self) -> NDArray[np.bool_]:
        """Return which pairs touch in which postures (N, pairs)."""
        touches: NDArray[np.bool_] = self.distances <= 0.0
        return touches


def random_postures(lower: Array, upper: Array, count: int = POSTURES) -> Array:
    """Return configurations (count, n) within limits, the same each time."""
    return np.random.default_rng(SEED).uniform(lower, upper, (count, len(lower)))


def survey(
    model: pin.Model,
    bodies: pin.GeometryModel,
    pairs: Sequence[tuple[int, int]],
    postures: Array,
    full: Callable[[Array], Array],
    near: float = NEAR,
) -> Survey:
    """Return how near pairs of bodies are to each other in postures.

    Args:
        model: All joints.
        bodies: The bodies.
        pairs: The pairs to look at, by index.
        postures: Configurations (N, n) of the actuated joints.
        full: Makes of one the configuration of all joints.
        near: Distances that are greater do not matter, m.
    """
    distances = np.full((len(postures), len(pairs)), np.inf)
    first, second = (np.array([pair[side] for pair in pairs], int) for side in (0, 1))
    shapes = [body.geometry for body in bodies.geometryObjects]
    for shape in shapes:
        shape.computeLocalAABB()
    radii = np.array([shape.aabb_radius for shape in shapes])
    reach = radii[first] + radii[second] + near if len(pairs) else np.zeros(0)
    request, data = _unsigned(), model.createData()
    for row, q in enumerate(postures):
        places = _places(model, data, bodies, full(q))
        middles = np.array([place.act(shape.aabb_center) for place, shape in zip(places, shapes, strict=True)])
        apart = np.linalg.norm(middles[first] - middles[second], axis=1)
        placed: dict[int, coal.Transform3s] = {}
        for k in np.flatnonzero(apart <= reach):
            i, j = pairs[int(k)]
            for body in (i, j):
                if body not in placed:
                    placed[body] = coal_placement(places[body])
            distance = coal.distance(shapes[i], placed[i], shapes[j], placed[j], request, coal.DistanceResult())
            if distance <= near:
                distances[row, k] = distance
    return Survey(postures, tuple(pairs), distances)


def _unsigned() -> coal.DistanceRequest:
    """Return a request that does not measure how deep bodies are in each other, which takes long."""
    request = coal.DistanceRequest()
    request.enable_signed_distance = False
    return request


def _places(model: pin.Model, data: pin.Data, bodies: pin.GeometryModel, q: Array) -> list[pin.SE3]:
    pin.forwardKinematics(model, data, q)
    return [data.oMi[body.parentJoint] * body.placement for body in bodies.geometryObjects]
