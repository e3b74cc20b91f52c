"""Reading and writing trajectories."""

from __future__ import annotations

import csv
import json
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from conftest import changed, plan

from humanoid_rail import (
    Auto,
    GradientProjection,
    InvalidInput,
    Robot,
    SafeVelocity,
    Scene,
    State,
    Trajectory,
    plan_case,
    read_trajectory,
    retime,
    write_trajectory,
)

FILES = {"trajectory.npz", "trajectory.csv", "summary.json"}

SAMPLES = ("hands", "hand_names", "clearance", "manipulability")


@pytest.fixture(scope="module")
def trajectory(robot: Robot, scene: Scene) -> Trajectory:
    return plan(robot, scene, "gradient-projection", dt=0.05)


def test_what_is_written_is_read_back(trajectory: Trajectory, tmp_path: Path) -> None:
    written = write_trajectory(trajectory, tmp_path / "a" / "b")
    assert {path.name for path in written} == FILES == {path.name for path in (tmp_path / "a" / "b").iterdir()}
    again = read_trajectory(tmp_path / "a" / "b")
    assert (again.robot, again.scene) == (None, None)  # read_plan knows them
    for part in fields(Trajectory):
        if part.name in ("robot", "scene"):
            continue
        one, two = getattr(trajectory, part.name), getattr(again, part.name)
        names = SAMPLES if part.name == "samples" else [field.name for field in fields(one)]
        for name in names:
            before, after = getattr(one, name), getattr(two, name)
            if isinstance(before, np.ndarray):
                np.testing.assert_array_equal(before, after)
                assert not after.flags.writeable
            else:
                assert before == after, name
    assert again.summary() == trajectory.summary()


def test_npz(trajectory: Trajectory, tmp_path: Path) -> None:
    write_trajectory(trajectory, tmp_path)
    n = len(trajectory.t)
    with np.load(tmp_path / "trajectory.npz") as arrays:
        shapes = {name: arrays[name].shape for name in arrays.files}
    assert shapes == {
        "t": (n,),
        "q": (n, 12),
        "left": (n, 3),
        "right": (n, 3),
        "clearance": (n, 2),
        "manipulability": (n,),
    }


def test_csv(trajectory: Trajectory, tmp_path: Path) -> None:
    write_trajectory(trajectory, tmp_path)
    with (tmp_path / "trajectory.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    hands = ["left_x", "left_y", "left_z", "right_x", "right_y", "right_z"]
    assert header == ["t", *trajectory.joint_names, *hands]
    expected = np.column_stack([trajectory.t, trajectory.q, trajectory.hands.reshape(-1, 6)])
    np.testing.assert_array_equal(np.array(rows, float), expected)


def test_summary(trajectory: Trajectory, tmp_path: Path) -> None:
    write_trajectory(trajectory, tmp_path)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["status"] == "reached"
    assert summary["reason"]
    assert summary["collision_free"] is True
    assert summary["limits_ok"] is False
    assert summary["duration"] == trajectory.t[-1]
    assert summary["planning_time"] > 0
    assert summary["evaluations"] > 100
    assert summary["min_clearance"] == trajectory.clearance.min()
    assert summary["manipulability_final"] == trajectory.manipulability[-1]
    assert summary["scene"] == "paper"
    method = summary["method"]
    assert method["name"] == "gradient-projection"
    assert method["gain"] == [1.0]
    assert (method["epsilon"], method["dt"]) == (1.0, 0.05)
    assert {"joint", "quantity", "value", "limit", "t"} == summary["violations"][0].keys()


def test_settings_in_numpys_numbers_can_be_written(robot: Robot, scene: Scene, tmp_path: Path) -> None:
    trajectory = plan(robot, scene, dt=np.float32(0.5), c_mu=np.float32(1.0), gain=np.ones(6, np.float32))
    write_trajectory(trajectory, tmp_path)
    assert read_trajectory(tmp_path).method == trajectory.method


def test_a_method_is_read_back_with_its_options_but_without_its_functions(
    trajectory: Trajectory, tmp_path: Path
) -> None:
    def upright(state: State) -> np.ndarray:
        return np.zeros_like(state.q)

    for method in (
        Auto(seed=3, max_planning_time=5.0, gain=[1.0, 2.0, 3.0]),
        Auto(),
        SafeVelocity(safety_distance=0.02, max_time=7.0),
        GradientProjection(engine="python", rtol=1e-3, far_clearances=True),
    ):
        write_trajectory(changed(trajectory, method=method), tmp_path)
        assert "Infinity" not in (tmp_path / "summary.json").read_text()
        assert read_trajectory(tmp_path).method == method
    write_trajectory(changed(trajectory, method=SafeVelocity(objectives=[upright], dt=0.02)), tmp_path)
    assert json.loads((tmp_path / "summary.json").read_text())["method"]["objectives"] == ["upright"]
    assert read_trajectory(tmp_path).method == SafeVelocity(dt=0.02)


@pytest.mark.parametrize("method", [{"name": "magic"}, {"name": "qp", "sead": 3}, {"name": "qp", "dt": -1.0}, "qp", {}])
def test_unknown_methods_and_options_are_bad_input(trajectory: Trajectory, method: object, tmp_path: Path) -> None:
    write_trajectory(trajectory, tmp_path)
    summary = json.loads((tmp_path / "summary.json").read_text())
    (tmp_path / "summary.json").write_text(json.dumps({**summary, "method": method}))
    with pytest.raises(InvalidInput, match=r"^trajectory is"):
        read_trajectory(tmp_path)


def test_without_an_engine_there_is_no_certificate(trajectory: Trajectory, tmp_path: Path) -> None:
    write_trajectory(changed(trajectory, certificate=None), tmp_path)
    assert json.loads((tmp_path / "summary.json").read_text())["certificate"] is None
    again = read_trajectory(tmp_path)
    assert again.certificate is None
    assert not again.certified


def test_a_contact_is_read_back(robot: Robot, tmp_path: Path) -> None:
    collided = plan_case(robot, 1, dt=0.05)
    assert collided.certificate.contact is not None
    write_trajectory(collided, tmp_path)
    assert read_trajectory(tmp_path).certificate == collided.certificate


def test_a_retimed_motion_is_read_back(robot: Robot, scene: Scene, trajectory: Trajectory, tmp_path: Path) -> None:
    motion = retime(trajectory, robot, scene)
    write_trajectory(motion, tmp_path)
    again = read_trajectory(tmp_path)
    np.testing.assert_array_equal(again.timing.acceleration, motion.timing.acceleration)
    assert again.timing.peaks == motion.timing.peaks
    assert again.summary() == motion.summary()


def test_min_clearance_is_null_without_obstacles(robot: Robot, scene: Scene, tmp_path: Path) -> None:
    write_trajectory(plan(robot, scene.model_copy(update={"obstacles": ()}), dt=0.5), tmp_path)
    assert json.loads((tmp_path / "summary.json").read_text())["min_clearance"] is None
    assert read_trajectory(tmp_path).clearance.shape[1] == 0


def test_collision_free_is_about_the_samples(trajectory: Trajectory) -> None:
    assert trajectory.collision_free
    clearance = trajectory.clearance.copy()
    clearance[3, 1] = -1e-6
    assert not changed(trajectory, clearance=clearance).collision_free


def test_nothing_is_left_half_written(trajectory: Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The disk is full at the first or only at the last file: nothing new appears, nothing old is touched."""
    write = Path.write_bytes

    def full_disk_at(name: str, path: Path, content: bytes) -> int:
        if name not in path.name:
            return write(path, content)
        write(path, content[:10])
        raise OSError("no space left on device")

    old = tmp_path / "old"
    write_trajectory(trajectory, old)
    before = {path.name: path.read_bytes() for path in old.iterdir()}
    for name in ("trajectory.npz", "summary.json"):
        monkeypatch.setattr(Path, "write_bytes", lambda path, content, at=name: full_disk_at(at, path, content))
        for folder in (old, tmp_path / "new"):
            with pytest.raises(InvalidInput, match="no space left"):
                write_trajectory(changed(trajectory, reason="another"), folder)
    assert {path.name: path.read_bytes() for path in old.iterdir()} == before
    assert not (tmp_path / "new").exists()


def test_folders_that_cannot_be_used(trajectory: Trajectory, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "below", "", tmp_path / ("x" * 300)):
        with pytest.raises(InvalidInput, match="out"):
            write_trajectory(trajectory, folder)
    with pytest.raises(InvalidInput, match="trajectory"):
        read_trajectory(tmp_path)
    write_trajectory(trajectory, tmp_path)
    (tmp_path / "trajectory.npz").write_bytes(b"PK\x03\x04 cut off")
    with pytest.raises(InvalidInput, match="trajectory"):
        read_trajectory(tmp_path)
    write_trajectory(trajectory, tmp_path)
    (tmp_path / "summary.json").write_text("{}")
    with pytest.raises(InvalidInput, match="trajectory"):
        read_trajectory(tmp_path)


def test_damaged_files_are_bad_input(trajectory: Trajectory, tmp_path: Path, rng: np.random.Generator) -> None:
    """Flipped bytes are found, or do not matter to what is read."""
    write_trajectory(trajectory, tmp_path)
    path = tmp_path / "trajectory.npz"
    whole = path.read_bytes()
    for _ in range(200):
        damaged = bytearray(whole)
        damaged[rng.integers(len(whole))] ^= rng.integers(1, 256)
        path.write_bytes(damaged)
        with suppress(InvalidInput):
            assert len(read_trajectory(tmp_path).q) == len(trajectory.t)


def test_arrays_have_something_for_each_sample(trajectory: Trajectory, tmp_path: Path) -> None:
    write_trajectory(trajectory, tmp_path)
    with np.load(tmp_path / "trajectory.npz") as file:
        arrays = dict(file)
    for name, value in (("t", trajectory.t[1:]), ("q", trajectory.q[:, 1:]), ("clearance", trajectory.clearance[1:])):
        np.savez(tmp_path / "trajectory.npz", **{**arrays, name: value})
        with pytest.raises(InvalidInput, match="is of shape"):
            read_trajectory(tmp_path)


def test_threads_can_write_to_the_same_folder(trajectory: Trajectory, tmp_path: Path) -> None:
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda _: write_trajectory(trajectory, tmp_path), range(40)))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["summary.json", "trajectory.csv", "trajectory.npz"]
    np.testing.assert_array_equal(read_trajectory(tmp_path).q, trajectory.q)
