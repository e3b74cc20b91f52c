"""The simulated robot of the export to MuJoCo: how well its actuators follow the motion, and what it touches."""

from __future__ import annotations

import contextlib
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from conftest import ROOT, changed, rest_to_rest
from mjcf_models import mujoco, nothing, other_robot, placed, still
from scipy.interpolate import CubicHermiteSpline

from humanoid_rail import Robot, Scene, Sphere, Trajectory
from humanoid_rail.io.export import export
from humanoid_rail.io.mujoco.player import HOLD, control, load, play, start, step, track


@pytest.fixture(scope="module")
def folder(motion: Trajectory, robot: Robot, scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("mujoco") / "case3"
    written = export(motion, robot, scene, "mujoco", folder)
    assert {path.name for path in written} == {path.name for path in folder.iterdir()}
    return folder


@pytest.fixture(scope="module")
def other() -> Robot:
    return other_robot()


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


def test_the_actuators_need_what_inverse_dynamics_says(motion: Trajectory, robot: Robot, tmp_path: Path) -> None:
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


def test_at_rest_the_actuators_hold_the_weight(
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
    assert (tmp_path / "scene.xml").read_text().count('rgba="0.0 1.0 0.0 1.0"') == 1
    assert "nowhere" not in (tmp_path / "scene.xml").read_text()


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
