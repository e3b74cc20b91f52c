"""Meshes in scenes: their files, and the convex pieces that they become."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_scene import VALID

from humanoid_rail import InvalidInput, Kinematics, Mesh, Robot, load_scene, make_scene


def mesh_scene(**fields: Any) -> dict[str, Any]:
    return {**VALID, "obstacles": [{"type": "mesh", "center": [0, 0, 1], **fields}]}


def test_mesh_files_are_relative_to_the_scene_file(tmp_path: Path, cube_file: str) -> None:
    (tmp_path / "part.stl").write_bytes(Path(cube_file).read_bytes())
    (tmp_path / "scene.json").write_text(json.dumps(mesh_scene(file="part.stl", scale=0.5)))
    mesh = load_scene(tmp_path / "scene.json").obstacles[0]
    assert isinstance(mesh, Mesh)
    (vertices,) = mesh.pieces
    np.testing.assert_allclose([vertices.min(axis=0), vertices.max(axis=0)], [3 * [-0.25], 3 * [0.25]])
    scaled = make_scene(mesh_scene(file=cube_file, scale=[1, 2, 3])).obstacles[0]
    np.testing.assert_allclose(np.ptp(scaled.pieces[0], axis=0), [1, 2, 3])


def test_meshes_that_cannot_be_used(tmp_path: Path, cube_file: str) -> None:
    import trimesh

    cube = trimesh.load_mesh(cube_file)
    trimesh.Trimesh(cube.vertices, cube.faces[:-1]).export(tmp_path / "open.stl")
    (tmp_path / "text.stl").write_text("not a mesh")
    (tmp_path / "empty.obj").write_text("")
    (tmp_path / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n")
    for fields, field in [
        ({"file": "none.stl"}, "file"),
        ({"file": "text.stl"}, "file"),
        ({"file": "empty.obj"}, "file"),
        ({"file": "open.stl"}, "file"),
        ({"file": "flat.obj"}, "file"),
        ({"file": "a" * 5000}, "file"),
        ({"file": "\0"}, "file"),
        ({"file": cube_file, "scale": [1, 1, 1e-9]}, "file"),
        ({"file": cube_file, "scale": 1e-300}, "file"),
        ({"file": "."}, "file"),
        ({"file": 3}, "file"),
        ({"file": cube_file, "scale": -1}, "scale"),
        ({"file": cube_file, "scale": [1, 1]}, "scale"),
        ({"file": cube_file, "scale": "big"}, "scale"),
    ]:
        with pytest.raises(InvalidInput) as caught:
            make_scene(mesh_scene(**fields), folder=tmp_path)
        assert caught.value.field == f"obstacles[0].{field}", fields


def test_scenes_pickle_and_compare(cube_file: str) -> None:
    scene = make_scene(mesh_scene(file=cube_file))
    again = pickle.loads(pickle.dumps(scene))
    assert again == scene
    np.testing.assert_array_equal(again.obstacles[0].pieces[0], scene.obstacles[0].pieces[0])


def test_a_hollow_mesh_becomes_pieces_that_leave_the_hollow_free(tmp_path: Path, robot: Robot) -> None:
    """A bin open at the top: its pieces cover the walls and not the room inside."""
    import trimesh

    inner = trimesh.creation.box((0.9, 0.9, 0.6), transform=trimesh.transformations.translation_matrix([0, 0, 0.05]))
    bin_mesh = trimesh.boolean.difference([trimesh.creation.box((1.0, 1.0, 0.6)), inner], engine="manifold")
    bin_mesh.export(tmp_path / "bin.stl")
    q = robot.initial
    hand = Kinematics(robot).hand_positions(q)[0]
    below = hand - [0.0, 0.0, 0.1]
    mesh = Mesh(file=str(tmp_path / "bin.stl"), center=below)
    assert len(mesh.pieces) >= 5
    volume = sum(trimesh.convex.convex_hull(piece).volume for piece in mesh.pieces)
    assert bin_mesh.volume * 0.999 <= volume <= 1.1 * bin_mesh.volume
    for wall in (np.array([0.475, 0.1, 0.0]), np.array([0.0, 0.0, -0.275]), np.array([-0.2, -0.475, 0.2])):
        inside = [trimesh.convex.convex_hull(p).contains([wall])[0] for p in mesh.pieces]
        assert any(inside), wall
    assert not any(trimesh.convex.convex_hull(p).contains([[0.0, 0.0, 0.0]])[0] for p in mesh.pieces)
