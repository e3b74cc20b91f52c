"""Point clouds and height fields: what stands for them contains them, and no more than is said."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial import cKDTree

from humanoid_rail import (
    HeightField,
    InvalidInput,
    PointCloud,
    Robot,
    Scene,
    plan,
    read_plan,
    verify,
    write_plan,
)
from humanoid_rail.collision.certifier import certify
from validation.plain_geometry import RADIUS, bones, point_segment, rotation

TARGETS = {"left": (-1.6, 0.6, 3.4), "right": (-1.6, 2.2, 3.4)}


def npz(folder: Path, **arrays: Any) -> str:
    np.savez(folder / "file.npz", **arrays)
    return str(folder / "file.npz")


def ply(path: Path, points: np.ndarray, kind: str) -> str:
    """Write a PLY file by hand."""
    header = f"ply\nformat {kind} 1.0\nelement vertex {len(points)}\n"
    header += "".join(f"property double {axis}\n" for axis in "xyz") + "end_header\n"
    if kind == "ascii":
        body = "".join(" ".join(map(repr, row)) + "\n" for row in points.tolist()).encode()
    else:
        body = points.astype("<f8" if "little" in kind else ">f8").tobytes()
    path.write_bytes(header.encode() + body)
    return str(path)


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_points_of_ply_files(kind: str, tmp_path: Path, rng: np.random.Generator) -> None:
    points = rng.normal(size=(50, 3))
    cloud = PointCloud(file=ply(tmp_path / "scan.ply", points, kind), radius=0.1)
    np.testing.assert_array_equal(cloud.centers, points[np.lexsort(points.T[::-1])])
    np.testing.assert_array_equal(cloud.radii, np.full(50, 0.1))


def test_points_that_are_the_same_have_one_sphere(tmp_path: Path) -> None:
    assert len(PointCloud(file=npz(tmp_path, points=np.ones((7, 3))), radius=0.1).radii) == 1


@pytest.mark.parametrize("voxel", [0.02, 0.1, 0.5])
def test_spheres_of_voxels_contain_all_balls_and_reach_no_farther_than_is_said(
    voxel: float, tmp_path: Path, rng: np.random.Generator
) -> None:
    points, radius = rng.uniform(-0.5, 0.5, (1000, 3)), 0.03
    cloud = PointCloud(file=npz(tmp_path, points=points), radius=radius, voxel=voxel)
    swelling = cloud.cover("it").swelling
    assert 0.0 < swelling < np.sqrt(3.0) * voxel + 1e-8
    assert len(cloud.radii) <= 1000
    nested = np.linalg.norm(points[:, None] - cloud.centers, axis=2) + radius - cloud.radii
    assert (nested.min(axis=1) <= 0.0).all()
    directions = rng.normal(size=(20, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    surface = (cloud.centers[:, None] + cloud.radii[:, None, None] * directions).reshape(-1, 3)
    beyond = cKDTree(points).query(surface)[0] - radius
    assert 0.1 * swelling < beyond.max() <= swelling


def test_clearances_of_a_cloud_are_those_of_its_points(
    robot: Robot, tmp_path: Path, rng: np.random.Generator, Kinematics: type
) -> None:
    points, rpy, center = rng.uniform(-1.0, 1.0, (300, 3)), (0.3, -0.4, 0.5), (0.2, 2.0, 3.0)
    cloud = PointCloud(file=npz(tmp_path, points=points), radius=0.05, rpy=rpy, center=center, velocity=(0.1, 0, 0))
    kinematics, there = Kinematics(robot, (cloud,)), points @ rotation(rpy).T + center
    for t in (0.0, 2.0):
        for q in rng.uniform(robot.lower, robot.upper, (20, robot.n)):
            at = there + np.array([0.1 * t, 0.0, 0.0])
            exact = point_segment(at[:, None], bones(q)[None]).min(axis=0) - RADIUS - 0.05
            np.testing.assert_allclose(kinematics.measure(q, t=t).clearance.ravel(), exact, atol=1e-9)


def solid_below(heights: np.ndarray, dx: float, dy: float, rng: np.random.Generator, n: int) -> np.ndarray:
    """Return points (n, 3) on a surface of two triangles in each cell, cut either way."""
    rows, columns = (rng.integers(0, k - 1, n) for k in heights.shape)
    u, v = rng.uniform(size=(2, n))
    a, b, c, d = (heights[rows + i, columns + j] for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)))
    one = np.where(u > v, a + u * (b - a) + v * (d - b), a + v * (c - a) + u * (d - c))
    other = np.where(u + v < 1, a + u * (b - a) + v * (c - a), d + (1 - u) * (c - d) + (1 - v) * (b - d))
    return np.stack([dx * (columns + u), dy * (rows + v), np.where(rng.random(n) < 0.5, one, other)], axis=-1)


def top_of(field: HeightField, at: np.ndarray) -> float:
    """Return how high the pieces are at (x, y): the highest convex combination of corners that is there."""
    best = -np.inf
    for piece in field.pieces:
        low, high = piece[:, :2].min(axis=0) - 1e-9, piece[:, :2].max(axis=0) + 1e-9
        if (at >= low).all() and (at <= high).all():
            inside = np.clip(at, piece[:, :2].min(axis=0), piece[:, :2].max(axis=0))
            equal = np.vstack([piece[:, :2].T, np.ones(len(piece))])
            best = max(best, -linprog(-piece[:, 2], A_eq=equal, b_eq=[*inside, 1.0], bounds=(0, 1)).fun)
    return best


@pytest.mark.parametrize("tolerance", [0.0, 0.01, 0.1])
def test_pieces_contain_the_surface_and_reach_no_farther_than_is_said(
    tolerance: float, tmp_path: Path, rng: np.random.Generator
) -> None:
    y, x = np.mgrid[0:9, 0:12]
    heights = np.where(x < 6, 0.1 * x + 0.05 * y, 0.2 * np.sin(x) * np.cos(y))  # half of it is plane
    field = HeightField(
        file=npz(tmp_path, heights=heights, spacing=[0.1, 0.2], origin=[1.0, -2.0]), tolerance=tolerance, base=-1.0
    )
    swelling = field.cover("it").swelling
    assert len(field.pieces) < 88  # cells
    points, origin = solid_below(heights, 0.1, 0.2, rng, 150), np.array([1.0, -2.0])
    over = [top_of(field, point[:2] + origin) - point[2] for point in points]
    assert min(over) >= -1e-7
    assert max(over) <= swelling + 1e-7
    assert {float(piece[:, 2].min()) for piece in field.pieces} == {-1.0}


def test_flat_ground_is_one_exact_piece(tmp_path: Path) -> None:
    field = HeightField(file=npz(tmp_path, heights=np.full((40, 30), 0.25), spacing=0.1))
    (piece,) = field.pieces
    np.testing.assert_allclose(piece.min(axis=0), [0.0, 0.0, 0.15], atol=1e-12)
    np.testing.assert_allclose(piece.max(axis=0), [2.9, 3.9, 0.25], atol=2e-9)
    assert field.cover("it").swelling < 2e-9


CLOUDS = [
    ({"points": np.zeros((3, 2))}, r"shape \(n, 3\), not \(3, 2\)"),
    ({"points": np.zeros((0, 3))}, r"shape \(n, 3\)"),
    ({"point": np.zeros((3, 3))}, "points is missing, it has point"),
    ({"points": np.zeros((3, 3)), "colors": np.zeros(3)}, "no other arrays than points; it has colors"),
    ({"points": np.array([[0, 0, 0], [0, np.nan, 0]])}, "1 are not, the first is number 1"),
    ({"points": np.array([["a"] * 3])}, "points that are numbers"),
    ({"points": np.array([[0, 0, 0], [2000.0, 0, 0]])}, r"millimetres\? \(scale: 0.001\)"),
    ({"points": np.random.default_rng(0).uniform(size=(10_001, 3))}, "at most 10000 spheres, not 10001: .*voxel: "),
]
FIELDS = [
    ({"heights": np.zeros((1, 5)), "spacing": 0.1}, r"\(ny, nx\), 2 or more each, not \(1, 5\)"),
    ({"heights": np.array([[0, 0], [np.nan, 0]]), "spacing": 0.1}, r"heights\[1, 0\]: fill the holes"),
    ({"heights": np.zeros((2, 2))}, "spacing is missing"),
    ({"heights": np.zeros((2, 2)), "spacing": -1.0}, "spacing: a number greater than 0"),
    ({"heights": np.zeros((2, 2)), "spacing": [1.0, 2.0, 3.0]}, "or two of them"),
    ({"heights": np.zeros((2, 2)), "spacing": 1.0, "origin": 3.0}, "origin: two numbers"),
    ({"heights": np.zeros((2, 2)), "spacing": 500.0}, "millimetres"),
    ({"heights": np.random.default_rng(0).uniform(size=(102, 102)), "spacing": 0.1}, "10000 convex pieces, not 10201"),
]


@pytest.mark.parametrize(("arrays", "said"), CLOUDS)
def test_clouds_that_are_refused(arrays: dict[str, Any], said: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=said) as caught:
        PointCloud(file=npz(tmp_path, **arrays), radius=0.01)
    assert caught.value.field == "file"


@pytest.mark.parametrize(("arrays", "said"), FIELDS)
def test_fields_that_are_refused(arrays: dict[str, Any], said: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=said) as caught:
        HeightField(file=npz(tmp_path, **arrays))
    assert caught.value.field == "file"


def test_the_voxel_that_is_said_is_enough(tmp_path: Path, rng: np.random.Generator) -> None:
    file = npz(tmp_path, points=rng.uniform(size=(30_000, 3)))
    with pytest.raises(InvalidInput) as caught:
        PointCloud(file=file, radius=0.001)
    voxel = float(caught.value.valid.split("voxel: ")[1])
    assert len(PointCloud(file=file, radius=0.001, voxel=voxel).radii) <= 10_000


def test_other_files_are_refused(tmp_path: Path, cube_file: str) -> None:
    (tmp_path / "text.ply").write_text("hello")
    (tmp_path / "text.npz").write_text("hello")
    short = ply(tmp_path / "short.ply", np.eye(3), "ascii")
    Path(short).write_text(Path(short).read_text()[:-20])
    for file, said in (
        (cube_file, "ends in .npz or .ply"),
        (str(tmp_path / "text.ply"), "begins with"),
        (str(tmp_path / "text.npz"), "that numpy can read"),
        (short, "PLY file"),
        ("nothing.ply", "an existing file"),
    ):
        with pytest.raises(InvalidInput, match=said):
            PointCloud(file=file, radius=0.1)


def test_a_ply_file_of_triangles_is_no_cloud(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    trimesh.creation.box().export(tmp_path / "box.ply")
    with pytest.raises(InvalidInput, match="without triangles; this has 12"):
        PointCloud(file=str(tmp_path / "box.ply"), radius=0.1)


def test_a_base_has_to_be_below_the_surface(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"a base at least 0\.0001 m below the lowest height, 0 m; it is 0"):
        HeightField(file=npz(tmp_path, heights=np.zeros((3, 3)), spacing=0.1), base=0.0)


@pytest.fixture
def measured(tmp_path: Path, rng: np.random.Generator) -> Scene:
    """A cloud and a field in reach of the robot."""
    wall = np.column_stack([np.full(400, -2.4), rng.uniform(0.0, 3.0, 400), rng.uniform(2.0, 4.0, 400)])
    np.savez(tmp_path / "wall.npz", points=wall)
    np.savez(tmp_path / "ground.npz", heights=0.1 * rng.uniform(size=(8, 5)), spacing=0.5)
    return Scene(
        targets=TARGETS,
        obstacles=(
            PointCloud(name="scan", file=str(tmp_path / "wall.npz"), radius=0.05, voxel=0.2),
            HeightField(file=str(tmp_path / "ground.npz"), center=(-3.0, -1.0, 0.4)),
        ),
    )


def test_a_plan_among_them_is_certified_says_what_it_covers_and_is_kept(
    robot: Robot, measured: Scene, tmp_path: Path
) -> None:
    trajectory = plan(robot, measured)
    assert trajectory.certificate is not None
    assert trajectory.certificate.certified
    scan, ground = trajectory.certificate.covers
    assert (scan.obstacle, scan.pieces) == ("obstacles[0] (scan)", "spheres")
    assert "reach at most" in str(scan)
    assert ground.obstacle == "obstacles[1] (heightfield)"
    write_plan(trajectory, robot, measured, tmp_path / "plan")
    for file in ("wall.npz", "ground.npz"):
        (tmp_path / file).unlink()
    again = read_plan(tmp_path / "plan")
    assert again.trajectory.certificate == trajectory.certificate
    for before, after in zip(measured.obstacles, again.scene.obstacles, strict=True):
        assert before.cover("it") == after.cover("it")
    assert verify(again.robot, again.scene, again.trajectory) == trajectory.certificate


def test_certificates_of_random_motions_hold_at_dense_samples(
    robot: Robot, measured: Scene, rng: np.random.Generator
) -> None:
    """By the points of the cloud alone, without coal."""
    cloud = measured.obstacles[0]
    points = np.load(cloud.file)["points"]
    certified = touched = 0
    for _ in range(150):
        a, b = rng.uniform(robot.lower, robot.upper, (2, robot.n))
        t, q = np.array([0.0, 1.0]), np.array([a, a + 0.1 * (b - a)])
        found = certify(robot, (cloud,), t, q)
        fine = np.linspace(q[0], q[1], 60)
        least = float(point_segment(points[:, None, None], bones(fine)[None]).min()) - RADIUS - cloud.radius
        bound = found.others_bound if found.others_bound is not None else found.clearance_bound
        if bound is not None:
            assert bound <= least + 1e-9
        certified, touched = certified + found.certified, touched + (least < 0.0)
        assert not (found.certified and least < 0.0)
    assert touched >= 3
    assert certified >= 3
