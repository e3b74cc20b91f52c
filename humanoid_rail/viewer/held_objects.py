"""The objects of a scene in the page: each in a node of its own, which the script puts where it is."""

from __future__ import annotations

from typing import Any

import meshcat
import pinocchio as pin

from humanoid_rail.holding.holding import Holding
from humanoid_rail.holding.phases import phases_of
from humanoid_rail.model.attached import COLOUR
from humanoid_rail.model.collision_bodies import coal_placement
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.colors import color_bytes
from humanoid_rail.scene.objects import pieces_of
from humanoid_rail.scene.placing import placement_of
from humanoid_rail.scene.scene import Scene
from humanoid_rail.scene.shapes import PlacedShape
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.viewer.colours import colour_of
from humanoid_rail.viewer.drawing import node_name
from humanoid_rail.viewer.forms import Group, instances


def draw_objects(view: meshcat.Visualizer, scene: Scene) -> None:
    """Draw each object in a node of its name, in the frame of the object."""
    for one in scene.objects:
        shapes, placements = pieces_of(one, placement_of(one))
        placed = [PlacedShape(shape, coal_placement(at)) for shape, at in zip(shapes, placements, strict=True)]
        colour = colour_of(COLOUR) if one.color is None else color_bytes(one.color)
        view[node_name(str(one.name))].set_object(Group({"body": instances(placed, colour, 1.0)}))


def objects_data(robot: Robot, scene: Scene, trajectory: Trajectory) -> list[dict[str, Any]]:
    """Return where each object is over time, as data that JSON can hold: from a time on in the frame of a joint.

    Joints are those of the page's kinematics; 0 is the base frame. Placements are matrices (4, 4) by columns.
    """
    if not scene.objects:
        return []
    phases = phases_of(robot, scene, trajectory.motion)
    return [
        {
            "node": node_name(str(one.name)),
            "name": str(one.name),
            "parts": [{"t": phase.begin, **_part(robot, phase.holding, str(one.name))} for phase in phases],
        }
        for one in scene.objects
    ]


def _part(robot: Robot, holding: Holding, name: str) -> dict[str, Any]:
    joint, place = 0, holding.standing.get(name)
    if place is None:
        held = holding.held[name]
        frame = robot.model.frames[robot.model.getFrameId(robot.hands[robot.hand(held.hands[0])].frame)]
        joint, place = int(frame.parentJoint), frame.placement * held.placement
    assert isinstance(place, pin.SE3)
    return {"joint": joint, "placement": place.homogeneous.T.ravel().tolist()}
