"""Scenes for what grasps nothing: the objects stand where they are, as obstacles."""

from __future__ import annotations

from humanoid_rail.scene.scene import Scene

NOTHING: dict[str, object] = {"grasp": {}, "release": {}, "contacts": {}}


def with_objects_standing(scene: Scene) -> Scene:
    """Return a scene whose objects are obstacles, and whose steps grasp and release nothing."""
    if not scene.objects:
        return scene
    steps = tuple(step.model_copy(update=NOTHING) for step in scene.steps)
    targets = steps if isinstance(scene.targets, tuple) else steps[0]
    return scene.model_copy(update={"obstacles": (*scene.obstacles, *scene.objects), "objects": (), "targets": targets})
