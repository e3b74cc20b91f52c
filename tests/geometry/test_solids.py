"""Meshes of several parts: what is enclosed is solid, however the file puts it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from humanoid_rail import InvalidInput, Kinematics, Mesh, NativeKinematics, Robot
from humanoid_rail.geometry.mesh_files import Triangles
from humanoid_rail.geometry.solids import solids, volume


def box(center: Any = (0.0, 0.0, 0.0), size: Any = 1.0, inwards: bool = False) -> trimesh.Trimesh:
    place = trimesh.transformations.translation_matrix(center)
    mesh = trimesh.creation.box(np.broadcast_to(size, 3), transform=place)
    if inwards:
        mesh.invert()
    return mesh


def triangles(*parts: trimesh.Trimesh) -> Triangles:
    """The parts as one mesh, each vertex once for each triangle that it is of, as an STL has it."""
    soup = np.vstack([part.triangles for part in parts]).reshape(-1, 3)
    return Triangles(soup, np.arange(len(soup)).reshape(-1, 3))


def volumes(mesh: Triangles) -> list[float]:
    return sorted(round(volume(solid), 9) for solid in solids(mesh))


@pytest.mark.parametrize("inwards", [False, True])
@pytest.mark.parametrize("other", [(3.0, 0.0, 0.0), (1.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.3, 0.2, 0.1)])
def test_parts_face_outwards_whether_or_not_they_touch(other: tuple[float, ...], inwards: bool) -> None:
    """Parts that are apart, share an edge, share a face, cross."""
    found = volumes(triangles(box(), box(other, inwards=inwards)))
    assert found == ([2.0] if other == (1.0, 0.0, 0.0) else [1.0, 1.0])


def test_triangles_that_face_another_way_or_come_twice() -> None:
    mesh = triangles(box())
    turned = mesh.faces.copy()
    turned[[2, 7]] = turned[[2, 7], ::-1]
    assert volumes(mesh._replace(faces=turned)) == [1.0]
    assert volumes(mesh._replace(faces=np.vstack([mesh.faces, turned]))) == [1.0]
    # A wall between two boxes that both have, with the same diagonal.
    middle = np.array([[0.5, -0.5, -0.5], [0.5, 0.5, -0.5], [0.5, 0.5, 0.5], [0.5, -0.5, 0.5]])
    walls = [middle[[0, 1, 2]], middle[[0, 2, 3]]]
    sides = [b.triangles[~np.isclose(b.triangles[:, :, 0], 0.5).all(axis=1)] for b in (box(), box((1.0, 0.0, 0.0)))]
    soup = np.vstack([*sides, walls, walls]).reshape(-1, 3)
    assert sum(volumes(Triangles(soup, np.arange(len(soup)).reshape(-1, 3)))) == pytest.approx(2.0)


def test_triangles_without_area() -> None:
    cube = box()
    a, b = cube.edges_unique[0]
    middle = len(cube.vertices)
    vertices = np.vstack([cube.vertices, cube.vertices[[a, b]].mean(axis=0)])
    for lines in ([[a, a, b]], [[a, middle, b]], [[a, middle, b], [a, middle, b]]):
        found = volumes(Triangles(vertices, np.vstack([cube.faces, lines])))
        assert [size for size in found if size] == [1.0]
    # In single precision a line has an area.
    single = np.round(vertices * 7.3, 6)
    assert len(solids(Triangles(single, np.vstack([cube.faces, [[a, middle, b]]])))) == 1
    # One that closes the gap without width between an edge and its two halves belongs to the surface.
    (first, *_) = (k for k, face in enumerate(cube.faces) if {a, b} <= set(face))
    (c,) = set(cube.faces[first]) - {a, b}
    halves = np.array([[a, middle, c], [middle, b, c], [a, middle, b]])
    assert volumes(Triangles(vertices, np.vstack([np.delete(cube.faces, first, axis=0), halves]))) == [1.0]


def test_vertices_that_differ_by_rounding_are_one() -> None:
    mesh = triangles(box((5.0, 2.0, 1.0)))
    noise = np.random.default_rng(1).normal(0.0, 1e-8, mesh.vertices.shape)
    (solid,) = solids(mesh._replace(vertices=mesh.vertices + noise))
    assert volume(solid) == pytest.approx(1.0, abs=1e-6)


def test_open_meshes_say_how_many_edges_are_open_and_where() -> None:
    mesh = triangles(box((5.0, 2.0, 1.0)), box())
    with pytest.raises(ValueError, match=r"closed.* 3 edges are open, one of them at \(\S+, \S+, \S+\)") as caught:
        solids(mesh._replace(faces=mesh.faces[1:]))
    where = np.array(str(caught.value).split("(")[-1].rstrip(")").split(","), float)
    assert abs(where - [5.0, 2.0, 1.0]).max() == pytest.approx(0.5)


def test_a_hand_in_a_part_that_faces_inwards_touches_it(tmp_path: Path, robot: Robot) -> None:
    hand = Kinematics(robot).hand_positions(robot.initial)[0]
    file = tmp_path / "two.stl"
    trimesh.util.concatenate([box((3.0, 0.0, 0.0)), box(size=0.5, inwards=True)]).export(file)
    psi = NativeKinematics(robot, (Mesh(file=str(file), center=hand),)).measure(robot.initial).clearance
    assert psi.min() < -0.2


def test_cavities_are_solid_and_parts_inside_others_no_pieces(tmp_path: Path) -> None:
    trimesh.util.concatenate([box(), box(size=0.5, inwards=True)]).export(tmp_path / "hollow.stl")
    (piece,) = Mesh(file=str(tmp_path / "hollow.stl"), center=(0, 0, 0)).pieces
    np.testing.assert_allclose(abs(piece), 0.5)


def test_a_sheet_beside_a_solid_is_not_lost(tmp_path: Path) -> None:
    sheet = trimesh.Trimesh([[2, 0, 0], [3, 0, 0], [2, 1, 0]], [[0, 1, 2], [2, 1, 0]])
    trimesh.util.concatenate([box(), sheet]).export(tmp_path / "sheet.off")
    with pytest.raises(InvalidInput, match=r"2\.5 m outside"):
        Mesh(file=str(tmp_path / "sheet.off"), center=(0, 0, 0))
