"""The benchmark runs, and its figures are what it says."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT

pytest.importorskip("humanoid_rail.native", reason="the native engine was not built")
pytest.importorskip("pink", reason="needs the extra compare")

from benchmarks.engine import PER_METRE, aisle
from benchmarks.engine_report import seconds
from benchmarks.pink_baseline import Pink
from benchmarks.stopwatch import ratio
from humanoid_rail import Robot, Scene
from humanoid_rail.paper import dh_table as dh


def test_one_command_prints_tables_and_writes_json_and_markdown(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "<!-- times -->\nof last week\n<!-- /times -->\nkept\n<!-- ratios -->\n<!-- /ratios -->\n", encoding="utf-8"
    )
    options = ["--repeats", "1", "--plans", "8", "--json", tmp_path / "b.json", "--readme", page, "--docs", page]
    result = subprocess.run(
        [sys.executable, ROOT / "scripts" / "benchmark.py", *options], capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    report = json.loads((tmp_path / "b.json").read_text())
    for figure in report["figures"]:
        assert 0 < figure["low"] <= figure["median"] <= figure["high"], figure
    wanted = {row["what"]: row["wanted"] for row in report["ratios"] if row["wanted"]}
    assert len(wanted) == 10
    assert "holds" in result.stdout
    text = page.read_text()
    for row in report["ratios"]:
        assert f"| {row['what']} |" in text
    assert "last week" not in text
    assert "kept" in text


@pytest.mark.parametrize("options", [["--repeats", "0"], ["--plans", "-1"], ["--repeats", "many"]])
def test_bad_options_are_one_line(options: list[str]) -> None:
    result = subprocess.run(
        [sys.executable, ROOT / "scripts" / "benchmark.py", *options], capture_output=True, text=True, check=False
    )
    assert result.returncode == 2
    assert result.stderr.startswith("error: ")
    assert len(result.stderr.splitlines()) == 1


def test_ratios_are_taken_repeat_by_repeat() -> None:
    found = ratio("x", np.array([1.0, 4.0, 9.0]), np.array([1.0, 2.0, 3.0]), least=2.5)
    assert (found.median, found.low, found.high, found.holds) == (2.0, 1.5, 2.5, False)
    assert ratio("x", np.ones(3), np.ones(3), most=1.0).holds
    assert [seconds(x) for x in (2.0, 0.0123, 3.2e-6)] == ["2 s", "12.3 ms", "3.2 us"]


def test_spheres_are_as_dense_however_many(rng: np.random.Generator) -> None:
    for count in (10, 1000):
        y = [sphere.center[1] for sphere in aisle(count, rng)]
        assert len(y) == count
        assert np.ptp(y) == pytest.approx(count / PER_METRE, rel=0.3)


def test_pink_moves_the_same_robot_to_the_same_targets(robot: Robot, scene: Scene) -> None:
    pink = Pink(robot, scene, dt=0.02)
    np.testing.assert_allclose(pink.configuration.q, robot.initial)
    assert len(pink.configuration.collision_model.collisionPairs) == 18
    e = dh.hands(robot.initial) - [scene.targets["left"], scene.targets["right"]]
    assert pink.error() == pytest.approx(np.linalg.norm(e), abs=1e-9)
    rollout = pink.rollout(tolerance=0.05)
    assert rollout.reached
    assert np.linalg.norm(dh.hands(rollout.q[-1]) - [scene.targets["left"], scene.targets["right"]]) <= 0.05 + 1e-9
