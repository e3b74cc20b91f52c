"""Scenes name their robot, and start by posture or by joint."""

from __future__ import annotations

import json
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner
from conftest import AHEAD, ROOT, plan

from humanoid_rail import InvalidInput, Robot, Scene, load_robot_of_scene, load_scene, make_scene, plan_many
from humanoid_rail.cli import commands
from humanoid_rail.scene.scene import check_scene, start_of_scene

sys.path.append(str(ROOT / "tests" / "model"))
from saved_robots import assert_same, load, write_robot

TARGETS = {"tool": [0.9, 0.7, 0.4]}
HANDS = {"tool": {"frame": "b4", "arm": ["j0", "j1", "j2", "j3", "j4"], "pointing": None}}
ENTRY: dict[str, Any] = {
    "name": "renamed",
    "urdf": "robots/meshy.urdf",
    "srdf": "robots/meshy.srdf",
    "joints": ["j0", "j1", "j2", "j3", "j4"],
    "locked": "every other joint, at 0 (at the nearest limit where 0 is outside the limits)",
    "locked_joints": ["grip"],
    "continuous_joints_within": [-3.0, 3.0],
    "hands": HANDS,
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    write_robot(tmp_path / "robots")
    return tmp_path


def write_scene(folder: Path, **fields: Any) -> Path:
    file = folder / "scene.json"
    file.write_text(json.dumps({"targets": TARGETS, **fields}), encoding="utf-8")
    return file


def test_a_scene_says_all_of_its_robot(folder: Path) -> None:
    file = write_scene(folder, robot=ENTRY, initial="bent", expect={"status": "reached"}, checked={"by": ["hand"]})
    schema = json.loads((ROOT / "humanoid_rail" / "scene.schema.json").read_text(encoding="utf-8"))
    jsonschema.validate(json.loads(file.read_text()), schema)
    scene = load_scene(file)
    robot = load_robot_of_scene(scene)
    assert (robot.name, robot.hand_names, robot.locked) == ("renamed", ("tool",), {"grip": 0.01})
    assert robot.upper[4] == 3.0
    assert scene.expect == {"status": "reached"}
    start = start_of_scene(robot, scene)
    assert start[1] == 0.5
    np.testing.assert_array_equal(plan(robot, scene, "gradient-projection", dt=0.1).q[0], start)


def test_a_scene_names_a_folder_relative_to_it(folder: Path) -> None:
    saved = load(folder / "robots" / "meshy.urdf")
    saved.save(folder / "saved")
    for said in ("saved", "saved/robot.yaml", str(folder / "saved")):
        assert_same(load_robot_of_scene(load_scene(write_scene(folder, robot=said))), saved)


def test_the_papers_robot_is_that_of_scenes_that_name_none(robot: Robot) -> None:
    for said in (None, "humanoid_rail"):
        assert_same(load_robot_of_scene(Scene(robot=said, targets=AHEAD)), robot)


def test_joints_that_are_not_named_start_where_the_robot_does(robot: Robot) -> None:
    start = start_of_scene(robot, Scene(targets=AHEAD, initial={"rail": 0.5}))
    assert start[0] == 0.5
    np.testing.assert_array_equal(start[1:], robot.initial[1:])


@pytest.mark.parametrize(
    ("initial", "field", "said"),
    [("bnet", "initial", "did you mean bent?; there are: bent"), ({"j9": 0.0}, "initial.j9", "j0, j1, j2, j3, j4")],
)
def test_what_a_start_names_has_to_be_there(initial: Any, field: str, said: str, folder: Path) -> None:
    robot = load(folder / "robots" / "meshy.urdf")
    with pytest.raises(InvalidInput) as caught:
        check_scene(robot, Scene(targets=TARGETS, initial=initial))
    assert caught.value.field == field
    assert said in caught.value.valid


@pytest.mark.parametrize(
    ("said", "field"),
    [
        ({**ENTRY, "hands": {"tool": {"farme": "b4"}}}, "robot.hands.tool.farme"),
        ({**ENTRY, "locked": "none"}, "robot.locked"),
        (7, "robot"),
    ],
)
def test_what_is_wrong_in_a_robot_is_named(said: Any, field: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        make_scene({"targets": TARGETS, "robot": said})
    assert caught.value.field == field


def test_a_robot_that_is_not_there_names_those_that_are(folder: Path) -> None:
    with pytest.raises(InvalidInput, match="humanoid_rail"):
        load_robot_of_scene(load_scene(write_scene(folder, robot="nobody")))


def test_the_command_takes_the_robot_of_the_scene_or_another(folder: Path) -> None:
    file, runner = str(write_scene(folder, robot=ENTRY, initial="bent")), CliRunner()

    def run(*arguments: str) -> tuple[int, str]:
        found = runner.invoke(commands, arguments, standalone_mode=False)
        return found.return_value if found.exception is None else 2, str(found.exception)

    options = ("--no-view", "--method", "gradient-projection", "--dt", "0.1")
    assert run("plan", file, *options, "--no-page", "--out", str(folder / "out"))[0] in (0, 1)
    assert run("verify", str(folder / "out"))[0] in (0, 1)
    assert load_scene(folder / "out" / "scene.json").robot == str(folder / "out" / "robot.yaml")
    load(folder / "robots" / "meshy.urdf").save(folder / "saved")
    assert run("plan", str(write_scene(folder)), *options, "--robot", str(folder / "saved"))[0] in (0, 1)
    file = str(write_scene(folder, robot=ENTRY))
    for more, said in (
        (("--link-radius", "0.1"), "link_radius"),
        (("--set", "beta=1"), "beta"),
        (("--srdf", "x.srdf"), "--srdf needs --robot"),
        (("--robot", "nobody"), "one of humanoid_rail"),
    ):
        code, error = run("plan", file, *options, *more)
        assert code == 2
        assert said in error


def test_many_scenes_of_a_robot_with_meshes_are_planned(folder: Path) -> None:
    scene = load_scene(write_scene(folder, robot=ENTRY, initial="bent"))
    robot = load_robot_of_scene(scene)
    alone = plan(robot, scene, "qp")
    for found in plan_many(robot, [scene, scene], "qp", n_jobs=2):
        np.testing.assert_array_equal(found.q, alone.q)


def test_a_robot_of_a_package_is_named_with_its_version() -> None:
    try:
        there = metadata.version("example-robot-data")
    except metadata.PackageNotFoundError:
        pytest.skip("example-robot-data is not installed")
    robot = {"package": f"example-robot-data=={there}", "urdf": "panda_description/urdf/panda.urdf", "name": "p"}
    scene = make_scene({"targets": {"hand": [0.5, 0.0, 0.4]}, "robot": robot})
    assert load_robot_of_scene(scene).name == "p"
