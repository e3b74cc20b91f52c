"""What is hidden from a camera, against points along the lines of sight."""

from __future__ import annotations

import numpy as np

from humanoid_rail import Kinematics, Robot
from humanoid_rail.viewer.line_of_sight import crossed, hidden_share
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


def test_a_board_before_the_hands_hides_them(robot: Robot) -> None:
    hands = Kinematics(robot).hand_positions(robot.initial)
    ahead = np.array([4.0, 0.0, 0.3])
    board = np.array([hands.min(axis=0) - 0.3, hands.max(axis=0) + 0.3]) + ahead / 2
    board[:, 0] = board[:, 0].mean() + np.array([-0.01, 0.01])
    middle = hands.mean(axis=0)
    q, none = robot.initial, np.zeros((0, 2, 3))
    assert hidden_share(robot, q, board[None], middle + ahead) >= 1.0 + hidden_share(robot, q, none, middle + ahead)
    behind = middle - ahead
    assert hidden_share(robot, q, board[None], behind) == hidden_share(robot, q, none, behind)


def test_points_are_around_the_whole_robot(robot: Robot, rng: np.random.Generator) -> None:
    for _ in range(10):
        q = rng.uniform(robot.lower, robot.upper)
        ends, points = Kinematics(robot).bones(q).reshape(-1, 3), robot_points(robot, (), q)
        for direction in rng.normal(size=(50, 3)):
            assert (points @ direction).max() >= (ends @ direction).max()
