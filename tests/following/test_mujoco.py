"""The example that drives MuJoCo by a follower."""

from __future__ import annotations

import sys

import pytest
from conftest import ROOT

pytest.importorskip("mujoco", reason="needs the extra tools")
sys.path.insert(0, str(ROOT / "examples"))


def test_a_simulated_robot_follows_and_is_not_touched() -> None:
    import follow_mujoco

    done = follow_mujoco.run(1.0, headless=True)
    assert done.touches == 0
    assert done.unproven == 0
    assert 0.0 < done.largest_error < 0.02
