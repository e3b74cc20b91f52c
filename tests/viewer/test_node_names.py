"""Joints, links and hands may be called anything: slashes in their names do not take apart what is drawn."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from pages import needs_browser
from screenshot import opened

from humanoid_rail import Robot, Scene, Trajectory, load_robot, plan
from humanoid_rail.viewer.playback import playback_html
from humanoid_rail.viewer.robot_page import robot_html

BODY = '<collision><origin xyz="0.1 0 0"/><geometry><sphere radius="0.05"/></geometry></collision>'
NAMES = ["lift", "lift/turn", "/lift/<object>"]
"""Joints: one is called as if it were below another."""
LINKS = ["base", "arm/1", "arm/1/2", "/tip"]
URDF = (
    "<robot name='a/b'>"
    + "".join(f'<link name="{name}">{BODY}{BODY.replace("collision>", "visual>")}</link>' for name in LINKS)
    + "".join(
        f'<joint name="{name.replace("<", "&lt;")}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        '<origin xyz="0.3 0 0"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>'
        for name, parent, child in zip(NAMES, LINKS[:-1], LINKS[1:], strict=True)
    )
    + "</robot>"
)
CENTRES = """path => {
    viewer.scene.updateMatrixWorld(true);
    const world = viewer.scene_tree.find(["meshcat", "world"]).object, centres = [];
    viewer.scene_tree.find(["meshcat", "world", ...path]).object.traverse(mesh => {
        if (!mesh.isInstancedMesh) return;
        const at = world.matrixWorld.clone(), own = at.clone();
        mesh.getMatrixAt(0, own);
        at.invert().multiply(mesh.matrixWorld).multiply(own);
        centres.push(at.elements.slice(12, 15));
    });
    return centres;
}"""


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot(URDF, hands={"to/ol": "/tip"}, initial=dict.fromkeys(NAMES, 0.3))


@pytest.fixture(scope="module")
def motion(robot: Robot) -> tuple[Scene, Trajectory]:
    scene = Scene(targets={"to/ol": (0.5, -0.4, 0.0)})
    return scene, plan(robot, scene)


def playback(robot: Robot, motion: tuple[Scene, Trajectory]) -> str:
    return playback_html(robot, *motion)


def page_of_robot(robot: Robot, motion: tuple[Scene, Trajectory]) -> str:
    return robot_html(robot)


@needs_browser
@pytest.mark.parametrize(
    ("page_of", "show", "node"),
    [
        (playback, "() => { playback.clock.pause(); playback.clock.seek(playback.clock.duration); }", ["motion0"]),
        (page_of_robot, "() => setPosture([-0.4, 0.5, 0.6])", []),
    ],
)
def test_bodies_are_drawn_where_they_are(
    page_of: Callable[[Robot, tuple[Scene, Trajectory]], str],
    show: str,
    node: list[str],
    robot: Robot,
    motion: tuple[Scene, Trajectory],
    tmp_path: Path,
) -> None:
    q = motion[1].q[-1] if node else np.array([-0.4, 0.5, 0.6])
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.full_configuration(q))
    bodies = robot.collision_model.geometryObjects
    expected = sorted((data.oMi[body.parentJoint] * body.placement).translation.tolist() for body in bodies)
    (tmp_path / "page.html").write_text(page_of(robot, motion), encoding="utf-8")
    with opened(tmp_path / "page.html") as (page, troubles):
        page.evaluate(show)
        for tree in ("robot", "bodies"):
            np.testing.assert_allclose(sorted(page.evaluate(CENTRES, [*node, tree])), expected, atol=1e-5)
        assert not troubles
