"""What is hidden from a camera, against points along the lines of sight."""

from __future__ import annotations

import numpy as np

from humanoid_rail import Kinematics, Robot
from humanoid_rail.viewer.line_of_sight import NEAR_HAND, crossed, hidden_hands
from humanoid_rail.viewer.sizes import robot_points


def test_lines_of_sight_cross_the_boxes_that_hold_a_point_of_theirs(rng: np.random.Generator) -> None:
    middles, halves = rng.uniform(-2, 2, (40, 1, 3)), rng.uniform(0.1, 0.8, (40, 1, 3))
    boxes = np.concatenate([middles - halves, middles + halves], axis=1)
    points, eye = rng.uniform(-2, 2, (30, 3)), np.array([3.0, -1.0, 2.0])
    along = points[:, None] + np.linspace(0, 1, 4000)[:, None] * (eye - points)[:, None]
    low, high = boxes[:, 0], boxes[:, 1]
    inside = np.array([[((low[j] < line) & (line < high[j])).all(axis=1).any() for j in range(40)] for line in along])
    found = crossed(points, eye, boxes)
    assert not (inside & ~found).any()
    assert (inside != found).mean() < 0.01, "only lines that graze a box may differ"
    assert 0.02 < inside.mean() < 0.5
    axis = crossed(
        np.zeros((1, 3)), np.array([0.0, 0.0, 5.0]), np.array([[[-1, -1, 1], [1, 1, 2]], [[1, 1, 1], [2, 2, 2.0]]])
    )
    np.testing.assert_array_equal(axis, [[True, False]])


def test_a_robot_hides_a_hand_from_behind_itself_and_not_from_beyond_the_hand(robot: Robot) -> None:
    boxes = robot_points(robot, (), robot.initial).reshape(-1, 8, 3)
    for name in robot.hand_names:
        one = robot.with_hands([name])
        (hand,) = Kinematics(one).hand_positions(robot.initial)
        body = boxes[0].mean(axis=0)
        away = (hand - body) / np.linalg.norm(hand - body)
        assert np.linalg.norm(hand - body) > NEAR_HAND
        shares = hidden_hands(one, robot.initial, np.array([body - 3.0 * away, hand + 5.0 * away]))
        assert shares.tolist() == [1.0, 0.0]


def test_points_are_around_the_whole_robot(robot: Robot, rng: np.random.Generator) -> None:
    for _ in range(10):
        q = rng.uniform(robot.lower, robot.upper)
        ends, points = Kinematics(robot).bones(q).reshape(-1, 3), robot_points(robot, (), q)
        for direction in rng.normal(size=(50, 3)):
            assert (points @ direction).max() >= (ends @ direction).max()
