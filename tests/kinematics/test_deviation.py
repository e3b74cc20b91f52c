"""How far motions leave constraints: bounds beside what is found between samples, on motions that keep nothing."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from conftest import random_q

from humanoid_rail import (
    AxisTask,
    ConfigurationTask,
    DirectionTask,
    DistanceTask,
    LineTask,
    OrientationTask,
    PointTask,
    RelativeTask,
    Robot,
    Task,
)
from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.deviation_bounds import RESOLUTION, deviations

T = 0.1


def placed(robot: Robot, q: Array, hand: str) -> pin.SE3:
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.full_configuration(q))
    return data.oMf[robot.model.getFrameId(f"{hand}_hand")].copy()


def angle(R: Array) -> float:
    return float(np.linalg.norm(pin.log3(R)))


def kept(robot: Robot, q: Array) -> dict[str, Task]:
    """Return constraints that hold at a configuration."""
    left, right = (placed(robot, q, hand) for hand in ("left", "right"))
    place, offset, turned = tuple(left.translation), (0.1, -0.2, 0.3), tuple(map(tuple, left.rotation.tolist()))
    between = left.actInv(right)
    relative = tuple(map(tuple, between.rotation.tolist()))
    apart = right.translation - left.translation
    return {
        "point": PointTask("left", place),
        "point with an offset": PointTask("left", tuple(left.act(np.array(offset))), offset),
        "line": LineTask("left", place, (1.0, 2.0, 3.0)),
        "difference": RelativeTask("left", "right", tuple(apart)),
        "place": RelativeTask("left", "right", tuple(between.translation), in_first=True),
        "distance": DistanceTask("left", "right", float(np.linalg.norm(apart))),
        "axis": AxisTask("left", tuple(left.rotation.T @ [0.0, 0.0, 1.0])),
        "direction": DirectionTask("left", tuple(left.rotation[:, 0]), (1.0, 0.0, 0.0)),
        "orientation": OrientationTask("left", turned),
        "relative orientation": OrientationTask("right", relative, "left"),
        "joint": ConfigurationTask(("rail",), (float(q[0]),)),
    }


def amount(robot: Robot, name: str, q: Array, start: Array) -> float:
    """Return by how much a constraint that holds at a start is left, in m or rad, by Pinocchio."""
    (l0, r0), (left, right) = ([placed(robot, x, hand) for hand in ("left", "right")] for x in (start, q))
    along = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
    offset = np.array([0.1, -0.2, 0.3])
    moved = left.translation - l0.translation
    lengths = [np.linalg.norm(b.translation - a.translation) for a, b in ((l0, r0), (left, right))]
    up = left.rotation @ l0.rotation.T @ [0.0, 0.0, 1.0]
    ahead = left.rotation[:, 0], l0.rotation[:, 0]
    found = {
        "point": np.linalg.norm(moved),
        "point with an offset": np.linalg.norm(left.act(offset) - l0.act(offset)),
        "line": np.linalg.norm(np.cross(moved, along)),
        "difference": np.linalg.norm(right.translation - r0.translation - moved),
        "place": np.linalg.norm(left.actInv(right).translation - l0.actInv(r0).translation),
        "distance": abs(lengths[1] - lengths[0]),
        "axis": np.arctan2(np.hypot(up[0], up[1]), up[2]),
        "direction": np.arctan2(np.linalg.norm(np.cross(*ahead)), ahead[0] @ ahead[1]),
        "orientation": angle(left.rotation @ l0.rotation.T),
        "relative orientation": angle(left.actInv(right).rotation @ l0.actInv(r0).rotation.T),
        "joint": abs(q[0] - start[0]),
    }
    return float(found[name])


def motion(robot: Robot, rng: np.random.Generator, spline: bool) -> tuple[Array, Array, Array | None]:
    t = np.array([0.0, T, 1.5 * T])
    q = random_q(robot, rng) + np.cumsum(rng.normal(scale=0.02, size=(3, robot.n)), axis=0)
    return t, q, rng.normal(scale=0.4, size=q.shape) if spline else None


def between(t: Array, q: Array, velocity: Array | None, count: int = 120) -> Array:
    """Return configurations of a motion, by the polynomials themselves."""
    found = []
    for k in range(len(t) - 1):
        h = t[k + 1] - t[k]
        for u in np.linspace(0.0, 1.0, count):
            if velocity is None:
                found.append((1.0 - u) * q[k] + u * q[k + 1])
                continue
            basis = 2 * u**3 - 3 * u**2 + 1, u**3 - 2 * u**2 + u, 3 * u**2 - 2 * u**3, u**3 - u**2
            parts = q[k], h * velocity[k], q[k + 1], h * velocity[k + 1]
            found.append(sum(w * part for w, part in zip(basis, parts, strict=True)))
    return np.array(found)


@pytest.mark.parametrize("spline", [False, True], ids=["linear", "spline"])
def test_no_motion_leaves_a_constraint_farther_than_its_bound_and_some_come_near_it(
    robot: Robot, rng: np.random.Generator, spline: bool
) -> None:
    for _ in range(4):
        t, q, velocity = motion(robot, rng, spline)
        tasks = kept(robot, q[0])
        found = deviations(robot, tuple(tasks.values()), t, q, velocity)
        there = between(t, q, velocity)
        for name, deviation in zip(tasks, found, strict=True):
            largest = max(amount(robot, name, x, q[0]) for x in there)
            assert largest <= deviation.bound + 1e-9, name
            assert deviation.bound <= 1.02 * largest + 2.0 * RESOLUTION, name


def test_the_time_of_a_deviation_is_about_when_it_is_largest(robot: Robot, rng: np.random.Generator) -> None:
    q = random_q(robot, rng)
    there = np.array([q, q + 0.01, q])
    (found,) = deviations(robot, (kept(robot, q)["point"],), np.array([0.0, 1.0, 3.0]), there)
    assert found.t == pytest.approx(1.0, abs=0.1)
    assert (found.begin, found.end, found.unit) == (0.0, 3.0, "m")


def test_a_motion_that_keeps_nothing_has_no_deviations(robot: Robot) -> None:
    assert deviations(robot, (), np.zeros(1), robot.initial[None, :]) == ()
