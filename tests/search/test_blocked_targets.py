"""Which targets are refused because of what the hand's body would touch there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from conftest import points

from humanoid_rail import Robot, Sphere
from humanoid_rail.search.blocked_targets import blocked_target, targets_inside

PLACES = [[-1.6, 0.6, 3.4], [-1.6, 0.66, 3.4]]


def test_the_bodies_that_hold_the_hands_keep_what_their_pair_keeps(robot: Robot) -> None:
    """The forearms, 5 cm in radius: with 6 cm between the points they are in each other."""
    tasks = points(np.array(PLACES))
    fault = blocked_target(robot, tasks, (), 0.01, 1e-3)
    assert fault is not None
    assert "0.04 m inside the right hand" in fault
    names = robot.link_names
    pair = tuple(sorted((names.index("left_forearm"), names.index("right_forearm"))))
    unchecked = tuple(p for p in robot.self_collision_pairs if tuple(sorted(p)) != pair)
    assert blocked_target(replace(robot, self_collision_pairs=unchecked), tasks, (), 0.01, 1e-3) is None
    near = points(np.array([PLACES[0], [-1.6, 0.704, 3.4]]))  # 4 mm apart
    assert blocked_target(robot, near, (), 0.01, 1e-3) is not None
    own = replace(robot, pair_distances={pair: 0.003})
    assert blocked_target(own, near, (), 0.01, 1e-3) is None


def test_a_point_outside_of_all_bodies_may_be_inside_of_something(robot: Robot) -> None:
    thing = Sphere(center=(-1.6, 0.6, 3.4), radius=0.1)
    assert blocked_target(robot, points(np.array(PLACES))[:1], (thing,), 0.01, 1e-3) is not None
    model = robot.model.copy()
    frame = model.getFrameId(robot.hands[0].frame)
    placement = model.frames[frame].placement
    placement.translation = placement.translation * 1.2
    model.frames[frame].placement = placement
    assert blocked_target(replace(robot, model=model), points(np.array(PLACES))[:1], (thing,), 0.01, 1e-3) is None
    [said] = targets_inside(points(np.array(PLACES))[:1], (Sphere(center=(0.0, 0.0, 0.0), radius=0.1), thing))
    assert said == "the target of the left hand is 0.1 m inside obstacles[1] (sphere)"
