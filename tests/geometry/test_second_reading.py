"""Files of which one reader loses a part: they are read whole or refused, whatever they are used for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from humanoid_rail import InvalidInput, Mesh
from humanoid_rail.geometry.mesh_bodies import mesh_hull
from humanoid_rail.geometry.mesh_files import read_triangles
from humanoid_rail.geometry.second_reading import check_against_assimp
from validation import mesh_traps
from validation.mesh_traps import TRAPS, read_wrongly


@pytest.fixture
def parts() -> list[trimesh.Trimesh]:
    ball = trimesh.creation.icosphere(1, 0.3)
    return [trimesh.creation.box((1.0, 2.0, 3.0)), ball.apply_translation((3.0, 0.0, 0.0))]


REASONS = {
    "OBJ, indices from the end": r"trimesh reads 92 triangles from \(2\.7 .*assimp 92 triangles from \(-0\.5 .*STL",
    "OBJ, tabs": "trimesh reads 12 triangles.*assimp 92 triangles",
    "OBJ, indices from 0": "assimp fails .*[Ii]nvalid face index",
    "glTF, placed root": None,
    "glTF, sparse": "sparse accessors",
    "glTF, compressed": "KHR_draco_mesh_compression",
    "glTF, instanced": "EXT_mesh_gpu_instancing",
    "glTF, skinned": "skins",
    "glTF, morphed": "morph targets",
    "glTF, fan": "triangle fans",
    "DAE, controller": "<instance_controller>",
    "DAE, reference to nothing": "<instance_geometry> of something outside.*#nowhere",
    "STL, cut off": "92 triangles, which take 4684 bytes, and it has 3278 bytes",
    "STL as text, cut off": "endsolid",
    "PLY, cut off": "unexpected length",
    "PLY as text, cut off": "trimesh reads 89 triangles.*assimp",
    "OFF, cut off": "number of faces",
}


@pytest.mark.parametrize("name", TRAPS)
def test_all_of_a_file_is_read_or_it_is_refused(name: str, parts: list[trimesh.Trimesh], tmp_path: Path) -> None:
    trap, reason = TRAPS[name], REASONS[name]
    file = tmp_path / f"mesh.{trap.suffix}"
    file.write_bytes(trap.write(parts))
    if reason is None:
        read = read_triangles(str(file), z_up=False)
        assert len(read.faces) == 92
        np.testing.assert_allclose(read.corners.min(axis=(0, 1)), (-0.5, -1.0, -1.5), atol=1e-5)
        np.testing.assert_allclose(read.corners.max(axis=(0, 1)), (3.3, 1.0, 1.5), atol=1e-5)
        return
    with pytest.raises(ValueError, match=reason):
        mesh_hull(file, 1.0)
    with pytest.raises(InvalidInput, match=reason):
        Mesh(file=str(file), center=(0.0, 0.0, 0.0))


def test_traps_are_noticed_where_nothing_is_checked(
    parts: list[trimesh.Trimesh], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert list(read_wrongly(parts, tmp_path)) == []
    monkeypatch.setattr("humanoid_rail.geometry.mesh_files.check_against_assimp", lambda *_: None)
    monkeypatch.setattr("humanoid_rail.geometry.mesh_files.check_parts", lambda *_: None)
    missed = set(read_wrongly(parts, tmp_path))
    assert {"OBJ, indices from the end", "OBJ, tabs", "OBJ, indices from 0", "glTF, sparse", "glTF, skinned"} <= missed
    assert "glTF, placed root" not in missed


def test_what_differs_is_noticed(parts: list[trimesh.Trimesh], tmp_path: Path) -> None:
    whole = trimesh.util.concatenate(parts)
    whole.export(tmp_path / "whole.stl")
    file, vertices, faces = str(tmp_path / "whole.stl"), np.array(whole.vertices), np.array(whole.faces)
    check_against_assimp(file, vertices, faces)
    check_against_assimp(file, np.vstack([vertices, [[9.0, 9.0, 9.0]]]), faces)  # the last is not used
    moved = vertices.copy()
    moved[3, 1] += 1e-3
    for wrong in ((moved, faces), (vertices, faces[:-1]), (0.001 * vertices, faces), (vertices, faces[:12])):
        with pytest.raises(ValueError, match=r"92 triangles from \(-0\.5 -1 -1\.5\) to \(3\.3 1 1\.5\)\. One of them"):
            check_against_assimp(file, *wrong)


@pytest.mark.parametrize("suffix", ["obj", "ply", "off", "glb", "dae"])
def test_far_away_and_with_triangles_that_are_lines(suffix: str, tmp_path: Path) -> None:
    """Single precision, and triangles that assimp leaves out, are no reason to refuse a file."""
    ball = trimesh.creation.icosphere(2, 0.3).apply_translation((100.0, 0.0, 0.0))
    faces = np.vstack([ball.faces, [[0, 0, 1], [2, 2, 2]]])
    trimesh.Trimesh(ball.vertices, faces, process=False).export(tmp_path / f"ball.{suffix}")
    assert len(read_triangles(str(tmp_path / f"ball.{suffix}")).faces) >= len(ball.faces)


def test_lines_and_points_beside_triangles_are_no_part_of_a_body(tmp_path: Path) -> None:
    line = trimesh.load_path(np.array([[0.0, 0.0, 0.0], [5.0, 5.0, 5.0]]))
    trimesh.Scene([trimesh.creation.box((1.0, 2.0, 3.0)), line]).export(tmp_path / "box.glb")
    np.testing.assert_allclose(mesh_hull(tmp_path / "box.glb", 1.0).pieces[0].max(axis=0), (0.5, 1.0, 1.5))


def test_every_trap_has_two_parts(parts: list[trimesh.Trimesh]) -> None:
    assert set(REASONS) == set(TRAPS)
    assert mesh_traps.TRAPS["OBJ, tabs"].write(parts).count(b"f\t") == len(parts[1].faces)
