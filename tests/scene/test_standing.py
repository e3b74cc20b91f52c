"""What grasps nothing takes objects for obstacles."""

from __future__ import annotations

from humanoid_rail import load_scene
from humanoid_rail.scene.standing import with_objects_standing


def test_objects_are_obstacles() -> None:
    scene = load_scene("scenes/kit.yaml")
    there = with_objects_standing(scene)
    assert there.obstacles == (*scene.obstacles, *scene.objects)
    assert not there.objects
    assert not any(step.grasp or step.release or step.contacts for step in there.steps)
    assert [dict(step) for step in there.steps] == [dict(step) for step in scene.steps]


def test_scenes_without_objects_stay_as_they_are() -> None:
    scene = load_scene("scenes/paper.yaml")
    assert with_objects_standing(scene) is scene
