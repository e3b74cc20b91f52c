"""Distances that proofs rest on are never above exact ones: closed forms in extended precision."""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin
import pytest

from humanoid_rail import Box
from humanoid_rail._arrays import triple
from humanoid_rail.scene.shapes import placed_shapes
from validation.exact_distances import KINDS, exact_distance, measured_distances
from validation.plain_geometry import rotation

ROUNDING = 64.0 * float(np.finfo(float).eps)
"""Rounding takes at most this share of the largest coordinate."""
TIGHT = 1e-5
"""Proven distances are at most this below exact ones, m, and in m per m of distance."""


@pytest.mark.parametrize("far", [0.0, 2e3])
@pytest.mark.parametrize("scale", [0.01, 1.0, 100.0])
@pytest.mark.parametrize("kind", KINDS)
def test_a_proven_distance_is_not_above_the_exact_one(kind: str, scale: float, far: float) -> None:
    rng = np.random.default_rng([KINDS.index(kind), int(100 * scale), int(far)])
    for _ in range(25):
        proven, distance, largest = measured_distances(kind, rng, scale, far)
        assert proven <= distance + ROUNDING * (largest + far + 10.0 * scale)
        if distance > 0.0:
            assert proven >= distance - TIGHT * (1.0 + distance)


def test_the_library_alone_is_above_the_exact_distance() -> None:
    """Its iterations end within 1e-6 of the distance, which is more than 1 um where that is large."""
    above = []
    rng = np.random.default_rng(3)
    for _ in range(300):
        radius, length = 1.0, 30.0
        rpy = triple(rng.normal(size=3) * 10.0 ** rng.uniform(-9.0, -2.0))
        obstacle = Box(center=triple(rng.normal(0.0, 60.0, 3)), size=(40.0, 20.0, 10.0), rpy=rpy)
        half = 0.5 * length * np.eye(3, dtype=np.longdouble)[2]
        (box,) = placed_shapes(obstacle)
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        capsule = coal.Capsule(radius, length)
        measured = coal.distance(capsule, coal.Transform3s(), box.shape, box.placement, request, result)
        distance = exact_distance(obstacle, np.array([-half, half]), radius)
        if distance > 0.0:
            above.append(measured - distance)
    assert max(above) > 2e-6


def test_rotations_of_the_oracle_are_those_of_the_robot() -> None:
    assert rotation((0.3, -0.4, 0.5)) == pytest.approx(pin.rpy.rpyToMatrix(0.3, -0.4, 0.5), abs=1e-15)
