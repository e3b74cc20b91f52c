"""Why plans fail: what blocks is what the scene's own description says, and what is said to help does."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from conftest import AHEAD, ROOT, PythonKinematics

from humanoid_rail import (
    Auto,
    Box,
    ConfigurationTask,
    Diagnosis,
    GradientProjection,
    PointTask,
    Problem,
    RelativeTask,
    Remedy,
    Robot,
    SafeVelocity,
    Scene,
    Sphere,
    Task,
    Trajectory,
    load_robot,
    load_scene,
    make_scene,
    plan,
    read_trajectory,
    retime,
    solve,
    write_trajectory,
)

FOLDER = ROOT / "scenes" / "unsolvable"
BUDGET = 600
"""Edge checks for scenes that cannot be solved."""
BLOCKED = {
    "stuck-1": ("wall",),
    "stuck-2": ("wall",),
    "stuck-3": ("board",),
    "stuck-4": ("doors",),
    "stuck-5": ("front above the slit", "front below the slit"),
    "stuck-6": ("cage, right side",),
    "stuck-7": ("ball in row 1", "ball in row 2", "ball in row 3", "ball in row 4", "ball in row 5"),
    "target_in_collision-1": ("ball",),
    "target_in_collision-2": ("turned box",),
    "target_in_collision-3": ("pipe",),
    "target_in_collision-4": ("wall",),
    "target_in_collision-5": ("crate",),
    "target_in_collision-6": ("board",),
    "target_in_collision-7": ("left_forearm", "right_forearm"),
}
"""What each scene's description says is in the way."""
AWAY = {
    "target_in_collision-1": {"left"},
    "target_in_collision-2": {"right"},
    "target_in_collision-3": {"left", "right"},
    "target_in_collision-4": {"left"},
    "target_in_collision-5": {"right"},
    "target_in_collision-6": {"left"},
    "target_out_of_reach-1": {"left"},
    "target_out_of_reach-2": {"right"},
    "target_out_of_reach-3": {"left", "right"},
    "target_out_of_reach-5": {"left"},
    "target_out_of_reach-6": {"right"},
    "stuck-4": {"left"},
    "stuck-5": {"right"},
}
"""The hands whose targets each description says cannot be reached."""


@cache
def planned(name: str) -> Trajectory:
    return plan(load_robot(), load_scene(FOLDER / f"{name}.yaml"), Auto(max_edge_checks=BUDGET))


def diagnosis_of(name: str) -> Diagnosis:
    found = planned(name).diagnosis
    assert found is not None
    return found


@pytest.mark.parametrize("name", sorted(path.stem for path in FOLDER.iterdir()))
def test_every_unsolvable_scene_gets_its_reason(robot: Robot, name: str) -> None:
    scene, trajectory, found = load_scene(FOLDER / f"{name}.yaml"), planned(name), diagnosis_of(name)
    assert trajectory.diagnosis == found
    assert "nearest miss" in trajectory.reason
    assert "\n" not in trajectory.reason
    if name in BLOCKED:
        worst = found.blocking[0]
        assert any(word in worst.other for word in BLOCKED[name])
        assert worst.other in trajectory.reason
        assert worst.beyond < 0.01
    else:
        assert found.limits
        assert found.limits[0] in trajectory.reason
    if name in AWAY:
        assert {miss.hand for miss in found.misses if miss.distance > 1e-3} == AWAY[name]
    assert found.remedies
    # The Python reference judges the nearest miss.
    q = np.array(found.q)
    assert ((q >= robot.lower - 1e-9) & (q <= robot.upper + 1e-9)).all()
    there = PythonKinematics(robot, scene.obstacles).measure(q)
    for miss in found.misses:
        np.testing.assert_allclose(there.hands[robot.hand(miss.hand)], miss.position, atol=1e-9)
        np.testing.assert_allclose(scene.targets[miss.hand], miss.target)
    if found.found_by != "reach":
        assert min(there.clearance.min(initial=np.inf), there.self_clearance.min()) > 0.01 - 1e-4
    for pair in found.blocking:
        if pair.obstacle is not None:
            link = robot.link_names.index(pair.link)
            assert there.clearance[link, pair.obstacle] == pytest.approx(pair.clearance, abs=1e-6)


def changed(robot: Robot, scene: Scene, remedy: Remedy) -> tuple[Robot, Scene, Auto]:
    """Return what a remedy says."""
    option = {} if remedy.option is None else {remedy.option[0]: remedy.option[1]}
    if remedy.limit is not None:
        joint, side, value = remedy.limit
        robot = load_robot(**{f"{joint}_{side}": value})
    targets = {**scene.targets, **dict(remedy.targets)}
    rest = tuple(obstacle for i, obstacle in enumerate(scene.obstacles) if i not in remedy.without)
    return robot, scene.model_copy(update={"targets": targets, "obstacles": rest}), Auto(**option)


@pytest.mark.parametrize("name", ["stuck-3", "stuck-6", "target_in_collision-7", "target_out_of_reach-3"])
def test_what_is_said_to_help_does(robot: Robot, name: str) -> None:
    scene = load_scene(FOLDER / f"{name}.yaml")
    remedies = [one for one in diagnosis_of(name).remedies if one.targets or one.limit or one.without]
    assert remedies
    for remedy in remedies:
        assert remedy.proven == "planned"
        trajectory = plan(*changed(robot, scene, remedy))
        assert (trajectory.status, trajectory.certified) == ("reached", True), remedy.what


def test_targets_that_are_too_far_apart_are_reached_one_after_the_other(robot: Robot) -> None:
    scene = load_scene(FOLDER / "target_out_of_reach-4.yaml")
    assert any("one after the other" in remedy.what for remedy in diagnosis_of("target_out_of_reach-4").remedies)
    steps = [{hand: at if hand == one else None for hand, at in scene.targets.items()} for one in scene.targets]
    assert plan(robot, scene.model_copy(update={"targets": steps})).status == "reached"


def test_shifts_are_no_longer_than_they_have_to_be() -> None:
    """The formula of the distance: the left forearm of radius 50 mm is to keep 10.8 mm from the board's face."""
    shift = diagnosis_of("target_in_collision-6").misses[0].distance
    assert shift == pytest.approx(0.05 + 0.01 + 0.0008 - 0.045, abs=0.003)
    ball = diagnosis_of("target_in_collision-1").misses[0].distance
    assert ball == pytest.approx(0.3 + 0.05 + 0.0108, abs=0.006)


def near_a_board(gap: float) -> Scene:
    """Return a scene in which the left forearm at its target is this far from a board, or a little farther, m."""
    x, y, z = 0.6, -1.8, 2.6
    board = Box(name="board", center=(x + 0.05 + gap + 0.02, y, z), size=(0.04, 0.6, 0.6))
    return Scene(name="near", targets={"left": (x, y, z), "right": None}, obstacles=(board,))


def test_a_smaller_safety_distance_that_is_enough_is_named(robot: Robot) -> None:
    scene = near_a_board(0.03)
    trajectory = plan(robot, scene, Auto(safety_distance=0.05))
    assert trajectory.status == "target_in_collision"
    remedy = next(one for one in trajectory.diagnosis.remedies if one.option is not None)
    assert remedy.option == ("safety_distance", 0.025)
    assert plan(*changed(robot, scene, remedy)).status == "reached"
    assert not any(one.option for one in plan(robot, near_a_board(-0.01)).diagnosis.remedies)


def test_auto_is_named_where_the_local_method_gets_stuck(robot: Robot) -> None:
    for file in sorted((ROOT / "scenes" / "dev").glob("shelf-*")):
        scene = load_scene(file)
        trajectory = plan(robot, scene, SafeVelocity())
        if trajectory.status != "reached":
            break
    assert trajectory.diagnosis.found_by == "motion"
    assert trajectory.diagnosis.q == tuple(trajectory.q[-1])
    assert trajectory.diagnosis.blocking
    assert "plan with the method auto" in [remedy.what for remedy in trajectory.diagnosis.remedies]
    assert plan(robot, scene).status == "reached"


def test_more_edge_checks_are_named_where_they_are_enough(robot: Robot) -> None:
    scene = load_scene(ROOT / "scenes/dev/deep-500004.json")
    trajectory = plan(robot, scene, Auto(max_edge_checks=20))
    remedy = next(one for one in trajectory.diagnosis.remedies if one.option is not None)
    assert remedy.option[0] == "max_edge_checks"
    assert plan(robot, scene, Auto(max_edge_checks=int(remedy.option[1]))).status == "reached"


def test_hands_that_need_not_be_turned(robot: Robot) -> None:
    """A hand in reach that is to point where its forearm cannot."""
    scene = make_scene(
        {"name": "turn", "targets": {"left": {"position": [0.3, -1.2, 5.4], "approach": [0, 0, -1]}, "right": None}}
    )
    trajectory = plan(robot, scene)
    assert trajectory.status == "target_out_of_reach"
    assert any("leave open how the hands are turned" in one.what for one in trajectory.diagnosis.remedies)


def test_a_later_step_is_named(robot: Robot) -> None:
    ball = Sphere(name="ball", center=(0.6, -1.8, 2.6), radius=0.3)
    steps = [AHEAD, {"left": (0.6, -1.8, 2.6), "right": None}]
    trajectory = plan(robot, Scene(name="two", targets=steps, obstacles=(ball,)))
    assert trajectory.diagnosis.step == 1
    assert [miss.hand for miss in trajectory.diagnosis.misses] == ["left"]
    assert retime(trajectory).diagnosis == trajectory.diagnosis


@pytest.mark.parametrize(
    ("task", "said"),
    [
        (ConfigurationTask(("rail",), (12.0,)), "rail is at its upper limit of 9"),
        (RelativeTask("left", "right", (0.0, 9.0, 0.0)), "is at its lower limit"),
        (PointTask("left", (-1.6, 0.6, 30.0), (0.3, 0.0, 0.0)), "is at its"),
    ],
)
def test_hands_without_a_target_of_their_own_are_not_said_to_be_there(robot: Robot, task: Task, said: str) -> None:
    problem = Problem(robot=robot, scene=Scene(targets=AHEAD), tasks=(task,), start=robot.initial)
    for method in (Auto(max_edge_checks=BUDGET), SafeVelocity()):
        trajectory = solve(problem, method)
        assert trajectory.diagnosis is not None
        assert not trajectory.diagnosis.misses
        assert "at their targets" not in trajectory.reason
        assert "nearest miss: ;" not in trajectory.reason
        if isinstance(method, Auto):
            assert said in trajectory.diagnosis.miss


def test_the_same_plan_has_the_same_diagnosis() -> None:
    again = plan(load_robot(), load_scene(FOLDER / "stuck-7.yaml"), Auto(max_edge_checks=BUDGET))
    assert again.diagnosis == diagnosis_of("stuck-7")
    assert again.reason == planned("stuck-7").reason


def test_what_cannot_be_tried_out_is_not_said(robot: Robot) -> None:
    assert plan(robot, Scene(name="free", targets=AHEAD)).diagnosis is None
    cut = plan(robot, load_scene(FOLDER / "stuck-1.yaml"), Auto(max_planning_time=0.05)).diagnosis
    assert cut.remedies == ()
    ball = Sphere(center=(0.6, -1.8, 2.6), radius=0.3)
    moves = replace_velocity(ball, (0.0, 0.001, 0.0))
    scene = Scene(name="moving", targets={"left": (0.6, -1.8, 2.6), "right": None}, obstacles=(moves,))
    found = plan(robot, scene).diagnosis
    assert found.remedies == ()
    assert [pair.obstacle for pair in found.blocking] == [0]


def replace_velocity(ball: Sphere, velocity: tuple[float, float, float]) -> Sphere:
    return ball.model_copy(update={"velocity": velocity})


@pytest.mark.parametrize("name", ["stuck-4", "target_out_of_reach-3"])
def test_it_is_kept_in_files(tmp_path: Path, name: str) -> None:
    trajectory = planned(name)
    write_trajectory(trajectory, tmp_path)
    assert read_trajectory(tmp_path).diagnosis == trajectory.diagnosis
    reached = replace(trajectory, verdict=replace(trajectory.verdict, diagnosis=None))
    write_trajectory(reached, tmp_path)
    assert read_trajectory(tmp_path).diagnosis is None


def test_what_helps_a_method_without_a_safety_distance_is_tried_with_that_of_auto(robot: Robot) -> None:
    """A bead is 4 mm from the forearm's end at its target: `auto` would keep 10 mm, so it is not proposed."""
    scene = load_scene(ROOT / "scenes/dev/deep-500003.json")
    center = np.add(scene.targets["left"], (0.0, 0.0, 0.05 + 0.004 + 0.05))
    bead = Sphere(center=tuple(center.tolist()), radius=0.05, name="bead")
    near = scene.model_copy(update={"obstacles": (*scene.obstacles, bead)})
    trajectory = plan(robot, near, GradientProjection())
    assert plan(robot, near, Auto(max_edge_checks=BUDGET)).status != "reached"
    remedies = trajectory.diagnosis.remedies
    assert remedies[0].proven == "planned"
    assert trajectory.reason.endswith(f"{remedies[0].what} (auto finds a plan then)")
    assert not [one.what for one in remedies if "the method auto" in one.what or one.option]


def test_among_obstacles_that_move_it_is_said_that_nothing_is_tried_out(robot: Robot) -> None:
    at_the_hand = Sphere(center=AHEAD["left"], radius=0.3)
    far = Sphere(center=(-5.0, 0.0, 9.0), radius=0.1, velocity=(0.01, 0.0, 0.0))
    among, at_rest = (
        plan(robot, Scene(targets=AHEAD, obstacles=obstacles), SafeVelocity(max_time=3.0))
        for obstacles in ((at_the_hand, far), (at_the_hand,))
    )
    assert among.diagnosis is not None
    assert not among.diagnosis.remedies
    assert among.reason.endswith("; what would help is not looked for among obstacles that move")
    assert "not looked for" not in at_rest.reason
