"""Scene files: what they may hold, and what is said of those that hold something else."""

from __future__ import annotations

import copy
import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from conftest import ROOT

from humanoid_rail import (
    Box,
    Capsule,
    HalfSpace,
    InvalidInput,
    Kinematics,
    Mesh,
    Robot,
    Sphere,
    load_scene,
    make_scene,
)

SCHEMA = json.loads((ROOT / "humanoid_rail" / "scene.schema.json").read_text(encoding="utf-8"))
DEV = sorted((ROOT / "scenes" / "dev").glob("*.json"))
VALID: dict[str, Any] = {
    "name": "all kinds",
    "initial": [0.0, 0.0, 1.0, 0.8, *(8 * [0.0])],
    "targets": {"left": [-1.0, 0.0, 3.0], "right": [-1, 2, 3]},
    "obstacles": [
        {"type": "sphere", "center": [-1.0, 2.0, 2.0], "radius": 0.25},
        {"type": "box", "center": [-2.0, 0.0, 1.0], "size": [0.5, 1, 0.1]},
        {"type": "box", "center": [-2.0, 0.0, 1.0], "size": [0.5, 1, 0.1], "rpy": [0, 0, 0.5]},
        {"type": "capsule", "center": [-2.0, 3.0, 1.0], "radius": 0.1, "length": 0.5, "rpy": [0.1, 0.2, 0.3]},
        {"type": "halfspace", "normal": [0, 0, 1], "offset": -0.3},
    ],
}


def test_the_paper_scene_is_section_5(scene: Any) -> None:
    assert scene.targets == {"left": (-2.0, 2.0, 4.0), "right": (-2.0, 4.0, 4.0)}
    assert scene.obstacles == (Sphere(center=(-1, 2, 3), radius=0.25), Sphere(center=(-1, 4, 3), radius=0.25))
    np.testing.assert_array_equal(scene.initial, [0, 0, np.pi / 3, np.pi / 4, *(8 * [0])])


def test_the_dev_scenes_load_and_fit_the_robot(robot: Robot) -> None:
    from humanoid_rail.scene.scene import check_scene

    families = [path.stem.split("-")[0] for path in DEV]
    assert {f: families.count(f) for f in set(families)} == {"sparse": 20, "dense": 20, "shelf": 20, "deep": 15}
    for path in DEV:
        scene = load_scene(path)
        check_scene(robot, scene)
        assert Kinematics(robot, scene.obstacles).measure(scene.initial).clearance.min() >= 0
        jsonschema.validate(json.loads(path.read_text(encoding="utf-8")), SCHEMA)


def test_every_kind_of_obstacle() -> None:
    kinds = [type(obstacle) for obstacle in make_scene(VALID).obstacles]
    assert kinds == [Sphere, Box, Box, Capsule, HalfSpace]
    jsonschema.validate(VALID, SCHEMA)


def test_yaml_and_json_say_the_same(tmp_path: Path) -> None:
    yaml = """
name: all kinds
initial: [0, 0, 1.0, 8e-1, 0, 0, 0, 0, 0, 0, 0, 0]   # 8e-1 is a number in YAML 1.2
targets:
  left: [-1, 0, 3]
  right: [-1, 2, 3]
obstacles:
  - {type: sphere, center: [-1, 2, 2], radius: 25e-2}
  - {type: box, center: [-2, 0, 1], size: [0.5, 1, 0.1]}
  - {type: box, center: [-2, 0, 1], size: [0.5, 1, 0.1], rpy: [0, 0, 0.5]}
  - {type: capsule, center: [-2, 3, 1], radius: 0.1, length: 0.5, rpy: [0.1, 0.2, 0.3]}
  - {type: halfspace, normal: [0, 0, 1], offset: -0.3}
"""
    (tmp_path / "a.yaml").write_text(yaml)
    (tmp_path / "a.json").write_text(json.dumps(VALID))
    assert load_scene(tmp_path / "a.yaml") == load_scene(tmp_path / "a.json") == make_scene(VALID)


def test_start_and_obstacles_are_optional() -> None:
    scene = make_scene({"name": "short", "targets": VALID["targets"]})
    assert scene.initial is None
    assert scene.obstacles == ()


def test_numpy_arrays_in_python() -> None:
    assert Sphere(center=np.array([1.0, 2.0, 3.0]), radius=np.float64(0.5)).center == (1.0, 2.0, 3.0)


def test_scenes_are_frozen(scene: Any) -> None:
    with pytest.raises(ValueError, match="frozen"):
        scene.name = "other"


def test_rpy_is_urdfs(robot: Robot) -> None:
    """A long thin box turned about z, then tilted about y, lies where fixed-axis roll, pitch, yaw puts it."""
    tip = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]) @ np.array(
        [[np.cos(0.3), 0, np.sin(0.3)], [0, 1, 0], [-np.sin(0.3), 0, np.cos(0.3)]]
    )
    end = np.array([-3.0, 0.0, 2.0]) + tip @ [1.0, 0.0, 0.0]
    box = Box(center=(-3.0, 0.0, 2.0), size=(2.0, 1e-3, 1e-3), rpy=(0.0, 0.3, np.pi / 2))
    ball = Sphere(center=end, radius=1e-3)
    kinematics = Kinematics(robot, (box, ball))
    q = robot.initial.copy()
    bones = kinematics.bones(q)
    nearest_to_end = np.linalg.norm(bones - end, axis=2).min(axis=1)
    assert (kinematics.measure(q).clearance[:, 0] <= nearest_to_end).all()
    other = Kinematics(robot, (box.model_copy(update={"rpy": (0.0, -0.3, np.pi / 2)}),)).measure(q).clearance
    assert abs(other[:, 0] - kinematics.measure(q).clearance[:, 0]).max() > 0.01


def edit(*path: Any, value: Any) -> dict[str, Any]:
    """Return the valid scene with one field changed; `...` as value removes it."""
    data = copy.deepcopy(VALID)
    node: Any = data
    for key in path[:-1]:
        node = node[key]
    if value is ...:
        del node[path[-1]]
    else:
        node[path[-1]] = value
    return data


@pytest.mark.parametrize(
    ("data", "field"),
    [
        (edit("obstacles", 0, "radius", value=-0.25), "obstacles[0].radius"),
        (edit("obstacles", 0, "radius", value=0), "obstacles[0].radius"),
        (edit("obstacles", 0, "radius", value=float("nan")), "obstacles[0].radius"),
        (edit("obstacles", 0, "radius", value="0.25"), "obstacles[0].radius"),
        (edit("obstacles", 0, "radius", value=True), "obstacles[0].radius"),
        (edit("obstacles", 0, "radius", value=...), "obstacles[0].radius"),
        (edit("obstacles", 0, "colour", value="red"), "obstacles[0].colour"),
        (edit("obstacles", 0, "type", value="ball"), "obstacles[0].type"),
        (edit("obstacles", 0, "type", value=...), "obstacles[0].type"),
        (edit("obstacles", 0, value=7), "obstacles[0]"),
        (edit("obstacles", 0, "center", value=[1, 2]), "obstacles[0].center"),
        (edit("obstacles", 0, "center", value=[1, 2, 3, 4]), "obstacles[0].center"),
        (edit("obstacles", 0, "center", value=[1, None, 3]), "obstacles[0].center[1]"),
        (edit("obstacles", 0, "center", value=[1, float("inf"), 3]), "obstacles[0].center[1]"),
        (edit("obstacles", 0, "center", value=[1, 10**400, 3]), "obstacles[0].center[1]"),
        (edit("obstacles", 0, "center", value=[1, 1e5, 3]), "obstacles[0].center[1]"),
        (edit("obstacles", 1, "size", value=[1, 0, 1]), "obstacles[1].size[1]"),
        (edit("obstacles", 1, "rpy", value="none"), "obstacles[1].rpy"),
        (edit("obstacles", 3, "length", value=-1), "obstacles[3].length"),
        ({**VALID, "obstacles": [{"type": "sphere", "centre": [0, 0, 0], "radius": 1}]}, "obstacles[0].centre"),
        (edit("obstacles", 4, "normal", value=[0, 0, 0]), "obstacles[4].normal"),
        (edit("obstacles", 4, "offset", value=...), "obstacles[4].offset"),
        (edit("obstacles", value={"type": "sphere"}), "obstacles"),
        (edit("targets", value=...), "targets"),
        (edit("targets", "left", value=[0, 0]), "targets.left"),
        (edit("targets", value=[[0, 0, 0], [1, 1, 1]]), "targets[0]"),
        (edit("targets", value=[]), "targets"),
        (edit("targets", value=3), "targets"),
        (edit("targets", value=[{"left": [0, 0, 0]}, {"left": [0, 0]}]), "targets[1].left"),
        (edit("targets", value=[{"left": {"position": [0, 0]}}]), "targets[0].left.position"),
        (edit("targets", "left", value={"approach": [1, 0, 0]}), "targets.left.position"),
        (edit("targets", "left", value={"position": [0, 0, 0], "approach": [0, 0, 0]}), "targets.left.approach"),
        (edit("targets", "left", value={"position": [0, 0, 0], "direction": [1, 0, 0]}), "targets.left.direction"),
        (
            edit("targets", "left", value={"position": [0, 0, 0], "approach": [1, 0, 0], "rpy": [0, 0, 0]}),
            "targets.left",
        ),
        (edit("targets", "left", value="anywhere"), "targets.left"),
        (edit("initial", value=True), "initial"),
        (edit("initial", 3, value=float("nan")), "initial[3]"),
        (edit("name", value=""), "name"),
        (edit("name", value=3), "name"),
        (edit("speed", value=3), "speed"),
        ([VALID], "scene"),
        (None, "scene"),
        ("paper", "scene"),
    ],
)
def test_what_is_wrong_is_named(data: Any, field: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        make_scene(data)
    assert caught.value.field == field
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize(
    "text",
    [
        "name: a\nname: b\n",
        "",
        "targets: [",
        "name: a\nname: b",
        "a: &a [*a]",
        "!!python/object/apply:os.system [ls]",
        "{" * 5000,
        "[" * 100_000,
        "\x00",
        "--- {}\n--- {}",
        "name: 2001-99-99",
        "? [a]\n: b",
        "name: !!binary x",
        "a: &a [x, x, x, x, x, x, x, x, x]\n"
        + "".join(f"{c}: &{c} [{', '.join(9 * [f'*{b}'])}]\n" for b, c in pairwise("abcdefghijkl"))
        + "name: *l\n",
    ],
)
def test_text_that_is_no_scene(text: str, tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(text)
    with pytest.raises(InvalidInput) as caught:
        load_scene(path)
    assert str(path) in str(caught.value)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="existing file"):
        load_scene(tmp_path / "none.yaml")
    with pytest.raises(InvalidInput, match="readable"):
        load_scene(tmp_path)
    (tmp_path / "latin.yaml").write_bytes("name: é".encode("latin-1"))
    with pytest.raises(InvalidInput, match="UTF-8"):
        load_scene(tmp_path / "latin.yaml")


def test_copies_are_validated(cube_file: str) -> None:
    scene = make_scene(VALID)
    assert scene.model_copy(update={"name": "other"}).name == "other"
    assert scene.model_copy() == scene
    sphere = Sphere(center=(0, 0, 0), radius=1)
    mesh = Mesh(file=cube_file, center=(0, 0, 0))
    assert mesh.model_copy(update={"center": (1, 0, 0)}).pieces[0].shape == mesh.pieces[0].shape
    nan = float("nan")
    for model, update in (
        (sphere, {"radius": -1.0}),
        (sphere, {"center": (nan, 0, 0)}),
        (scene, {"targts": {}}),
        (scene, {"targets": {"left": (nan, 0, 0)}}),
        (scene, {"obstacles": ({"type": "box"},)}),
    ):
        with pytest.raises(InvalidInput):
            model.model_copy(update=update)


def test_errors_of_yaml_say_where(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text("name: x\ntargets: {left: [0, 0, 0]\nobstacles: []\n")
    with pytest.raises(InvalidInput) as caught:
        load_scene(path)
    assert str(caught.value).startswith(f"{path}:3:")


def test_python_raises_the_same_errors() -> None:
    with pytest.raises(InvalidInput, match=r"radius is -1"):
        Sphere(center=(0, 0, 0), radius=-1)
    with pytest.raises(InvalidInput, match=r"center is \[0, 0\]; valid: three numbers"):
        Box(center=[0, 0], size=(1, 1, 1))
    with pytest.raises(InvalidInput, match="colour"):
        HalfSpace(normal=(0, 0, 1), offset=0, colour="red")


@pytest.mark.parametrize("stop", [1, "no", None])
def test_stop_is_true_or_false(stop: object) -> None:
    step = {"left": [0, 0, 1], "right": None}
    asked = make_scene({"targets": [{**step, "stop": False}, step]})
    assert [one.stop for one in asked.steps] == [False, True]
    with pytest.raises(InvalidInput, match=r"targets\[0\]\.stop"):
        make_scene({"targets": [{**step, "stop": stop}, step]})
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"targets": [{**step, "stop": stop}, step]}, SCHEMA)


def test_the_schema_knows_what_a_step_says_beside_its_hands() -> None:
    jsonschema.validate({"targets": [{"left": [0, 0, 1], "right": None, "stop": False}]}, SCHEMA)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"targets": [{"left": [0, 0, 1], "right": None, "stopp": False}]}, SCHEMA)
