"""Scenes of very many obstacles: the page stays small, and nothing is left out of it."""

from __future__ import annotations

from collections import Counter
from typing import Any

import meshcat
import numpy as np
import pytest
from pages import commands, tracks

from humanoid_rail import Box, Capsule, Mesh, Robot, Scene, Sphere, plan_case
from humanoid_rail.viewer.closest_pairs import ClosestPairs
from humanoid_rail.viewer.page import CommandList, page_html
from humanoid_rail.viewer.view import fill_view

MANY = 20_000
LARGEST_PAGE = 10e6
"""In bytes."""


def some(kind: type, count: int, rng: np.random.Generator, cube_file: str, velocities: np.ndarray) -> tuple[Any, ...]:
    """Return obstacles of a kind, of any size, anywhere, each with one of the velocities (v, 3)."""
    obstacles = []
    for i in range(count):
        center, rpy = rng.uniform(-9, 9, 3), rng.uniform(-1, 1, 3)
        place: dict[str, Any] = {"center": center, "velocity": velocities[i % len(velocities)]}
        size = rng.uniform(0.05, 0.2, 3)
        match kind.__name__:
            case "Box":
                obstacles.append(Box(size=size, rpy=rpy, **place))
            case "Sphere":
                obstacles.append(Sphere(radius=size[0], **place))
            case "Capsule":
                obstacles.append(Capsule(radius=size[0], length=size[1], rpy=rpy, **place))
            case "Mesh":
                obstacles.append(Mesh(file=cube_file, scale=round(size[0], 2), rpy=rpy, **place))
    return tuple(obstacles)


def page_of(robot: Robot, scene: Scene, obstacles: tuple[Any, ...]) -> str:
    scene, drawn = scene.model_copy(update={"obstacles": obstacles}), CommandList()
    fill_view(meshcat.Visualizer(window=drawn), robot, scene, plan_case(robot, 3, dt=0.5), ClosestPairs())
    return page_html("many", "", drawn)


def bodies(page: str) -> Counter[str]:
    """Return how many bodies are drawn of the obstacles, by the geometry that they are instances of."""
    found: Counter[str] = Counter()
    (drawn,) = (command["object"] for command in commands(page) if command.get("path", "").endswith("/obstacles"))
    types = {geometry["uuid"]: geometry["type"] for geometry in drawn["geometries"]}
    for group in drawn["object"]["children"]:
        for each in group["children"]:
            assert len(each["instanceMatrix"]["array"].data) == 64 * each["count"]
            found[types[each["geometry"]]] += each["count"]
    return found


def test_twenty_thousand_boxes(robot: Robot, scene: Scene, rng: np.random.Generator) -> None:
    page = page_of(robot, scene, some(Box, MANY, rng, "", np.zeros((1, 3))))
    assert bodies(page) == {"BoxGeometry": MANY, "BufferGeometry": MANY}  # with their edges
    assert len(page) < LARGEST_PAGE


@pytest.mark.parametrize("distinct", [3, 900])
def test_many_of_every_kind_some_of_which_move(
    distinct: int, robot: Robot, scene: Scene, rng: np.random.Generator, cube_file: str
) -> None:
    each = MANY // 20
    velocities = np.vstack([np.zeros(3), rng.uniform(-0.1, 0.1, (distinct - 1, 3))])
    kinds = (Box, Sphere, Capsule, Mesh)
    page = page_of(robot, scene, sum((some(kind, each, rng, cube_file, velocities) for kind in kinds), ()))
    assert bodies(page) == {
        "BoxGeometry": each,
        "SphereGeometry": each + 2 * each,  # and the ends of capsules
        "CylinderGeometry": each,
        "BufferGeometry": each + each,  # the edges of boxes, and meshes
    }
    assert len(page) < LARGEST_PAGE / 5
    moved = tracks(page, "obstacles")
    assert [*moved] == [f"together{i}.position" for i in range(1, distinct)]
    for velocity, positions in zip(velocities[1:], moved.values(), strict=True):
        np.testing.assert_allclose(positions[30], velocity, atol=1e-9)  # after 1 s
