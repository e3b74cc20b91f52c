"""The check of robots against their own meshes: a small share of it, and that it finds what is wrong."""

from __future__ import annotations

from dataclasses import replace
from importlib import metadata

import numpy as np
import pytest

from humanoid_rail._resources import resource
from humanoid_rail.model.library import OWN, robots
from humanoid_rail.model.robot_file import read_robot_file
from validation.check_robots import Case, check_motions, check_postures, load_case, scenes_of


def has(package: str) -> bool:
    try:
        metadata.version(package)
    except metadata.PackageNotFoundError:
        return False
    return True


needs_models = pytest.mark.skipif(not has("example-robot-data"), reason="needs the package example-robot-data")
GALLERY = [name for name in robots() if name not in OWN]


@pytest.fixture(scope="module")
def panda() -> Case:
    return load_case("panda")


@needs_models
def test_bodies_miss_no_contact_and_links_are_where_they_are(panda: Case) -> None:
    row, wrong = check_postures(panda, 40, np.random.default_rng(5))
    assert wrong == []
    assert float(row[-2].rstrip("%")) <= 5.0


@needs_models
def test_certificates_hold_of_the_meshes(panda: Case) -> None:
    row, wrong = check_motions(panda, 4, np.random.default_rng(5))
    assert wrong == []
    assert int(row[1]) > 0


@needs_models
def test_bodies_that_are_too_small_are_noticed(panda: Case) -> None:
    bodies = panda.robot.collision_model.copy()
    for body in bodies.geometryObjects:
        body.placement.translation = body.placement.translation + np.array([9.0, 0.0, 0.0]) * (body.parentJoint == 1)
    wrong = Case("panda", replace(panda.robot, collision_model=bodies), panda.original)
    assert any("do not" in line for line in check_postures(wrong, 150, np.random.default_rng(5))[1])


@pytest.mark.parametrize("name", GALLERY)
def test_each_robot_names_its_package_and_has_two_scenes(name: str) -> None:
    file = read_robot_file(resource("robots", f"{name}/robot.yaml"))
    assert file.package is not None
    assert file.name == name
    assert len(scenes_of(name)) == 2
