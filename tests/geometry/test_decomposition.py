"""Decompositions end when they have to, and are kept; what they leave out is noticed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from itertools import count
from pathlib import Path

import numpy as np
import psutil
import pytest
import trimesh

from humanoid_rail import InvalidInput, Mesh
from humanoid_rail.geometry import convex_decomposition, decomposition
from humanoid_rail.geometry.coverage import farthest_outside, points_in, points_on, winding_numbers
from humanoid_rail.geometry.decomposition import cache_folder, decompose
from humanoid_rail.geometry.mesh_files import Triangles

ENDLESS = """
import trimesh
from humanoid_rail.geometry.decomposition import decompose
from humanoid_rail.geometry.mesh_files import Triangles
inner = trimesh.creation.box((0.5, 0.5, 0.5))
inner.invert()
mesh = trimesh.util.concatenate([trimesh.creation.box((1, 1, 1)), inner])
"""
"""CoACD never comes to an end with a cube inside a cube."""


def ell() -> Triangles:
    upright, foot = trimesh.creation.box((0.2, 0.4, 1.0)), trimesh.creation.box((1.0, 0.4, 0.2))
    foot.apply_translation((0.4, 0.0, -0.4))
    mesh = trimesh.boolean.union([upright, foot], engine="manifold")
    return Triangles(np.array(mesh.vertices), np.array(mesh.faces))


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return cache_folder()


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGKILL])
def test_an_interrupt_ends_a_decomposition_and_its_process(sent: signal.Signals, tmp_path: Path) -> None:
    program = f"{ENDLESS}\ndecompose(Triangles(mesh.vertices, mesh.faces), 'mesh')"
    environment = {**os.environ, "TMPDIR": str(tmp_path)}  # one that is killed leaves its temporary files
    with subprocess.Popen(
        [sys.executable, "-c", program], stderr=subprocess.PIPE, text=True, env=environment
    ) as process:
        children: list[psutil.Process] = []
        while not children and process.poll() is None:
            children = psutil.Process(process.pid).children()
        process.send_signal(sent)
        assert process.stderr is not None
        said = process.stderr.read()
    assert len(children) == 1, said
    psutil.wait_procs(children)
    assert sent == signal.SIGKILL or said.rstrip().endswith("KeyboardInterrupt")
    assert process.returncode == -sent


def test_a_decomposition_has_a_budget(cache: Path) -> None:
    names: dict[str, trimesh.Trimesh] = {}
    exec(ENDLESS, names)
    mesh = names["mesh"]
    with pytest.raises(ValueError, match="within 1 s of processor time: one of fewer triangles"):
        decompose(Triangles(np.array(mesh.vertices), np.array(mesh.faces)), "mesh", budget=1)
    assert not list(cache.glob("*"))


def test_results_are_kept_and_damaged_ones_made_anew(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = count()
    run = decomposition._run
    monkeypatch.setattr(decomposition, "_run", lambda *arguments: (next(made), run(*arguments))[1])
    first = decompose(ell(), "ell")
    assert len(first) >= 2
    (file,) = cache.glob("*")
    content = file.read_bytes()
    for pieces in (decompose(ell(), "another name"), decompose(ell(), "ell")):
        assert all(map(np.array_equal, pieces, first))
    assert next(made) == 1
    for damaged in (b"", content[: len(content) // 2], b"no archive"):
        file.write_bytes(damaged)
        assert all(map(np.array_equal, decompose(ell(), "ell"), first))
        assert file.read_bytes() != damaged
    assert next(made) == 5
    scaled = ell()
    decompose(scaled._replace(vertices=2.0 * scaled.vertices), "ell")
    assert next(made) == 7


def test_without_a_folder_for_the_cache_it_works(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    monkeypatch.setattr(decomposition, "_run", lambda solid, name, budget: [solid.vertices])
    assert len(decompose(ell(), "ell")) == 1


def test_pieces_that_leave_something_out_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The walls without the inside, and a part without the rest."""
    from scipy.spatial import ConvexHull

    solid = ell()
    trimesh.Trimesh(*solid).export(tmp_path / "ell.stl")
    inner = solid._replace(vertices=0.98 * (solid.vertices - solid.vertices.mean(axis=0)) + solid.vertices.mean(axis=0))
    walls = [np.vstack([solid.corners[i], inner.corners[i]]) for i in range(len(solid.faces))]
    assert all(ConvexHull(wall).volume > 0 for wall in walls)
    for pieces in (walls, [solid.vertices[solid.vertices[:, 0] < 0.2]]):
        monkeypatch.setattr(convex_decomposition, "decompose", lambda *_, pieces=pieces: pieces)
        with pytest.raises(InvalidInput, match=r"leave out points up to 0\.\d+ m deep") as caught:
            Mesh(file=str(tmp_path / "ell.stl"), center=(0, 0, 0))
        assert caught.value.field == "file"


def test_inside_and_outside_by_winding_numbers(rng: np.random.Generator) -> None:
    solid = ell()
    points = rng.uniform(-1.0, 1.0, (500, 3))
    boxes = np.array([[[-0.1, -0.2, -0.5], [0.1, 0.2, 0.5]], [[-0.1, -0.2, -0.5], [0.9, 0.2, -0.3]]])
    inside = np.any([((low < points) & (points < high)).all(axis=1) for low, high in boxes], axis=0)
    np.testing.assert_allclose(winding_numbers(points, solid), inside, atol=1e-9)
    corners = [np.array(np.meshgrid(*box.T)).reshape(3, -1).T for box in boxes]
    looked_at = np.vstack([points_in(solid, rng), points_on(solid, rng)])
    assert farthest_outside(looked_at, corners) < 1e-7  # the boolean operation is in single precision
    assert farthest_outside(looked_at, corners[:1]) == pytest.approx(0.8, rel=1e-6)
    assert farthest_outside(np.array([[-0.1, 0.0, 0.9]]), corners) == pytest.approx(0.4)


def test_a_file_that_changes_is_read_again(tmp_path: Path) -> None:
    file = tmp_path / "box.stl"
    for size in (1.0, 2.0):
        trimesh.creation.box((size, size, size)).export(file)
        os.utime(file, (size, size))
        assert np.ptp(Mesh(file=str(file), center=(0, 0, 0)).pieces[0]) == size
