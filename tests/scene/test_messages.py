"""What errors say of input that is nearly right: what was probably meant."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import AHEAD, plan, points

from humanoid_rail import (
    Box,
    Capsule,
    HalfSpace,
    InvalidInput,
    Mesh,
    Pose,
    Problem,
    Robot,
    Scene,
    Sphere,
    export,
    load_robot,
    make_scene,
)
from humanoid_rail.planning.methods import as_method

TARGETS = {"left": [-1.6, 0.6, 3.4], "right": [-1.6, 2.2, 3.4]}
MODELS = (Scene, Sphere, Box, Capsule, HalfSpace, Mesh, Pose)


def refused(action: Any, *arguments: Any, **named: Any) -> InvalidInput:
    with pytest.raises(InvalidInput) as caught:
        action(*arguments, **named)
    assert len(str(caught.value)) < 1000
    return caught.value


@pytest.mark.parametrize("model", MODELS)
def test_every_field_that_is_misspelt_is_recognised(model: Any) -> None:
    for name in model.model_fields:
        for misspelt in (f"{name}s", f"{name}_", name[:-1] if len(name) > 3 else name + name[-1]):
            if misspelt not in model.model_fields:
                error = refused(model, **{misspelt: 1})
                assert (error.field, error.value) == (misspelt, 1)
                assert f"did you mean {name}?" in error.valid, misspelt


@pytest.mark.parametrize(
    ("data", "field", "meant"),
    [
        ({"obstacle": []}, "obstacle", "obstacles"),
        ({"obstacles": [{"type": "sphere", "centre": [0, 0, 0], "radius": 1}]}, "obstacles[0].centre", "center"),
        ({"obstacles": [{"type": "shpere", "center": [0, 0, 0], "radius": 1}]}, "obstacles[0].type", "sphere"),
        ({"targets": {**TARGETS, "left": {"positon": [0, 0, 3]}}}, "targets.left.positon", "position"),
        (
            {"targets": [TARGETS, {"left": {"position": [0, 0, 3], "aproach": [1, 0, 0]}}]},
            "targets[1].left.aproach",
            "approach",
        ),
    ],
)
def test_names_in_files(data: dict[str, Any], field: str, meant: str) -> None:
    error = refused(make_scene, {"name": "x", "targets": TARGETS, **data})
    assert error.field == field
    assert f"did you mean {meant}?" in error.valid


def test_other_names(robot: Robot, free: Scene, planned: Any, tmp_path: Path) -> None:
    assert "did you mean link_radius?" in refused(load_robot, link_radus=0.1).valid
    assert "did you mean auto?" in refused(as_method, "atuo").valid
    assert "did you mean ros-yaml?" in refused(export, planned, robot, free, "ros_yaml", tmp_path / "x").valid
    targets = {"lefft": (-1.6, 0.6, 3.4), "right": (-1.6, 2.2, 3.4)}
    assert "did you mean left?" in refused(plan, robot, Scene(name="x", targets=targets)).valid
    assert "did you mean" not in refused(as_method, "dance").valid


def test_models_are_made_by_names() -> None:
    error = refused(Box, (0, 0, 0), (1, 1, 1))
    assert (error.field, error.valid) == ("Box", "arguments by name: Box(center=(0, 0, 0), size=(1, 1, 1))")
    assert refused(Sphere, (0, 0, 0)).valid == "arguments by name: Sphere(center=(0, 0, 0), radius=...)"
    for model in MODELS:
        assert f"{model.__name__}(" in refused(model, 1).valid


@pytest.mark.parametrize("scale", [1000.0, 4000.0])
def test_targets_in_millimetres(scale: float, robot: Robot) -> None:
    targets = {hand: tuple(np.multiply(scale, at).tolist()) for hand, at in AHEAD.items()}
    try:
        said = plan(robot, Scene(name="x", targets=targets)).reason
    except InvalidInput as error:  # farther away than any scene is large
        said = str(error)
    assert "given in millimetres?" in said
    assert "e+" not in said


def test_targets_out_of_reach_in_metres(robot: Robot) -> None:
    said = plan(robot, Scene(name="x", targets={**AHEAD, "left": (-6.0, 0.6, 3.4)})).reason
    assert "out of reach" in said
    assert "millimetres" not in said


def test_obstacles_in_millimetres(robot: Robot) -> None:
    obstacles = (Sphere(center=(-1000.0, 2000.0, 3000.0), radius=5000.0),)
    assert "millimetres?" in refused(plan, robot, Scene(name="x", targets=AHEAD, obstacles=obstacles)).valid


def test_angles_in_degrees(robot: Robot) -> None:
    q = np.rad2deg(robot.initial)
    for error in (
        refused(plan, robot, Scene(name="x", targets=AHEAD, initial=q)),
        refused(Problem, robot, Scene(name="x", targets=AHEAD), points([*AHEAD.values()]), q),
    ):
        assert "given in degrees?" in error.valid
    q = robot.initial.copy()
    q[0] = 1500.0
    assert "given in millimetres?" in refused(plan, robot, Scene(name="x", targets=AHEAD, initial=q)).valid
    slightly = robot.initial.copy()
    slightly[2] = robot.upper[2] + 0.1
    assert "given in" not in refused(plan, robot, Scene(name="x", targets=AHEAD, initial=slightly)).valid
    for model, fields in ((Box, {"size": (1, 1, 1)}), (Capsule, {"radius": 1, "length": 1})):
        error = refused(model, center=(0, 0, 0), rpy=(0, 0, 90), **fields)
        assert (error.field, error.value) == ("rpy[2]", 90)
        assert "given in degrees?" in error.valid
    assert "given in degrees?" in refused(Pose, position=(0, 0, 0), rpy=(180, 0, 0)).valid
    assert Pose(position=(0, 0, 0), rpy=(0, 0, 2 * math.pi)).rpy == (0, 0, 2 * math.pi)


@pytest.mark.parametrize("method", ["auto", "gradient-projection"])
@pytest.mark.parametrize("length", [1.0, 2.0])
def test_a_floor_that_the_links_touch(method: str, length: float) -> None:
    """The offset that the error asks for is right: a bit less will do, a bit more will not."""
    for radius in (0.05, 0.1):
        robot = load_robot(link_radius=radius)
        floor = HalfSpace(normal=(0.0, 0.0, length), offset=0.0)
        scene = Scene(name="x", targets=AHEAD, obstacles=(floor,))
        error = refused(plan, robot, scene, method)
        assert error.field == "initial"
        assert error.valid.endswith(f"has to be below {-radius * length:.4g}")
        lower = floor.model_copy(update={"offset": -radius * length - 1e-3})
        plan(robot, scene.model_copy(update={"obstacles": (lower,)}), method, max_time=0.1, dt=0.1)


@pytest.mark.parametrize("obstacles", [(), (Sphere(center=(-1.0, 2.0, 3.0), radius=0.25),)])
def test_links_that_are_too_thick(obstacles: tuple[Any, ...]) -> None:
    scene = Scene(name="x", targets=AHEAD, obstacles=obstacles)
    error = refused(plan, load_robot(link_radius=5.0), scene)
    assert (error.field, error.value) == ("link_radius", 5.0)
    most = float(error.valid.split()[2])
    assert 0.05 < most < 1.0
    free = scene.model_copy(update={"obstacles": ()})
    assert refused(plan, load_robot(link_radius=most + 1e-3), free).field == "link_radius"
    plan(load_robot(link_radius=most - 1e-3), free, "qp", max_time=0.1, dt=0.1)


def test_a_start_in_which_links_touch_is_to_blame_itself(robot: Robot, folded_q: np.ndarray) -> None:
    assert refused(plan, robot, Scene(name="x", targets=AHEAD, initial=folded_q)).field == "initial"


def test_all_unknown_keys_are_named() -> None:
    obstacle = {"type": "sphere", "center": [0, 0, 1], "radius": 0.1}
    data = {"name": "x", "targts": AHEAD, "obstacels": [obstacle], "units": "mm"}
    with pytest.raises(InvalidInput) as caught:
        make_scene(data)
    assert caught.value.field == "targts"
    assert "did you mean targets?" in caught.value.valid
    assert caught.value.valid.endswith("; unknown as well: 'obstacels', did you mean obstacles?, 'units'")

    odd = [{**obstacle, "colour": "red"}, {**obstacle, "velocty": [0, 0, 1]}]
    with pytest.raises(InvalidInput) as caught:
        make_scene({"name": "x", "targets": AHEAD, "obstacles": odd})
    assert caught.value.field == "obstacles[0].colour"
    assert caught.value.valid.endswith("; unknown elsewhere: obstacles[1].velocty")
