"""Motions of several planners are judged alike and compared scene by scene."""

from __future__ import annotations

import json
import shutil
from contextlib import ExitStack
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from conftest import ROOT

from benchmarks import compare_motions
from benchmarks.compare_motions import cells, command, compare
from benchmarks.motions import (
    BEFORE,
    DRAKE_SEEDED,
    DRAKE_STRAIGHT,
    OPTIMISED,
    QUICK,
    ROBOPLAN,
    Outcome,
    judge,
    largest_rates,
    least_duration,
    make_rows,
)
from humanoid_rail import Robot, Scene, load_scene, plan, retime
from humanoid_rail.errors import HumanoidRailError, InvalidInput

SCENE = ROOT / "scenes" / "dev" / "sparse-80000.json"
KNOWN = {"scene": "sparse-80000", "family": "sparse", "seed": 0, "method": QUICK}


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene(SCENE)


@pytest.fixture(scope="module")
def answer(robot: Robot, scene: Scene) -> dict[str, Any]:
    """A retimed plan, as a worker hands it over."""
    motion = retime(plan(robot, scene))
    assert motion.timing is not None
    times = {"planning_time": 0.5, "time": 0.75, "reason": motion.reason}
    return {**times, "t": motion.t, "q": motion.q, "velocity": motion.timing.velocity}


def ramp(robot: Robot, joint: int, way: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the fastest motion of one joint along a way that has room for its limit of velocity."""
    fastest, strongest = robot.velocity_limit[joint], robot.acceleration_limit[joint]
    rise = fastest / strongest
    t = np.array([0.0, rise, way / fastest, way / fastest + rise])
    q, velocity = np.tile(robot.initial, (4, 1)), np.zeros((4, robot.n))
    q[:, joint] += [0.0, 0.5 * fastest * rise, way - 0.5 * fastest * rise, way]
    velocity[1:3, joint] = fastest
    return t, q, velocity


def test_the_bound_is_the_slowest_joint_alone(robot: Robot) -> None:
    t, q, _ = ramp(robot, 0, 4.0)
    assert least_duration(robot, q[0], q[-1]) == pytest.approx(t[-1]) == pytest.approx(2.5)
    goal = robot.initial.copy()
    goal[1] += 0.1  # too short for its limit of velocity
    goal[5] -= 0.05
    assert least_duration(robot, robot.initial, goal) == pytest.approx(2.0 * np.sqrt(0.1 / robot.acceleration_limit[1]))
    assert least_duration(robot, goal, goal) == 0.0


def test_rates_are_in_units_of_the_limits_and_ends_have_to_rest(robot: Robot) -> None:
    t, q, velocity = ramp(robot, 0, 4.0)
    assert largest_rates(robot, t, q, velocity) == pytest.approx((1.0, 1.0), abs=1e-9)
    assert largest_rates(robot, t / 1.1, q, 1.1 * velocity) == pytest.approx((1.1, 1.21), abs=1e-2)
    cut = largest_rates(robot, t[1:] - t[1], q[1:], velocity[1:])
    assert cut[0] == pytest.approx(1.0)
    assert cut[1] > 100.0
    assert largest_rates(robot, t[:1], q[:1], velocity[:1]) == (0.0, 0.0)


def test_motions_are_judged_by_themselves(robot: Robot, scene: Scene, answer: dict[str, Any]) -> None:
    found = judge(robot, scene, KNOWN, answer)
    assert (found.good, found.touched, found.excess) == (True, False, 0.0)
    assert (found.planning_time, found.total_time, found.duration) == (0.5, 0.75, answer["t"][-1])
    assert found.bound is not None
    assert 0.9 * answer["t"][-1] < found.bound <= answer["t"][-1]
    faster = judge(robot, scene, KNOWN, {**answer, "t": answer["t"] / 1.1, "velocity": 1.1 * answer["velocity"]})
    assert faster.good
    assert 0.1 < faster.excess < 0.25
    half = len(answer["t"]) // 2
    short = judge(robot, scene, KNOWN, {**answer, **{name: answer[name][:half] for name in ("t", "q", "velocity")}})
    assert (short.reached, short.certified) == (False, True)
    high = np.array(answer["q"])
    high[:, 0] += robot.upper[0] - high[:, 0].max() + 0.25
    assert judge(robot, scene, KNOWN, {**answer, "q": high}).excess == pytest.approx(0.25)
    none = judge(robot, scene, KNOWN, {"failed": "no path was found", "planning_time": 2.0})
    assert (none.reached, none.reason, none.total_time, none.duration) == (False, "no path was found", 2.0, None)


def outcome(scene: str, method: str, time: float, duration: float | None, **more: Any) -> Outcome:
    family = scene.partition("-")[0]
    known = Outcome(scene, family, 0, method, "", time, 2.0 * time, True, True, False, 0.0, duration, 1.0)
    return replace(known, **more)


def test_rows_compare_with_the_commit_before_and_with_drake() -> None:
    outcomes = [
        *(outcome(f"a-{k}", BEFORE, time, 2.0) for k, time in enumerate((1.0, 2.0, 4.0))),
        outcome("a-0", QUICK, 1.0, 1.0),
        outcome("a-1", QUICK, 1.0, 3.0, excess=2e-6),
        outcome("a-2", QUICK, 1.0, 9.0, certified=False, touched=True),
        outcome("a-0", DRAKE_SEEDED, 5.0, 0.8),
        outcome("a-1", DRAKE_SEEDED, 5.0, 2.0, excess=9e-7),
        outcome("b-0", QUICK, 1.0, None, reached=False, bound=None),
    ]
    rows = {(row.family, row.method): row for row in make_rows(outcomes)}
    assert {family for family, _ in rows} == {"a", "b", "all"}
    row = rows["a", QUICK]
    assert (row.motions, row.reached, row.certified, row.touched, row.beyond_limits) == (3, 3, 2, 1, 1)
    assert (row.median_time, row.total_time) == (1.0, 2.0)
    assert (row.median_to_before, row.by_scene_to_before) == (0.5, 0.5)
    assert row.p95_to_before == pytest.approx(1.0 / 3.8)
    assert (row.duration, row.to_bound) == (2.0, 2.0)  # what touches something is no motion
    assert (row.duration_to_before, row.duration_by_scene, row.longest_to_before) == (1.0, 1.0, 1.5)
    assert row.to_drake == pytest.approx(np.median([1.0 / 0.8, 1.5]))
    assert rows["a", DRAKE_SEEDED].beyond_limits == 0
    assert rows["all", QUICK].reached == 3
    empty = rows["b", QUICK]
    assert (empty.duration, empty.to_bound, empty.median_to_before, empty.to_drake) == (None,) * 4
    assert cells(empty)[:6] == ["b", QUICK, "0/1", "1/1", "0", "0"]
    assert len(cells(empty)) == len(compare_motions.COLUMNS)


def test_planners_take_turns_and_the_fastest_answer_counts(robot: Robot, scene: Scene, answer: dict[str, Any]) -> None:
    asked: list[str] = []

    def planner(name: str) -> compare_motions.Planner:
        def ask(file: Path, seed: int, quick: compare_motions.Answer) -> compare_motions.Answer:
            asked.append(name)
            assert (file, seed) == (SCENE, 3)
            assert ("t" in quick) == (name == DRAKE_STRAIGHT)
            return {**answer, "time": 10.0 - len(asked), "planning_time": 5.0 - len(asked) / 2}

        return ask

    planners = {name: planner(name) for name in (QUICK, BEFORE, DRAKE_STRAIGHT)}
    found = {one.method: one for one in compare(robot, scene, SCENE, 3, planners, 2)}
    assert asked == [QUICK, BEFORE, BEFORE, QUICK, DRAKE_STRAIGHT]
    assert [found[name].total_time for name in planners] == [6.0, 7.0, 5.0]
    assert all(one.good and one.seed == 3 for one in found.values())


class Named:
    """Stands in for a checkout whose `Auto` has some options."""

    def __init__(self, *options: str) -> None:
        self.about, self.asked = {"options": options}, list[Any]()

    def ask(self, request: Any) -> dict[str, Any]:
        self.asked.append(request["options"])
        return {}

    def close(self) -> None:
        pass


def test_the_quick_plan_is_asked_for_where_there_is_another(monkeypatch: pytest.MonkeyPatch) -> None:
    for options, expected in ((("seed",), {QUICK: {}}), (("optimise",), {QUICK: {"optimise": False}, OPTIMISED: {}})):
        own = Named(*options)
        monkeypatch.setattr(compare_motions, "Checkout", lambda folder, script, own=own: own)
        monkeypatch.setattr(compare_motions, "_version", lambda package: None)
        with ExitStack() as stack:
            planners = compare_motions.start((), None, stack)
            for planner in planners.values():
                planner(SCENE, 7, {})
        assert list(planners) == list(expected)
        assert own.asked == [{**given, "seed": 7} for given in expected.values()]


@pytest.mark.parametrize("method", ["pink", BEFORE, OPTIMISED, ROBOPLAN, DRAKE_SEEDED])
def test_what_is_not_there_is_named(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compare_motions, "Checkout", lambda folder, script: Named())
    monkeypatch.setattr(compare_motions, "_version", lambda package: None)
    with ExitStack() as stack, pytest.raises(InvalidInput, match="method"):
        compare_motions.start((method,), None, stack)


def test_a_process_that_ends_is_named() -> None:
    worker = compare_motions.Worker(["true"])
    with pytest.raises(HumanoidRailError, match="ended"):
        worker.ask({})
    worker.close()


@pytest.mark.skipif(not (ROOT / ".venv" / "bin" / "python").exists(), reason="the checkout has no .venv")
def test_one_command_compares_what_is_installed(tmp_path: Path) -> None:
    folder, page, file = tmp_path / "scenes", tmp_path / "page.md", tmp_path / "motions.json"
    folder.mkdir()
    shutil.copy(SCENE, folder)
    page.write_text("<!-- motions -->\n<!-- /motions -->\n", encoding="utf-8")
    options = ["--base", str(ROOT), "--repeats", "1", "--json", str(file), "--table", str(page)]
    result = CliRunner().invoke(command, [str(folder), *options], standalone_mode=False)
    assert result.exception is None
    outcomes = {one["method"]: one for one in json.loads(file.read_text())["outcomes"]}
    expected = {QUICK, BEFORE}
    expected |= {ROBOPLAN} if find_spec("roboplan") else set()
    expected |= {DRAKE_STRAIGHT, DRAKE_SEEDED} if find_spec("pydrake") else set()
    assert outcomes.keys() - {OPTIMISED} == expected
    for method, one in outcomes.items():
        assert one["reached"], method
        assert one["certified"], method
        assert one["excess"] < 1e-3, method
        assert one["duration"] > one["bound"] * (1.0 - 1e-6), method
        assert one["total_time"] > 0.0, method
    for method in {DRAKE_STRAIGHT, DRAKE_SEEDED} & expected:
        assert outcomes[method]["bound"] == pytest.approx(outcomes[QUICK]["bound"], rel=1e-5)
        assert outcomes[method]["duration"] < outcomes[QUICK]["duration"]
    assert f"| sparse | {QUICK} | 1/1 | 1/1 | 0 | 0 |" in page.read_text()


def test_the_committed_table_is_of_all_scenes() -> None:
    text = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")
    table = text.partition("<!-- motions -->")[2].partition("<!-- /motions -->")[0]
    scenes = len(list((ROOT / "scenes" / "dev").glob("*.json")))
    for method in (QUICK, BEFORE):
        assert f"| all | {method} | {scenes}/{scenes} | {scenes}/{scenes} | 0 | 0 |" in table
