"""The camera of the playback page: what it sees, by rays of coal's that it does not share."""

from __future__ import annotations

import statistics

import coal
import numpy as np
import pytest
from conftest import ROOT, plan

from humanoid_rail import Box, Capsule, Robot, Scene, Sphere, load_scene, plan_case
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.scene.scene import start_of_scene
from humanoid_rail.scene.shapes import placed_shapes
from humanoid_rail.scene.targets import position
from humanoid_rail.viewer.camera import HALF_HEIGHT, WIDE, View, best_view
from humanoid_rail.viewer.occlusion import blockers, hidden
from validation.check_views import THIN, hidden_share

SCENES = sorted((ROOT / "scenes" / "dev").glob("shelf-*"))[:3] + sorted((ROOT / "scenes" / "dev").glob("deep-*"))[:3]


def test_obstacles_hide_next_to_nothing_of_the_robot(robot: Robot) -> None:
    own, opposite = [], []
    for file in SCENES:
        scene = load_scene(file)
        trajectory = plan(robot, scene)
        view = best_view(robot, scene, trajectory)
        for shares, turned in ((own, [1.0, 1.0, 1.0]), (opposite, [-1.0, -1.0, 1.0])):
            shares.append(hidden_share(robot, scene, trajectory, view.middle + view.camera * turned, 40))
    assert statistics.median(own) <= 0.02
    assert statistics.median(opposite) > 0.1, "the measure sees that shelves hide what is behind them"


@pytest.mark.parametrize("wide", [WIDE, 0.8])
def test_the_whole_motion_is_in_the_picture(robot: Robot, scene: Scene, wide: float) -> None:
    trajectory = plan_case(robot, 3)
    view = best_view(robot, scene, trajectory, wide=wide)
    points = view.points
    assert {*map(tuple, trajectory.hands[-1].round(1))} <= {*map(tuple, points.round(1))} or len(points) > 100
    is_in_the_picture(view, np.vstack([points, *trajectory.hands[::20]]), wide)


def test_without_a_motion_start_and_targets_are_seen(robot: Robot) -> None:
    own, opposite = list[np.ndarray](), list[np.ndarray]()
    for file in SCENES:
        scene = load_scene(file)
        view = best_view(robot, scene, wide=1.0)
        targets = np.array([position(target) for step in scene.steps for target in step.values() if target is not None])
        hands = Kinematics(robot).hand_positions(start_of_scene(robot, scene)).reshape(-1, 3)
        is_in_the_picture(view, np.vstack([targets, hands]), 1.0)
        for found, turned in ((own, [1.0, 1.0, 1.0]), (opposite, [-1.0, 1.0, 1.0])):
            camera = view.middle + view.camera * turned
            found.append(hidden(blockers(scene.obstacles), camera, targets, np.zeros(len(targets))))
    assert not np.concatenate(own).any()
    assert np.concatenate(opposite).any(), "shelves hide what is behind them"


def is_in_the_picture(view: View, points: np.ndarray, wide: float) -> None:
    middle, camera = view.middle, view.camera
    back = camera / np.linalg.norm(camera)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    for point in points:
        from_camera = point - middle - camera
        depth = -from_camera @ back
        assert depth > 0
        assert abs(from_camera @ up) < HALF_HEIGHT * depth
        assert abs(from_camera @ right) < wide * HALF_HEIGHT * depth


def test_rays_meet_what_coal_says_that_they_meet(rng: np.random.Generator) -> None:
    obstacles = [
        *(Sphere(center=rng.uniform(-2, 2, 3), radius=0.3, velocity=(0.5, 0.0, 0.1)) for _ in range(6)),
        *(Box(center=rng.uniform(-2, 2, 3), size=rng.uniform(0.1, 1, 3), rpy=rng.uniform(-2, 2, 3)) for _ in range(6)),
    ]
    camera, points, times = np.array([4.0, 1.0, 2.0]), rng.uniform(-3, 3, (200, 3)), np.repeat([0.0, 1.5], 100)
    found = hidden(blockers(obstacles), camera, points, times)
    assert 20 < found.sum() < 180
    for is_hidden, point, t in zip(found, points, times, strict=True):
        ray = coal.Capsule(THIN, float(np.linalg.norm(camera - point)))
        z = (camera - point) / np.linalg.norm(camera - point)
        x = np.cross(z, [0.3, 0.4, 0.5])
        x /= np.linalg.norm(x)
        here = coal.Transform3s(np.column_stack([x, np.cross(z, x), z]), (camera + point) / 2)
        request, result = coal.CollisionRequest(), coal.CollisionResult
        touched = []
        for obstacle in obstacles:
            (placed,) = placed_shapes(obstacle)
            moved = placed.placement.getTranslation() + t * np.array(obstacle.velocity)
            at = coal.Transform3s(placed.placement.getRotation(), moved)
            touched.append(coal.collide(ray, here, placed.shape, at, request, result()) > 0)
        assert is_hidden == any(touched)


def test_what_is_no_box_is_looked_at_as_the_box_around_it() -> None:
    capsule = Capsule(center=(0.0, 0.0, 0.0), radius=0.1, length=1.0, rpy=(np.pi / 2, 0.0, 0.0))
    camera, points = np.array([5.0, 0.0, 0.0]), np.array([[-1.0, 0.5, 0.0], [-1.0, 0.0, 0.5], [1.0, 0.0, 0.0]])
    assert hidden(blockers([capsule]), camera, points, np.zeros(3)).tolist() == [True, False, False]
    assert not hidden(blockers([]), camera, points, np.zeros(3)).any()


def test_a_camera_is_found_among_very_many_obstacles(robot: Robot, scene: Scene, rng: np.random.Generator) -> None:
    crowd = tuple(Sphere(center=(3.0, *rng.uniform(-4, 6, 2)), radius=0.2) for _ in range(2500))
    scene = scene.model_copy(update={"obstacles": crowd})  # a wall in front
    trajectory = plan_case(robot, 3, dt=0.5)
    view = best_view(robot, scene, trajectory)
    assert hidden_share(robot, scene, trajectory, view.middle + view.camera, 20) == pytest.approx(0.0, abs=0.1)
