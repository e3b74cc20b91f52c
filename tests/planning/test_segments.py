"""Targets one after the other, hands without a target, and hands that have to be turned."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import conftest
import numpy as np
import pinocchio as pin
import pytest
from conftest import ROOT, Plan

from humanoid_rail import (
    Box,
    HalfSpace,
    InvalidInput,
    Kinematics,
    Pose,
    Robot,
    Scene,
    Sphere,
    Status,
    load_robot_of_scene,
    load_scene,
    make_scene,
    retime,
    verify,
)
from humanoid_rail.io.export import export
from humanoid_rail.io.mujoco.player import track
from humanoid_rail.paper import dh_table as dh
from humanoid_rail.scene.obstacles import moved

BOTH = {"left": [-1.6, 0.6, 3.4], "right": [-1.6, 2.2, 3.4]}
SHELF = [
    {"type": "sphere", "center": [-1.0, 2.0, 2.6], "radius": 0.25},
    {"type": "box", "center": [-1.9, 1.4, 2.9], "size": [0.4, 3.0, 0.04]},
]
METHODS = ("auto", "qp", "gradient-projection")


def scene(targets: object, obstacles: object = SHELF) -> Scene:
    return make_scene({"name": "picks", "targets": targets, "obstacles": obstacles})


def rotation(robot: Robot, q: np.ndarray, hand: str) -> np.ndarray:
    """Return the orientation of a hand's frame by Pinocchio."""
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.full_configuration(q))
    return np.array(data.oMf[robot.model.getFrameId(f"{hand}_hand")].rotation)


@pytest.mark.parametrize("method", METHODS)
def test_targets_one_after_the_other(robot: Robot, method: str) -> None:
    steps: list[dict[str, Any]] = [
        BOTH,
        {"left": [-1.6, 1.6, 3.3], "right": None},
        {"left": None, "right": [-1.2, 3.4, 3.0]},
    ]
    asked = scene(steps)
    motion = conftest.plan(robot, asked, method)
    assert motion.status is Status.REACHED, motion.reason
    assert motion.reason.startswith("at the targets at t = ")
    assert len(motion.arrivals) == 3
    assert motion.arrivals[-1] == motion.duration
    for step, arrival in zip(steps, motion.arrivals, strict=True):
        hands = dh.hands(motion.configuration(arrival))
        for name, hand in zip(("left", "right"), hands, strict=True):
            if step[name] is not None:
                assert np.linalg.norm(hand - step[name]) <= 0.01 + 1e-9
    assert (np.diff(motion.t) > 0).all()
    assert motion.hands.shape == (len(motion.t), 2, 3)
    if method != "gradient-projection":
        assert motion.certified
        assert motion.limits_ok
        assert verify(robot, asked, motion) == motion.certificate


def test_one_step_in_a_list_is_the_same_as_without(robot: Robot) -> None:
    np.testing.assert_array_equal(conftest.plan(robot, scene(BOTH)).q, conftest.plan(robot, scene([BOTH])).q)


def test_a_hand_without_target_frees_the_other(robot: Robot, plan: Plan) -> None:
    """One hand alone gets by eq. 4.9 where the other could not follow."""
    alone = scene({"left": None, "right": [-1.2, 4.4, 3.0]}, [])
    motion = plan(robot, alone)
    assert motion.status is Status.REACHED
    np.testing.assert_allclose(dh.hands(motion.q[-1])[1], [-1.2, 4.4, 3.0], atol=0.01)
    start = dh.hands(robot.initial)[1]
    error = np.linalg.norm(start - [-1.2, 4.4, 3.0])
    assert motion.duration == pytest.approx(np.log(error / 0.01), rel=1e-3)  # of this hand's error alone
    assert motion.manipulability[0] == pytest.approx(2.0, abs=1e-9)  # of both arms, as ever


def test_a_gain_for_each_coordinate_goes_with_its_hand(robot: Robot, plan: Plan) -> None:
    alone = scene({"left": None, "right": [-1.2, 4.4, 3.0]}, [])
    motion = plan(robot, alone, gain=(1.0, 1.0, 1.0, 2.0, 2.0, 2.0))
    error = np.linalg.norm(dh.hands(robot.initial)[1] - [-1.2, 4.4, 3.0])
    assert motion.duration == pytest.approx(np.log(error / 0.01) / 2.0, rel=1e-3)
    assert motion.method.options()["gain"] == [1.0, 1.0, 1.0, 2.0, 2.0, 2.0]


def test_what_cannot_be_reached_ends_the_motion_where_it_got(robot: Robot) -> None:
    steps = [BOTH, {"left": [0.6, 0.0, 8.0], "right": None}, BOTH]
    motion = conftest.plan(robot, scene(steps))
    assert motion.status is Status.TARGET_OUT_OF_REACH
    assert motion.reason.startswith("step 2 of 3, begun at t = ")
    assert len(motion.arrivals) == 1
    np.testing.assert_allclose(dh.hands(motion.configuration(motion.arrivals[0])), list(BOTH.values()), atol=0.01)
    assert motion.certified


@pytest.mark.parametrize("method", ["auto", "qp"])
def test_times_in_reasons_count_from_the_start_of_the_motion(robot: Robot, method: str) -> None:
    motion = conftest.plan(robot, scene([BOTH, {"left": [0.6, 0.0, 8.0], "right": None}]), method)
    assert motion.status is not Status.REACHED
    begun, end = re.findall(r"\bt = ([\d.]+) s", motion.reason)
    assert float(begun) == pytest.approx(motion.arrivals[0], rel=1e-3)
    assert float(end) == pytest.approx(motion.duration, rel=1e-3)


def test_what_runs_into_the_robot_does_so_at_a_time_of_the_whole_motion(robot: Robot) -> None:
    first = conftest.plan(robot, scene([BOTH], []), "qp").duration
    x, y, z = BOTH["left"]
    # It comes from the left, faster than any evasion, and is there three seconds after the first targets.
    ball = {"type": "sphere", "center": [x, y - 8.0 * (first + 3.0), z], "radius": 0.6, "velocity": [0.0, 8.0, 0.0]}
    motion = conftest.plan(robot, scene([BOTH, {"left": [-1.6, 0.6, 2.2], "right": None}], [ball]), "qp")
    assert motion.status is Status.OVERRUN
    times = [float(t) for t in re.findall(r"\bt = ([\d.]+) s", motion.reason)]
    assert len(times) == 3
    assert times[0] == pytest.approx(motion.arrivals[0], rel=1e-3)
    assert times[1:] == pytest.approx(2 * [motion.duration], abs=0.05)


def test_the_longest_motion_is_that_of_all_legs(robot: Robot) -> None:
    whole = conftest.plan(robot, scene([BOTH, {"left": None, "right": [-1.2, 4.4, 3.0]}]), "qp")
    assert whole.status is Status.REACHED
    for longest in (whole.arrivals[0] + 1.0, whole.arrivals[0] - 1.0):
        cut = conftest.plan(robot, scene([BOTH, {"left": None, "right": [-1.2, 4.4, 3.0]}]), "qp", max_time=longest)
        assert cut.status is Status.TIME_LIMIT
        assert cut.duration <= longest + 1e-9


@pytest.mark.parametrize("approach", [(-1.0, 0.0, 0.0), (-2.0, 0.0, -1.0)])
def test_a_hand_points_where_it_is_asked_to(robot: Robot, approach: tuple[float, float, float]) -> None:
    pose = {"position": [-1.6, 2.2, 3.4], "approach": list(approach)}
    asked = scene({"left": BOTH["left"], "right": pose})
    motion = conftest.plan(robot, asked)
    assert motion.status is Status.REACHED, motion.reason
    assert motion.certified
    np.testing.assert_allclose(dh.hands(motion.q[-1]), [BOTH["left"], [-1.6, 2.2, 3.4]], atol=1e-6)
    pointing = rotation(robot, motion.q[-1], "right")[:, 0]
    np.testing.assert_allclose(pointing, np.array(approach) / np.linalg.norm(approach), atol=1e-6)


def test_a_hand_is_turned_as_it_is_asked_to(robot: Robot) -> None:
    rpy = (0.0, 0.0, 3.14)
    asked = scene({"left": {"position": BOTH["left"], "rpy": list(rpy)}, "right": None})
    motion = conftest.plan(robot, asked)
    assert motion.status is Status.REACHED, motion.reason
    assert motion.certified
    np.testing.assert_allclose(rotation(robot, motion.q[-1], "left"), pin.rpy.rpyToMatrix(*rpy), atol=1e-6)
    np.testing.assert_allclose(dh.hands(motion.q[-1])[0], BOTH["left"], atol=1e-6)


def test_a_hand_is_turned_while_the_other_is_free(robot: Robot) -> None:
    asked = scene({"left": {"position": BOTH["left"], "approach": [-1, 0, 0]}, "right": None}, [])
    motion = conftest.plan(robot, asked)
    assert motion.status is Status.REACHED
    np.testing.assert_allclose(rotation(robot, motion.q[-1], "left")[:, 0], [-1, 0, 0], atol=1e-6)


def test_a_round_of_kitting(tmp_path: Path) -> None:
    """The example: into the bays of a shelf, into a tray from above, certified, and followed by MuJoCo's robot."""
    asked = load_scene(ROOT / "scenes" / "picks.yaml")
    robot = load_robot_of_scene(asked)
    lengths = dh.Lengths(0.7, 0.3, 0.3, 0.22, 0.45, 0.45, 0.22, 0.45, 0.45, np.pi / 2)
    # At full speed MuJoCo's drives are off by more than the safety distance.
    motion = retime(conftest.plan(robot, asked), robot, asked, dwell=0.2, speed=0.7)
    assert motion.status is Status.REACHED, motion.reason
    assert motion.certified
    assert motion.limits_ok
    for step, arrival in zip(asked.steps, motion.arrivals, strict=True):
        q = motion.configuration(arrival)
        for hand, there in zip(("left", "right"), dh.hands(q, lengths), strict=True):
            if (target := step[hand]) is not None:
                np.testing.assert_allclose(there, target.position if isinstance(target, Pose) else target, atol=1e-6)
            if isinstance(target, Pose):
                np.testing.assert_allclose(rotation(robot, q, hand)[:, 0], target.approach, atol=1e-6)
    export(motion, robot, asked, "mujoco", tmp_path / "mujoco")
    followed = track(tmp_path / "mujoco")
    assert followed.largest_hand_error < 0.02
    assert followed.final_hand_error < 0.01
    assert not followed.contacts


def test_another_direction_can_be_the_one_a_hand_points_in(robot: Robot) -> None:
    left, right = robot.hands
    sideways = replace(robot, hands=(replace(left, pointing=(0.0, -2.0, 0.0)), right))
    asked = scene({"left": {"position": BOTH["left"], "approach": [0, -1, 0]}, "right": None}, [])
    motion = conftest.plan(sideways, asked)
    assert motion.status is Status.REACHED
    np.testing.assert_allclose(rotation(robot, motion.q[-1], "left")[:, 1], [0, 1, 0], atol=1e-6)


def test_how_a_hand_cannot_be_turned_is_said(robot: Robot) -> None:
    """High above, at the end of its reach, a hand can point upwards but not down."""
    pose = {"position": [0.3, 0.6, 5.4], "approach": [0, 0, -1]}
    motion = conftest.plan(robot, scene({"left": pose, "right": None}))
    assert motion.status is Status.TARGET_OUT_OF_REACH
    assert "left hand is" in motion.reason
    assert "deg from how it has to be turned" in motion.reason
    assert motion.arrivals == ()


def test_hands_that_can_be_turned_are_not_said_to_be_unable(robot: Robot, rng: np.random.Generator) -> None:
    """Targets are the hands of random configurations, both turned."""
    kinematics, reached = Kinematics(robot), 0
    for _ in range(60):
        q = rng.uniform(robot.lower, robot.upper)
        if kinematics.measure(q).self_clearance.min() < 0.05:
            continue
        poses = {
            name: {"position": list(hand), "rpy": list(pin.rpy.matrixToRpy(rotation(robot, q, name)))}
            for name, hand in zip(robot.hand_names, dh.hands(q), strict=True)
        }
        motion = conftest.plan(robot, scene(poses, []))
        assert motion.status in (Status.REACHED, Status.STUCK), motion.reason
        reached += motion.status is Status.REACHED
    assert reached >= 25


@pytest.mark.parametrize("z", [5.47, 5.475, 5.48])
def test_what_a_hand_lacks_by_little_is_said_too(robot: Robot, z: float) -> None:
    """At its highest the left hand points upwards or nearly so; that it does not quite is no matter of the search."""
    pose = {"position": [0.1, -1.0, z], "approach": [0, 0, 1]}
    motion = conftest.plan(robot, scene({"left": pose, "right": None}, []))
    assert motion.status is Status.TARGET_OUT_OF_REACH
    assert "deg from how it has to be turned" in motion.reason


@pytest.mark.parametrize("method", ["qp", "gradient-projection"])
def test_other_methods_turn_no_hands(robot: Robot, method: str) -> None:
    pose = {"position": BOTH["left"], "approach": [-1, 0, 0]}
    with pytest.raises(InvalidInput, match="only auto turns hands") as caught:
        conftest.plan(robot, scene({"left": pose, "right": None}), method)
    assert caught.value.field == "targets.left"


def test_nothing_turns_hands_among_obstacles_that_move(robot: Robot) -> None:
    ball = {"type": "sphere", "center": [-1.0, 2.0, 1.0], "radius": 0.1, "velocity": [0.0, 0.1, 0.0]}
    pose = {"position": BOTH["left"], "approach": [-1, 0, 0]}
    with pytest.raises(InvalidInput, match="obstacles at rest"):
        conftest.plan(robot, scene({"left": pose, "right": None}, [ball]))


def test_obstacles_go_on_moving_from_leg_to_leg(robot: Robot) -> None:
    """The second leg meets a sphere where it has got to by then, and the whole motion is certified with it."""
    ball = {"type": "sphere", "center": [-1.0, 1.4, 0.2], "radius": 0.2, "velocity": [0.0, 0.0, 0.15]}
    asked = scene([BOTH, {"left": [-1.6, 1.0, 3.3], "right": [-1.6, 2.6, 3.3]}], [ball])
    motion = conftest.plan(robot, asked, "qp")
    assert motion.status is Status.REACHED, motion.reason
    assert motion.certified
    assert verify(robot, asked, motion).certified


@pytest.mark.parametrize(
    "obstacle",
    [
        Sphere(center=(-1.0, 2.0, 2.0), radius=0.2, velocity=(0.1, -0.2, 0.3)),
        Box(center=(-1.0, 2.0, 2.0), size=(0.2, 0.3, 0.4), rpy=(0.1, 0.2, 0.3), velocity=(0.1, -0.2, 0.3)),
        HalfSpace(normal=(0.0, 1.0, 2.0), offset=-3.0, velocity=(0.1, -0.2, 0.3)),
    ],
    ids=lambda obstacle: obstacle.type,
)
def test_where_an_obstacle_has_moved_to(robot: Robot, obstacle: Any) -> None:
    later = Kinematics(robot, (obstacle,)).measure(robot.initial, t=2.5).clearance
    there = Kinematics(robot, (moved(obstacle, 2.5),)).measure(robot.initial).clearance
    np.testing.assert_allclose(later, there, atol=1e-9)


@pytest.mark.parametrize(
    ("targets", "field"),
    [
        ({"left": None, "right": None}, "targets"),
        ([BOTH, {"left": None, "right": None}], "targets[1]"),
        ([BOTH, {"left": [0.0, 0.0, 3.0]}], "targets[1].right"),
        ([{**BOTH, "middle": None}], "targets[0].middle"),
    ],
)
def test_targets_that_are_not_for_this_robot(robot: Robot, targets: object, field: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        conftest.plan(robot, scene(targets))
    assert caught.value.field == field
