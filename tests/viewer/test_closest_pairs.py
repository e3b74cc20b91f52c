"""The closest bodies at each moment of a motion, against the distances of the kinematics."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from conftest import plan

from humanoid_rail import Box, Capsule, HalfSpace, Kinematics, Mesh, Robot, Scene, Sphere, plan_case
from humanoid_rail.viewer.closest_pairs import closest_of_all, closest_pairs


def segment_distance(point: np.ndarray, ends: np.ndarray) -> float:
    difference = ends[1] - ends[0]
    share = np.clip((point - ends[0]) @ difference / (difference @ difference), 0.0, 1.0)
    return float(np.linalg.norm(point - ends[0] - share * difference))


def every_obstacle(cube_file: str) -> tuple[Any, ...]:
    return (
        Sphere(center=(-1.2, 1.4, 4.6), radius=0.2, velocity=(0.0, 0.1, -0.35)),
        Box(center=(-2.0, 2.4, 3.0), size=(0.3, 0.4, 0.5), rpy=(0.1, 0.2, 0.3), velocity=(0.0, -0.1, 0.0)),
        Capsule(center=(-1.0, 3.0, 2.4), radius=0.1, length=0.4, rpy=(1.0, 0.0, 0.0)),
        HalfSpace(normal=(0.0, 0.0, 2.0), offset=-1.2, velocity=(0.0, 0.0, 0.05)),
        Mesh(file=cube_file, center=(-1.3, 0.4, 3.2), scale=0.4, velocity=(0.05, 0.0, 0.0)),
    )


@pytest.mark.parametrize("method", ["gradient-projection", "qp"])
def test_closest_pairs_are_those_of_the_kinematics(method: str, robot: Robot, scene: Scene, cube_file: str) -> None:
    scene = scene.model_copy(update={"obstacles": every_obstacle(cube_file)})
    trajectory = plan(robot, scene, method, c_kappa=0.0, c_mu=0.0)
    kinematics, times = Kinematics(robot, scene.obstacles), np.linspace(0.0, trajectory.duration, 100)
    pairs = closest_pairs(robot, scene, trajectory, times)
    assert len(pairs.obstacles) == len(pairs.links) == len(times)
    for t, obstacle, links in zip(times, *pairs, strict=True):
        q = trajectory.configuration(t)
        measured = kinematics.measure(q, t=t)
        bones = dict(zip(robot.link_names, kinematics.bones(q), strict=True))
        link = robot.link_names.index(obstacle.link)
        other = int(re.fullmatch(r"obstacles\[(\d)\] \((\w+)\)", obstacle.other)[1])
        assert obstacle.t == links.t == t
        assert obstacle.distance == pytest.approx(measured.clearance[link, other], abs=1e-6)
        assert obstacle.distance == pytest.approx(measured.clearance.min(), abs=2e-5)
        assert links.distance == pytest.approx(measured.self_clearance.min(), abs=2e-5)
        for pair in (obstacle, links):
            assert np.linalg.norm(pair.points[1] - pair.points[0]) == pytest.approx(abs(pair.distance), abs=1e-6)
            assert segment_distance(pair.points[0], bones[pair.link]) == pytest.approx(0.05, abs=1e-4)
        assert segment_distance(links.points[1], bones[links.other]) == pytest.approx(0.05, abs=1e-4)
        if other == 0:
            centre = np.array(scene.obstacles[0].center) + t * np.array(scene.obstacles[0].velocity)
            assert np.linalg.norm(obstacle.points[1] - centre) == pytest.approx(0.2, abs=1e-4)
    assert len({pair.other for pair in pairs.obstacles}) > 1
    assert (min(pair.distance for pair in pairs.obstacles) < 0) == (method == "gradient-projection")


@pytest.mark.parametrize("case", [1, 2, 3])
def test_the_closest_of_all_is_that_of_the_trajectory(case: int, robot: Robot, scene: Scene) -> None:
    trajectory = plan_case(robot, case)
    pairs = closest_pairs(robot, scene, trajectory, [0.0, trajectory.duration / 2])  # far too few
    obstacle, links = closest_of_all(robot, scene, trajectory, pairs)
    assert obstacle.distance == pytest.approx(trajectory.min_clearance, abs=1e-6)
    k = np.abs(trajectory.t - obstacle.t).argmin()
    assert trajectory.clearance[k].min() == pytest.approx(obstacle.distance, abs=1e-6)
    assert links.distance == pytest.approx(trajectory.min_clearance_self, abs=1e-3)


def test_a_contact_between_samples_is_among_the_closest(robot: Robot, scene: Scene) -> None:
    hand = plan_case(robot, 3).hands[:, 0]
    between = tuple((hand[0] + 0.12 * (hand[-1] - hand[0])).tolist())
    scene = scene.model_copy(update={"obstacles": (Sphere(center=between, radius=0.1),)})
    trajectory = plan(robot, scene, "gradient-projection", c_kappa=0.0, dt=1.0)
    assert trajectory.collision_free
    assert trajectory.certificate.contact is not None
    pairs = closest_pairs(robot, scene, trajectory, trajectory.t)
    obstacle, _ = closest_of_all(robot, scene, trajectory, pairs)
    assert obstacle.distance < 1e-5


def test_a_tie_does_not_change_the_closest_pair(robot: Robot, scene: Scene) -> None:
    trajectory = plan_case(robot, 3)  # all along it several pairs are 0.4 m apart, up to rounding
    pairs = closest_pairs(robot, scene, trajectory, trajectory.t)
    assert len({(pair.link, pair.other) for pair in pairs.links}) == 1
