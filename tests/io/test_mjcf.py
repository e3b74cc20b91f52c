"""The model of the export to MuJoCo, in MuJoCo: the same kinematics, dynamics and contacts."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import pytest
from mjcf_models import compiled, mujoco, nothing, other_robot, placed, still, text_of

from humanoid_rail import (
    Box,
    Capsule,
    HalfSpace,
    InvalidInput,
    Mesh,
    Robot,
    Scene,
    Sphere,
    Trajectory,
    load_robot,
    robot_from_urdf,
)


@pytest.fixture(scope="module")
def other() -> Robot:
    return other_robot()


def names(model: Any, pairs: Any) -> set[frozenset[str]]:
    return {frozenset(model.geom(int(i)).name for i in pair) for pair in pairs}


@pytest.mark.parametrize("which", ["robot", "other"])
def test_frames_are_pinocchios(
    which: str, motion: Trajectory, rng: np.random.Generator, request: pytest.FixtureRequest
) -> None:
    robot = request.getfixturevalue(which)
    model = compiled(robot, nothing(robot), still(robot, motion, robot.initial))
    joints = [model.joint(i).name for i in range(model.njnt)]
    assert joints == list(robot.model.names)[1:]
    data = robot.model.createData()
    for _ in range(20):
        q = robot.full_configuration(rng.uniform(robot.lower, robot.upper))
        pin.framesForwardKinematics(robot.model, data, q)
        simulated = placed(model, q)
        for index, frame in enumerate(robot.model.frames):
            if frame.type == pin.FrameType.BODY:
                body = simulated.body(frame.name)
                np.testing.assert_allclose(body.xpos, data.oMf[index].translation, atol=1e-9)
                np.testing.assert_allclose(body.xmat.reshape(3, 3), data.oMf[index].rotation, atol=1e-9)
        for hand in robot.hands:
            at = data.oMf[robot.model.getFrameId(hand.frame)]
            site = simulated.site(f"{hand.name}_hand")
            np.testing.assert_allclose(site.xpos, at.translation, atol=1e-9)
            np.testing.assert_allclose(site.xmat.reshape(3, 3), at.rotation, atol=1e-9)
        for k, body in enumerate(robot.collision_model.geometryObjects):
            at = data.oMi[body.parentJoint] * body.placement
            geom = simulated.geom(body.name)
            np.testing.assert_allclose(geom.xpos, at.translation, atol=1e-9, err_msg=str(k))
            np.testing.assert_allclose(geom.xmat.reshape(3, 3), at.rotation, atol=1e-9)


@pytest.mark.parametrize("which", ["robot", "other"])
def test_inertia_is_pinocchios(
    which: str, motion: Trajectory, rng: np.random.Generator, request: pytest.FixtureRequest
) -> None:
    robot = request.getfixturevalue(which)
    model = compiled(robot, nothing(robot), still(robot, motion, robot.initial))
    data = robot.model.createData()
    for _ in range(5):
        q = robot.full_configuration(rng.uniform(robot.lower, robot.upper))
        upper = np.triu(pin.crba(robot.model, data, q))
        expected = upper + np.triu(upper, 1).T
        found, simulated = np.zeros((model.nv, model.nv)), placed(model, q)
        for column, unit in zip(found, np.eye(model.nv), strict=True):
            mujoco.mj_mulM(model, simulated, column, unit)
        np.testing.assert_allclose(found, expected, atol=1e-9 * abs(expected).max())


@pytest.mark.parametrize("which", ["robot", "unchecked", "folding", "other"])
def test_what_may_be_in_contact_is_what_is_checked(which: str, motion: Trajectory, robot: Robot, other: Robot) -> None:
    """MuJoCo reports every pair nearer than a margin that is larger than the scene."""
    unchecked, folding = robot_from_urdf(robot.urdf, None, robot.hands), load_robot(elbow_upper=2.5)
    robot = {"robot": robot, "unchecked": unchecked, "folding": folding, "other": other}[which]
    obstacles = (
        Sphere(center=(1.0, 2.0, 3.0), radius=0.1),
        Sphere(center=(0.0, 2.0, 3.0), radius=0.1, velocity=(0.0, 0.1, 0.0)),
    )
    scene = nothing(robot).model_copy(update={"obstacles": obstacles})
    text = text_of(robot, scene, still(robot, motion, robot.initial))
    text = text.replace("<geom class", '<geom margin="100" class').replace("<pair ", '<pair margin="100" ')
    model = mujoco.MjModel.from_xml_string(text)
    data = placed(model, robot.full_configuration(robot.initial))
    bodies = [body.name for body in robot.collision_model.geometryObjects]
    checked = {frozenset((bodies[i], bodies[j])) for i, j in robot.self_collision_pairs}
    against = {frozenset(pair) for pair in product(bodies, ("obstacles[0] (sphere)", "obstacles[1] (sphere)"))}
    seen = names(model, data.contact.geom)
    # A far part is a part of its link, which is checked against others anyway.
    extra = {pair for pair in seen - checked if any(" away from " in name for name in pair)} - against
    assert {frozenset(name.split(" away from ")[0] for name in pair) for pair in extra} <= checked
    assert seen - extra == checked | against
    assert len(checked) == {"robot": 27, "unchecked": 36, "folding": 29, "other": 15}[which]


def test_links_inside_each_other_are_reported(motion: Trajectory, robot: Robot, folded_q: np.ndarray) -> None:
    """Against coal, pair by pair."""
    model = compiled(robot, nothing(robot), still(robot, motion, folded_q))
    data = placed(model, robot.full_configuration(folded_q))
    geometry, kinematics = robot.collision_model.createData(), robot.model.createData()
    pin.updateGeometryPlacements(
        robot.model, kinematics, robot.collision_model, geometry, robot.full_configuration(folded_q)
    )
    bodies = robot.collision_model.geometryObjects
    inside = set()
    for i, j in robot.self_collision_pairs:
        (a, at_a), (b, at_b) = (
            (bodies[k].geometry, coal.Transform3s(geometry.oMg[k].rotation, geometry.oMg[k].translation))
            for k in (i, j)
        )
        if coal.distance(a, at_a, b, at_b, coal.DistanceRequest(), coal.DistanceResult()) < 0:
            inside.add(frozenset((bodies[i].name, bodies[j].name)))
    assert inside
    assert names(model, data.contact.geom) == inside


def test_obstacles_are_where_the_scene_has_them(
    motion: Trajectory, robot: Robot, cube_file: str, rng: np.random.Generator
) -> None:
    """Distances of small spheres from each obstacle in MuJoCo, against closed forms of distance in its own frame."""
    rpy = (0.3, -0.5, 0.7)
    R = pin.rpy.rpyToMatrix(*rpy)
    center = np.array([0.5, 0.6, 0.7])
    obstacles = (
        Sphere(center=tuple(center), radius=0.3),
        Box(center=tuple(center), size=(0.2, 0.4, 0.6), rpy=rpy),
        Capsule(center=tuple(center), radius=0.1, length=0.5, rpy=rpy),
        HalfSpace(normal=(1.0, 2.0, 2.0), offset=3.0),
        Mesh(file=cube_file, center=tuple(center), rpy=rpy, scale=(0.2, 0.4, 0.6)),
    )

    def box(p: np.ndarray) -> float:
        return float(np.linalg.norm(np.maximum(abs(R.T @ (p - center)) - [0.1, 0.2, 0.3], 0.0)))

    def capsule(p: np.ndarray) -> float:
        local = R.T @ (p - center)
        return float(np.linalg.norm(local - [0, 0, np.clip(local[2], -0.25, 0.25)])) - 0.1

    distances = (
        lambda p: float(np.linalg.norm(p - center)) - 0.3,
        box,
        capsule,
        lambda p: float(p @ [1, 2, 2]) / 3 - 1.0,
        box,
    )
    moved = tuple(obstacle.model_copy(update={"velocity": (0.1, 0.0, 0.0)}) for obstacle in obstacles)
    for scenery, shift in ((obstacles, np.zeros(3)), (moved, np.array([0.2, -0.1, 0.3]))):
        for obstacle, distance in zip(scenery, distances, strict=True):
            scene = nothing(robot).model_copy(update={"obstacles": (obstacle,)})
            text = text_of(robot, scene, still(robot, motion, robot.initial))
            probe = '<body name="probe"><freejoint/><geom name="probe" size="0.001"/></body></worldbody>'
            # The probe has no inertial; only here do geoms have mass.
            text = text.replace("</worldbody>", probe).replace('inertiafromgeom="false"', 'inertiafromgeom="auto"')
            text = text.replace("<key ", "<!-- ").replace('name="start" />', "-->")
            model = mujoco.MjModel.from_xml_string(text)
            data = mujoco.MjData(model)
            if model.nmocap:
                data.mocap_pos[:] = shift
            geom, ball = model.geom(f"obstacles[0] ({obstacle.type})").id, model.geom("probe").id
            for p in rng.uniform(-1.5, 2.5, (20, 3)):
                if distance(p - shift) > 0.01:
                    data.qpos[-7:-4] = p
                    mujoco.mj_kinematics(model, data)
                    found = mujoco.mj_geomDistance(model, data, geom, ball, 100.0, None)
                    assert found + 0.001 == pytest.approx(distance(p - shift), abs=1e-5), obstacle.type


def test_a_mesh_is_its_convex_pieces(motion: Trajectory, robot: Robot, tmp_path: Path) -> None:
    """An L, 1 m long and high and 0.2 m thick, around a probe in its hollow."""
    import trimesh

    outline = np.array([[0, 0], [1, 0], [1, 0.2], [0.2, 0.2], [0.2, 1], [0, 1]], float)
    vertices = np.array([[x, y, z] for z in (0.0, 0.2) for x, y in outline])
    bottom = [[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 5, 4]]
    sides = [[[i, (i + 1) % 6, (i + 1) % 6 + 6], [i, (i + 1) % 6 + 6, i + 6]] for i in range(6)]
    faces = [*bottom, *([a + 6, c + 6, b + 6] for a, b, c in bottom), *(face for side in sides for face in side)]
    trimesh.Trimesh(vertices, faces).export(tmp_path / "ell.stl")
    mesh = Mesh(file=str(tmp_path / "ell.stl"), center=(1.0, 2.0, 3.0))
    assert len(mesh.pieces) > 1
    scene = nothing(robot).model_copy(update={"obstacles": (mesh,)})
    text = text_of(robot, scene, still(robot, motion, robot.initial))
    probe = '<geom name="probe" pos="1.4 2.5 3.1" size="0.001"/></worldbody>'
    model = mujoco.MjModel.from_xml_string(text.replace("</worldbody>", probe))
    data = placed(model, robot.full_configuration(robot.initial))
    pieces = [i for i in range(model.ngeom) if model.geom(i).name.startswith("obstacles[0] (mesh) piece")]
    assert len(pieces) == len(mesh.pieces) == model.nmesh
    nearest = min(mujoco.mj_geomDistance(model, data, i, model.geom("probe").id, 10.0, None) for i in pieces)
    assert nearest == pytest.approx(0.2 - 0.001, abs=0.01)


def test_what_mujoco_cannot_have_is_refused(motion: Trajectory, scene: Scene) -> None:
    thin = load_robot(link_radius=0.0)
    with pytest.raises(InvalidInput, match="collision body carriage_0"):
        text_of(thin, scene, motion)
