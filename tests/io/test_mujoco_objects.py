"""Objects in MuJoCo lie where they are until they are grasped, move with the hand, and lie where they were put."""

from __future__ import annotations

import io
import re
import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from conftest import changed
from mjcf_models import mujoco

from humanoid_rail import Box, Capsule, Event, InvalidInput, Robot, Scene, Sphere, Trajectory, load_robot, plan, retime
from humanoid_rail.io.mujoco.folder import mujoco_files
from humanoid_rail.io.mujoco.objects import DENSITY, held_load, inertia_of
from humanoid_rail.io.mujoco.player import ExportedMotion, load, start, step

DOWN = [0, 0, -1]
AT, PUT = np.array([-0.6, 0.3, 0.95]), np.array([0.6, 0.9, 0.95])
PART = Box(name="part", center=tuple(AT), size=(0.05, 0.05, 0.08))
OTHER = Capsule(name="left_hand", center=(-0.6, 0.45, 0.93), radius=0.02, length=0.06, rpy=(np.pi / 2, 0.0, 0.0))
BOARDS = [
    {"type": "box", "center": [-0.6, 0.3, 0.9], "size": [0.3, 0.5, 0.02]},
    {"type": "box", "center": [0.6, 0.9, 0.9], "size": [0.3, 0.5, 0.02]},
]


@pytest.fixture(scope="module")
def gripping() -> Robot:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return load_robot("human-sized")


@pytest.fixture(scope="module")
def table() -> Scene:
    up = np.array([0.0, 0.0, 0.2])
    above = [AT + up, AT, AT + up, PUT + up, PUT, PUT + up]
    targets = [{"left": {"position": p.tolist(), "approach": DOWN}, "right": None} for p in above]
    return Scene(name="table", targets=targets, obstacles=BOARDS)


@pytest.fixture(scope="module")
def carried(gripping: Robot, table: Scene) -> Trajectory:
    """The part is grasped at the second target and released at the fifth."""
    trajectory = retime(plan(gripping, table), gripping, table, dwell=0.3)
    assert trajectory.certified
    grasp, release = trajectory.arrivals[1], trajectory.arrivals[4]
    hold = pose_of_hand(gripping, trajectory, grasp).actInv(pin.SE3(np.eye(3), AT))
    put = pose_of_hand(gripping, trajectory, release) * hold
    x, y, z, w = pin.Quaternion(put.rotation).coeffs()
    events = (
        Event(grasp, "grasp", "part", ("left",), tuple(AT), (1.0, 0.0, 0.0, 0.0)),
        Event(release, "release", "part", ("left",), tuple(put.translation), (w, x, y, z)),
    )
    return replace(trajectory, motion=replace(trajectory.motion, events=events))


def pose_of_hand(robot: Robot, trajectory: Trajectory, t: float) -> pin.SE3:
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.full_configuration(trajectory.configuration(t)))
    return data.oMf[robot.model.getFrameId("left_hand")].copy()


@pytest.fixture(scope="module")
def folder(carried: Trajectory, gripping: Robot, table: Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(carried, gripping, table, tmp_path_factory.mktemp("objects"))


def written(trajectory: Trajectory, robot: Robot, scene: Scene, folder: Path) -> Path:
    for name, content in mujoco_files(trajectory, robot, scene, (PART, OTHER)).items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(content)
    return folder


def simulated(folder: Path) -> list[tuple[float, np.ndarray, np.ndarray, pin.SE3]]:
    """Return times, the positions of both objects, and the pose of the part in the hand."""
    model, motion = load(folder)
    data, found = start(model, motion), []
    while data.time < motion.time[-1]:
        step(model, data, motion)
        mujoco.mj_kinematics(model, data)
        hand, part = (pose(data, name) for name in ("left_hand", "part"))
        found.append((data.time, data.body("part").xpos.copy(), data.body("left_hand_").xpos.copy(), hand.actInv(part)))
    return found


def pose(data: Any, name: str) -> pin.SE3:
    return pin.SE3(data.body(name).xmat.reshape(3, 3), data.body(name).xpos)


def test_a_part_moves_with_the_hand_and_lies_where_it_was_put(folder: Path, carried: Trajectory) -> None:
    grasp, release = carried.events
    rows = simulated(folder)
    before = [part for t, part, _, _ in rows if t < grasp.t]
    np.testing.assert_allclose(before, np.tile(AT, (len(before), 1)), atol=1e-3)
    held = [relative for t, _, _, relative in rows if grasp.t + 0.002 < t < release.t]
    assert max(np.linalg.norm(pin.log6(held[0].actInv(relative)).vector) for relative in held) < 2e-3
    assert max(part[2] for _, part, _, _ in rows) > 1.1
    assert np.linalg.norm(rows[-1][1] - release.position) < 5e-3
    after = [part for t, part, _, _ in rows if t > release.t + 0.25]
    assert np.ptp(after, axis=0).max() < 1e-3
    others = [other for _, _, other, _ in rows]
    np.testing.assert_allclose(others, np.tile(OTHER.center, (len(others), 1)), atol=2e-3)


def test_an_object_that_is_not_put_down_falls(
    carried: Trajectory, gripping: Robot, table: Scene, tmp_path: Path
) -> None:
    grasp, release = carried.events
    early = (grasp, replace(release, t=carried.arrivals[2]))
    rows = simulated(written(changed(carried, events=early), gripping, table, tmp_path))
    assert rows[-1][1][2] == pytest.approx(0.95, abs=0.03)
    assert np.linalg.norm(rows[-1][1][:2] - AT[:2]) < 0.05


def test_the_player_says_where_objects_end(folder: Path) -> None:
    command = [sys.executable, folder / "play.py", "--headless"]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert "no contacts" in said
    off = {name: float(x) for name, x in re.findall(r"^(\w+): ([\d.]+) mm from where it is to be", said, re.MULTILINE)}
    assert set(off) == {"part", "left_hand_"}
    assert max(off.values()) < 5.0


def test_the_player_starts_over(folder: Path) -> None:
    model, motion = load(folder)
    data = start(model, motion)
    while data.time < motion.event_time[0] + 0.01:
        step(model, data, motion)
    assert data.eq_active[model.equality("part in left").id]
    again = start(model, motion)
    step(model, again, motion)
    assert not again.eq_active[model.equality("part in left").id]


@pytest.mark.parametrize(
    ("shape", "volume", "moments"),
    [
        (PART, 0.05 * 0.05 * 0.08, [0.05**2 + 0.08**2, 0.05**2 + 0.08**2, 2 * 0.05**2]),
        (Sphere(name="ball", center=(1.0, 2.0, 3.0), radius=0.1), 4 / 3 * np.pi * 1e-3, 3 * [12 * 0.4 * 0.01]),
    ],
)
def test_inertias_are_those_of_solids(shape: Any, volume: float, moments: list[float]) -> None:
    inertia = inertia_of(shape)
    assert inertia.mass == pytest.approx(DENSITY * volume)
    np.testing.assert_allclose(inertia.lever, 0.0, atol=1e-12)
    np.testing.assert_allclose(inertia.inertia, np.diag(moments) * inertia.mass / 12, atol=1e-9)


def test_the_weight_of_what_is_held_is_borne(carried: Trajectory, gripping: Robot) -> None:
    """The load is the gradient of the object's potential energy, on every column, and 0 while nothing is held."""
    load_of = held_load(gripping, (PART, OTHER), carried)
    grasp, release = carried.events
    is_held = (carried.t >= grasp.t) & (carried.t < release.t)
    assert not load_of[~is_held].any()
    hold = pose_of_hand(gripping, carried, grasp.t).actInv(AT)
    data = gripping.model.createData()

    def energy(q: np.ndarray) -> float:
        pin.framesForwardKinematics(gripping.model, data, gripping.full_configuration(q))
        return 9.81 * inertia_of(PART).mass * data.oMf[gripping.model.getFrameId("left_hand")].act(hold)[2]

    for i in np.flatnonzero(is_held)[::40]:
        expected = [
            (energy(carried.q[i] + step) - energy(carried.q[i] - step)) / 2e-6 for step in 1e-6 * np.eye(gripping.n)
        ]
        np.testing.assert_allclose(load_of[i], expected, atol=1e-6)


def test_two_hands_share_the_weight(carried: Trajectory, gripping: Robot) -> None:
    both = changed(carried, events=tuple(replace(event, hands=("left", "right")) for event in carried.events))
    one, shared = held_load(gripping, (PART,), carried), held_load(gripping, (PART,), both)
    rail = gripping.joint_names.index("left_elbow_pitch")
    np.testing.assert_allclose(shared[:, rail], one[:, rail] / 2, atol=1e-9)


def test_exports_without_objects_are_as_before(carried: Trajectory, gripping: Robot, table: Scene) -> None:
    files = mujoco_files(changed(carried, events=()), gripping, table)
    assert b"weld" not in files["scene.xml"]
    assert b"freejoint" not in files["scene.xml"]
    with np.load(io.BytesIO(files["motion.npz"])) as arrays:
        assert ExportedMotion(**arrays).event_time.size == 0
        assert not [name for name in arrays.files if "event" in name or "object" in name]


@pytest.mark.parametrize(
    ("change", "objects", "field"),
    [
        ({"object": "bolt"}, (PART,), "trajectory.events[0].object"),
        ({"hands": ("third",)}, (PART,), "trajectory.events[0].hands"),
        ({}, (), "trajectory.events[0].object"),
        ({}, (PART, PART), "scene.objects"),
    ],
)
def test_events_name_what_is_there(
    carried: Trajectory, gripping: Robot, table: Scene, change: dict[str, Any], objects: Any, field: str
) -> None:
    wrong = changed(carried, events=(replace(carried.events[0], **change),))
    with pytest.raises(InvalidInput) as caught:
        mujoco_files(wrong, gripping, table, objects)
    assert caught.value.field == field
