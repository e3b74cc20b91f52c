"""The export to MuJoCo, in MuJoCo: the same kinematics, dynamics and contacts, and how well the drives follow."""

from __future__ import annotations

import contextlib
import subprocess
import sys
from itertools import product
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import pytest
from conftest import ROOT, changed, rest_to_rest
from scipy.interpolate import CubicHermiteSpline

from humanoid_rail import (
    Box,
    Capsule,
    HalfSpace,
    Hand,
    InvalidInput,
    Kinematics,
    Mesh,
    Robot,
    Scene,
    Sphere,
    Timing,
    Trajectory,
    load_robot,
    paper_scene,
    plan_case,
    retime,
    robot_from_urdf,
)
from humanoid_rail.io.export import export
from humanoid_rail.io.mujoco.actuators import position_actuators
from humanoid_rail.io.mujoco.mjcf import mjcf

mujoco = pytest.importorskip("mujoco")

from humanoid_rail.io.mujoco.player import HOLD, control, load, play, start, step, track  # noqa: E402


@pytest.fixture(scope="module")
def motion(robot: Robot) -> Trajectory:
    """The paper's third case, retimed."""
    return retime(plan_case(robot, 3), robot, paper_scene())


@pytest.fixture(scope="module")
def folder(motion: Trajectory, robot: Robot, scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("mujoco") / "case3"
    written = export(motion, robot, scene, "mujoco", folder)
    assert {path.name for path in written} == {path.name for path in folder.iterdir()}
    return folder


def text_of(robot: Robot, scene: Scene, motion: Trajectory) -> str:
    return mjcf(robot, scene, motion, position_actuators(robot, motion.q), motion.q[0])


def compiled(robot: Robot, scene: Scene, motion: Trajectory) -> Any:
    return mujoco.MjModel.from_xml_string(text_of(robot, scene, motion))


def names(model: Any, pairs: Any) -> set[frozenset[str]]:
    return {frozenset(model.geom(int(i)).name for i in pair) for pair in pairs}


def placed(model: Any, q_full: np.ndarray) -> Any:
    data = mujoco.MjData(model)
    data.qpos[:] = q_full
    mujoco.mj_forward(model, data)
    return data


# A tool on an arm whose frames are turned in every way, with a passive finger, without an SRDF.
OTHER = """
<robot name="other">
  <material name="green"><color rgba="0 1 0 1"/></material>
  <link name="world"/>
  <joint name="stand" type="fixed"><parent link="world"/><child link="base"/>
    <origin xyz="0.1 0.2 0.3" rpy="0.1 0.2 0.3"/></joint>
  <link name="base">
    <visual><geometry><mesh filename="package://nowhere/base.stl" scale="1 1 1"/></geometry></visual>
    <visual><origin xyz="0 0 -0.1"/><geometry><box size="0.2 0.2 0.2"/></geometry><material name="green"/></visual>
    <collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>
  </link>
  {joints}
  <joint name="flange" type="fixed"><parent link="l3"/><child link="tool"/><origin xyz="0 0 0.1" rpy="1 2 3"/></joint>
  <link name="tool">{inertial}<collision><geometry><sphere radius="0.02"/></geometry></collision></link>
  <joint name="finger" type="revolute"><parent link="tool"/><child link="f"/><origin xyz="0 0.05 0" rpy="0 1 0"/>
    <axis xyz="0 1 1"/><limit lower="0" upper="0" velocity="1" effort="0"/>
    <mimic joint="j2" multiplier="0.5" offset="0.1"/></joint>
  <link name="f">{inertial}</link>
</robot>
"""
JOINT = """
  <joint name="j{i}" type="{kind}"><parent link="{parent}"/><child link="l{i}"/>
    <origin xyz="0.1 0 0.3" rpy="0.{i} -0.4 0.5"/><axis xyz="{axis}"/>
    <limit lower="-1" upper="1.5" velocity="1" effort="0"/></joint>
  <link name="l{i}">{inertial}<collision><origin xyz="0 0 0.1" rpy="0.3 0 0"/>
    <geometry><cylinder radius="0.03" length="0.2"/></geometry></collision></link>
"""
INERTIAL = """<inertial><origin xyz="0.01 0.02 0.03" rpy="0.4 0.5 0.6"/><mass value="1.5"/>
  <inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0.001" ixz="0.002" iyz="-0.003"/></inertial>"""


@pytest.fixture(scope="module")
def other() -> Robot:
    kinds = [
        ("base", "prismatic", "0 1 0"),
        ("l0", "revolute", "0 0 1"),
        ("l1", "revolute", "1 2 2"),
        ("l2", "revolute", "1 0 0"),
    ]
    joints = "".join(
        JOINT.format(i=i, parent=parent, kind=kind, axis=axis, inertial=INERTIAL)
        for i, (parent, kind, axis) in enumerate(kinds)
    )
    urdf = OTHER.format(joints=joints, inertial=INERTIAL)
    return robot_from_urdf(urdf, None, [Hand("tip", "flange", ("j1", "j2", "j3"))])


def still(robot: Robot, motion: Trajectory, q: np.ndarray) -> Trajectory:
    """A motion of any robot that stays where it is."""
    zeros = np.zeros((3, robot.n))
    hands = np.tile(Kinematics(robot).hand_positions(q).reshape(-1, 3), (3, 1, 1))
    return changed(
        motion,
        t=np.array([0.0, 0.1, 0.2]),
        q=zeros + q,
        hands=hands,
        timing=Timing(zeros, zeros, ()),
        joint_names=robot.joint_names,
        hand_names=robot.hand_names,
    )


def nothing(robot: Robot) -> Scene:
    return Scene(name="nothing", targets=dict.fromkeys(robot.hand_names, (0.0, 0.0, 0.0)))


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


@pytest.mark.parametrize("which", ["robot", "unchecked", "other"])
def test_what_may_be_in_contact_is_what_is_checked(which: str, motion: Trajectory, robot: Robot, other: Robot) -> None:
    """MuJoCo reports every pair nearer than a margin that is larger than the scene."""
    robot = {"robot": robot, "unchecked": robot_from_urdf(robot.urdf, None, robot.hands), "other": other}[which]
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
    assert names(model, data.contact.geom) == checked | against
    assert len(checked) == {"robot": 27, "unchecked": 36, "other": 15}[which]


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


def test_the_reference_between_samples_is_the_spline_of_the_motion(
    folder: Path, motion: Trajectory, robot: Robot
) -> None:
    model, exported = load(folder)
    with np.load(folder / "motion.npz") as arrays:
        assert set(arrays.files) == {"time", "qpos", "qvel", "load", "ctrl", "hands", "mocap"}
    spline = CubicHermiteSpline(motion.t, motion.q, motion.timing.velocity)
    joints = [robot.model.joints[robot.model.getJointId(name)].idx_q for name in robot.joint_names]
    for t in np.linspace(0.0, motion.duration, 777)[:-1]:
        q, velocity = exported.at(t)
        np.testing.assert_allclose(q, robot.full_configuration(spline(t)), atol=1e-12)
        np.testing.assert_allclose(velocity[joints], spline(t, 1), atol=1e-10)
    for i, t in enumerate(motion.t):
        np.testing.assert_allclose(control(model, exported, t), exported.ctrl[i], atol=1e-12)
        site = placed(model, exported.qpos[i]).site
        for k, hand in enumerate(robot.hand_names):
            np.testing.assert_allclose(site(f"{hand}_hand").xpos, exported.hands[i, k], atol=1e-9)
    for t in (-1.0, motion.duration, motion.duration + 1.0):
        q, velocity = exported.at(t)
        np.testing.assert_allclose(q, robot.full_configuration(motion.q[0 if t < 0 else -1]), atol=1e-12)
        assert not velocity.any()


def test_the_simulated_robot_follows_the_papers_third_case(folder: Path) -> None:
    tracking = track(folder)
    print(tracking)
    assert 1e-5 < tracking.largest_hand_error <= 0.004
    assert tracking.final_hand_error <= 0.002
    assert tracking.contacts == ()


def test_the_drives_need_what_inverse_dynamics_says(motion: Trajectory, robot: Robot, tmp_path: Path) -> None:
    """Against Pinocchio: S^T of what all joints need, as the passive ones are moved by their leaders."""
    ends = np.array([robot.initial, motion.q[-1]])
    line = changed(motion, q=ends[0] + np.linspace(0.0, 1.0, 9)[:, None] * (ends[1] - ends[0]))
    line = rest_to_rest(robot, line, duration=3.0)
    export(line, robot, nothing(robot), "mujoco", tmp_path)
    data, S = robot.model.createData(), robot.coupling
    needed = [
        S.T @ pin.rnea(robot.model, data, robot.full_configuration(q), S @ v, S @ a)
        for q, v, a in zip(line.q, line.timing.velocity, line.timing.acceleration, strict=True)
    ]
    found = track(tmp_path).largest_forces
    assert list(found) == list(robot.joint_names)
    np.testing.assert_allclose([*found.values()], abs(np.array(needed)).max(axis=0), rtol=0.05, atol=1.0)


def test_at_rest_the_drives_hold_the_weight(
    motion: Trajectory, robot: Robot, rng: np.random.Generator, tmp_path: Path
) -> None:
    """Against the change of the potential energy, by central differences along each actuated joint."""
    q = rng.uniform(robot.lower, robot.upper)
    export(still(robot, motion, q), robot, nothing(robot), "mujoco", tmp_path)
    data, step = robot.model.createData(), 1e-6

    def potential(q: np.ndarray) -> float:
        return float(pin.computePotentialEnergy(robot.model, data, robot.full_configuration(q)))

    weight = [(potential(q + by) - potential(q - by)) / (2 * step) for by in step * np.eye(robot.n)]
    tracking = track(tmp_path)
    np.testing.assert_allclose([*tracking.largest_forces.values()], np.abs(weight), rtol=0.02, atol=2.0)
    assert tracking.largest_hand_error < 1e-3


def test_passive_joints_have_no_play(folder: Path, robot: Robot) -> None:
    model, motion = load(folder)
    data = start(model, motion)
    worst = 0.0
    while data.time < motion.time[-1]:
        step(model, data, motion)
        waist, spine = data.joint("waist_pitch").qpos[0], data.joint("spine_pitch").qpos[0]
        found = data.joint("chest_level_waist").qpos[0], data.joint("chest_level_spine").qpos[0]
        worst = max(worst, abs(found[0] - np.pi / 2 + waist), abs(found[1] + spine))
    assert worst < 2e-3


def test_an_obstacle_in_the_way_is_reported_with_its_time(motion: Trajectory, robot: Robot, tmp_path: Path) -> None:
    """A ball that meets the resting left hand after 0.1 s, at 1 m/s."""
    resting = still(robot, motion, robot.initial)
    hand = resting.hands[0, 0]
    ball = Sphere(center=(hand[0] - 0.2, hand[1], hand[2]), radius=0.05, velocity=(1.0, 0.0, 0.0))
    scene = nothing(robot).model_copy(update={"obstacles": (ball,)})
    export(resting, robot, scene, "mujoco", tmp_path)
    contacts = track(tmp_path).contacts
    assert {contacts[0].one, contacts[0].other} == {"left_forearm_0", "obstacles[0] (sphere)"}
    # The capsule ends 5 cm around the hand.
    assert contacts[0].time == pytest.approx(0.1, abs=0.005)
    assert contacts[0].depth > 0


def test_another_robot_holds_still(motion: Trajectory, other: Robot, tmp_path: Path) -> None:
    """Under its own weight, without effort limits, and with a passive joint whose own limits forbid its place."""
    resting = still(other, motion, other.initial)
    export(resting, other, nothing(other), "mujoco", tmp_path)
    tracking = track(tmp_path)
    assert tracking.largest_hand_error < 1e-4
    assert (tmp_path / "scene.xml").read_text().count('rgba="0 1 0 1"') == 1
    assert "nowhere" not in (tmp_path / "scene.xml").read_text()


def test_what_mujoco_cannot_have_is_refused(motion: Trajectory, scene: Scene, other: Robot) -> None:
    thin = load_robot(link_radius=0.0)
    with pytest.raises(InvalidInput, match="collision body carriage_0"):
        text_of(thin, scene, motion)
    light = robot_from_urdf(other.urdf.replace('<mass value="1.5"/>', '<mass value="0"/>'), None, other.hands)
    with pytest.raises(InvalidInput, match="inertial of what j0 moves"):
        text_of(light, nothing(light), still(light, motion, light.initial))


def test_the_player_needs_mujoco_and_numpy_alone(folder: Path) -> None:
    assert (folder / "play.py").read_text() == (ROOT / "humanoid_rail" / "io" / "mujoco" / "player.py").read_text()
    blocked = "import sys; sys.modules['humanoid_rail'] = None; import runpy; sys.argv = ['play.py', '--headless']"
    code = f"{blocked}; runpy.run_path({str(folder / 'play.py')!r}, run_name='__main__')"
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=folder.parent
    )
    assert result.returncode == 0, result.stderr
    assert "largest error of a hand" in result.stdout
    assert "no contacts" in result.stdout


def test_the_viewer_plays_in_a_loop(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a stand-in for the window, which a test has no display for."""
    times: list[float] = []

    class Window(contextlib.nullcontext):
        def __init__(self, model: Any, data: Any) -> None:
            super().__init__(self)
            self.data, self.user_scn = data, mujoco.MjvScene(model, maxgeom=1000)

        def lock(self) -> Any:
            return contextlib.nullcontext()

        def is_running(self) -> bool:
            return len(times) < 400

        def sync(self) -> None:
            times.append(self.data.time)

    monkeypatch.setattr("mujoco.viewer.launch_passive", lambda model, data, **_: Window(model, data))
    monkeypatch.setattr("time.sleep", lambda _: None)
    play(folder)
    restart = int(np.argmin(np.diff(times))) + 1
    assert times[restart - 1] == pytest.approx(load(folder)[1].time[-1] + HOLD, abs=0.1)
    assert times[restart] == times[0]
    np.testing.assert_allclose(np.diff(times[:restart]), 0.02, atol=0.0011)


def test_nothing_but_the_player_imports_mujoco() -> None:
    code = "import sys, humanoid_rail.io.export; print('mujoco' in sys.modules)"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert result.stdout.strip() == "False"
