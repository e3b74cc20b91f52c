"""Scenes of the gallery are solved, and something is in the way; of robots that load fast, `make gallery` of all."""

from __future__ import annotations

from importlib import metadata
from pathlib import Path

import pytest
from conftest import ROOT
from gallery import plans_of, touches

from humanoid_rail import Robot, load_robot, load_scene, plan
from humanoid_rail._resources import resource
from humanoid_rail.model.library import OWN, robots
from humanoid_rail.model.robot_file import read_robot_file


def gallery_robot(name: str) -> Robot:
    package = str(read_robot_file(resource("robots", f"{name}/robot.yaml")).package).partition(">")[0]
    try:
        metadata.version(package)
    except metadata.PackageNotFoundError:
        pytest.skip(f"{package}, a package of models, is not installed")
    return load_robot(name)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", ["dual_fr3", "kinova", "panda", "ur5"])
def test_scenes_are_solved_and_something_is_in_the_way(name: str) -> None:
    bounds, _, wrong = plans_of(name, gallery_robot(name), 1)
    assert wrong == []
    assert len(bounds) == 2


@pytest.mark.filterwarnings("ignore")
def test_a_scene_with_nothing_in_the_way_is_noticed() -> None:
    robot = gallery_robot("panda")
    free = load_scene(ROOT / "scenes" / "robots" / "panda-wall.json").model_copy(update={"obstacles": ()})
    assert not touches(robot, free, plan(robot, free).q[[0, -1]])


def test_every_robot_of_the_gallery_has_a_small_picture_in_the_document() -> None:
    text = (ROOT / "docs" / "robots.md").read_text(encoding="utf-8")
    for name in robots():
        if name not in OWN:
            picture = Path("robots") / f"{name.replace('_', '-')}.png"
            assert f"]({picture})" in text
            assert (ROOT / "docs" / picture).stat().st_size < 150_000
