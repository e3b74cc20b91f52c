"""Round parts, as CAD writes them: bodies of few vertices that contain all of theirs, and are hardly larger."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from humanoid_rail import Mesh, NativeKinematics, Robot
from humanoid_rail.geometry.enclosing_hull import MOST_SWELLING, MOST_VERTICES, enclosing_hull
from humanoid_rail.scene.shapes import placed_shapes


def bicone(sections: int) -> trimesh.Trimesh:
    cone = trimesh.creation.cone(1.0, 1.0, sections=sections)
    return trimesh.convex.convex_hull(np.vstack([cone.vertices, cone.vertices * [1.0, 1.0, -1.0]]))


ROUND = {
    "cone": trimesh.creation.cone(0.5, 2.0, sections=300),
    "cone of 255": trimesh.creation.cone(0.5, 2.0, sections=255),
    "cylinder": trimesh.creation.cylinder(0.5, 1.0, sections=300),
    "rod": trimesh.creation.cylinder(0.01, 2.0, sections=400),
    "disc": trimesh.creation.cylinder(0.5, 0.001, sections=1000),
    "bicone": bicone(400),
    "sphere": trimesh.creation.icosphere(4),
    "lens": trimesh.creation.icosphere(4).apply_scale([1.0, 1.0, 0.01]),
    "capsule": trimesh.creation.capsule(2.0, 0.3),
}


@pytest.mark.parametrize("name", ROUND)
def test_round_parts(name: str, robot: Robot, tmp_path: Path) -> None:
    mesh = ROUND[name]
    mesh.export(tmp_path / "round.ply")
    obstacle = Mesh(file=str(tmp_path / "round.ply"), center=(-1.0, 2.0, 2.0))
    (piece,) = obstacle.pieces
    assert len(piece) <= MOST_VERTICES
    planes, exact = ConvexHull(piece).equations, ConvexHull(mesh.vertices).equations
    size = np.ptp(mesh.vertices, axis=0).max()
    # PLY is in single precision.
    assert (mesh.vertices @ planes[:, :3].T + planes[:, 3]).max() < 1e-6 * size
    assert (piece @ exact[:, :3].T + exact[:, 3]).max() < MOST_SWELLING * size
    assert len(placed_shapes(obstacle)) == 1
    assert np.isfinite(NativeKinematics(robot, (obstacle,)).measure(robot.initial).clearance).all()


def test_few_vertices_stay_as_they_are(rng: np.random.Generator) -> None:
    points = rng.normal(size=(100, 3))
    vertices = enclosing_hull(np.vstack([points, 0.1 * points]))
    np.testing.assert_array_equal(np.unique(vertices, axis=0), np.unique(points[ConvexHull(points).vertices], axis=0))
