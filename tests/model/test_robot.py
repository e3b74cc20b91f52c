"""The URDF, and the robot built from it, against the hand-coded DH table."""

from __future__ import annotations

import copy
import inspect
import pickle
import re
from collections.abc import Callable
from math import pi
from pathlib import Path
from xml.etree import ElementTree

import coal
import numpy as np
import pinocchio as pin
import pytest
from conftest import LINKS, ROOT, plan, random_q

from humanoid_rail import (
    InvalidInput,
    Kinematics,
    Robot,
    Scene,
    build_urdf,
    load_robot,
)
from humanoid_rail.model.humanoid import RobotArguments, xacro_arguments
from humanoid_rail.model.library import FileArguments
from humanoid_rail.model.robot_file import IN_FILES_ONLY, RobotFile
from humanoid_rail.paper import dh_table as dh

LENGTHS = ("l_t1", "l_t2", "l_t3", "l_l1", "l_l2", "l_l3", "l_r1", "l_r2", "l_r3", "beta")


def all_frames(q: np.ndarray, lengths: dh.Lengths | None = None) -> dict[str, np.ndarray]:
    lengths = lengths or dh.Lengths()
    T = dh.frames(q, lengths)
    T |= {"B": np.eye(4)}
    T |= {"L0": T["T4"] @ dh.left_arm_base(lengths.beta), "R0": T["T4"] @ dh.right_arm_base(lengths.beta)}
    return T


def error_of_frames(robot: Robot, q: np.ndarray, lengths: dh.Lengths | None = None) -> float:
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.full_configuration(q))
    T = all_frames(q, lengths)
    ids = {frame: robot.model.getFrameId(link) for link, frame in LINKS.items()}
    return max(abs(data.oMf[i].homogeneous - T[frame]).max() for frame, i in ids.items())


def test_every_frame_is_the_papers(robot: Robot, rng: np.random.Generator) -> None:
    assert max(error_of_frames(robot, rng.uniform(robot.lower, robot.upper)) for _ in range(1000)) <= 1e-12


def test_every_length_is_an_argument(rng: np.random.Generator) -> None:
    for _ in range(5):
        values = dict(zip(LENGTHS, rng.uniform(0.3, 1.4, 10), strict=True))
        robot = load_robot(**values)
        q = rng.uniform(robot.lower, robot.upper)
        assert error_of_frames(robot, q, dh.Lengths(**values)) <= 1e-12


def test_actuated_joints_are_q1_to_q12_in_order(robot: Robot) -> None:
    arm = ("shoulder_roll", "shoulder_pitch", "upper_arm_roll", "elbow_pitch")
    torso = ("rail", "waist_yaw", "waist_pitch", "spine_pitch")
    assert robot.joint_names == (*torso, *(f"left_{j}" for j in arm), *(f"right_{j}" for j in arm))
    passive = [name for name in robot.model.names if name.startswith("chest_level")]
    assert [*robot.model.names][1:] == [*torso, *passive, *robot.joint_names[4:]]


def test_limits_are_the_nominal_ones(robot: Robot) -> None:
    elbow = np.radians(75)
    arm = [pi, 2.4, pi, elbow]
    np.testing.assert_allclose(robot.lower, [-1, -pi, -pi / 6, -2.4, *np.negative(arm), *np.negative(arm)])
    np.testing.assert_allclose(robot.upper, [9, pi, 7 * pi / 6, 2.4, *arm, *arm])
    np.testing.assert_array_equal(robot.velocity_limit, 12 * [2.0])
    np.testing.assert_array_equal(robot.acceleration_limit, [4.0, *(11 * [10.0])])


def test_passive_limits_follow_from_their_leaders() -> None:
    robot = load_robot(waist_pitch_lower=-0.3, waist_pitch_upper=1.1, spine_pitch_lower=-0.7, spine_pitch_upper=0.4)
    corners = [robot.full_configuration(q)[4:6] for q in (robot.lower, robot.upper)]
    np.testing.assert_allclose(robot.model.lowerPositionLimit[4:6], np.min(corners, axis=0), atol=1e-15)
    np.testing.assert_allclose(robot.model.upperPositionLimit[4:6], np.max(corners, axis=0), atol=1e-15)


def test_every_limit_is_an_argument() -> None:
    declared = xacro_arguments()
    for joint in ElementTree.fromstring(build_urdf()).iter("joint"):
        name = joint.attrib["name"].removeprefix("left_").removeprefix("right_").replace("elbow_pitch", "elbow")
        if joint.attrib["type"] != "fixed" and not name.startswith("chest_level"):
            assert {f"{name}_lower", f"{name}_upper"} <= declared.keys()
    robot = load_robot(
        rail_velocity=1.5, rail_acceleration=3, revolute_velocity=1, revolute_acceleration=7, elbow_upper=1
    )
    assert (robot.velocity_limit[0], robot.velocity_limit[1]) == (1.5, 1.0)
    assert (robot.acceleration_limit[0], robot.acceleration_limit[1]) == (3.0, 7.0)
    assert robot.upper[7] == robot.upper[11] == 1.0


@pytest.mark.parametrize("radius", [0.05, 0.0, 0.11])
def test_nine_capsules_lie_along_the_bones(radius: float, rng: np.random.Generator) -> None:
    robot = load_robot(link_radius=radius)
    bodies = robot.collision_model.geometryObjects
    assert robot.link_names[:9] == tuple(dh.BONES)  # then far parts, which thick bones have
    assert all(isinstance(body.geometry, coal.Capsule) and body.geometry.radius == radius for body in bodies)
    kinematics = Kinematics(robot)
    for _ in range(50):
        q = rng.uniform(robot.lower, robot.upper)
        for ends, expected in zip(kinematics.bones(q)[:9], dh.bones(q).values(), strict=True):
            error = min(abs(ends - expected).max(), abs(ends[::-1] - expected).max())
            assert error <= 1e-12


def test_srdf_disables_the_pairs_that_share_an_end_point(robot: Robot, rng: np.random.Generator) -> None:
    bones = list(dh.bones(rng.uniform(robot.lower, robot.upper)).values())
    touching = {
        (i, j)
        for i in range(9)
        for j in range(i + 1, 9)
        if min(np.linalg.norm(a - b) for a in bones[i] for b in bones[j]) < 1e-9
    }
    assert len(touching) == 9
    every = {(i, j) for i in range(9) for j in range(i + 1, 9)}
    assert set(robot.self_collision_pairs) == every - touching


def test_built_urdf_is_not_stale() -> None:
    from generate import generated

    for path, text in generated().items():
        assert (ROOT / path).read_text(encoding="utf-8") == text, f"{path} is stale: run `make generate`"


COVERS = ("trunk", "head")
"""Links that are thin covers without mass."""


def test_masses_and_inertias_are_those_of_the_visual_geometry() -> None:
    """An independent sum over coal's volumes and moments of inertia."""
    urdf, density = build_urdf(density=450.0), 450.0
    model = pin.buildModelFromXML(urdf)
    visual = pin.buildGeomFromUrdfString(model, urdf, pin.GeometryType.VISUAL)
    expected = [pin.Inertia.Zero() for _ in range(model.njoints)]
    for body in visual.geometryObjects:
        if model.frames[body.parentFrame].name in COVERS:
            continue
        shape = body.geometry
        inertia = pin.Inertia(
            density * shape.computeVolume(), shape.computeCOM(), density * shape.computeMomentofInertiaRelatedToCOM()
        )
        expected[body.parentJoint] += body.placement.act(inertia)
    for name, built, summed in zip(model.names, model.inertias, expected, strict=True):
        assert built.mass > 0, name
        assert built.isApprox(summed, 1e-9), name


def test_visual_geometry_does_not_depend_on_the_collision_radius() -> None:
    def visuals(urdf: str) -> list[str]:
        return [ElementTree.tostring(v, encoding="unicode") for v in ElementTree.fromstring(urdf).iter("visual")]

    assert visuals(build_urdf(link_radius=0.2)) == visuals(build_urdf(link_radius=0.01))


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ({"l_t9": 1.0}, "argument"),
        ({"l_t1": 0.0}, "l_t1"),
        ({"l_l2": -1.0}, "l_l2"),
        ({"link_radius": -0.01}, "link_radius"),
        ({"beta": float("nan")}, "beta"),
        ({"beta": "wide"}, "beta"),
        ({"rail_upper": float("inf")}, "rail_upper"),
        ({"rail_lower": 9.0}, "limits of joint rail"),
        ({"density": 0.0}, "density"),
        ({"rail_upper": 1e300}, "rail_upper"),
        ({"waist_yaw_lower": -1e300}, "waist_yaw_lower"),
        ({"l_t2": 1e300}, "l_t2"),
        ({"l_r1": 5e-324}, "l_r1"),
        ({"link_radius": 1e300}, "link_radius"),
        ({"density": 5e-324}, "density"),
        ({"revolute_effort": 1e300}, "revolute_effort"),
    ],
)
def test_bad_arguments_are_named(arguments: dict[str, float], field: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        load_robot(**arguments)
    assert caught.value.field == field
    assert field in str(caught.value)


def test_arrays_are_read_only(robot: Robot) -> None:
    with pytest.raises(ValueError, match="read-only"):
        robot.lower[0] = 0.0


def test_the_model_pickles_and_copies(robot: Robot, rng: np.random.Generator) -> None:
    model = pickle.loads(pickle.dumps(robot.model))
    q = robot.full_configuration(random_q(robot, rng))
    for other in (model, copy.copy(robot.model)):
        data, expected = other.createData(), robot.model.createData()
        pin.framesForwardKinematics(other, data, q)
        pin.framesForwardKinematics(robot.model, expected, q)
        assert data.oMf[robot.model.getFrameId("left_hand")] == expected.oMf[robot.model.getFrameId("left_hand")]


def test_robots_pickle(robot: Robot, scene: Scene) -> None:
    again = pickle.loads(pickle.dumps(robot))
    trajectory, expected = plan(again, scene, dt=0.5), plan(robot, scene, dt=0.5)
    np.testing.assert_array_equal(trajectory.q, expected.q)
    np.testing.assert_array_equal(trajectory.clearance, expected.clearance)
    assert pickle.loads(pickle.dumps(trajectory)).summary() == trajectory.summary()


def test_files_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from humanoid_rail._resources import resource

    monkeypatch.chdir(tmp_path)
    assert resource("robots", "humanoid_rail.urdf.xacro").is_file()
    with pytest.raises(FileNotFoundError, match=r"robots/nothing\.urdf"):
        resource("robots", "nothing.urdf")


@pytest.mark.parametrize("function", [load_robot, build_urdf])
def test_arguments_are_shown(function: Callable[..., object]) -> None:
    """Those that the xacro file declares, with its defaults; each is described."""
    shown = {name: parameter.default for name, parameter in inspect.signature(function).parameters.items()}
    if function is load_robot:
        of_files = {"source", *FileArguments.__annotations__}
        assert of_files <= shown.keys()
        assert {*FileArguments.__annotations__} == {*RobotFile.model_fields} - {*IN_FILES_ONLY}
        shown = {name: default for name, default in shown.items() if name not in of_files}
    assert shown.keys() == xacro_arguments().keys() == RobotArguments.__annotations__.keys()
    assert build_urdf(**shown) == build_urdf()
    described = inspect.getsource(RobotArguments)
    assert all(re.search(rf'    {name}: SupportsFloat\n    """.+"""', described) for name in shown)
