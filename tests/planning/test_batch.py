"""Many scenes at once: order, failures, dying workers, other backends."""

from __future__ import annotations

import os
import pickle
import signal
from dataclasses import replace
from pathlib import Path
from typing import Any

import joblib
import numpy as np
import pytest
from conftest import ROOT, plan, plan_many

from humanoid_rail import InvalidInput, Robot, Scene, Trajectory, WorkerDied, load_scene
from humanoid_rail.planning import batch
from humanoid_rail.planning.shared_memory import pack, shared_folder, unpack


@pytest.fixture(scope="module")
def scenes() -> list[Scene]:
    return [load_scene(path) for path in sorted((ROOT / "scenes" / "dev").glob("sparse-*.json"))[:6]]


def bad(scene: Scene) -> Scene:
    return scene.model_copy(update={"name": "bad", "targets": {"left": (0.0, 0.0, 3.0)}})


def same(a: object, b: Trajectory) -> bool:
    if not isinstance(a, Trajectory) or a.provenance.scene != b.provenance.scene:
        return False
    return np.array_equal(a.q, b.q) and a.method == b.method


@pytest.mark.parametrize("n_jobs", [1, 2])
def test_results_are_those_of_plan_in_order(robot: Robot, scenes: list[Scene], n_jobs: int) -> None:
    many = [*scenes, *scenes, *scenes, *scenes]
    outcomes = plan_many(robot, iter(many), n_jobs=n_jobs, dt=0.05, c_mu=0.5)
    assert len(outcomes) == len(many)
    for scene, outcome in zip(many, outcomes, strict=True):
        assert same(outcome, plan(robot, scene, dt=0.05, c_mu=0.5)), scene.name
        assert isinstance(outcome, Trajectory)
        for array in (outcome.q, outcome.t, outcome.hands, outcome.clearance, outcome.manipulability):
            assert not array.flags.writeable


@pytest.mark.parametrize("n_jobs", [1, 2])
def test_a_failing_scene_is_an_error_in_its_place(robot: Robot, scenes: list[Scene], n_jobs: int) -> None:
    outcomes = plan_many(robot, [scenes[0], bad(scenes[0]), scenes[1]], n_jobs=n_jobs, dt=0.05)
    assert same(outcomes[0], plan(robot, scenes[0], dt=0.05))
    assert isinstance(outcomes[1], InvalidInput)
    assert outcomes[1].field == "targets.right"
    assert same(outcomes[2], plan(robot, scenes[1], dt=0.05))


class Deadly(Scene):
    """A scene that kills the process it is planned in, as a crash or a lack of memory would."""

    parent: int

    def __getattribute__(self, name: str) -> Any:
        if name == "initial" and os.getpid() != super().__getattribute__("parent"):
            os.kill(os.getpid(), signal.SIGKILL)
        return super().__getattribute__(name)


def test_not_even_a_dying_worker_takes_others_down(robot: Robot, scenes: list[Scene]) -> None:
    deadly = Deadly(**{**scenes[0].model_dump(), "obstacles": (), "name": "deadly", "parent": os.getpid()})
    many = [*scenes[:3], deadly, *scenes[3:]]
    outcomes = plan_many(robot, many, n_jobs=2, dt=0.05)
    assert isinstance(outcomes[3], WorkerDied)
    assert "deadly" in str(outcomes[3])
    alive = [*outcomes[:3], *outcomes[4:]]
    for scene, outcome in zip(scenes, alive, strict=True):
        assert same(outcome, plan(robot, scene, dt=0.05))


def test_errors_that_do_not_pickle_come_back_as_text() -> None:
    error = RuntimeError("odd")
    error.held = lambda: None  # type: ignore[attr-defined]
    assert str(batch._that_pickles(error)) == "RuntimeError: odd"
    whole = InvalidInput("initial", [1.0], "something", "file")
    assert batch._that_pickles(whole) is whole
    assert str(pickle.loads(pickle.dumps(whole))) == str(whole)


@pytest.mark.parametrize(
    ("arguments", "field"),
    [({"method": "magic"}, "method"), ({"method": 3}, "method"), ({"gain": (1.0, 1.0)}, "gain")],
)
def test_arguments_that_are_wrong_for_every_scene_are_raised(
    robot: Robot, scenes: list[Scene], arguments: dict[str, Any], field: str
) -> None:
    with pytest.raises(InvalidInput) as caught:
        plan_many(robot, scenes, n_jobs=2, **arguments)
    assert caught.value.field == field


@pytest.mark.parametrize("n_jobs", [1, 2])
def test_objectives_go_to_the_workers(robot: Robot, scenes: list[Scene], n_jobs: int) -> None:
    """Also those that only cloudpickle pickles. Their errors are the outcomes of their scenes."""
    rail = np.eye(robot.n)[0]
    objectives = (lambda state: -0.5 * rail,)
    outcomes = plan_many(robot, scenes[:2], n_jobs=n_jobs, method="qp", dt=0.05, objectives=objectives)
    for scene, outcome in zip(scenes, outcomes, strict=False):
        assert isinstance(outcome, Trajectory)
        np.testing.assert_array_equal(outcome.q, plan(robot, scene, "qp", dt=0.05, objectives=objectives).q)
        assert not np.array_equal(outcome.q, plan(robot, scene, "qp", dt=0.05).q)

    def broken(state: Any) -> np.ndarray:
        raise ZeroDivisionError("of the objective")

    for outcome in plan_many(robot, scenes[:2], n_jobs=n_jobs, objectives=[broken]):
        assert isinstance(outcome, ZeroDivisionError)
        assert str(outcome) == "of the objective"


@pytest.mark.parametrize("n_jobs", [1, 2])
def test_an_objective_that_fails_in_one_scene_leaves_the_others(robot: Robot, scenes: list[Scene], n_jobs: int) -> None:
    """What it returns depends on the state, so it is that scene's outcome and no wrong argument."""
    many = [scenes[0].model_copy(update={"obstacles": ()}), scenes[1]]
    assert scenes[1].obstacles

    def without_obstacles(state: Any) -> np.ndarray:
        return np.full(state.q.size, 0.0 if state.clearance.size else np.nan)

    failed, planned = plan_many(robot, many, n_jobs=n_jobs, dt=0.05, objectives=[without_obstacles])
    assert isinstance(failed, InvalidInput)
    assert failed.field == "objectives[0](state)"
    assert isinstance(planned, Trajectory)


def test_unknown_arguments_and_jobs_are_refused(robot: Robot, scenes: list[Scene]) -> None:
    with pytest.raises(InvalidInput, match="speed is 3"):
        plan_many(robot, scenes, speed=3)
    for n_jobs in (0, 1.5, "two", True):
        with pytest.raises(InvalidInput, match="n_jobs"):
            plan_many(robot, scenes, n_jobs=n_jobs)  # type: ignore[arg-type]


@pytest.mark.parametrize("scenes", ["scenes/dev", 3, [1], None])
def test_what_is_no_list_of_scenes_is_refused(robot: Robot, scenes: Any) -> None:
    with pytest.raises(InvalidInput, match="scenes"):
        plan_many(robot, scenes)


def test_one_scene_is_no_list_and_a_robot_is_needed(robot: Robot, scenes: list[Scene]) -> None:
    with pytest.raises(InvalidInput, match="a list of scenes"):
        plan_many(robot, scenes[0])  # type: ignore[arg-type]
    with pytest.raises(InvalidInput, match="robot"):
        plan_many(None, scenes)  # type: ignore[arg-type]


def test_backends_that_have_no_results_before_the_last(robot: Robot, scenes: list[Scene]) -> None:
    with joblib.parallel_config(backend="multiprocessing"):
        outcomes = plan_many(robot, scenes, n_jobs=2, dt=0.05)
    for scene, outcome in zip(scenes, outcomes, strict=True):
        assert same(outcome, plan(robot, scene, dt=0.05))


def test_no_scenes(robot: Robot) -> None:
    assert plan_many(robot, []) == []


def test_progress_goes_to_stderr(robot: Robot, scenes: list[Scene], capfd: pytest.CaptureFixture[str]) -> None:
    plan_many(robot, scenes, n_jobs=1, dt=0.05, progress=True)
    shown = capfd.readouterr()
    assert shown.out == ""
    assert "planning" in shown.err
    assert "6/6" in shown.err
    plan_many(robot, scenes, n_jobs=1, dt=0.05)
    assert capfd.readouterr().err == ""


def test_threads(robot: Robot, scenes: list[Scene]) -> None:
    with joblib.parallel_config(backend="threading"):
        outcomes = plan_many(robot, scenes * 4, n_jobs=4, dt=0.05)
    for scene, outcome in zip(scenes * 4, outcomes, strict=True):
        assert same(outcome, plan(robot, scene, dt=0.05))


def test_a_dask_cluster(robot: Robot, scenes: list[Scene]) -> None:
    distributed = pytest.importorskip("distributed", reason="needs the extra dask")
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=40)
    with cluster, distributed.Client(cluster), joblib.parallel_config(backend="dask"):
        outcomes = plan_many(robot, [*scenes, bad(scenes[0])], n_jobs=-1, dt=0.05)
    for scene, outcome in zip(scenes, outcomes[:-1], strict=True):
        assert same(outcome, plan(robot, scene, dt=0.05))
    assert isinstance(outcomes[-1], InvalidInput)


def test_parcels(robot: Robot, scenes: list[Scene], tmp_path: Path) -> None:
    trajectory = replace(plan(robot, scenes[0], dt=0.05), robot=None, scene=None)
    with shared_folder() as folder:
        parcel = pack([trajectory, "text"], folder)
        assert len(parcel.pickled) < 6000
        assert parcel.file is not None
        (again, text) = unpack(parcel)
        assert (same(again, trajectory), text) == (True, "text")
        assert not parcel.file.exists()
        assert not again.q.flags.writeable
    np.testing.assert_array_equal(again.q, trajectory.q)
    elsewhere = pack([trajectory], str(tmp_path / "another machine"))
    assert elsewhere.file is None
    assert same(unpack(elsewhere)[0], trajectory)
    assert unpack(pack(["no arrays"], str(tmp_path))) == ["no arrays"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a full device")
def test_a_full_shared_memory_is_no_failure(
    robot: Robot, scenes: list[Scene], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trajectory = plan(robot, scenes[0], dt=0.05)
    opened = Path.open
    monkeypatch.setattr(Path, "open", lambda self, *a, **k: opened(Path("/dev/full"), *a, **k))
    parcel = pack([trajectory], str(tmp_path))
    assert parcel.file is None
    assert same(unpack(parcel)[0], trajectory)
