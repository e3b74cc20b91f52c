"""Scenes of very many obstacles: the page stays small, and nothing is left out of it."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import changed
from pages import commands, needs_browser, page_data
from screenshot import opened, seek, settle

from humanoid_rail import Box, Capsule, Mesh, Robot, Scene, Sphere, plan_case
from humanoid_rail.viewer.playback import playback_html

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
    scene = scene.model_copy(update={"obstacles": obstacles})
    # A motion through whatever there is, of which nothing is claimed.
    motion = changed(plan_case(robot, 3, dt=0.5), certificate=None)
    return playback_html(robot, scene, replace(motion, scene=scene))


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


@needs_browser
def test_twenty_thousand_boxes(robot: Robot, scene: Scene, rng: np.random.Generator, tmp_path: Path) -> None:
    page = page_of(robot, scene, some(Box, MANY, rng, "", np.zeros((1, 3))))
    assert bodies(page) == {"BoxGeometry": MANY}
    assert len(page) < LARGEST_PAGE
    (tmp_path / "page.html").write_text(page, encoding="utf-8")
    with opened(tmp_path / "page.html") as (browser, troubles):
        seek(browser, 1.0)
        drawn = """() => {
            const count = meshes => meshes.reduce((sum, mesh) => sum + mesh.count, 0), all = [];
            playback.obstacles.groups[0].node.traverse(node => { if (node.isInstancedMesh) all.push(node); });
            const boxes = all.filter(mesh => !mesh.material.wireframe);
            const edges = all.filter(mesh => mesh.material.wireframe);
            return [count(boxes), count(edges), count(boxes.filter(mesh => mesh.material.transparent))];
        }"""
        boxes, edges, faded = browser.evaluate(drawn)
        assert (boxes, edges) == (MANY, MANY)
        assert 0 < faded < MANY / 2, "those in front of the robot fade"
        browser.keyboard.press("o")
        settle(browser)
        assert browser.evaluate(drawn) == [MANY, MANY, 0]
        assert not troubles


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
        "BufferGeometry": each,
    }
    assert len(page) < LARGEST_PAGE / 5
    moved = page_data(page)["velocities"]
    assert [*moved] == [f"together{i}" for i in range(1, distinct)]
    np.testing.assert_allclose([*moved.values()], velocities[1:], atol=1e-12)
