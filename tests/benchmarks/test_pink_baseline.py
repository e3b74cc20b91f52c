"""Pink is set up as this package is."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("pink", reason="needs the extra compare")

from benchmarks.pink_baseline import Pink
from humanoid_rail import Robot, Scene
from humanoid_rail.paper import dh_table


def test_pink_moves_the_same_robot_to_the_same_targets(robot: Robot, scene: Scene) -> None:
    pink = Pink(robot, scene, dt=0.02)
    np.testing.assert_allclose(pink.configuration.q, robot.initial)
    assert len(pink.configuration.collision_model.collisionPairs) == 18
    targets = [scene.targets["left"], scene.targets["right"]]
    assert pink.error() == pytest.approx(np.linalg.norm(dh_table.hands(robot.initial) - targets), abs=1e-9)
    rollout = pink.rollout(tolerance=0.05)
    assert rollout.reached
    assert np.linalg.norm(dh_table.hands(rollout.q[-1]) - targets) <= 0.05 + 1e-9


def test_pink_gives_up_where_qp_does(robot: Robot, scene: Scene) -> None:
    far = scene.model_copy(update={"obstacles": (), "targets": {"left": (-9.0, 0.0, 3.0), "right": (-9.0, 0.0, 3.0)}})
    rollout = Pink(robot, far, dt=0.05, safety_distance=0.01).rollout(patience=0.5)
    assert (rollout.status, rollout.reached) == ("stalled", False)
    assert len(rollout.t) == len(rollout.q) < 60 / 0.05
    assert Pink(robot, far, dt=0.05, safety_distance=0.01).rollout(max_time=0.2).status == "time_limit"
