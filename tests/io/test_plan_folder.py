"""Plan folders hold all that a plan needs."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
import trimesh
from conftest import AHEAD, plan

from humanoid_rail import Box, InvalidInput, Mesh, Robot, Scene, Trajectory, verify
from humanoid_rail.io.plan_folder import read_plan, write_plan


@pytest.fixture(scope="module")
def motion(robot: Robot) -> Trajectory:
    return plan(robot, Scene(name="mesh", targets=AHEAD), "gradient-projection", dt=0.1)


def write_mesh(folder: Path, suffix: str, size: float = 1.0) -> Path:
    """Write a mesh of two parts with material and texture coordinates, in a file of a format with all it refers to."""
    folder.mkdir(exist_ok=True)
    parts = [trimesh.creation.icosphere(2, radius=0.3 * size), trimesh.creation.box((size / 3, size / 7, 1.0))]
    parts[1].apply_translation((2.0 * size / 3, 0.1, 0.2))
    scene = trimesh.Scene(parts)
    if suffix == "gltf":
        for name, content in trimesh.exchange.gltf.export_gltf(scene).items():
            (folder / name.replace("model", "part")).write_bytes(content)
    elif suffix in ("glb", "obj"):
        scene.export(folder / f"part.{suffix}")
    else:
        scene.to_mesh().export(folder / f"part.{suffix}")
    return folder / f"part.{suffix}"


@pytest.mark.parametrize("suffix", ["gltf", "glb", "obj", "dae", "stl", "ply", "off"])
def test_meshes_are_read_back_where_nothing_else_is_left(
    suffix: str, robot: Robot, motion: Trajectory, tmp_path: Path
) -> None:
    file = write_mesh(tmp_path / "parts", suffix)
    mesh = Mesh(file=str(file), center=(-6.0, 3.0, 3.0), rpy=(0.1, 0.2, -0.3), scale=(1.0, 0.5, 2.0))
    scene = Scene(name="mesh", targets=AHEAD, obstacles=(Box(center=(5.0, 0.0, 0.0), size=(1.0, 1.0, 1.0)), mesh))
    write_plan(motion, robot, scene, tmp_path / "out")
    shutil.rmtree(tmp_path / "parts")
    (tmp_path / "out").rename(tmp_path / "elsewhere")
    found = read_plan(tmp_path / "elsewhere")
    again = found.scene.obstacles[1]
    assert isinstance(again, Mesh)
    assert len(again.pieces) == 2
    for piece, other in zip(again.pieces, mesh.pieces, strict=True):
        np.testing.assert_array_equal(piece, other)
    assert verify(robot, found.scene, motion) == verify(robot, scene, motion)
    assert len(list((tmp_path / "elsewhere").glob("mesh-*"))) == 1


@pytest.mark.parametrize("suffix", ["gltf", "stl"])
def test_a_mesh_that_has_changed_or_gone_is_refused(
    suffix: str, robot: Robot, motion: Trajectory, tmp_path: Path
) -> None:
    mesh = Mesh(file=str(write_mesh(tmp_path / "parts", suffix)), center=(-6.0, 3.0, 3.0))
    scene = Scene(name="mesh", targets=AHEAD, obstacles=(mesh,))
    write_mesh(tmp_path / "parts", suffix, size=2.0)
    for valid in ("has not changed", "still there"):
        with pytest.raises(InvalidInput, match=valid) as caught:
            write_plan(motion, robot, scene, tmp_path / "out")
        assert caught.value.field == "obstacles[0].file"
        assert not (tmp_path / "out").exists()
        shutil.rmtree(tmp_path / "parts", ignore_errors=True)
