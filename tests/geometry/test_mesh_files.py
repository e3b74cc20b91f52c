"""Mesh files as people have them: split vertices, units, axes and references."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

from humanoid_rail import InvalidInput, Mesh
from humanoid_rail.geometry.mesh_files import Triangles, off_bytes, read_triangles
from humanoid_rail.geometry.solids import solids, volume

SIZE = (1.0, 2.0, 3.0)
"""Edges of the box in all files, m; with y up its height is the second one."""


def extents(file: Path, **fields: float) -> list[float]:
    (piece,) = Mesh(file=str(file), center=(0, 0, 0), **fields).pieces
    return np.ptp(piece, axis=0).round(6).tolist()


def hard_edges() -> trimesh.Trimesh:
    """A box whose vertices are split, with a normal for each of its sides."""
    mesh = trimesh.creation.box(SIZE)
    mesh.unmerge_vertices()
    return trimesh.Trimesh(
        mesh.vertices, mesh.faces, vertex_normals=np.repeat(mesh.face_normals, 3, axis=0), process=False
    )


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply", "off", "glb", "gltf", "dae", "3mf"])
def test_split_vertices_are_closed_in_every_format(suffix: str, tmp_path: Path) -> None:
    if suffix == "3mf":
        pytest.importorskip("networkx")
    file = tmp_path / f"box.{suffix}"
    mesh = hard_edges()
    if suffix == "gltf":
        for name, content in trimesh.exchange.gltf.export_gltf(trimesh.Scene(mesh)).items():
            (tmp_path / ("box.gltf" if name.endswith(".gltf") else name)).write_bytes(content)
    else:
        mesh.export(
            file,
            **({"include_normals": True} if suffix == "obj" else {"vertex_normal": True} if suffix == "ply" else {}),
        )
    y_is_up = suffix in ("glb", "gltf", "dae")
    assert extents(file) == ([1.0, 3.0, 2.0] if y_is_up else [1.0, 2.0, 3.0])


OBJ = """
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
vt 0 0
vt 1 0
vt 0 1
vn 0 0 -1
vn 0 -1 0
vn -1 0 0
vn 1 1 1
f 1/1/1 3/2/1 2/3/1
f 1/1/2 2/2/2 4/3/2
f 1/1/3 4/2/3 3/3/3
f 2/1/4 3/2/4 4/3/4
"""


@pytest.mark.parametrize("simplify", [lambda face: face, lambda face: face.replace("/1 ", " ")])
def test_obj_with_normals_and_textures(simplify: Callable[[str], str], tmp_path: Path) -> None:
    (tmp_path / "tetrahedron.obj").write_text(OBJ)
    (solid,) = solids(read_triangles(str(tmp_path / "tetrahedron.obj")))
    assert volume(solid) == pytest.approx(1 / 6)


@pytest.mark.parametrize(
    ("axis", "expected"),
    [("X_UP", [2.0, 3.0, 1.0]), ("Y_UP", [1.0, 3.0, 2.0]), ("Z_UP", [1.0, 2.0, 3.0]), (None, [1.0, 3.0, 2.0])],
)
@pytest.mark.parametrize("unit", [None, 1.0, 0.01])
def test_collada_says_its_unit_and_axis(
    axis: str | None, expected: list[float], unit: float | None, tmp_path: Path
) -> None:
    trimesh.creation.box(SIZE).export(tmp_path / "box.dae")
    text = (tmp_path / "box.dae").read_text()
    begin, end = text.index("<up_axis>"), text.index("</asset>")
    said = f"<up_axis>{axis}</up_axis>" if axis else ""
    measure = f'<unit name="u" meter="{unit}"/>' if unit else ""
    (tmp_path / "box.dae").write_text(text[:begin] + measure + said + text[end:])
    assert extents(tmp_path / "box.dae") == [(unit or 1.0) * x for x in expected]


def test_what_is_up_in_a_file_is_up_in_the_scene(tmp_path: Path) -> None:
    """A cone, whose point is where its file's up axis points."""
    for suffix, up in (("stl", 2), ("glb", 1), ("dae", 1)):
        cone = trimesh.creation.cone(0.2, 1.0, sections=8)
        cone.vertices = np.roll(cone.vertices, up - 2, axis=1)
        cone.export(tmp_path / f"cone.{suffix}")
        (piece,) = Mesh(file=str(tmp_path / f"cone.{suffix}"), center=(0, 0, 0)).pieces
        np.testing.assert_allclose(piece[piece[:, 2].argmax()], [0.0, 0.0, 1.0], atol=1e-6)


def test_parts_of_a_file_are_where_its_nodes_put_them(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    for x, factor in ((2.0, 1.0), (-2.0, -1.0)):
        place = np.diag([factor, 1.0, 1.0, 1.0])  # one is mirrored, which turns its triangles
        place[0, 3] = x
        scene.add_geometry(trimesh.creation.box((1.0, 1.0, 1.0)), transform=place)
    scene.export(tmp_path / "two.glb")
    pieces = Mesh(file=str(tmp_path / "two.glb"), center=(0, 0, 0)).pieces
    assert sorted(piece[:, 0].mean().round(6) for piece in pieces) == [-2.0, 2.0]


def test_five_plates_of_a_bin_need_no_cutting(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from humanoid_rail.geometry import convex_decomposition

    monkeypatch.setattr(convex_decomposition, "decompose", None)
    plates = [((1.0, 1.0, 0.1), (0.0, 0.0, 0.05))]
    plates += [((0.1, 1.0, 0.5), (x, 0.0, 0.35)) for x in (-0.45, 0.45)]
    plates += [((0.8, 0.1, 0.5), (0.0, y, 0.35)) for y in (-0.45, 0.45)]
    translation = trimesh.transformations.translation_matrix
    bin_of_plates = [trimesh.creation.box(size, transform=translation(at)) for size, at in plates]
    for suffix in ("stl", "obj", "ply"):
        trimesh.util.concatenate(bin_of_plates).export(tmp_path / f"bin.{suffix}")
        assert len(Mesh(file=str(tmp_path / f"bin.{suffix}"), center=(0, 0, 0)).pieces) == 5


def test_a_mesh_in_millimetres_gives_a_hint(tmp_path: Path) -> None:
    trimesh.creation.box((400.0, 300.0, 200.0)).export(tmp_path / "bin.stl")
    with pytest.warns(UserWarning, match=r"bin\.stl is 400 m large.*scale 0\.001"):
        extents(tmp_path / "bin.stl")
    assert extents(tmp_path / "bin.stl", scale=0.001) == [0.4, 0.3, 0.2]


def test_a_file_without_the_one_that_it_refers_to_is_refused(tmp_path: Path) -> None:
    files = trimesh.exchange.gltf.export_gltf(trimesh.Scene(trimesh.creation.box()))
    (tmp_path / "box.gltf").write_bytes(files["model.gltf"])
    with pytest.raises(InvalidInput, match=r"gltf_buffer_0\.bin"):
        extents(tmp_path / "box.gltf")


def test_off_holds_triangles_without_loss(rng: np.random.Generator, tmp_path: Path) -> None:
    triangles = Triangles(rng.normal(size=(30, 3)) / 3.0, rng.integers(0, 30, (40, 3)))
    (tmp_path / "mesh.off").write_bytes(off_bytes(triangles))
    again = read_triangles(str(tmp_path / "mesh.off"))
    np.testing.assert_array_equal(again.corners, triangles.corners)
