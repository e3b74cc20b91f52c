"""What the script of a playback page knows of motions, as data that JSON can hold."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import is_moving, name_of
from humanoid_rail.scene.scene import Scene
from humanoid_rail.scene.targets import alternatives, numbers_there, position
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.viewer.camera import HALF_HEIGHT, SHARE, View
from humanoid_rail.viewer.closest_pairs import Closest
from humanoid_rail.viewer.colours import CLEARANCE_SCALE, PENETRATION_COLOUR, hand_colour
from humanoid_rail.viewer.drawing import moving_together
from humanoid_rail.viewer.joints import joints_data
from humanoid_rail.viewer.page import packed
from humanoid_rail.viewer.series import Series
from humanoid_rail.viewer.sizes import scale


def scene_data(robot: Robot, scene: Scene, view: View, floor: float) -> dict[str, Any]:
    """Return what a page knows of a robot and a scene; m, rad and s."""
    moving = moving_together(scene.obstacles)
    return {
        "scale": scale(robot),
        "floor": floor,
        "view": {
            "middle": view.middle.tolist(),
            "direction": (view.camera / np.linalg.norm(view.camera)).tolist(),
            "points": packed(view.points),
            "halfHeight": float(HALF_HEIGHT),
            "share": SHARE,
        },
        "joints": joints_data(robot),
        "jointNames": list(robot.joint_names),
        "hands": [_hand(robot, i) for i in range(len(robot.hands))],
        "obstacles": [name_of(scene.obstacles, i) for i in range(len(scene.obstacles))],
        "velocities": {
            name: list(scene.obstacles[numbers[0]].velocity)
            for name, numbers in moving.items()
            if is_moving(scene.obstacles[numbers[0]])
        },
        "steps": len(scene.steps),
        "targets": [
            {"steps": numbers_there(scene.steps, number, hand, choice), "hand": hand, "position": list(position(one))}
            for number, step in enumerate(scene.steps)
            for hand, target in step.items()
            for choice, one in enumerate(alternatives(target))
            if one is not None
        ],
        "clearanceColours": [[at, f"#{colour:06x}"] for at, colour in CLEARANCE_SCALE],
        "penetrationColour": f"#{PENETRATION_COLOUR:06x}",
    }


def motion_data(name: str, trajectory: Trajectory, series: Series) -> dict[str, Any]:
    """Return what a page knows of a motion over time; arrays row by row."""
    return {
        "name": name,
        "duration": trajectory.duration,
        "arrivals": list(trajectory.arrivals),
        "t": packed(series.t),
        "q": packed(series.q),
        "clearance": None if series.clearance is None else packed(series.clearance),
        "manipulability": packed(series.manipulability),
        "speed": packed(series.speed),
        "acceleration": None if series.acceleration is None else packed(series.acceleration),
        "handSpeed": packed(series.hand_speed),
        "closest": {kind: _pairs(pairs) for kind, pairs in series.pairs._asdict().items() if pairs},
    }


def _pairs(pairs: Sequence[Closest]) -> dict[str, Any]:
    names = [f"{pair.link} \u2013 {pair.other}" for pair in pairs]
    known = {name: number for number, name in enumerate(dict.fromkeys(names))}
    return {
        "names": list(known),
        "pair": [known[name] for name in names],
        "distance": packed([pair.distance for pair in pairs]),
        "points": packed([pair.points for pair in pairs]),
    }


def _hand(robot: Robot, i: int) -> dict[str, Any]:
    frame = robot.model.frames[robot.model.getFrameId(robot.hands[i].frame)]
    return {
        "name": robot.hands[i].name,
        "joint": int(frame.parentJoint),
        "offset": frame.placement.translation.tolist(),
        "colour": f"#{hand_colour(i):06x}",
    }
