"""What a robot is, in words: hands, joints and limits, bodies, pairs, and what was assumed."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import coal
import numpy as np

from humanoid_rail.model.far_parts import AWAY
from humanoid_rail.model.hand_links import hand_bodies
from humanoid_rail.model.robot import Robot

MOST_PAIRS = 8
"""No more pairs than this are named with one reason."""


def report_of(robot: Robot) -> str:
    """Return a text about a robot."""
    sections = {
        "Hands": _hands(robot),
        "Joints": _joints(robot),
        "Joints that follow others": _followers(robot),
        "Joints that are locked": [f"{name} at {value:.6g}" for name, value in robot.locked.items()],
        "Postures": list(robot.postures),
        "Bodies": _bodies(robot),
        "Links with visuals or a mass and without a collision body": list(robot.links_without_body),
        "Pairs of links that are not checked, or only in part": _unchecked(robot),
        "Pairs that are kept nearer than the safety distance": _near(robot),
        "Found or assumed": list(robot.assumed),
    }
    pairs = len(robot.self_collision_pairs)
    title = f"{robot.name}: {robot.n} joints that move, {robot.collision_model.ngeoms} bodies, {pairs} pairs checked"
    return "\n\n".join([title, *(_section(name, lines) for name, lines in sections.items() if lines)]) + "\n"


def _section(title: str, lines: Sequence[str]) -> str:
    return "\n".join([title, *(f"  {line}" for line in lines)])


def _hands(robot: Robot) -> list[str]:
    found = []
    for hand, reach in zip(robot.hands, robot.arm_reaches, strict=True):
        points = "nowhere" if hand.pointing is None else "along " + " ".join(f"{x:g}" for x in hand.pointing)
        found.append(f"{hand.name}: {hand.frame}, points {points}, reaches {reach:.3f} m; arm {', '.join(hand.arm)}")
        links = dict.fromkeys(robot.link_names[i] for i in hand_bodies(robot, hand.name))
        found.append(f"  may touch what it grasps: {', '.join(links) or 'none of its bodies'}")
    return found


def _joints(robot: Robot) -> list[str]:
    """Return a table: limits of position, speed and acceleration, and the start."""
    rows: list[tuple[str, ...]] = [("joint", "unit", "from", "to", "speed", "acceleration", "start")]
    for i, name in enumerate(robot.joint_names):
        values = (
            robot.lower[i],
            robot.upper[i],
            robot.velocity_limit[i],
            robot.acceleration_limit[i],
            robot.initial[i],
        )
        rows.append((name, robot.unit_of(name), *(f"{value:.4g}" for value in values)))
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return [
        f"{row[0]:<{widths[0]}}  "
        + "  ".join(f"{text:>{width}}" for text, width in zip(row[1:], widths[1:], strict=True))
        for row in rows
    ]


def _followers(robot: Robot) -> list[str]:
    found = []
    for name in list(robot.model.names)[1:]:
        if name in robot.joint_names:
            continue
        joint = robot.model.joints[robot.model.getJointId(name)]
        row = robot.coupling[joint.idx_v]
        leader = int(np.argmax(abs(row)))
        found.append(f"{name} = {row[leader]:g} {robot.joint_names[leader]} + {robot.offset[joint.idx_q]:g}")
    return found


def _bodies(robot: Robot) -> list[str]:
    bodies = zip(robot.link_names, robot.collision_model.geometryObjects, strict=True)
    return [
        f"{link}: {', '.join(_shape(body.geometry) + _away(body.name) for _, body in group)}"
        for link, group in groupby(bodies, key=lambda pair: pair[0])
    ]


def _away(name: str) -> str:
    """Return what is added to a body that is the far part of another one."""
    other = name.partition(AWAY)[2]
    return f" (what of it is away from {other})" if other else ""


def _unchecked(robot: Robot) -> list[str]:
    """Return the reasons, each with its pairs."""
    pairs: dict[str, list[str]] = {}
    for pair in robot.unchecked_pairs:
        pairs.setdefault(pair.why, []).append(f"{pair.link} and {pair.other}")
    return [f"{_some(names)}: {why}" for why, names in pairs.items()]


def _some(names: Sequence[str]) -> str:
    more = len(names) - MOST_PAIRS
    return ", ".join(names[:MOST_PAIRS]) + (f" and {more} more pairs (robot.unchecked_pairs)" if more > 0 else "")


def _shape(shape: coal.CollisionGeometry) -> str:
    match shape:
        case coal.Sphere():
            return f"sphere of radius {shape.radius:g} m"
        case coal.Capsule():
            return f"capsule of radius {shape.radius:g} m and length {2 * shape.halfLength:g} m"
        case coal.Cylinder():
            return f"cylinder of radius {shape.radius:g} m and length {2 * shape.halfLength:g} m"
        case coal.Box():
            return "box of " + " x ".join(f"{2 * side:g}" for side in shape.halfSide) + " m"
        case _:
            return f"convex body of {shape.num_points} vertices"


def _near(robot: Robot) -> list[str]:
    links = robot.link_names
    named = {f"{links[i]} and {links[j]}: {1e3 * apart:.3g} mm" for (i, j), apart in robot.pair_distances.items()}
    return sorted(named)
