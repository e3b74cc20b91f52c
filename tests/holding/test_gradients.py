"""Gradients of clearances with objects in hands, and the rows that the safe velocity makes of them."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import central_difference, in_order, points, random_q, some_obstacles

from humanoid_rail import Gains, NativeKinematics, Robot, Safety, Scene
from humanoid_rail._arrays import Array
from humanoid_rail.holding.holding import after_grasp, at_the_start, hand_placement, robot_among
from humanoid_rail.kinematics import kinematics
from humanoid_rail.resolution.native_velocity import constrained_velocity
from humanoid_rail.resolution.qp import constraints
from humanoid_rail.scene.scene import make_scene

TARGETS = np.array([[-1.6, 0.6, 3.4], [-1.6, 2.2, 3.4]])


@pytest.fixture(scope="module")
def scene(robot: Robot) -> Scene:
    """Return a scene with two objects at the hands, and one that stands; large ones, so that they touch much."""
    left, right = (hand_placement(robot, name, robot.initial).translation for name in robot.hand_names)
    return make_scene(
        {
            "name": "gradients",
            "targets": {"left": None, "right": [0, 0, 3]},
            "objects": [
                {"type": "capsule", "name": "bar", "center": left.tolist(), "radius": 0.25, "length": 1.2},
                {"type": "sphere", "name": "ball", "center": right.tolist(), "radius": 0.5},
                {"type": "sphere", "name": "stand", "center": [-0.8, 1.0, 2.5], "radius": 0.5},
            ],
        }
    )


@pytest.fixture(scope="module")
def holding(robot: Robot, scene: Scene) -> Robot:
    """Return the robot with both in its hands."""
    held = after_grasp(robot, at_the_start(scene), {"bar": ("left",), "ball": ("right",)}, robot.initial)
    return robot_among(robot, scene, held, {})[0]


def is_smooth(one: Array, other: Array) -> bool:
    """Return whether differences of two lengths agree: where the nearest points jump they do not."""
    return bool(np.allclose(one, other, atol=1e-5))


def test_clearances_of_what_is_held(holding: Robot, Kinematics: type, rng: np.random.Generator) -> None:
    """Every column, from obstacles, on both sides of contact."""
    rows = [holding.link_names.index(name) for name in ("bar", "ball")]
    seen = {"apart": 0, "contact": 0}
    for _ in range(40):
        here, q = Kinematics(holding, some_obstacles(rng, 40)), random_q(holding, rng)
        state = here.state(q)
        one, other = (
            central_difference(lambda x, here=here: here.measure(x).clearance[rows], q, h) for h in (1e-6, 1e-5)
        )
        for k, link in enumerate(rows):
            for number, distance in enumerate(state.clearance[link]):
                if is_smooth(one[k, number], other[k, number]):
                    np.testing.assert_allclose(state.clearance_gradient[link, number], one[k, number], atol=1e-5)
                    seen["contact" if distance < 0 else "apart"] += 1
    assert seen["contact"] >= 20
    assert seen["apart"] >= 200


def test_distances_of_what_is_held_from_links(holding: Robot, Kinematics: type, rng: np.random.Generator) -> None:
    """Every column, from links, from each other and from what stands, on both sides of contact."""
    names, here = holding.link_names, Kinematics(holding)
    pairs = [
        i for i, pair in enumerate(holding.self_collision_pairs) if {names[k] for k in pair} & set(holding.objects)
    ]
    seen = {"apart": 0, "contact": 0, "objects": 0}
    for _ in range(40):
        q = random_q(holding, rng)
        state = here.state(q)
        one, other = (central_difference(lambda x: here.measure(x).self_clearance, q, h) for h in (1e-6, 1e-5))
        for i in pairs:
            if is_smooth(one[i], other[i]):
                np.testing.assert_allclose(state.links.gradient[i], one[i], atol=1e-5)
                seen["contact" if state.links.distance[i] < 0 else "apart"] += 1
                seen["objects"] += {names[k] for k in holding.self_collision_pairs[i]} <= set(holding.objects)
    assert seen["contact"] >= 20
    assert seen["apart"] >= 300
    assert seen["objects"] >= 60


def test_both_engines_have_the_same_rows(holding: Robot, rng: np.random.Generator) -> None:
    """Those of the Python engine are made of the gradients above."""
    safety, compared, with_objects = Safety(safety_distance=0.02, damper_gain=3.0), 0, 0
    for _ in range(20):
        obstacles, q = some_obstacles(rng, 9), random_q(holding, rng)
        state = kinematics.Kinematics(holding, obstacles).state(q)
        expected = constraints(holding, state, safety, 0.01)
        fast = NativeKinematics(holding, obstacles)
        constrained_velocity(fast, points(TARGETS), Gains(), safety, 0.01)(q, 0.0)
        rows, sides = fast.native.constraints()
        found = in_order(sides, rows)
        np.testing.assert_allclose(found, in_order(expected.sides, expected.rows), atol=1e-6)
        compared += len(found)
        with_objects += bool((state.clearance[-3:-1] <= safety.horizon).any())
    assert compared > 100
    assert with_objects > 5
