"""Exports of robots of other people: meshes, limits of effort, one hand, joints that follow."""

from __future__ import annotations

import csv
import io
import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from conftest import changed, package_robot
from mjcf_models import INERTIAL, mujoco, nothing, other_robot, still

from humanoid_rail import (
    Box,
    InvalidInput,
    Robot,
    Scene,
    Timing,
    Trajectory,
    export,
    retime,
    robot_from_urdf,
)
from humanoid_rail import plan as plan_motion
from humanoid_rail.io.mujoco.player import track
from humanoid_rail.io.ros import joint_trajectory
from humanoid_rail.io.tables import csv_bytes, npz_bytes
from humanoid_rail.kinematics.kinematics import Kinematics


@pytest.fixture(scope="module")
def panda() -> Robot:
    return package_robot("example-robot-data:panda", initial=[0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])


@pytest.fixture(scope="module")
def reach(panda: Robot) -> tuple[Scene, Trajectory]:
    """A scene with a box beside the way of a Panda, and its motion."""
    boxes = (Box(center=(0.65, 0.0, 0.15), size=(0.3, 0.5, 0.1)),)
    (name,) = panda.hand_names
    scene = Scene(name="reach", targets={name: (0.55, 0.2, 0.4)}, obstacles=boxes)
    return scene, retime(plan_motion(panda, scene), panda, scene)


def test_a_plan_is_followed_in_mujoco(panda: Robot, reach: tuple[Scene, Trajectory], tmp_path: Path) -> None:
    scene, motion = reach
    assert motion.certificate is not None
    assert motion.certificate.certified
    files = export(motion, panda, scene, "mujoco", tmp_path / "out")
    assert sum(path.suffix == ".stl" for path in files) > 10
    tracking = track(tmp_path / "out")
    assert tracking.contacts == ()
    assert tracking.largest_hand_error < 2e-3
    assert tracking.largest_forces.keys() == set(panda.joint_names)
    # Where the player puts the robot is where the plan ends.
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "out" / "scene.xml"))
    assert model.site(f"{panda.hand_names[0]}_end").pos == pytest.approx(motion.hands[-1, 0])


def test_a_motion_into_an_obstacle_is_seen(panda: Robot, reach: tuple[Scene, Trajectory], tmp_path: Path) -> None:
    """The same motion with a box where it goes: hulls and fingers touch it."""
    scene, motion = reach
    box = Box(center=tuple(motion.hands[-1, 0].tolist()), size=(0.1, 0.1, 0.1))
    blocked = scene.model_copy(update={"obstacles": (box,)})
    export(motion, panda, blocked, "mujoco", tmp_path)
    assert any("obstacles[0] (box)" in (touch.one, touch.other) for touch in track(tmp_path).contacts)


def test_tables_have_the_joints_and_the_one_hand(panda: Robot, reach: tuple[Scene, Trajectory]) -> None:
    _, motion = reach
    (hand,) = panda.hand_names
    header, *rows = csv.reader(io.StringIO(csv_bytes(motion).decode()))
    rates = [f"{name}_{kind}" for kind in ("velocity", "acceleration") for name in panda.joint_names]
    assert header == ["t", *panda.joint_names, f"{hand}_x", f"{hand}_y", f"{hand}_z", *rates]
    end = np.array(rows[-1], float)
    at = Kinematics(panda).hand_positions(end[1:8]).ravel()  # radians, as they are
    assert end[8:11] == pytest.approx(at, abs=1e-12)
    with np.load(io.BytesIO(npz_bytes(motion))) as arrays:
        assert arrays[hand].shape == (len(rows), 3)
        assert arrays["q"].shape == (len(rows), 7)
    message = joint_trajectory(motion, panda)
    assert message["joint_names"] == list(panda.joint_names)
    assert message["points"][-1]["positions"] == end[1:8].tolist()


@pytest.mark.parametrize("name", ["q", "velocity", "file"])
def test_hands_are_not_called_as_arrays_are(motion: Trajectory, name: str) -> None:
    with pytest.raises(InvalidInput, match="hands is"):
        npz_bytes(changed(motion, hand_names=(name, "right")))


def test_followers_are_there_if_asked_for(motion: Trajectory) -> None:
    other = other_robot()
    resting = still(other, motion, np.array([0.1, 0.2, 0.3, 0.4]))
    assert "finger" not in joint_trajectory(resting, other)["joint_names"]
    message = joint_trajectory(resting, other, passive=True)
    point = dict(zip(message["joint_names"], message["points"][0]["positions"], strict=True))
    assert point["finger"] == pytest.approx(0.5 * point["j2"] + 0.1)


def meshed_robot(folder: Path) -> Robot:
    """The robot of `OTHER` with a mesh of the same name in each of two folders, one in a mirror."""
    import trimesh

    for name, size in (("one", 0.1), ("two", 0.2)):
        (folder / name).mkdir()
        trimesh.creation.box((size, size, size)).export(folder / name / "Part.stl")
    triangle = trimesh.Trimesh([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]])
    triangle.export(folder / "two" / "part.stl.obj")
    visual = '<visual><geometry><mesh filename="{}" scale="{}"/></geometry></visual>'
    urdf = other_robot().urdf.replace('filename="package://nowhere/base.stl"', f'filename="{folder}/one/Part.stl"')
    more = visual.format(folder / "two" / "Part.stl", "1 1 -1") + visual.format(folder / "two/part.stl.obj", "1 1 1")
    urdf = urdf.replace('<link name="f">', f'<link name="f">{more}')
    return robot_from_urdf(urdf, None, other_robot().hands)


def test_meshes_of_the_same_name_do_not_mix(motion: Trajectory, tmp_path: Path) -> None:
    robot = meshed_robot(tmp_path)
    export(still(robot, motion, robot.initial), robot, nothing(robot), "mujoco", tmp_path / "out")
    names = sorted(path.name for path in (tmp_path / "out" / "meshes").iterdir())
    assert names == ["Part-2.stl", "Part.stl", "part.stl.stl"]
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "out" / "scene.xml"))
    sizes = {}
    for i in range(model.nmesh):
        begin, count = model.mesh_vertadr[i], model.mesh_vertnum[i]
        sizes[model.mesh(i).name] = float(np.ptp(model.mesh_vert[begin : begin + count], axis=0).max())
    assert sizes["meshes/Part"] == pytest.approx(0.1, abs=1e-6)
    assert sizes["meshes/Part-2"] == pytest.approx(0.2, abs=1e-6)
    assert str(tmp_path) not in (tmp_path / "out" / "scene.xml").read_text()
    mirrored = (tmp_path / "out" / "meshes" / "Part-2.stl").read_bytes()[84:]
    corners = np.frombuffer(mirrored, np.dtype([("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")]))["c"]
    volume = np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume == pytest.approx(0.008, rel=1e-5)  # outwards: not inside out


def test_meshes_that_are_gone_are_named(motion: Trajectory, tmp_path: Path) -> None:
    robot = meshed_robot(tmp_path)
    (tmp_path / "two" / "Part.stl").write_bytes(b"")
    with pytest.warns(UserWarning, match="link f.visual.*left out of the export"):
        export(still(robot, motion, robot.initial), robot, nothing(robot), "mujoco", tmp_path / "out")
    assert {path.name for path in (tmp_path / "out" / "meshes").iterdir()} == {"Part.stl", "part.stl.stl"}


def test_joints_that_are_too_weak_are_named(motion: Trajectory, tmp_path: Path) -> None:
    """At rest against gravity, and in a motion that needs a force of mass times acceleration."""
    other = other_robot()
    assert INERTIAL in other.urdf
    for effort, weak in (("1000", False), ("0.5", True)):
        robot = robot_from_urdf(other.urdf.replace('effort="0"', f'effort="{effort}"'), None, other.hands)
        resting = still(robot, motion, robot.initial)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            export(resting, robot, nothing(robot), "mujoco", tmp_path / effort)
        assert any(re.search(r"limits of effort.* of 0.5.*weight alone", str(w.message)) for w in caught) == weak
    # j0 slides 9 kg, nearly along the ground: 1800 N, and a little for the weight.
    zeros, pushed = np.zeros((3, 4)), np.zeros((3, 4))
    pushed[:, 0] = 200.0
    robot = robot_from_urdf(other.urdf.replace('effort="0"', 'effort="1000"'), None, other.hands)
    fast = changed(still(robot, motion, robot.initial), timing=Timing(zeros, pushed, ()))
    with pytest.warns(UserWarning, match=r"j0 1\.8\d*e\+03 of 1e\+03; lower limits of acceleration"):
        export(fast, robot, nothing(robot), "mujoco", tmp_path / "fast")
