"""What can be added to in one place is registered in all the others too: code, engine and documentation."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pinocchio as pin
import pytest
from conftest import ROOT

import humanoid_rail
from humanoid_rail import Box, Capsule, Cylinder, HalfSpace, HeightField, Mesh, PointCloud, Robot, Sphere, Status
from humanoid_rail._native import engine, why_no_engine
from humanoid_rail.cli import COMMANDS
from humanoid_rail.io.export import FORMATS, Format
from humanoid_rail.io.mujoco.mjcf_bodies import shape_attributes
from humanoid_rail.kinematics import kept_tasks as kept_tasks_module
from humanoid_rail.kinematics import task as tasks_module
from humanoid_rail.kinematics.native_tasks import native_tasks
from humanoid_rail.live.triangles import obstacle_triangles
from humanoid_rail.planning.methods import METHODS, as_method
from humanoid_rail.scene import groups as groups_module
from humanoid_rail.scene import obstacles as obstacles_module
from humanoid_rail.scene.groups import Group, Shelf
from humanoid_rail.scene.native_obstacles import native_obstacles
from humanoid_rail.scene.placing import put_into
from humanoid_rail.scene.shapes import placed_shapes, support
from humanoid_rail.viewer.drawing import obstacle_colours
from humanoid_rail.viewer.forms import forms_of

needs_engine = pytest.mark.skipif(why_no_engine() is not None, reason="there is no native engine")

GROUPS = (Group, Shelf)
"""Entries of scene files that are turned into obstacles."""
UP = np.array([0.0, 0.0, 1.0])
NO_COMMANDS = {"__init__", "console", "plan_folder_options", "plan_options", "report", "robot_options", "streams"}
"""The modules of cli/ that commands share."""
TASKS = {
    "PointTask": ("left", (1.0, 2.0, 3.0)),
    "DirectionTask": ("left", (0.0, 0.0, 1.0)),
    "RelativeTask": ("left", "right", (0.0, 1.0, 0.0)),
    "ConfigurationTask": (("rail",), (1.0,)),
    "LineTask": ("left", (1.0, 2.0, 3.0), (0.0, 0.0, 1.0)),
    "DistanceTask": ("left", "right", 2.0),
    "AxisTask": ("left", (0.0, 0.0, 1.0)),
    "OrientationTask": ("left", ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))),
}
"""Arguments to make one of each task."""
ENGINE_STATUS = {"out_of_time": "planning_timeout"}
"""The engine calls these otherwise."""


def page(name: str) -> str:
    return (ROOT / "docs" / name).read_text(encoding="utf-8")


def first_cells(text: str) -> set[str]:
    """Return the code in the first cells of all tables, without arguments."""
    cells = re.findall(r"^\| ([^|]*`[^|]*) \|", text, re.MULTILINE)
    return {name for cell in cells for name in re.findall(r"`([\w-]+)", cell)}


def one_of_each_obstacle(cube_file: str, tmp_path: Path) -> dict[type, Any]:
    point = (0.0, 0.0, 1.0)
    np.savez(tmp_path / "points.npz", points=np.eye(3))
    np.savez(tmp_path / "heights.npz", heights=np.eye(3), spacing=0.1)
    return {
        Sphere: Sphere(center=point, radius=0.1),
        Box: Box(center=point, size=(0.1, 0.2, 0.3)),
        Capsule: Capsule(center=point, radius=0.1, length=0.3),
        Cylinder: Cylinder(center=point, radius=0.1, length=0.3),
        HalfSpace: HalfSpace(normal=point, offset=-9.0),
        Mesh: Mesh(file=cube_file, center=point),
        HeightField: HeightField(file=str(tmp_path / "heights.npz")),
        PointCloud: PointCloud(file=str(tmp_path / "points.npz"), radius=0.1),
    }


def kinds() -> tuple[type, ...]:
    """The obstacles that a scene may hold."""
    return get_args(get_args(obstacles_module.Obstacle)[0])


def entries() -> tuple[type, ...]:
    """What a scene file may have as an obstacle, groups too."""
    return get_args(get_args(groups_module.Entry)[0])


def test_methods() -> None:
    for name, method in METHODS.items():
        assert method.name == name
        assert as_method(name) == method()
        assert getattr(humanoid_rail, method.__name__, None) is method, f"{method.__name__} is no public name"
        assert f"`{method.__name__}" in page("plan.md"), method.__name__
        assert name in page("plan.md"), name
        assert f"humanoid_rail.{method.__name__}" in page("api.md"), method.__name__
    from benchmarks.planners import EVERY

    assert set(METHODS) <= set(EVERY)


def test_formats() -> None:
    assert all(isinstance(one, Format) and one.description and callable(one.write) for one in FORMATS.values())
    assert set(FORMATS) <= first_cells(page("export.md")), "a format has no row in the table of docs/export.md"


def test_obstacles_are_known_everywhere(cube_file: str, tmp_path: Path) -> None:
    made = one_of_each_obstacle(cube_file, tmp_path)
    assert set(kinds()) == set(made), "enter the new obstacle in this test"
    assert set(entries()) == {*kinds(), *GROUPS}, "scene files do not know the new obstacle"
    types = {one.type for one in made.values()} | {kind.model_fields["type"].default for kind in GROUPS}
    assert types <= first_cells(page("scenes.md"))
    schema = (ROOT / "humanoid_rail" / "scene.schema.json").read_text(encoding="utf-8")
    for kind, one in made.items():
        assert placed_shapes(one), kind
        assert getattr(humanoid_rail, kind.__name__) is kind
        assert f"humanoid_rail.{kind.__name__}" in page("api.md")
        assert f'"{one.type}"' in schema


@needs_engine
def test_the_engine_knows_every_obstacle(cube_file: str, tmp_path: Path) -> None:
    native_obstacles(tuple(one_of_each_obstacle(cube_file, tmp_path).values()))
    adders = {name for name in dir(engine().Obstacles) if not name.startswith("_")}
    assert len(adders) == len(kinds()) - 1, adders  # height fields are added as meshes are: convex


def test_every_obstacle_is_drawn_and_put_elsewhere(cube_file: str, tmp_path: Path) -> None:
    frame = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, 1.0), np.array([1.0, 2.0, 3.0]))
    for kind, one in one_of_each_obstacle(cube_file, tmp_path).items():
        coloured = one.model_copy(update={"color": "red"})
        assert obstacle_colours([coloured]) == [0xFF0000]
        for placed in placed_shapes(one):
            assert forms_of(placed), kind
            assert shape_attributes(placed)["type"], kind
        assert len(obstacle_triangles(one).faces), kind
        there = put_into(frame, one, {})
        for before, after in zip(placed_shapes(one), placed_shapes(there), strict=True):
            a, b = (support(each, along) for each, along in ((before, UP), (after, frame.rotation @ UP)))
            assert b == pytest.approx(a + frame.translation @ (frame.rotation @ UP), abs=1e-12), kind


def test_tasks_are_known_everywhere() -> None:
    modules = {**vars(tasks_module), **vars(kept_tasks_module)}
    known = {name for name in modules if name.endswith("Task") and name != "Task"}
    assert known == set(TASKS), "enter the new task in this test"
    assert known <= first_cells(page("plan.md"))
    for name in known:
        assert getattr(humanoid_rail, name) is modules[name]
        assert f"humanoid_rail.{name}" in page("api.md")


@needs_engine
def test_the_engine_knows_every_task(robot: Robot) -> None:
    def unused(q: np.ndarray, t: float) -> Any:
        raise AssertionError("a task was called back")

    for name, arguments in TASKS.items():
        task = getattr(humanoid_rail, name)(*arguments)
        assert native_tasks(robot, [task], unused).rows == task.rows
    native = {name for name in vars(engine()) if name.endswith("Task")}
    assert native - {"Task", "FunctionTask", "WithinBoxTask", "WithinBallTask"} == set(TASKS)


def test_every_status_is_documented() -> None:
    rows = first_cells(page("plan.md"))
    assert {str(status) for status in Status} <= rows
    for status in Status:
        assert f"`{status}`" in page("plan.md")


@needs_engine
def test_every_status_of_the_engine_is_one_of_a_plan() -> None:
    for status in engine().Status.__members__:
        name = status.lower()
        assert ENGINE_STATUS.get(name, name) in set(Status), status


def test_commands_are_modules() -> None:
    modules = {path.stem for path in Path(import_module("humanoid_rail.cli").__path__[0]).glob("*.py")}
    assert modules - NO_COMMANDS == set(COMMANDS)
    for name, said in COMMANDS.items():
        command = import_module(f"humanoid_rail.cli.{name}").command
        assert command.get_short_help_str(200) or said
        assert f"humanoid-rail {name}" in page("commands.md"), name


def test_the_budget_of_auto_is_the_documented_one() -> None:
    budget = f"{humanoid_rail.Auto().max_edge_checks:,}".replace(",", " ")
    assert f"`max_edge_checks` ({budget} for each segment)" in page("auto.md")
