"""Robots whose visual bodies are meshes: in the picture, with their size, place and colours."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import trimesh
from conftest import AHEAD, plan
from pages import commands

from humanoid_rail import Robot, Scene, build_urdf
from humanoid_rail.geometry.mesh_names import find_mesh
from humanoid_rail.model.humanoid import paper_robot
from humanoid_rail.viewer.forms import Group
from humanoid_rail.viewer.playback import playback_html
from humanoid_rail.viewer.visual_meshes import draw_visuals, robot_visuals

RED, BLUE = (255, 0, 0, 255), (0, 0, 255, 128)


def robot_with(name: str, attributes: str = "", material: str = "") -> Robot:
    """The paper's robot with a mesh as the only visual body of its chest, turned and moved."""
    urdf = build_urdf()
    at = urdf.index('<link name="chest">') + len('<link name="chest">')
    origin = '<origin xyz="0.1 0.2 0.3" rpy="0 0 1.5707963267948966"/>'
    visual = f'<visual>{origin}<geometry><mesh filename="{name}" {attributes}/></geometry>{material}</visual>'
    return paper_robot(urdf[:at] + visual + urdf[at:])


class Recorder:
    """Takes what is drawn, by path."""

    def __init__(self, drawn: dict[str, Any], path: str = "") -> None:
        self.drawn, self.path = drawn, path

    def __getitem__(self, path: str) -> Recorder:
        return Recorder(self.drawn, f"{self.path}/{path}")

    def set_object(self, geometry: Any, material: Any = None) -> None:
        self.drawn[self.path] = geometry, material

    def set_transform(self, T: np.ndarray) -> None:
        self.drawn[f"{self.path} at"] = T


def drawn(robot: Robot) -> list[tuple[Any, Any]]:
    found: dict[str, Any] = {}
    draw_visuals(Recorder(found), robot_visuals(robot))
    (place,) = {path.rsplit("/", 1)[0] for path, it in found.items() if isinstance(it, tuple) and "chest_0/" in path}
    T = found[f"{place} at"]
    np.testing.assert_allclose(T, [[0, -1, 0, 0.1], [1, 0, 0, 0.2], [0, 0, 1, 0.3], [0, 0, 0, 1]], atol=1e-9)
    return [it for path, it in found.items() if path.startswith(f"{place}/")]


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply", "glb", "dae"])
def test_meshes_of_every_format_are_drawn(suffix: str, tmp_path: Path) -> None:
    trimesh.creation.box((1.0, 2.0, 3.0)).export(tmp_path / f"box.{suffix}")
    if suffix == "dae":
        text = (tmp_path / "box.dae").read_text()
        (tmp_path / "box.dae").write_text(text.replace("<up_axis>", '<unit meter="0.5"/><up_axis>'))
    ((geometry, _),) = drawn(robot_with(str(tmp_path / f"box.{suffix}"), 'scale="1 10 0.1"'))
    expected = np.array([1.0, 20.0, 0.3]) * (0.5 if suffix == "dae" else 1.0)
    np.testing.assert_allclose(np.ptp(geometry.vertices, axis=0), expected, rtol=1e-6)
    assert len(geometry.faces) == 12


def test_colours_are_those_of_the_urdf_or_else_of_the_file(tmp_path: Path) -> None:
    parts = [
        trimesh.creation.box(),
        trimesh.creation.box(transform=trimesh.transformations.translation_matrix([2, 0, 0])),
    ]
    for part, colour in zip(parts, (RED, BLUE), strict=True):
        part.visual = trimesh.visual.ColorVisuals(part, face_colors=[colour] * 12)
    trimesh.util.concatenate(parts).export(tmp_path / "two.ply")
    file = str(tmp_path / "two.ply")
    ((geometry, material),) = drawn(robot_with(file))
    assert material.vertexColors
    is_red = geometry.vertices[:, 0] < 1.0
    np.testing.assert_allclose(geometry.color, np.where(is_red[:, None], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]))
    ((_, material),) = drawn(robot_with(file, material='<material name="m"><color rgba="0 1 0 0.5"/></material>'))
    assert (material.color, material.opacity, material.vertexColors) == (0x00FF00, 0.5, False)
    trimesh.Scene(parts).export(tmp_path / "two.glb")
    both = drawn(robot_with(str(tmp_path / "two.glb")))
    assert sorted(len(geometry.faces) for geometry, _ in both) == [12, 12]


def test_a_page_holds_the_mesh(tmp_path: Path) -> None:
    trimesh.creation.icosphere(2, radius=0.3).export(tmp_path / "ball.stl")
    robot = robot_with(str(tmp_path / "ball.stl"))
    scene = Scene(name="mesh", targets=AHEAD)
    page = playback_html(robot, scene, plan(robot, scene, "gradient-projection", dt=0.1))
    (ball,) = [c for c in commands(page) if "chest_0" in c["path"] and c["type"] == "set_object"]
    attributes = ball["object"]["geometries"][0]["data"]["attributes"]
    vertices = np.frombuffer(attributes["position"]["array"].data, np.float32).reshape(-1, 3)
    np.testing.assert_allclose(np.linalg.norm(vertices, axis=1), 0.3, rtol=1e-6)
    assert str(tmp_path) not in page


def test_names_of_meshes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    places = ["one/parts/a.stl", "two/share/tools/b.stl", "here/arms/c.stl", "parts own/d.stl"]
    for place in places:
        (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / place).touch()
    a, b, c, d = (tmp_path / place for place in places)
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{tmp_path / 'one'}:{tmp_path / 'parts own'}")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "two"))
    monkeypatch.chdir(tmp_path / "here")
    for name, file in [
        ("package://parts/a.stl", a),
        ("package://tools/b.stl", b),
        ("model://tools/b.stl", b),
        ("package://arms/c.stl", c),
        ("package://parts own/d.stl", d),
        (f"package:///{str(d).lstrip('/')}", d),
        (f"file://{str(d).replace(' ', '%20')}", d),
        ("arms/c.stl", c),
        (str(a), a),
    ]:
        assert find_mesh("body", name) == file
    assert find_mesh("body", "parts/a.stl", tmp_path / "one") == a


@pytest.mark.parametrize(
    "name", ["package://parts/none.stl", "none.stl", "http://parts/a.stl", "", "a" * 5000, "a.stl"]
)
def test_meshes_that_are_not_there_or_are_none(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.stl").write_text("no mesh")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "packages"))
    monkeypatch.chdir(tmp_path)
    expected = {"a.stl": "holds a triangle mesh", "package://parts/none.stl": str(tmp_path / "packages/parts/none.stl")}
    found: dict[str, Any] = {}
    robot = robot_with(name)
    with pytest.warns(UserWarning, match=r"^link chest\.visual") as warned:
        draw_visuals(Recorder(found), robot_visuals(robot))
    assert expected.get(name, "looked at: ") in str(warned[0].message)
    shapes = [type(drawn[0]).__name__ for path, drawn in found.items() if "chest_" in path and not path.endswith(" at")]
    assert shapes  # the capsule of the chest


def test_the_paper_s_robot_is_drawn_as_pinocchio_has_it(robot: Robot) -> None:
    found: dict[str, Any] = {}
    draw_visuals(Recorder(found), robot_visuals(robot))
    visual = pin.buildGeomFromUrdfString(robot.model, robot.urdf, pin.GeometryType.VISUAL)
    assert len(found) == visual.ngeoms
    assert all(isinstance(drawn, Group) for drawn, _ in found.values())
