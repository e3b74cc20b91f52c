"""Groups, repeats, shelves and colours: what a scene makes of them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from conftest import ROOT

from humanoid_rail import (
    Box,
    Cylinder,
    Group,
    HalfSpace,
    InvalidInput,
    Repeat,
    Scene,
    Shelf,
    Sphere,
    flat_obstacles,
    make_scene,
)
from humanoid_rail._yaml import parse_yaml
from humanoid_rail.scene.groups import MOST_OBSTACLES
from humanoid_rail.scene.shapes import placed_shapes

TARGETS = {"left": [-1.6, 0.6, 3.4], "right": [-1.6, 2.2, 3.4]}
BALL = {"type": "sphere", "center": [0, 0, 0], "radius": 0.1}


def scene_of(*obstacles: dict[str, Any]) -> Scene:
    return make_scene({"targets": TARGETS, "obstacles": list(obstacles)})


def names(scene: Scene) -> list[str | None]:
    return [obstacle.name for obstacle in scene.obstacles]


def test_a_shelf_is_its_boards() -> None:
    scene = scene_of({"type": "shelf", "name": "rack", "center": [-1, 0, 2], "size": [0.4, 2.0, 1.0], "columns": 2})
    assert names(scene) == [
        *(f"rack/board {i}" for i in (1, 2, 3, 4)),
        *(f"rack/side {i}" for i in (1, 2, 3)),
        "rack/back",
    ]
    corners = np.array([np.add(o.center, s * np.array(o.size) / 2) for o in scene.obstacles for s in (-1, 1)])
    np.testing.assert_allclose(corners.min(axis=0), [-1.2, -1.0, 2.0], atol=1e-12)
    np.testing.assert_allclose(corners.max(axis=0), [-0.8, 1.0, 3.0], atol=1e-12)


@pytest.mark.parametrize("turn", [0.0, 1.1])
def test_bays_are_open_in_front_and_closed_elsewhere(turn: float) -> None:
    (shelf,) = flat_shelf = (Shelf(center=(0.5, -0.3, 1.0), size=(0.4, 1.2, 0.9), rows=3, columns=4, rpy=(0, 0, turn)),)
    boxes = [(shape.halfSide, place) for o in flat_obstacles(flat_shelf) for shape, place in placed_shapes(o)]

    def is_solid(point: tuple[float, float, float]) -> bool:
        there = pin.rpy.rpyToMatrix(0, 0, turn) @ point + np.array(shelf.center)
        return any(
            (abs(place.getRotation().T @ (there - place.getTranslation())) <= half).all() for half, place in boxes
        )

    for row in range(3):
        for column in range(4):
            y, z = -0.6 + 0.3 * (column + 0.5), 0.3 * (row + 0.5)
            assert not any(is_solid((x, y, z)) for x in np.linspace(-0.17, 0.25, 20))
            assert is_solid((-0.19, y, z))
            assert any(is_solid((0.1, y + dy, z)) for dy in np.linspace(0.0, 0.2, 60))
            assert any(is_solid((0.1, y, z + dz)) for dz in np.linspace(0.0, 0.2, 60))


def test_frames_of_nested_groups_are_multiplied(rng: np.random.Generator) -> None:
    (a, b), (ra, rb, rc) = rng.uniform(-1, 1, (2, 3)).tolist(), rng.uniform(-1, 1, (3, 3)).tolist()
    box = {"type": "box", "center": [0.1, 0.2, 0.3], "size": [0.1, 0.2, 0.3], "rpy": rc, "velocity": [1, 0, 0]}
    inner = {"type": "group", "center": b, "rpy": rb, "obstacles": [box]}
    (found,) = scene_of(
        {"type": "group", "center": a, "rpy": ra, "velocity": [0, 0, 2], "obstacles": [inner]}
    ).obstacles
    frames = [pin.SE3(pin.rpy.rpyToMatrix(*r), np.array(c)) for c, r in ((a, ra), (b, rb), ([0.1, 0.2, 0.3], rc))]
    there = frames[0] * frames[1] * frames[2]
    assert isinstance(found, Box)
    np.testing.assert_allclose(found.center, there.translation, atol=1e-14)
    np.testing.assert_allclose(pin.rpy.rpyToMatrix(*found.rpy), there.rotation, atol=1e-14)
    velocity = frames[0].rotation @ frames[1].rotation @ [1, 0, 0] + [0, 0, 2]
    np.testing.assert_allclose(found.velocity, velocity, atol=1e-14)
    assert found.name == "group/group/box"


def test_half_spaces_turn_with_their_group() -> None:
    wall = HalfSpace(normal=(0.0, 0.0, 2.0), offset=0.4)
    (found,) = flat_obstacles([Group(center=(1.0, 2.0, 3.0), rpy=(0.0, np.pi / 2, 0.0), obstacles=(wall,))])
    assert isinstance(found, HalfSpace)
    np.testing.assert_allclose(found.normal, [2.0, 0.0, 0.0], atol=1e-15)
    assert found.offset == pytest.approx(0.4 + 2.0)


def test_rows_and_grids() -> None:
    row = scene_of({"type": "group", "name": "row", "repeat": {"count": 3, "step": [0, 1, 0.5]}, "obstacles": [BALL]})
    assert [o.center for o in row.obstacles] == [(0, 0, 0), (0, 1, 0.5), (0, 2, 1)]
    assert names(row) == ["row 1/sphere", "row 2/sphere", "row 3/sphere"]
    grid = {"count": [2, 1, 2], "step": [1, 9, 0.5]}
    made = scene_of({"type": "group", "name": "g", "repeat": grid, "obstacles": [BALL]})
    assert {o.name: o.center for o in made.obstacles} == {
        "g 1-1/sphere": (0, 0, 0),
        "g 1-2/sphere": (0, 0, 0.5),
        "g 2-1/sphere": (1, 0, 0),
        "g 2-2/sphere": (1, 0, 0.5),
    }


def test_names_in_groups_are_different() -> None:
    ball, named = Sphere(center=(0, 0, 0), radius=0.1), Sphere(center=(0, 0, 0), radius=0.1, name="sphere 1")
    flat = flat_obstacles([Group(obstacles=(ball, ball, named)), Group(obstacles=(ball,)), ball, ball])
    called = [obstacle.name for obstacle in flat]
    assert called[-2:] == [None, None]
    assert len(set(called[:-2])) == 4


def test_python_and_files_give_the_same() -> None:
    cylinder = Cylinder(center=(0, 0, 0), radius=0.1, length=0.3)
    group = Group(
        name="g", center=(1, 2, 3), repeat=Repeat(count=2, step=(0, 0, 1)), obstacles=(cylinder,), color="tan"
    )
    data = {
        "type": "group",
        "name": "g",
        "center": [1, 2, 3],
        "repeat": {"count": 2, "step": [0, 0, 1]},
        "color": "tan",
        "obstacles": [{"type": "cylinder", "center": [0, 0, 0], "radius": 0.1, "length": 0.3}],
    }
    scene = Scene(targets=TARGETS, obstacles=(group,))
    assert scene.obstacles == flat_obstacles([group]) == scene_of(data).obstacles
    assert scene.model_copy(update={"name": "other"}).obstacles == scene.obstacles


def test_colours_are_passed_on() -> None:
    red = {**BALL, "color": "#ff0000"}
    scene = scene_of({"type": "group", "color": "tan", "obstacles": [BALL, red]})
    assert [o.color for o in scene.obstacles] == ["tan", "#ff0000"]


LONG = {"type": "group", "name": "n" * 50, "obstacles": [BALL]}


@pytest.mark.parametrize(
    ("entry", "field", "said"),
    [
        ({**BALL, "color": "bleu"}, "obstacles[0].color", "did you mean blue?"),
        ({**BALL, "color": "#12345"}, "obstacles[0].color", "six hexadecimal digits"),
        ({"type": "group", "obstacles": []}, "obstacles[0].obstacles", "1 at least"),
        (
            {"type": "group", "obstacles": [{**BALL, "radius": -1}]},
            "obstacles[0].obstacles[0].radius",
            "greater than 0",
        ),
        ({"type": "group", "obstacles": [{**BALL, "radios": 1}]}, "obstacles[0].obstacles[0].radios", "one of"),
        ({"type": "group", "obstacles": [{"type": "bal"}]}, "obstacles[0].obstacles[0].type", "one of"),
        (
            {"type": "group", "obstacles": [BALL], "repeat": {"count": 0, "step": [1, 0, 0]}},
            "obstacles[0].repeat.count",
            "a whole number from 1 to 10000",
        ),
        (
            {"type": "group", "obstacles": [BALL], "repeat": {"count": [1, 2, -3], "step": [1, 0, 0]}},
            "obstacles[0].repeat.count",
            "a whole number from 1 to 10000",
        ),
        ({"type": "shelf", "center": [0, 0, 0], "size": [1, 1, 1], "rows": 0}, "obstacles[0].rows", "from 1 to 10000"),
        (
            {"type": "group", "obstacles": [BALL], "repeat": {"count": [100, 100, 100], "step": [1, 1, 1]}},
            "obstacles[0]",
            "groups and shelves that make at most 10000 obstacles, not 1000000",
        ),
        (
            {"type": "shelf", "center": [0, 0, 0], "size": [0.4, 1, 1], "rows": 60},
            "obstacles[0]",
            "leave room between 61 boards, for the rows: more than 1.22 m",
        ),
        ({"type": "shelf", "center": [0, 0, 0], "size": [0.01, 1, 1]}, "obstacles[0]", "a depth of more than"),
        ({"type": "group", "name": "m" * 50, "obstacles": [LONG]}, "obstacles", "no longer than 80 characters"),
        (
            {"type": "group", "center": [9000, 0, 0], "obstacles": [{**BALL, "center": [9000, 0, 0]}]},
            "obstacles",
            "center",
        ),
    ],
)
def test_errors_name_the_field(entry: dict[str, Any], field: str, said: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        scene_of(entry)
    assert caught.value.field == field
    assert said in str(caught.value)


def test_groups_make_so_many_obstacles_at_most() -> None:
    half = {
        "type": "group",
        "obstacles": [BALL],
        "repeat": {"count": MOST_OBSTACLES // 2, "step": [0, 0.001, 0]},
    }
    assert len(scene_of(half, half, BALL).obstacles) == MOST_OBSTACLES + 1
    with pytest.raises(InvalidInput, match="not 10001") as caught:
        scene_of(half, half, {"type": "group", "obstacles": [BALL]})
    assert caught.value.field == "obstacles"


def test_the_scenes_of_the_documentation_are_scenes(tmp_path: Path) -> None:
    np.savez(tmp_path / "ground.npz", heights=np.zeros((3, 3)), spacing=0.5)
    (tmp_path / "scan.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 1\n"
        + "".join(f"property float {axis}\n" for axis in "xyz")
        + "end_header\n1 2 3\n"
    )
    blocks = re.findall(r"```yaml\n(.*?)```", (ROOT / "docs" / "scenes.md").read_text(encoding="utf-8"), re.DOTALL)
    data = [block for block in map(parse_block, blocks) if "obstacles" in block]
    assert len(data) >= 5
    for block in data:
        assert make_scene({"targets": TARGETS, **block}, folder=tmp_path).obstacles


def parse_block(text: str) -> dict[str, Any]:
    block = parse_yaml("scene", text, "docs/scenes.md")
    assert isinstance(block, dict)
    return block
