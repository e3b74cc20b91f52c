"""What robots are drawn with."""

from __future__ import annotations

import re

import coal
import numpy as np
import pinocchio as pin
import pytest

from humanoid_rail import Robot, Scene, plan_case, robot_from_urdf
from humanoid_rail.viewer.playback import playback_html
from humanoid_rail.viewer.visual_bodies import PLAIN, visual_bodies


def test_primitives_are_those_of_pinocchio(robot: Robot) -> None:
    expected = pin.buildGeomFromUrdfString(robot.model, robot.urdf, pin.GeometryType.VISUAL).geometryObjects
    found = visual_bodies(robot).geometryObjects
    assert len(found) == len(expected) > 40
    for body, other in zip(found, expected, strict=True):
        assert (body.parentJoint, body.parentFrame) == (other.parentJoint, other.parentFrame)
        assert type(body.geometry) is type(other.geometry)
        assert body.geometry.computeVolume() == pytest.approx(other.geometry.computeVolume(), rel=1e-12)
        assert body.placement.isApprox(other.placement, 1e-12)
        np.testing.assert_allclose(body.meshColor, other.meshColor)


def test_meshes_that_nobody_can_find_are_named(robot: Robot, scene: Scene) -> None:
    """In place of the hands' bodies; the column, which has a capsule, is drawn as that."""
    urdf = re.sub(
        r'(?s)(<link name="(carriage|left_hand)">.*?)<visual>.*?</visual>',
        r'\1<visual><geometry><mesh filename="package://nowhere/\2.dae"/></geometry></visual>',
        robot.urdf,
    )
    other = robot_from_urdf(urdf, None, robot.hands, robot.initial)
    with pytest.warns(UserWarning, match="package://nowhere/carriage.dae, package://nowhere/left_hand.dae"):
        bodies = visual_bodies(other).geometryObjects
    capsules = [body for body in bodies if isinstance(body.geometry, coal.Capsule)]
    assert [other.model.frames[body.parentFrame].name for body in capsules] == ["carriage"]
    assert tuple(capsules[0].meshColor) == PLAIN
    with pytest.warns(UserWarning, match="not drawn"):
        assert "meshcat" in playback_html(other, scene, plan_case(other, 3))
