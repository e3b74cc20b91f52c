"""The command that plays two plans back at the same time."""

from __future__ import annotations

import signal
from dataclasses import replace
from pathlib import Path
from urllib.request import urlopen

import pytest
from running import Ran, assert_bad_input, started

from humanoid_rail import InvalidInput, Robot, Scene, load_robot, plan_case
from humanoid_rail.cli.compare import compare_html
from humanoid_rail.io.plan_folder import Plan, write_plan


@pytest.fixture(scope="module")
def folders(robot: Robot, scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    base = tmp_path_factory.mktemp("plans")
    thick = load_robot(link_radius=0.08)
    for name, own, case in (("one", robot, 3), ("two", robot, 1), ("thick", thick, 3)):
        write_plan(plan_case(own, case, dt=0.1), own, scene, base / name)
    return {path.name: path for path in base.iterdir()}


def test_compare_writes_one_page(folders: dict[str, Path], tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "new" / "both.html"
    ran = Ran(capfd, "compare", folders["one"], folders["two"], "-o", out)
    assert (ran.code, ran.err) == (0, "")
    assert ran.out == f"The page is {out}.\n"
    page = out.read_text(encoding="utf-8")
    assert "<h1>one</h1>" in page
    assert "<h1>two</h1>" in page
    assert page.count('"arrivals":') == 2
    assert "among other obstacles" not in page.partition('id="page-data"')[0]


def test_compare_serves_the_page_until_it_is_interrupted(folders: dict[str, Path], tmp_path: Path) -> None:
    process = started("compare", folders["one"], folders["one"], cwd=tmp_path)
    assert process.stdout is not None
    url = process.stdout.readline().removeprefix("Playing at ").partition(" ")[0]
    with urlopen(url) as answer:
        assert f"<h1>{folders['one']}</h1>" in answer.read().decode(), "folders of the same name are named in full"
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate()
    assert (process.returncode, errors) == (0, "")


def test_robots_with_other_hands_are_not_compared(robot: Robot, scene: Scene) -> None:
    trajectory = plan_case(robot, 3, dt=0.1)
    elsewhere = replace(robot, hands=tuple(replace(hand, frame="chest") for hand in robot.hands))
    with pytest.raises(InvalidInput, match="its hands"):
        compare_html(Plan(robot, scene, trajectory), Plan(elsewhere, scene, trajectory), ("one", "two"))


def test_a_plan_for_other_targets_says_so(robot: Robot, scene: Scene) -> None:
    (step,) = scene.steps
    other = scene.model_copy(update={"targets": (step, step)})
    trajectory = plan_case(robot, 3, dt=0.1)
    one = Plan(robot, scene, trajectory)
    assert "than those in the picture" not in compare_html(one, one, ("one", "two"))
    assert "planned for other targets than" in compare_html(one, Plan(robot, other, trajectory), ("one", "two"))
    bare = other.model_copy(update={"obstacles": ()})
    said = "planned among other obstacles and for other targets than"
    assert said in compare_html(one, Plan(robot, bare, replace(trajectory, scene=bare)), ("one", "two"))


def test_plans_of_different_robots_are_not_compared(
    folders: dict[str, Path], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    ran = Ran(capfd, "compare", folders["one"], folders["thick"], "-o", tmp_path / "both.html")
    assert_bad_input(ran, "robot is 'humanoid_rail'; valid: the robot of ")
    assert not (tmp_path / "both.html").exists()
    assert_bad_input(Ran(capfd, "compare", folders["one"], tmp_path, "--no-view"), "trajectory is ")
