"""A robot that is saved loads as the same robot, wherever it is and with nothing else there."""

from __future__ import annotations

import pickle
import shutil
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import coal
import pinocchio as pin
import pytest
import trimesh
from conftest import ROOT, package_robot
from saved_robots import assert_same, load, write_robot

from humanoid_rail import InvalidInput, Robot, load_robot, robots
from humanoid_rail.geometry import simple_hull
from humanoid_rail.model import examination


@pytest.fixture(scope="module")
def meshy(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    return load(write_robot(tmp_path_factory.mktemp("meshy") / "in"))


def test_a_robot_with_meshes_is_the_same_elsewhere_without_its_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = load(write_robot(tmp_path / "in"))
    assert len(robot.meshes) == 3
    assert robot.locked == {"grip": 0.02}
    assert "bent" in robot.postures
    assert robot.left_out
    written = robot.save(tmp_path / "out")
    assert all(path.is_file() for path in written)
    shutil.rmtree(tmp_path / "in")
    (tmp_path / "out").rename(tmp_path / "elsewhere")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(examination, "survey", None)  # nothing is looked for
    again = load_robot(tmp_path / "elsewhere")
    assert_same(robot, again)
    assert all(tmp_path / "elsewhere" in file.parents for file in again.meshes.values())
    # And it can be saved again, as the same files but for the copies of copies.
    again.save(tmp_path / "twice")
    name = "robot.yaml"
    assert (tmp_path / "twice" / name).read_bytes() == (tmp_path / "elsewhere" / name).read_bytes()


def test_hulls_of_many_vertices_are_not_simplified_again(tmp_path: Path) -> None:
    urdf = write_robot(tmp_path / "in")
    bar = trimesh.creation.capsule(0.3, 0.1, count=(48, 48))
    bar.export(tmp_path / "in" / "bar.stl")
    robot = load(urdf)
    assert max(getattr(b.geometry, "num_points", 0) for b in robot.collision_model.geometryObjects) > 64
    robot.save(tmp_path / "out")
    assert_same(robot, load_robot(tmp_path / "out"))


def test_a_hull_that_has_to_swell_too_much_is_warned_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    urdf = write_robot(tmp_path / "in")
    trimesh.creation.icosphere(3, radius=1.0).export(tmp_path / "in" / "bar.stl")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(simple_hull, "MOST_VERTICES", 90)
    with pytest.warns(UserWarning, match="mm out of its mesh"):
        load(urdf)


def test_what_a_mesh_refers_to_is_saved_with_it(tmp_path: Path, meshy: Robot) -> None:
    meshy.save(tmp_path / "out")
    (obj,) = (tmp_path / "out" / "meshes" / "visual").rglob("*.obj")
    material = next(line.split()[1] for line in obj.read_text().splitlines() if line.startswith("mtllib"))
    assert (obj.parent / material).is_file()


def test_several_pieces_of_one_mesh_are_several_collisions(tmp_path: Path, meshy: Robot) -> None:
    bodies = pin.GeometryModel()
    for body in meshy.collision_model.geometryObjects:
        for name in (f"{body.name}.0", f"{body.name}.1") if body.name == "b0_0" else (body.name,):
            copy = body.copy()
            copy.name = name
            bodies.addGeometryObject(copy)
    left_out = {frozenset((pair.link, pair.other)) for pair in meshy.left_out}
    links = [meshy.model.frames[body.parentFrame].name for body in bodies.geometryObjects]
    every = combinations(range(len(links)), 2)
    pairs = [(i, j) for i, j in every if links[i] != links[j] and frozenset((links[i], links[j])) not in left_out]
    cut = replace(meshy, collision_model=bodies, self_collision_pairs=tuple(pairs), pair_distances={})
    cut.save(tmp_path)
    again = load_robot(tmp_path)
    assert again.collision_model.ngeoms == meshy.collision_model.ngeoms + 1
    assert again.self_collision_pairs == cut.self_collision_pairs
    assert again.link_names == cut.link_names


def test_the_papers_robot_is_saved_with_the_far_parts_of_neighbours(tmp_path: Path) -> None:
    robot = load_robot(link_radius=0.04, l_l3=1.1)
    robot.save(tmp_path)
    assert_same(robot, load_robot(tmp_path))
    assert any("farther than" in pair.why for pair in robot.left_out)


def test_the_robot_file_of_the_papers_robot_is_that_robot() -> None:
    assert_same(load_robot(), load_robot(ROOT / "robots" / "humanoid_rail.yaml"))


def test_a_robot_as_its_urdf_is_written_is_saved_without_limits_that_it_has_not(tmp_path: Path) -> None:
    from arms import arm

    robot = arm()
    robot.save(tmp_path)
    again = load_robot(tmp_path)
    assert_same(robot, again)
    assert not again.assumed


def test_pairs_that_were_taken_out_stay_out(tmp_path: Path, meshy: Robot) -> None:
    some = replace(meshy, self_collision_pairs=meshy.self_collision_pairs[1:])
    some.save(tmp_path)
    again = load_robot(tmp_path)
    assert again.self_collision_pairs == some.self_collision_pairs
    assert len(again.unchecked_pairs) == len(meshy.unchecked_pairs) + 1


def test_bodies_that_were_replaced_are_refused(tmp_path: Path, meshy: Robot) -> None:
    bodies = meshy.collision_model.copy()
    body = bodies.geometryObjects[bodies.getGeometryId("b3_0")]
    body.geometry = coal.Cylinder(body.geometry.radius + 0.01, 0.1)
    with pytest.raises(InvalidInput) as caught:
        replace(meshy, collision_model=bodies).save(tmp_path / "out")
    assert caught.value.value == "b3_0"
    assert not (tmp_path / "out").exists()


def test_a_mesh_that_is_gone_is_named(tmp_path: Path) -> None:
    robot = load(write_robot(tmp_path / "in"))
    shutil.rmtree(tmp_path / "in")
    with pytest.raises(InvalidInput, match="still there"):
        robot.save(tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_robots_with_meshes_pickle(meshy: Robot) -> None:
    assert_same(meshy, pickle.loads(pickle.dumps(meshy)))


def test_an_unknown_name_lists_the_robots() -> None:
    with pytest.raises(InvalidInput) as caught:
        load_robot("humanoid_rial")
    assert all(name in caught.value.valid for name in robots())
    assert "did you mean humanoid_rail" in caught.value.valid


@pytest.mark.parametrize("name", ["panda", "baxter", "pr2"])
def test_robots_of_a_package_are_the_same_elsewhere(name: str, tmp_path: Path) -> None:
    robot = package_robot(f"example-robot-data:{name}")
    robot.save(tmp_path)
    assert_same(robot, load_robot(tmp_path), names=False)
