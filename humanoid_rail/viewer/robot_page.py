"""A page to look at a robot: its bodies over its meshes, joints to move, and which bodies touch."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping
from typing import Any

import coal
import meshcat
import meshcat.transformations as mt
import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.model.pairs import NO_JOINT
from humanoid_rail.model.robot import Robot
from humanoid_rail.viewer.camera import CAMERA, fitted
from humanoid_rail.viewer.drawing import draw_bodies, node_name
from humanoid_rail.viewer.joints import joints_data
from humanoid_rail.viewer.page import CommandList, page_html
from humanoid_rail.viewer.sizes import robot_points
from humanoid_rail.viewer.view import BELOW, dim, set_up
from humanoid_rail.viewer.visual_meshes import draw_visuals, robot_visuals

NEAR = 0.01
"""Checked pairs that are nearer than this are marked, m: the safety distance, unless a pair has a smaller one."""
MOVED = 4
"""The camera also sees the robot in so many random postures."""
START = "start"
"""The posture in which motions start is called so."""
FRONT = CAMERA * [-1.0, -1.0, 1.0]
"""The camera is in this direction, in front of the robot."""


def robot_html(robot: Robot) -> str:
    """Return a page to look at a robot: one file, which needs neither a server nor the network.

    It shows meshes and collision bodies, a slider for each joint that is actuated, buttons for the postures, and which
    bodies touch, at each move of a slider. It does not show how deep bodies are in each other, and no obstacles.
    """
    drawn, visuals = CommandList(), robot_visuals(robot)
    view = meshcat.Visualizer(window=drawn)
    points = robot_points(robot, visuals, robot.initial)
    moved = np.random.default_rng(0).uniform(robot.lower, robot.upper, (MOVED, robot.n))
    seen = np.vstack([points, *(robot_points(robot, (), q) for q in moved)])
    middle = (seen.min(axis=0) + seen.max(axis=0)) / 2
    set_up(view, middle, fitted(FRONT, seen - middle), float(points[:, 2].min()) - BELOW)
    dim(view)
    world = view["world"]
    world.set_transform(mt.translation_matrix(-middle))
    draw_visuals(world["robot"], visuals)
    bodies = robot.collision_model.copy()
    for body in bodies.geometryObjects:
        body.meshColor = np.array([0.3, 0.55, 0.84, 0.3])
    draw_bodies(world["bodies"], robot, bodies)
    data = page_data(robot)
    title, scripts = f"{robot.name}: humanoid_rail", ("kinematics.js", "convex_distance.js", "robot_page.js")
    return page_html(title, _panel(robot, data), drawn, data, style="robot_page.css", scripts=scripts)


def page_data(robot: Robot) -> dict[str, Any]:
    """Return what the page's script knows of a robot, as data that JSON can hold; m and rad."""
    return {
        "nodes": [node_name(name) for name in robot.model.names],
        "joints": joints_data(robot),
        "initial": robot.initial.tolist(),
        "postures": {START: robot.initial.tolist(), **{name: [*q] for name, q in robot.postures.items()}},
        "sliders": [
            {"name": name, "unit": robot.unit_of(name), "lower": lower, "upper": upper}
            for name, lower, upper in zip(robot.joint_names, robot.lower.tolist(), robot.upper.tolist(), strict=True)
        ],
        "bodies": [_body(robot, body) for body in robot.collision_model.geometryObjects],
        "checked": [[i, j, robot.pair_distances.get((i, j), NEAR)] for i, j in robot.self_collision_pairs],
        "unchecked": list(_unchecked(robot)),
        "reasons": [str(pair) for pair in robot.unchecked_pairs],
    }


def _body(robot: Robot, body: pin.GeometryObject) -> dict[str, Any]:
    """Return a collision body in the frame of its joint, as convex_distance.js has bodies."""
    points, disc, radius = _core(body.geometry)
    placed = points @ body.placement.rotation.T + body.placement.translation
    middle = (placed.min(axis=0) + placed.max(axis=0)) / 2
    return {
        "node": node_name(body.name),
        "link": robot.model.frames[body.parentFrame].name,
        "joint": int(body.parentJoint),
        "points": placed.tolist(),
        "disc": disc,
        "axis": body.placement.rotation[:, 2].tolist(),
        "radius": radius,
        "middle": middle.tolist(),
        "extent": float(np.linalg.norm(placed - middle, axis=1).max()) + disc + radius,
    }


def _core(shape: coal.CollisionGeometry) -> tuple[Array, float, float]:
    """Return points (k, 3) of a shape, the radius of the discs around them across z, and its thickness, m."""
    swept = float(shape.getSweptSphereRadius()) if hasattr(shape, "getSweptSphereRadius") else 0.0
    match shape:
        case coal.Sphere():
            return np.zeros((1, 3)), 0.0, float(shape.radius) + swept
        case coal.Capsule():
            return np.array([[0, 0, -1.0], [0, 0, 1.0]]) * shape.halfLength, 0.0, float(shape.radius) + swept
        case coal.Cylinder():
            return np.array([[0, 0, -1.0], [0, 0, 1.0]]) * shape.halfLength, float(shape.radius), swept
        case coal.Box():
            corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
            return corners * np.array(shape.halfSide), 0.0, swept
        case coal.ConvexBase():
            return np.array(shape.points()), 0.0, swept
        case _:
            raise TypeError(f"no distance of a {type(shape).__name__} in a page")


def _unchecked(robot: Robot) -> Iterator[list[int]]:
    """Yield the pairs of bodies of links that are not checked, but could move, and the number of the reason."""
    of_link: dict[str, list[int]] = {}
    for i, name in enumerate(robot.link_names):
        of_link.setdefault(name, []).append(i)
    for number, pair in enumerate(robot.unchecked_pairs):
        if not pair.why.endswith(NO_JOINT):
            yield from ([i, j, 0, number] for i in of_link[pair.link] for j in of_link[pair.other])


def _panel(robot: Robot, data: Mapping[str, Any]) -> str:
    """Return the page around what is drawn, of the data that its script knows, as HTML."""
    sliders = "".join(
        f'<div class="joint"><label for="slider-{i}">{html.escape(joint["name"])}</label><span id="value-{i}"></span>'
        f'<input type="range" id="slider-{i}" min="{joint["lower"]}" max="{joint["upper"]}" step="any">'
        f'<span class="limit">{joint["lower"]:.3f}</span><span class="limit">{joint["upper"]:.3f}</span></div>'
        for i, joint in enumerate(data["sliders"])
    )
    postures = "".join(
        f'<button data-posture="{html.escape(name)}">{html.escape(name)}</button>' for name in data["postures"]
    )
    contacts = "".join(
        f'<p><span class="key" style="background:{colour}"></span>{said}: <b id="{name}-count"></b></p>'
        f'<ul id="{name}"></ul>'
        for name, colour, said in (("touching", "#d7191c", "touching"), ("near", "#f07f1b", "near"))
    )
    return f"""<div id="robot-panel">
<h1>{html.escape(robot.name)}</h1>
<p class="quiet">Hands: {html.escape(", ".join(f"{hand.name} ({hand.frame})" for hand in robot.hands))}</p>
<label><input type="checkbox" id="show-robot" checked> meshes (M)</label>
<label><input type="checkbox" id="show-bodies" checked> collision bodies (B)</label>
<h2>Postures</h2>{postures}
<h2>Pairs that are checked: {len(data["checked"])}</h2>{contacts}
<details><summary>touching, but not checked: <b id="unchecked-count"></b></summary><ul id="unchecked"></ul></details>
<h2>Joints</h2>{sliders}
<h2>This posture</h2><textarea id="posture" readonly></textarea>
<p class="quiet">Drag to turn, scroll to zoom. Near is below the distance that is kept. The page has no obstacles.</p>
</div>
<div id="meshcat-pane"></div>"""
