"""What moves on the playback page beside the robot: obstacles, and the lines between the closest bodies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import plan
from pages import drawn, needs_browser
from screenshot import opened, seek

from humanoid_rail import Robot, Scene, Sphere, Trajectory
from humanoid_rail.viewer.closest_pairs import closest_pairs
from humanoid_rail.viewer.playback import motions_html, playback_html


@pytest.fixture(scope="module")
def moving(robot: Robot, scene: Scene) -> tuple[Scene, Trajectory]:
    """A sphere that comes down between the arms, and one at rest."""
    obstacles = (
        Sphere(center=(-1.2, 1.4, 4.6), radius=0.2, velocity=(0.0, 0.1, -0.35)),
        Sphere(center=(-3.0, 0.0, 1.0), radius=0.2),
    )
    scene = scene.model_copy(update={"obstacles": obstacles})
    return scene, plan(robot, scene, "qp")


@needs_browser
def test_the_browser_moves_obstacles_and_connections(
    robot: Robot, moving: tuple[Scene, Trajectory], tmp_path: Path
) -> None:
    scene, trajectory = moving
    (tmp_path / "page.html").write_text(playback_html(robot, scene, trajectory), encoding="utf-8")
    with opened(tmp_path / "page.html") as (page, troubles):
        page.keyboard.press("o")  # nothing fades
        for t in (1.0, 3.0, trajectory.duration):
            seek(page, t)
            (((low, high),),) = drawn(page, "together0")
            top, bottom, one, two = np.array(
                page.evaluate(
                    """() => {
                        viewer.scene.updateMatrixWorld(true);
                        const find = path => viewer.scene_tree.find(["meshcat", "world", ...path]).object;
                        const to_world = find([]).matrixWorld.clone().invert();
                        const place = (path, y) => {
                            const point = find([]).position.clone().set(0, y, 0);
                            return point.applyMatrix4(find(path).matrixWorld).applyMatrix4(to_world).toArray();
                        };
                        const part = name => ["motion0", "closest", "obstacles", name, "2", "<object>"];
                        return [
                            place(part("line"), 0.5), place(part("line"), -0.5),
                            place(part("one"), 0), place(part("two"), 0),
                        ];
                    }"""
                )
            )
            centre = np.array(scene.obstacles[0].center) + t * np.array(scene.obstacles[0].velocity)
            np.testing.assert_allclose((low + high) / 2, centre, atol=2e-3)
            (closest,) = closest_pairs(robot, scene, trajectory, [t]).obstacles
            assert closest.other == "obstacles[0] (sphere)"
            np.testing.assert_allclose([one, two], closest.points, atol=5e-3)
            np.testing.assert_allclose([bottom, top], [one, two], atol=1e-3)
            seen = page.evaluate(
                """() => {
                    const path = ["meshcat", "world", "motion0", "closest", "obstacles", "one", "2", "<object>"];
                    const bead = viewer.scene_tree.find(path).object;
                    return [bead.renderOrder, bead.material.depthTest];
                }"""
            )
            assert seen == [2, False]
        assert not troubles


@needs_browser
def test_two_motions_are_in_one_page(
    robot: Robot, moving: tuple[Scene, Trajectory], scene: Scene, tmp_path: Path
) -> None:
    other = plan(robot, scene, optimise=False)
    page_file = tmp_path / "page.html"
    page_file.write_text(motions_html(robot, [("one", *moving), ("two", scene, other)]), encoding="utf-8")
    with opened(page_file) as (page, troubles):
        assert page.evaluate("playback.clock.duration") == max(moving[1].duration, other.duration)
        assert page.locator("h1").all_inner_texts() == ["one", "two"]
        duration = page.evaluate("playback.clock.duration")
        for number, own in enumerate((moving[1], other)):
            places = page.locator(f".mark-at.of{number}").evaluate_all("all => all.map(one => one.style.left)")
            expected = [100 * t / duration for t in own.arrivals]
            assert [float(place.rstrip("%")) for place in places] == pytest.approx(expected, abs=1e-3)
        assert len(other.arrivals) == 1
        assert "among other obstacles" in page.locator("#caption section").nth(1).inner_text()
        t = 1.0
        seek(page, t)
        for number, trajectory in enumerate((moving[1], other)):
            q = page.evaluate("([number, t]) => playback.figures[number].configuration(t)", [number, t])
            np.testing.assert_allclose(q, trajectory.configuration(t), atol=1e-4)
            read = page.evaluate("([number, t]) => playback.plots.read('manipulability', t)[number]", [number, t])
            expected = np.interp(t, trajectory.t, trajectory.manipulability)
            assert read["values"][0] == pytest.approx(expected, rel=0.02)
        through = page.evaluate(
            """() => playback.figures.map(figure => {
                const found = new Set();
                figure.find("robot").traverse(node => { if (node.material) found.add(node.material.opacity < 1); });
                return [...found];
            })"""
        )
        assert through[1] == [True]
        assert False in through[0]
        assert len(page.locator("#plot-manipulability .value b").all()) == 2
        assert not troubles
