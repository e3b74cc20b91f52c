"""What moves on the playback page beside the robot: obstacles, and the lines between the closest bodies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from conftest import plan
from pages import drawn, needs_browser, tracks
from screenshot import opened, seek

from humanoid_rail import Kinematics, Robot, Scene, Sphere, Trajectory
from humanoid_rail.viewer.closest_pairs import closest_pairs
from humanoid_rail.viewer.frames import FRAMES_PER_SECOND, HOLD
from humanoid_rail.viewer.playback import playback_html


@pytest.fixture(scope="module")
def moving(robot: Robot, scene: Scene) -> tuple[Scene, Trajectory]:
    """A sphere that comes down between the arms, and one at rest."""
    obstacles = (
        Sphere(center=(-1.2, 1.4, 4.6), radius=0.2, velocity=(0.0, 0.1, -0.35)),
        Sphere(center=(-3.0, 0.0, 1.0), radius=0.2),
    )
    scene = scene.model_copy(update={"obstacles": obstacles})
    return scene, plan(robot, scene, "qp")


def test_the_animation_moves_obstacles_and_connections(robot: Robot, moving: tuple[Scene, Trajectory]) -> None:
    scene, trajectory = moving
    page = playback_html(robot, scene, trajectory)
    (positions,) = (moved := tracks(page, "obstacles")).values()
    times = np.minimum(np.arange(len(positions)) / FRAMES_PER_SECOND, trajectory.duration)
    assert len(positions) / FRAMES_PER_SECOND > trajectory.duration + HOLD
    np.testing.assert_allclose(positions, np.outer(times, scene.obstacles[0].velocity), atol=1e-9)
    assert [*moved] == ["together0.position"], "the other one is at rest"

    kinematics = Kinematics(robot, scene.obstacles)
    for kind in ("obstacles", "links"):
        one, two = (tracks(page, f"closest/{kind}/{end}")[".position"] for end in ("one", "two"))
        line = tracks(page, f"closest/{kind}/line")
        assert len(one) == len(two) == len(positions)
        for frame in range(0, len(times), 10):
            measured = kinematics.measure(trajectory.configuration(times[frame]), t=times[frame])
            least = (measured.clearance if kind == "obstacles" else measured.self_clearance).min()
            difference = two[frame] - one[frame]
            assert np.linalg.norm(difference) == pytest.approx(least, abs=2e-5)
            x, y, z, w = line[".quaternion"][frame]
            ends = pin.Quaternion(w, x, y, z) * (line[".scale"][frame] * [0.0, 1.0, 0.0])
            np.testing.assert_allclose(ends, difference, atol=1e-6)
            np.testing.assert_allclose(line[".position"][frame], (one[frame] + two[frame]) / 2, atol=1e-9)


@needs_browser
def test_the_browser_moves_obstacles_and_connections(
    robot: Robot, moving: tuple[Scene, Trajectory], tmp_path: Path
) -> None:
    scene, trajectory = moving
    (tmp_path / "page.html").write_text(playback_html(robot, scene, trajectory), encoding="utf-8")
    with opened(tmp_path / "page.html") as (page, troubles):
        for t in (1.0, 3.0, trajectory.duration + 1.0):
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
                        const part = name => ["closest", "obstacles", name, "2", "<object>"];
                        return [
                            place(part("line"), 0.5), place(part("line"), -0.5),
                            place(part("one"), 0), place(part("two"), 0),
                        ];
                    }"""
                )
            )
            time = min(t, trajectory.duration)
            centre = np.array(scene.obstacles[0].center) + time * np.array(scene.obstacles[0].velocity)
            np.testing.assert_allclose((low + high) / 2, centre, atol=2e-3)
            (closest,) = closest_pairs(robot, scene, trajectory, [time]).obstacles
            assert closest.other == "obstacles[0] (sphere)"
            np.testing.assert_allclose([one, two], closest.points, atol=5e-3)
            np.testing.assert_allclose([bottom, top], [one, two], atol=1e-3)
            seen = page.evaluate(
                """() => {
                    const path = ["meshcat", "world", "closest", "obstacles", "one", "2", "<object>"];
                    const bead = viewer.scene_tree.find(path).object;
                    return [bead.renderOrder, bead.material.depthTest];
                }"""
            )
            assert seen == [2, False]
        assert not troubles
