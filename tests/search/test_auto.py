"""`method="auto"`: a plan whenever there is one, and the right reason where there is none."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, plan, plan_many

from humanoid_rail import (
    Box,
    GradientProjection,
    InvalidInput,
    Robot,
    SafeVelocity,
    Scene,
    Sphere,
    Status,
    load_robot,
    load_scene,
    paper_scene,
    plan_case,
    read_trajectory,
    verify,
    write_trajectory,
)
from humanoid_rail.search.smoothing import MAX_TURN

DEV = ROOT / "scenes" / "dev"
UNSOLVABLE = sorted((ROOT / "scenes" / "unsolvable").iterdir())
SOME = sorted(DEV.glob("sparse-*"))[::4] + sorted(DEV.glob("dense-*"))[::3] + sorted(DEV.glob("shelf-*"))[::2]
DEEP = sorted(DEV.glob("deep-*"))[::2]
BUDGET = 2000
"""Edge checks for scenes that cannot be solved."""


@pytest.mark.parametrize("file", [*SOME, *DEEP], ids=lambda file: file.stem)
def test_scenes_are_solved(robot: Robot, file: Path) -> None:
    scene = load_scene(file)
    trajectory = plan(robot, scene)
    assert trajectory.status is Status.REACHED, trajectory.reason
    assert trajectory.found_by in {"qp", "straight line", "rrt-connect"}
    assert verify(robot, scene, trajectory).certified
    assert trajectory.limits_ok
    assert trajectory.certificate.clearance_bound is not None
    assert trajectory.certificate.clearance_bound > 0.01 - 1.1e-3
    np.testing.assert_allclose(trajectory.hands[-1], [scene.targets[name] for name in robot.hand_names], atol=0.01)
    assert trajectory.path.sharpest_turn <= MAX_TURN
    assert trajectory.search is not None
    if trajectory.found_by == "rrt-connect":
        assert trajectory.search.raw is not None
        assert trajectory.path.length < trajectory.search.raw.length
    by_qp = plan(robot, scene, "qp")
    if by_qp.status is Status.REACHED:
        assert trajectory.path.length <= 1.01 * by_qp.path.length


@pytest.mark.parametrize("file", UNSOLVABLE, ids=lambda file: file.stem)
def test_what_cannot_be_solved_says_why(robot: Robot, file: Path) -> None:
    scene = load_scene(file)
    trajectory = plan(robot, scene, max_edge_checks=BUDGET)
    assert trajectory.status == file.stem.rsplit("-", 1)[0], trajectory.reason
    assert trajectory.search.checks <= BUDGET + 1
    assert trajectory.found_by == ""
    assert trajectory.certified
    assert trajectory.certificate == verify(robot, scene, trajectory)
    assert trajectory.limits_ok


def test_there_are_twenty_of_them() -> None:
    assert len(UNSOLVABLE) >= 20


def test_reasons_name_hands_and_distances(robot: Robot) -> None:
    far = Scene(name="far", targets={"left": (0.3, -1.2, 7.0), "right": (0.6, 1.8, 2.6)})
    assert "the target of the left hand is 1.5" in plan(robot, far).reason
    inside = Scene(
        name="inside",
        targets={"left": (0.6, -1.8, 2.6), "right": (0.6, 1.8, 2.6)},
        obstacles=(Sphere(center=(0.6, 1.8, 2.6), radius=0.1),),
    )
    assert "the right hand at its target would be 0.15 m inside obstacles[0] (sphere)" in plan(robot, inside).reason


@pytest.mark.parametrize("name", ["shelf-900013", "deep-500004", "dense-240000"])
def test_the_same_seed_gives_the_same_plan(robot: Robot, name: str) -> None:
    scene = load_scene(DEV / f"{name}.json")
    one, two, other = plan(robot, scene, seed=7), plan(robot, scene, seed=7), plan(robot, scene, seed=8)
    np.testing.assert_array_equal(one.t, two.t)
    np.testing.assert_array_equal(one.q, two.q)
    assert one.search == two.search
    assert not np.array_equal(one.q, other.q)


def test_the_same_plan_beside_others(robot: Robot) -> None:
    scenes = [load_scene(file) for file in [*DEEP[:3], *SOME[:3]]]
    for scene, trajectory in zip(scenes, plan_many(robot, scenes, n_jobs=2, progress=False), strict=True):
        assert not isinstance(trajectory, Exception)
        np.testing.assert_array_equal(trajectory.q, plan(robot, scene).q)


def test_where_there_is_nothing_in_the_way_the_way_is_straight(robot: Robot) -> None:
    scene = paper_scene().model_copy(update={"obstacles": ()})
    trajectory = plan(robot, scene, optimise=False)
    assert trajectory.found_by == "straight line"
    assert trajectory.path.sharpest_turn < 1e-6
    assert trajectory.duration == pytest.approx((abs(trajectory.q[-1] - trajectory.q[0]) / robot.velocity_limit).max())
    bare = replace(robot, self_collision_pairs=())
    assert plan(bare, scene).certificate.clearance_bound is None


def test_hands_that_are_there_stay(robot: Robot) -> None:
    start = plan_case(robot, 1, dt=0.5)
    targets = dict(zip(robot.hand_names, map(tuple, start.hands[0].tolist()), strict=True))
    trajectory = plan(robot, Scene(name="there", targets=targets))
    assert (trajectory.status, trajectory.duration, trajectory.path.length) == (Status.REACHED, 0.0, 0.0)


def test_a_start_too_near_to_something_is_led_away(robot: Robot) -> None:
    """A board 4 mm from the left forearm: nearer than the safety distance, and behind it the way is free."""
    scene = paper_scene().model_copy(update={"obstacles": ()})
    hand = plan_case(robot, 1, dt=0.5).hands[0, 0]
    board = Box(center=(hand[0], hand[1], hand[2] - 0.05 - 0.004 - 0.02), size=(0.6, 0.6, 0.04))
    trajectory = plan(robot, scene.model_copy(update={"obstacles": (board,)}))
    assert trajectory.status is Status.REACHED, trajectory.reason
    assert trajectory.certified
    clearance = trajectory.clearance.min(axis=1)
    assert clearance[0] == pytest.approx(0.004, abs=1e-6)
    assert clearance.min() >= 0.004 - 1e-6
    assert clearance[np.argmax(clearance > 0.01) :].min() >= 0.01 - 1e-4


def test_a_motion_that_would_take_too_long(robot: Robot) -> None:
    scene = load_scene(DEV / "shelf-900000.json")
    whole = plan(robot, scene, optimise=False)
    trajectory = plan(robot, scene, max_time=0.2)
    assert trajectory.status is Status.TIME_LIMIT
    assert f"takes {whole.duration:.4g} s" in trajectory.reason
    assert trajectory.certified
    assert trajectory.duration <= 0.2


def test_obstacles_that_move_are_left_to_qp(robot: Robot) -> None:
    scene = paper_scene()
    moving = scene.model_copy(
        update={"obstacles": (*scene.obstacles, Sphere(center=(3.0, 0.0, 3.0), radius=0.2, velocity=(-0.1, 0.0, 0.0)))}
    )
    trajectory, by_qp = plan(robot, moving), plan(robot, moving, "qp")
    np.testing.assert_array_equal(trajectory.q, by_qp.q)
    assert (trajectory.found_by, trajectory.method.name, trajectory.search) == ("qp", "auto", None)


@pytest.mark.parametrize("dt", [1e-3, 0.05, 0.2, 1.0])
@pytest.mark.parametrize("name", ["deep-500009", "shelf-900019", "dense-240000"])
def test_samples_far_apart_keep_to_the_way(robot: Robot, name: str, dt: float) -> None:
    trajectory = plan(robot, load_scene(DEV / f"{name}.json"), dt=dt, optimise=False)
    assert trajectory.status is Status.REACHED, trajectory.reason
    assert trajectory.certificate.clearance_bound is not None
    assert trajectory.certificate.clearance_bound > 0.01 - 1.1e-3
    assert trajectory.path.sharpest_turn <= MAX_TURN
    assert trajectory.limits_ok


@pytest.mark.parametrize("gap", [0.012, 0.011, 0.0105, 0.004])
def test_where_qp_arrives_this_does_too(robot: Robot, gap: float) -> None:
    """A board below the left target leaves the forearm little more than the safety distance, or a little less."""
    left = (0.6, -1.8, 2.6)
    board = Box(center=(left[0], left[1], left[2] - 0.05 - gap - 0.01), size=(0.3, 0.3, 0.02))
    scene = Scene(name="tight", targets={"left": left, "right": (0.6, 1.8, 2.6)}, obstacles=(board,))
    assert plan(robot, scene, "qp").status is Status.REACHED
    trajectory = plan(robot, scene)
    assert trajectory.status is Status.REACHED, trajectory.reason
    assert trajectory.certified


@pytest.mark.parametrize("speed", [0.0, 0.3, 3.1, np.inf])
def test_other_speed_limits(robot: Robot, speed: float) -> None:
    """Of a joint that begins at its limit."""
    limits = robot.velocity_limit.copy()
    limits[3] = speed
    other = replace(robot, velocity_limit=limits, lower=np.where(np.arange(robot.n) == 3, robot.initial, robot.lower))
    trajectory = plan(other, paper_scene())
    assert trajectory.status is Status.REACHED, trajectory.reason
    assert trajectory.limits_ok
    if speed == 0.0:
        np.testing.assert_array_equal(trajectory.q[:, 3], robot.initial[3])


def test_a_joint_that_cannot_move_at_all(robot: Robot) -> None:
    locked = replace(
        robot,
        lower=np.where(np.arange(robot.n) == 5, robot.initial, robot.lower),
        upper=np.where(np.arange(robot.n) == 5, robot.initial, robot.upper),
    )
    far = Scene(name="far", targets={"left": (0.3, -1.2, 7.0), "right": (0.6, 1.8, 2.6)})
    assert plan(locked, far).status is Status.TARGET_OUT_OF_REACH
    assert plan(locked, load_scene(DEV / "shelf-900005.json")).status is Status.REACHED


@pytest.mark.parametrize("budget", [0.001, 0.01, 0.03])
def test_no_false_reason_where_time_is_short(robot: Robot, budget: float) -> None:
    far = Scene(name="far", targets={"left": (0.3, -1.2, 7.0), "right": (0.6, 1.8, 2.6)})
    trajectory = plan(robot, far, max_planning_time=budget)
    assert trajectory.status in {Status.PLANNING_TIMEOUT, Status.TARGET_OUT_OF_REACH}
    assert "not both" not in trajectory.reason


def test_plans_in_threads_are_those_of_one_thread(robot: Robot) -> None:
    scenes = [load_scene(file) for file in DEEP[:8]]
    with ThreadPoolExecutor(8) as threads:
        plans = list(threads.map(lambda scene: plan(robot, scene), scenes))
    for scene, found in zip(scenes, plans, strict=True):
        np.testing.assert_array_equal(found.q, plan(robot, scene).q)


def test_a_plan_that_is_cut_off_says_so(robot: Robot) -> None:
    trajectory = plan(robot, load_scene(DEEP[0]), max_planning_time=1e-9)
    assert trajectory.status is Status.PLANNING_TIMEOUT
    assert "cut off by max_planning_time" in trajectory.reason
    assert trajectory.certified


def test_the_budget_decides_and_not_the_time(robot: Robot) -> None:
    """A scene that has no path ends after the same number of checks, however long they take."""
    scene = load_scene(next(file for file in UNSOLVABLE if file.stem == "stuck-1"))
    one, two = (plan(robot, scene, max_edge_checks=1000) for _ in range(2))
    assert one.status is Status.STUCK
    assert one.search == two.search
    assert one.search is not None
    assert 1000 <= one.search.checks <= 1001
    assert "1000 edges" in one.reason
    np.testing.assert_array_equal(one.q, two.q)


@pytest.mark.parametrize(
    ("argument", "valid"),
    [
        ({"seed": -1}, "0 to 2"),
        ({"seed": 0.5}, "whole"),
        ({"seed": True}, "whole"),
        ({"max_planning_time": 0}, "great"),
        ({"max_edge_checks": 0}, "whole"),
    ],
)
def test_bad_arguments(robot: Robot, argument: dict[str, float], valid: str) -> None:
    with pytest.raises(InvalidInput, match=f"{next(iter(argument))} is .*{valid}"):
        plan(robot, paper_scene(), **argument)  # type: ignore[arg-type]


@pytest.mark.parametrize("option", ["seed", "max_planning_time", "max_edge_checks"])
def test_options_of_auto_alone(option: str) -> None:
    for method in (SafeVelocity, GradientProjection):
        with pytest.raises(InvalidInput, match=f"{option} is 1"):
            method(**{option: 1})


def test_a_plan_is_read_as_it_was_written(robot: Robot, tmp_path: Path) -> None:
    trajectory = plan(robot, load_scene(DEEP[1]), seed=np.int64(3))  # type: ignore[arg-type]
    write_trajectory(trajectory, tmp_path)
    again = read_trajectory(tmp_path)
    assert again.search is not None
    assert (again.found_by, again.path, again.search) == (trajectory.found_by, trajectory.path, trajectory.search)


def test_other_lengths_of_links() -> None:
    thin = load_robot(link_radius=0.0)
    assert plan(thin, load_scene(DEEP[2])).status is Status.REACHED
