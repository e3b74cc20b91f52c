"""Why a plan failed, in a picture: the nearest miss as a ghost, what blocks in red, and how far the hands are off."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import Any

import meshcat
import meshcat.geometry as mg
import meshcat.transformations as mt
import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.diagnosis import TRIED, Diagnosis, besides, length
from humanoid_rail.model.robot import Robot, called
from humanoid_rail.scene.obstacles import HalfSpace, moved
from humanoid_rail.scene.scene import Scene
from humanoid_rail.scene.shapes import PlacedShape, placed_shapes
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.viewer.colours import BLOCKING_COLOUR, rgb
from humanoid_rail.viewer.connection import OnTop
from humanoid_rail.viewer.drawing import draw_bodies, is_floor, node_name
from humanoid_rail.viewer.forms import Group, instances
from humanoid_rail.viewer.sizes import bounds, scale
from humanoid_rail.viewer.visual_meshes import Visual, draw_visuals

GHOST = (0.35, 0.40, 0.47, 0.32)
"""The robot at the nearest miss has this colour, red, green, blue and opacity from 0 to 1."""
OPACITY, LARGE_OPACITY = 0.75, 0.3
"""How opaque what blocks is, from 0 to 1; and how opaque it is where it is large, as a wall, so that it hides less."""
LARGE = 3.0
"""What is at least this long is large, m; scaled with the robot."""
SHORTEST = 0.002
"""Hands that are nearer to their targets have no line to them, m."""
FOUND = {
    "search": "the nearest place to which a path was found",
    "motion": "where the motion ends",
    "posture": "the nearest configuration that was found to keep clear",
    "reach": "as near as the joint limits allow",
}
"""Where a nearest miss comes from, in words."""


def draw_miss(
    view: meshcat.Visualizer, robot: Robot, scene: Scene, visuals: Sequence[Visual], trajectory: Trajectory
) -> None:
    """Draw the nearest miss of a plan that failed; nothing if it did not.

    Args:
        view: The node in which it is drawn.
        robot: The robot.
        scene: The scene.
        visuals: The visual bodies of the robot.
        trajectory: The motion of the plan.
    """
    found = trajectory.diagnosis
    if found is None:
        return
    data, size = robot.model.createData(), scale(robot)
    pin.forwardKinematics(robot.model, data, robot.full_configuration(found.q))
    ghost, links = view["ghost"], view["links"]
    draw_visuals(ghost, [v._replace(rgba=GHOST) for v in visuals if v.joint != robot.model.names[0]])
    draw_bodies(links, robot, _blocking_bodies(robot, found))
    for number, joint in enumerate(robot.model.names):
        for node in (ghost, links):
            node[node_name(joint)].set_transform(data.oMi[number].homogeneous)
    blocking = [moved(scene.obstacles[i], trajectory.duration) for i in _obstacles(found) if i < len(scene.obstacles)]
    pieces = [piece for o in blocking if not (isinstance(o, HalfSpace) and is_floor(o)) for piece in placed_shapes(o)]
    large = [piece for piece in pieces if _length(piece) >= LARGE * size]
    small = [piece for piece in pieces if _length(piece) < LARGE * size]
    drawn = [*instances(small, BLOCKING_COLOUR, OPACITY, 1), *instances(large, BLOCKING_COLOUR, LARGE_OPACITY, 1)]
    view["obstacles"].set_object(Group({"blocking": drawn}))
    for miss in found.misses:
        if miss.distance > SHORTEST:
            _draw_line(view["lines"][node_name(miss.hand)], np.array(miss.position), np.array(miss.target), size)


def miss_data(found: Diagnosis | None) -> dict[str, Any] | None:
    """Return what the script of a page knows of a nearest miss: where its lengths are written."""
    if found is None:
        return None
    return {
        "labels": [
            {
                "text": f"{length(miss.distance)} m",
                # Each at another share of its line, so that those of hands that are together can be read.
                "place": (
                    np.array(miss.position) + (0.3 + 0.4 * (i % 2)) * np.subtract(miss.target, miss.position)
                ).tolist(),
            }
            for i, miss in enumerate(found.misses)
            if miss.distance > SHORTEST
        ]
    }


def miss_panel(name: str, reason: str, found: Diagnosis) -> str:
    """Return what a page says of a plan that failed, as HTML: how near it gets, what would help, and what blocks.

    Args:
        name: A heading.
        reason: The reason of the plan; its first clause is in the caption.
        found: Why it failed.
    """
    hands = [f"{called(m.hand)} stays {length(m.distance)} m away" for m in found.misses if m.distance > SHORTEST]
    pairs = [f"{pair.link} \u2013 {pair.other}, {_apart(pair.beyond)}" for pair in found.blocking]
    helps = [f"{remedy.what} ({TRIED[remedy.proven]})" for remedy in found.remedies]
    parts = [
        ("Nearest miss", [*hands, FOUND[found.found_by]]),
        ("What would help", helps or ["nothing that was tried"]),
        ("What blocks, where it would have to go on", [*pairs, *found.limits]),
        ("Besides", besides(reason, found)[1:]),
    ]
    lists = "".join(
        f"<h3>{title}</h3><ul>{''.join(f'<li>{html.escape(line)}</li>' for line in lines)}</ul>"
        for title, lines in parts
        if lines
    )
    return f"<h2>{html.escape(name)}</h2>{lists}"


def _apart(distance: float) -> str:
    return f"{-distance:.3f} m inside one another" if distance < 0 else f"{distance:.3f} m apart"


def _length(piece: PlacedShape) -> float:
    """Return the longest side of the box around a piece, m."""
    box = bounds(piece)
    return float(np.ptp(box, axis=0).max()) if len(box) else np.inf


def _obstacles(found: Diagnosis) -> list[int]:
    return [pair.obstacle for pair in found.blocking if pair.obstacle is not None]


def _blocking_bodies(robot: Robot, found: Diagnosis) -> pin.GeometryModel:
    """Return the bodies of the links that block, in red."""
    names = {pair.link for pair in found.blocking} | {p.other for p in found.blocking if p.obstacle is None}
    bodies = pin.GeometryModel()
    for link, body in zip(robot.link_names, robot.collision_model.geometryObjects, strict=True):
        if link in names:
            own = body.copy()
            own.meshColor = np.array([*rgb(BLOCKING_COLOUR), OPACITY])
            bodies.addGeometryObject(own)
    return bodies


def _draw_line(view: meshcat.Visualizer, start: Array, end: Array, size: float) -> None:
    """Draw a line with a bar across each of its ends, seen through everything."""
    along = end - start
    far = float(np.linalg.norm(along))
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 1.0, 0.0]), along / far).matrix()
    view["line"].set_object(OnTop(mg.Cylinder(far, 0.012 * size), BLOCKING_COLOUR, 3))
    view["line"].set_transform(pin.SE3(turn, (start + end) / 2).homogeneous)
    for name, at in (("hand", start), ("target", end)):
        view[name].set_object(OnTop(mg.Cylinder(0.012 * size, 0.05 * size), BLOCKING_COLOUR, 3))
        view[name].set_transform(mt.translation_matrix(at) @ pin.SE3(turn, np.zeros(3)).homogeneous)
