"""The paper's robot in the size of a human: its kinematics, and bodies for what is seen of trunk, head and hands."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import coal
import numpy as np
import pinocchio as pin
import pytest
from conftest import ROOT, random_q

from humanoid_rail import InvalidInput, Kinematics, Robot, Scene, build_urdf, export, load_robot, plan, retime, robots
from humanoid_rail.model.collision_bodies import coal_placement
from humanoid_rail.paper import dh_table as dh

LENGTHS = dh.Lengths(0.7, 0.3, 0.3, 0.22, 0.45, 0.45, 0.22, 0.45, 0.45, np.pi / 2)
COVERED = ("trunk", "head", "left_hand", "right_hand")


@pytest.fixture(scope="module")
def human() -> Robot:
    return load_robot("human-sized")


def test_its_kinematics_are_those_of_the_table(human: Robot, rng: np.random.Generator) -> None:
    assert "human-sized" in robots()
    for _ in range(20):
        q = random_q(human, rng)
        np.testing.assert_allclose(Kinematics(human).measure(q).hands, dh.hands(q, LENGTHS), atol=1e-9)


def test_it_is_as_tall_as_a_human(human: Robot) -> None:
    q = human.initial.copy()
    q[2:4] = np.pi / 2, 0.0
    data = human.model.createData()
    pin.forwardKinematics(human.model, data, human.full_configuration(q))
    heights = []
    for name, body in zip(human.link_names, human.collision_model.geometryObjects, strict=True):
        if name == "head":
            placed = coal.CollisionObject(body.geometry, coal_placement(data.oMi[body.parentJoint] * body.placement))
            placed.computeAABB()
            heights.append(placed.getAABB().max_[2])
    assert max(heights) == pytest.approx(1.6, abs=0.03)
    np.testing.assert_allclose(human.arm_reaches, 0.9)
    np.testing.assert_allclose(Kinematics(human).measure(human.initial).hands[:, 1] @ [1, 1], 0.0, atol=1e-9)


def test_what_is_seen_of_trunk_head_and_hands_is_inside_their_bodies(human: Robot) -> None:
    model = human.model
    visuals = pin.buildGeomFromUrdfString(model, human.urdf, pin.GeometryType.VISUAL).geometryObjects
    seen = dict.fromkeys(COVERED, 0)
    for visual in visuals:
        if (name := model.frames[visual.parentFrame].name) not in COVERED:
            continue
        bodies = [
            body
            for link, body in zip(human.link_names, human.collision_model.geometryObjects, strict=True)
            if body.parentJoint == visual.parentJoint and link in (name, name.replace("hand", "forearm"))
        ]
        for point in surface(visual.geometry):
            at = coal.Transform3s(np.eye(3), visual.placement.act(point))
            distances = [
                coal.distance(
                    coal.Sphere(1e-9),
                    at,
                    body.geometry,
                    coal_placement(body.placement),
                    coal.DistanceRequest(),
                    coal.DistanceResult(),
                )
                for body in bodies
            ]
            assert min(distances) < 1e-6, (name, point)
        seen[name] += 1
    assert all(seen.values())


def surface(shape: coal.ShapeBase) -> np.ndarray:
    """Return points (k, 3) on a shape, the outermost ones among them."""
    angles = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    match shape:
        case coal.Box():
            return np.array(np.meshgrid(*[(-h, h) for h in shape.halfSide])).reshape(3, -1).T
        case coal.Cylinder():
            ends = (-shape.halfLength, shape.halfLength)
            return np.vstack([np.column_stack([shape.radius * circle, np.full(24, z)]) for z in ends])
        case coal.Sphere():
            turns = [pin.utils.rotate("x", a) for a in angles]
            return np.vstack([shape.radius * np.column_stack([circle, np.zeros(24)]) @ R.T for R in turns])
    raise TypeError(shape)


def test_links_without_a_body_are_named(human: Robot, robot: Robot) -> None:
    assert not {*COVERED} & {*human.links_without_body}
    assert {*COVERED} <= {*robot.links_without_body}
    trajectory = plan(human, Scene(name="x", targets={"left": (-0.5, -0.2, 1.2), "right": None}))
    assert trajectory.status == "reached"
    assert trajectory.certificate.links_without_body == human.links_without_body


def test_what_would_be_hit_first_is_named_first(robot: Robot) -> None:
    names = robot.links_without_body
    assert {*names[:2]} == {"left_hand", "right_hand"}
    assert {*names[2:4]} == {"head", "trunk"}
    assert names[-1] == "base_link", "it never moves"


def test_the_documents_name_the_bodies_that_are_not_checked(robot: Robot) -> None:
    """And how to have them checked."""
    checked = {*load_robot(trunk_bodies=1).link_names} - {*robot.link_names}
    assert checked == {"left_hand", "right_hand", "head", "trunk"}
    for page in ("README.md", "docs/safety.md", "docs/tutorial.md", "docs/robot.md"):
        text = " ".join((ROOT / page).read_text(encoding="utf-8").split()).lower()
        without = [said for said in text.split(".") if "no collision body" in said or "none" in said]
        assert any(all(name in said for name in ("hands", "head", "trunk")) for said in without), page
        assert "load_robot(trunk_bodies=1)" in text, page


def test_trunk_bodies_are_there_or_not() -> None:
    assert "trunk_box" in build_urdf(trunk_bodies=1)
    assert "trunk_box" not in build_urdf()
    with pytest.raises(InvalidInput, match=r"trunk_bodies.*1 or 0"):
        build_urdf(trunk_bodies=0.5)


def test_mujoco_shows_trunk_and_head(human: Robot, tmp_path: Path) -> None:
    scene = Scene(name="x", targets={"left": (-0.5, -0.2, 1.2), "right": None})
    export(retime(plan(human, scene)), human, scene, "mujoco", tmp_path / "mujoco")
    (file,) = (tmp_path / "mujoco").glob("*.xml")
    bodies = {body.get("name"): body for body in ElementTree.parse(file).iter("body")}
    for name in ("trunk", "head"):
        assert len(bodies[name].findall("geom")) > 1
