"""The evaluation counts what planning scene by scene gives."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROOT

from benchmarks import evaluation
from benchmarks.planners import EVERY, RRT_CONNECT, Motion, make_planner
from humanoid_rail import Box, Certificate, Robot, Scene, load_scene, plan
from humanoid_rail.planning.methods import METHODS

DEV = ROOT / "scenes" / "dev"
NAMES = ("dense-240000", "dense-240009", "sparse-80000")


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three scenes of two families."""
    folder = tmp_path_factory.mktemp("scenes")
    for name in NAMES:
        shutil.copy(DEV / f"{name}.json", folder)
    (folder / "notes.txt").write_text("no scene")
    return folder


def run(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "benchmarks.evaluate", *map(str, arguments)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )


def rows_of(report: dict[str, Any]) -> dict[tuple[str, str], dict[str, Any]]:
    return {(row["family"], row["method"]): row for row in report["rows"]}


def test_one_command_prints_a_table_and_writes_json_and_markdown_and_a_picture(
    folder: Path, robot: Robot, tmp_path: Path
) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "kept\n<!-- evaluation -->\nof last week\n<!-- /evaluation -->\n<!-- results -->\n<!-- /results -->\n",
        encoding="utf-8",
    )
    files = ["--json", tmp_path / "made" / "e.json", "--figure", tmp_path / "e.png", "--table", page, "--results", page]
    result = run(folder, *files)
    assert (result.returncode, result.stderr) == (0, ""), result.stderr
    assert "gradient-projection" in result.stdout
    text = page.read_text()
    assert "| dense | qp | 2/2 |" in text
    assert re.search(r"^\| qp \| 3/3 \| [\d.]+ \| [\d.]+ \|$", text, re.MULTILINE), text
    assert "kept" in text
    assert "last week" not in text
    assert (tmp_path / "e.png").read_bytes().startswith(b"\x89PNG")

    report = json.loads((tmp_path / "made" / "e.json").read_text())
    assert [(o["scene"], o["method"]) for o in report["outcomes"]] == [
        (name, method) for name in NAMES for method in METHODS
    ]
    for outcome in report["outcomes"]:
        found = plan(robot, load_scene(folder / f"{outcome['scene']}.json"), outcome["method"])
        assert (outcome["status"], outcome["reason"]) == (found.status, found.reason)
        assert outcome["certified"] == found.certified
        assert outcome["touched"] == (found.certificate.contact is not None)
        assert outcome["min_clearance_obstacles"] == pytest.approx(found.min_clearance_obstacles)
        assert outcome["min_clearance_self"] == pytest.approx(found.min_clearance_self)
        assert outcome["duration"] == pytest.approx(found.duration)
        assert outcome["planning_time"] > 0
        assert (outcome["excess"] > 0) == (not found.limits_ok)
    rows = rows_of(report)
    assert list(rows) == [(f, m) for f in ("dense", "sparse", "all") for m in METHODS]
    for (family, method), row in rows.items():
        mine = [o for o in report["outcomes"] if o["method"] == method and family in (o["family"], "all")]
        assert row["scenes"] == len(mine)
        assert row["reached"] == sum(o["status"] == "reached" for o in mine)
        assert row["reached_and_certified"] == sum(o["status"] == "reached" and o["certified"] for o in mine)
        assert row["touched"] == sum(o["touched"] for o in mine)
        assert row["beyond_limits"] == sum(o["excess"] > 1e-6 for o in mine)
        assert row["median_time"] == pytest.approx(np.median([o["planning_time"] for o in mine]))
        assert row["median_time"] <= row["p95_time"] <= max(o["planning_time"] for o in mine)
        assert row["min_clearance_self"] == min(o["min_clearance_self"] for o in mine)


def test_families_and_methods_are_selected(folder: Path, tmp_path: Path) -> None:
    options = ["--family", "sparse", "--method", "qp", "--json", tmp_path / "e.json", "--figure", tmp_path / "e.svg"]
    result = run(folder, *options)
    assert result.returncode == 0, result.stderr
    report = json.loads((tmp_path / "e.json").read_text())
    assert list(rows_of(report)) == [("sparse", "qp")]  # and no total of one family
    assert report["rows"][0]["reached_and_certified"] == 1
    assert "<svg" in (tmp_path / "e.svg").read_text()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--family", "shelf"], "family is 'shelf'; valid: one of dense, sparse"),
        (["--method", "rrt"], f"method is 'rrt'; valid: one of {', '.join(EVERY)}"),
        (["--figure", "figure.pdf"], "valid: a file name that ends in .png or .svg"),
        (["--json", "/dev/null/e.json"], "out is '/dev/null'"),
    ],
)
def test_bad_options_are_one_line(options: list[str], said: str, folder: Path) -> None:
    result = run(folder, *options)
    assert (result.returncode, result.stdout, result.stderr.count("\n")) == (2, "", 1), result.stderr
    assert result.stderr.startswith("error: ")
    assert said in result.stderr


def test_a_folder_without_scenes_is_named(robot: Robot, tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("no scene")
    for folder in (tmp_path, tmp_path / "missing"):
        with pytest.raises(ValueError, match=rf"{folder}: scenes is missing; .* \(\*\.json, \*\.yaml"):
            evaluation.load_families(robot, str(folder))


def test_a_scene_that_is_not_for_the_robot_is_named(robot: Robot, tmp_path: Path) -> None:
    (tmp_path / "x.yml").write_text("name: x\ntargets: {left: [0, 0, 3]}\n")
    with pytest.raises(ValueError, match=r"x\.yml: targets\.right is missing"):
        evaluation.load_families(robot, str(tmp_path))


@pytest.mark.parametrize(
    ("name", "family"),
    [
        ("sparse-80000", "sparse"),
        ("top-shelf-7", "top-shelf"),
        ("shelf", "shelf"),
        ("-7", "-7"),
    ],
)
def test_the_family_is_the_name_without_its_number(name: str, family: str) -> None:
    assert evaluation.family_of(Scene(name=name, targets={})) == family


def test_a_start_in_contact_is_a_result(robot: Robot, scene: Scene) -> None:
    inside = scene.model_copy(update={"obstacles": (Box(center=(0.0, 0.0, 1.5), size=(1.0, 1.0, 1.0)),)})
    planners = {"qp": make_planner("qp")}
    outcomes = evaluation.evaluate(robot, [inside, scene], planners)
    assert [outcome.status for outcome in outcomes] == ["failed", "reached"]
    assert "start clear of obstacles" in outcomes[0].reason
    (row,) = evaluation.make_rows(outcomes[:1])
    assert (row.failed, row.certified, row.touched, row.path_length) == (1, 0, 0, None)


def test_the_path_is_as_long_as_it_takes_at_the_speed_limits(robot: Robot) -> None:
    q = robot.initial + np.outer([0.0, 1.0, 3.0, 2.0], np.eye(robot.n)[0] * robot.velocity_limit[0])
    motion = Motion(np.arange(4.0), q, "reached", "", Certificate(True, None, None, None, None), (), 0.0)
    outcome = evaluation.judge(robot, load_scene(DEV / "sparse-80000.json"), "any", motion)
    assert outcome.path_length == pytest.approx(4.0)
    assert outcome.sharpest_turn == pytest.approx(np.pi)
    assert outcome.sampled_length is None


def test_the_textbooks_planner_is_judged_like_this_one(robot: Robot) -> None:
    scene = load_scene(DEV / "sparse-80000.json")
    planner = make_planner(RRT_CONNECT)
    outcome = evaluation.judge(robot, scene, RRT_CONNECT, evaluation.attempt(planner, robot, scene))
    assert outcome.reached
    assert outcome.excess <= 1e-6
    assert outcome.sampled_length > outcome.path_length > plan(robot, scene).path.length


def test_pink_is_judged_like_the_planner(robot: Robot) -> None:
    pytest.importorskip("pink", reason="needs the extra compare")
    scene = load_scene(DEV / "sparse-80000.json")
    motion = evaluation.attempt(make_planner("pink"), robot, scene)
    outcome = evaluation.judge(robot, scene, "pink", motion)
    assert outcome.good
    assert outcome.excess <= 1e-6
    assert min(outcome.min_clearance_obstacles, outcome.min_clearance_self) > 0.009
    # An obstacle on the move is not for Pink.
    moving = scene.obstacles[0].model_copy(update={"velocity": (0.1, 0.0, 0.0)})
    motion = evaluation.attempt(make_planner("pink"), robot, scene.model_copy(update={"obstacles": (moving,)}))
    assert motion.status == "failed"
    assert "velocity" in motion.reason
