"""Convex bodies of a robot's meshes contain them, are barely larger, and are kept."""

from __future__ import annotations

import re
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from scipy.optimize import nnls
from scipy.spatial import ConvexHull

from humanoid_rail.geometry import mesh_bodies
from humanoid_rail.geometry.coverage import farthest_outside
from humanoid_rail.geometry.mesh_bodies import MOST_SWELLING, THICKENED, mesh_hull, mesh_pieces
from humanoid_rail.geometry.mesh_files import Triangles
from humanoid_rail.geometry.ordered_mesh import enclosed_volume, in_order
from humanoid_rail.geometry.plane_cuts import plane_cuts
from humanoid_rail.geometry.simple_hull import simple_hull

Points = NDArray[np.float64]


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "humanoid_rail" / "mesh_bodies"


def written(mesh: trimesh.Trimesh, folder: Path, name: str = "mesh.ply") -> Path:
    mesh.export(folder / name)
    return folder / name


def capsule() -> trimesh.Trimesh:
    mesh = trimesh.creation.capsule(0.2, 0.05, count=(48, 48))
    mesh.apply_transform(trimesh.transformations.rotation_matrix(0.7, (1, 2, 3), (0.1, 0, 0.4)))
    return mesh


def ell() -> trimesh.Trimesh:
    upright, foot = trimesh.creation.box((0.2, 0.4, 1.0)), trimesh.creation.box((1.0, 0.4, 0.2))
    foot.apply_translation((0.4, 0.0, -0.4))
    return trimesh.boolean.union([upright, foot], engine="manifold")


def raw(vertices: Points, faces: object, folder: Path) -> Path:
    """Write a mesh as it is."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(vertices, float).tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in np.asarray(faces).tolist()]
    (folder / "raw.obj").write_text("\n".join(lines) + "\n")
    return folder / "raw.obj"


def distance_by_weights(point: Points, points: Points) -> float:
    """Return the distance of a point from the hull of points, by a minimum over weights of these."""
    # The last row makes the sum of the weights 1.
    rows = np.vstack([(points - point).T, np.full(len(points), 1e3)])
    weights, _ = nnls(rows, np.array([0.0, 0.0, 0.0, 1e3]))
    return float(np.linalg.norm(weights @ points / weights.sum() - point))


@pytest.mark.parametrize("shape", ["capsule", "sphere", "torus", "finger"])
def test_hulls_contain_the_mesh_and_swell_as_they_say(shape: str, tmp_path: Path, rng: np.random.Generator) -> None:
    mesh = {
        "capsule": capsule(),
        "sphere": trimesh.creation.icosphere(3, 0.1),
        "torus": trimesh.creation.torus(0.3, 0.05, 64, 32),
        "finger": trimesh.creation.capsule(0.03, 0.01, count=(32, 32)),
    }[shape]
    file = written(mesh, tmp_path)
    mesh = trimesh.load_mesh(file, process=False)
    (piece,), swelling = mesh_hull(file, 1.0).pieces, mesh_hull(file, 1.0).swelling
    inside = rng.dirichlet(np.ones(3), len(mesh.faces))
    points = np.vstack([mesh.vertices, np.einsum("nk,nkx->nx", inside, mesh.triangles)])
    assert farthest_outside(points, [piece]) < 1e-12
    assert len(piece) < len(ConvexHull(mesh.vertices).vertices) / 3
    assert 0.0 < swelling <= min(MOST_SWELLING, 0.01 * float(np.ptp(mesh.vertices, axis=0).max())) + 2e-9
    hull = mesh.vertices[ConvexHull(mesh.vertices).vertices]
    assert swelling == pytest.approx(max(distance_by_weights(p, hull) for p in piece), abs=2e-6)


def test_dense_meshes_take_memory_by_their_vertices(monkeypatch: pytest.MonkeyPatch) -> None:
    """A ball of 10242 vertices: all on the hull, whose swelling is known from the radii in and around it."""
    monkeypatch.setattr("humanoid_rail.geometry.simple_hull.NUMBERS", 2**18)
    ball = trimesh.creation.icosphere(5, 0.1)
    inner = float(np.einsum("fx,fx->f", ball.face_normals, ball.triangles[:, 0]).min())
    tracemalloc.start()
    hull = simple_hull(np.array(ball.vertices), MOST_SWELLING)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 3000 * len(ball.vertices)  # bytes; a matrix of vertices by planes takes 3600 for each
    assert len(hull.vertices) < 300
    planes = ConvexHull(hull.vertices).equations
    assert (ball.vertices @ planes[:, :3].T + planes[:, 3]).max() < 1e-12
    outer = float(np.linalg.norm(hull.vertices, axis=1).max())
    assert outer - 0.1 - 1e-9 <= hull.swelling <= min(outer - inner + 2e-9, MOST_SWELLING + 2e-9)


def test_the_order_in_the_file_does_not_matter(tmp_path: Path, rng: np.random.Generator) -> None:
    mesh, results = capsule(), []
    for _ in range(3):
        order = rng.permutation(len(mesh.vertices))
        faces = np.argsort(order)[mesh.faces][rng.permutation(len(mesh.faces))]
        results.append(mesh_hull(raw(mesh.vertices[order], np.roll(faces, 1, axis=1), tmp_path), 1.0))
    for result in results[1:]:
        np.testing.assert_array_equal(result.pieces[0], results[0].pieces[0])
        assert result.swelling == results[0].swelling


def test_small_convex_meshes_are_their_own_vertices(tmp_path: Path) -> None:
    mesh = trimesh.creation.icosphere(1, 0.1)
    bodies = mesh_hull(raw(mesh.vertices, mesh.faces, tmp_path), 1.0)
    np.testing.assert_array_equal(bodies.pieces[0], np.unique(mesh.vertices + 0.0, axis=0))
    assert bodies.swelling == 0.0
    assert bodies.hull_share == pytest.approx(1.0)
    hull = trimesh.Trimesh(bodies.pieces[0]).convex_hull
    again = mesh_hull(raw(hull.vertices, hull.faces, tmp_path), 1.0)
    np.testing.assert_array_equal(again.pieces[0], bodies.pieces[0])


def test_a_flat_mesh_gets_some_thickness(tmp_path: Path) -> None:
    vertices = trimesh.creation.icosphere(2, 0.1).vertices * (1.0, 1.0, 0.0) + (0.0, 0.3, 0.0)
    file = raw(vertices, trimesh.creation.icosphere(2).faces, tmp_path)
    for bodies in (mesh_hull(file, 1.0), mesh_pieces(file, 1.0)):
        (piece,) = bodies.pieces
        assert farthest_outside(vertices, [piece]) < 1e-12
        assert THICKENED <= bodies.swelling <= 2.1e-3
        assert bodies.hull_share == 1.0
        assert ConvexHull(piece).volume > 0.0
        hull = trimesh.convex.convex_hull(piece)
        (again,) = mesh_hull(raw(hull.vertices, hull.faces, tmp_path), 1.0).pieces
        assert farthest_outside(piece, [again]) < 1e-12


@pytest.mark.parametrize(("line", "where"), [((1.0, 0.0, 0.0), "on one line"), ((0.0, 0.0, 0.0), "at one point")])
@pytest.mark.parametrize("suffix", ["obj", "stl"])
def test_a_mesh_without_a_surface_is_refused(
    line: tuple[float, ...], where: str, suffix: str, tmp_path: Path, rng: np.random.Generator
) -> None:
    ball = trimesh.creation.icosphere(2, 0.1)
    vertices = ball.vertices * line @ trimesh.transformations.random_rotation_matrix(rng.random(3))[:3, :3] + 0.3
    file = written(trimesh.Trimesh(vertices, ball.faces, process=False), tmp_path, f"mesh.{suffix}")
    for bodies in (mesh_hull, mesh_pieces):
        with pytest.raises(ValueError, match=f"has a surface: all its vertices are {where}"):
            bodies(file, 1.0)


@pytest.mark.parametrize("junk", [np.zeros((5, 3)), np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]])])
def test_kept_bodies_that_are_flat_are_made_anew(junk: Points, cache: Path, tmp_path: Path) -> None:
    file = written(capsule(), tmp_path)
    first = mesh_hull(file, 1.0)
    (kept,) = cache.iterdir()
    np.savez(kept, np.array([[0.0, 1.0, 0.0]]), junk)
    np.testing.assert_array_equal(mesh_hull(file, 1.0).pieces[0], first.pieces[0])


def test_open_degenerate_and_scattered_meshes_have_a_hull(tmp_path: Path) -> None:
    box = trimesh.creation.box((0.1, 0.2, 0.3))
    vertices = np.vstack(
        [box.vertices, box.vertices + np.array((1.0, 0.0, 0.0)), [[9.0, 9.0, 9.0]]]
    )  # the last is not used
    faces = np.vstack([box.faces[:-1], box.faces + 8, [[0, 0, 0], [1, 1, 2]]])
    bodies = mesh_hull(raw(vertices, faces, tmp_path), 1.0)
    assert len(bodies.pieces[0]) == 8
    assert bodies.hull_share == 1.0


@pytest.mark.parametrize("suffix", ["stl", "obj", "dae", "ply", "glb"])
def test_five_formats_give_the_same_hull_scaled_and_mirrored(suffix: str, tmp_path: Path) -> None:
    mesh = trimesh.creation.box((0.5, 0.25, 0.125))
    mesh.apply_translation((1.0, 2.0, 3.0))
    file = written(mesh, tmp_path, f"mesh.{suffix}")
    if suffix == "dae":
        unit_of_file = '<unit name="half" meter="0.5"/><up_axis>Y_UP</up_axis></asset>'
        said = re.sub(r"<unit[^>]*/>|<up_axis>.*?</up_axis>", "", file.read_text()).replace("</asset>", unit_of_file)
        file.write_text(said)
    unit = 0.5 if suffix == "dae" else 1.0
    bodies = mesh_hull(file, (-1.0, 2.0, 1.0))
    expected = np.unique(mesh.vertices * unit * (-1.0, 2.0, 1.0), axis=0)
    np.testing.assert_allclose(bodies.pieces[0], expected, atol=1e-6)
    assert bodies.hull_share == pytest.approx(1.0)


def test_the_second_call_reads_no_mesh(cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = written(capsule(), tmp_path)
    first = mesh_hull(file, 1.0)
    (kept,) = cache.iterdir()
    with monkeypatch.context() as patched:
        patched.setattr(mesh_bodies, "read_triangles", None)
        again = mesh_hull(str(file), (1.0, 1.0, 1.0))
    np.testing.assert_array_equal(again.pieces[0], first.pieces[0])
    assert (again.swelling, again.hull_share) == (first.swelling, first.hull_share)
    kept.write_bytes(kept.read_bytes()[:100])
    np.testing.assert_array_equal(mesh_hull(file, 1.0).pieces[0], first.pieces[0])
    written(trimesh.creation.box(), tmp_path)
    assert len(mesh_hull(file, 1.0).pieces[0]) == 8
    assert len(mesh_hull(file, 2.0).pieces[0]) == 8
    assert len(list(cache.iterdir())) == 3


def test_without_a_cache_it_works(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "no_folder").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "no_folder"))
    assert len(mesh_hull(written(trimesh.creation.box(), tmp_path), 1.0).pieces[0]) == 8


@pytest.mark.parametrize("is_open", [False, True])
def test_pieces_contain_every_triangle(is_open: bool, tmp_path: Path, rng: np.random.Generator) -> None:
    mesh = ell()
    file = raw(mesh.vertices, mesh.faces[2:] if is_open else mesh.faces, tmp_path)
    bodies = mesh_pieces(file, 0.5)
    assert 1 < len(bodies.pieces) <= 30
    assert bodies.hull_share == (1.0 if is_open else pytest.approx(mesh.volume / mesh.convex_hull.volume))
    assert sum(ConvexHull(piece).volume for piece in bodies.pieces) < 0.8 * mesh.convex_hull.volume / 8.0
    corners = mesh.triangles[2:] if is_open else mesh.triangles
    weights = rng.dirichlet(np.ones(3), (200, len(corners)))
    points = np.vstack([corners.reshape(-1, 3), np.einsum("nmk,mkx->nmx", weights, corners).reshape(-1, 3)])
    assert farthest_outside(0.5 * points, bodies.pieces) < 1e-9


def test_pieces_of_a_solid_contain_its_inside_and_follow_its_hollow(rng: np.random.Generator) -> None:
    torus = trimesh.creation.torus(0.3, 0.08, 48, 24)
    torus.apply_transform(trimesh.transformations.rotation_matrix(0.7, (1, 2, 3), (0.1, 0, 0.4)))
    sets = plane_cuts(in_order(Triangles(torus.vertices, torus.faces)))
    points = rng.uniform(*torus.bounds, (3000, 3))
    assert farthest_outside(points[torus.contains(points)], sets) < 1e-9
    assert sum(ConvexHull(part).volume for part in sets) < 0.65 * torus.convex_hull.volume
    assert farthest_outside(torus.centroid[None], sets) > 0.1


def test_volumes_are_those_of_closed_meshes_alone() -> None:
    box = trimesh.creation.box((1.0, 2.0, 3.0))
    mesh = in_order(Triangles(box.vertices, box.faces))
    assert enclosed_volume(mesh) == pytest.approx(6.0)
    assert enclosed_volume(mesh._replace(faces=mesh.faces[1:])) is None


@pytest.mark.parametrize(
    ("said", "scale", "valid"),
    [
        ("", 1.0, "triangle mesh"),
        ("v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", 1.0, "finite vertices"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", (1.0, 0.0, 1.0), "other than 0"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", (1.0, 1.0), "one or three"),
        (None, 1.0, "can be read"),
    ],
)
def test_other_files_are_refused(said: str | None, scale: float, valid: str, tmp_path: Path) -> None:
    file = tmp_path / "mesh.obj"
    if said is not None:
        file.write_text(said)
    for bodies in (mesh_hull, mesh_pieces):
        with pytest.raises(ValueError, match=valid):
            bodies(file, scale)
