"""The playback page, opened by a real browser, and what it says."""

from __future__ import annotations

import re
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from urllib.error import HTTPError, URLError
from urllib.request import urlopen

import numpy as np
import pinocchio as pin
import pytest
from conftest import ROOT, changed, plan
from pages import drawn, needs_browser, page_data, pixels, share
from screenshot import opened, seek

from humanoid_rail import (
    Box,
    Capsule,
    HalfSpace,
    HumanoidRailError,
    InvalidInput,
    Mesh,
    Robot,
    Scene,
    Sphere,
    Trajectory,
    load_scene,
    paper_scene,
    plan_case,
    read_plan,
    view,
    write_plan,
)
from humanoid_rail.viewer import server
from humanoid_rail.viewer.camera import viewpoint
from humanoid_rail.viewer.playback import playback_html, show
from humanoid_rail.viewer.server import served


@needs_browser
def test_the_page_shows_the_robot_moving(robot: Robot, scene: Scene, tmp_path: Path) -> None:
    trajectory = plan_case(robot, 3)
    (tmp_path / "playback.html").write_text(playback_html(robot, scene, trajectory), encoding="utf-8")
    with opened(tmp_path / "playback.html") as (page, troubles):
        running = pixels(page)
        page.wait_for_timeout(1000)
        later = pixels(page)
        stills = {}
        for t in (0.0, 2.0, trajectory.duration):
            seek(page, t)
            stills[t] = pixels(page)
        joints = {
            name: page.evaluate(
                """name => {
                    const find = path => viewer.scene_tree.find(path).object;
                    const world = find(["meshcat", "world"]);
                    const node = find(["meshcat", "world", "motion0", "robot", name]);
                    viewer.scene.updateMatrixWorld(true);
                    return world.matrixWorld.clone().invert().multiply(node.matrixWorld).elements;
                }""",
                name,
            )
            for name in [*robot.model.names][1:]
        }
        hidden = page.evaluate(
            """() => viewer.scene_tree.find(["meshcat", "world", "motion0", "bodies"]).object.visible === false"""
        )
        assert hidden
        assert "certified free of contact" in page.inner_text("body")
        assert "paper" in page.title()
        assert not troubles
    assert (abs(running - later).max(axis=2) > 30).mean() > 1e-3, "the animation does not run"
    first, middle, last = stills.values()
    assert (abs(first - middle).max(axis=2) > 30).mean() > 5e-3
    assert (abs(middle - last).max(axis=2) > 30).mean() > 1e-3
    for image in stills.values():
        assert share(image, (45, 120, 210), 60) > 3e-4, "no blue arm"
        assert share(image, (240, 120, 40), 60) > 3e-4, "no orange arm"
        assert share(image, (165, 182, 198), 30) > 1e-3, "no obstacles"
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.full_configuration(trajectory.q[-1]))
    for name, elements in joints.items():
        shown = np.array(elements).reshape(4, 4).T
        np.testing.assert_allclose(shown, data.oMi[robot.model.getJointId(name)].homogeneous, atol=1e-5, err_msg=name)


@needs_browser
def test_every_kind_of_obstacle_is_drawn(robot: Robot, tmp_path: Path, cube_file: str) -> None:
    obstacles = (
        Sphere(center=(-2.0, 0.0, 2.0), radius=0.2),
        Box(center=(-2.0, 1.0, 2.0), size=(0.3, 0.4, 0.5), rpy=(0.1, 0.2, 0.3)),
        Capsule(center=(-2.0, 2.0, 2.0), radius=0.1, length=0.4, rpy=(1.0, 0.0, 0.0)),
        HalfSpace(normal=(0.0, 0.0, 1.0), offset=-0.3),
        HalfSpace(normal=(-1.0, 0.0, 0.0), offset=-9.0),
        Mesh(file=cube_file, center=(-2.0, 3.0, 2.0), scale=0.4),
    )
    targets = {"left": (0.1, -2.1, 3.1), "right": (0.1, 2.3, 3.1)}
    scene = Scene(name="<all> & more", targets=targets, obstacles=obstacles)
    (tmp_path / "page.html").write_text(playback_html(robot, scene, plan(robot, scene)), encoding="utf-8")
    with opened(tmp_path / "page.html") as (page, troubles):
        page.keyboard.press("o")  # nothing fades
        seek(page, 0.0)
        floor = page.evaluate("playback.page.floor")
        (sphere,), (box,), (tube,), ends, (wall,), (hull,) = drawn(page, "together0")
        assert page.title().startswith("<all> & more")
        assert page.inner_text("h1") == "<all> & more"
        assert not troubles
    capsule = np.minimum(ends[0][0], ends[1][0]), np.maximum(ends[0][1], ends[1][1])
    bodies = [obstacle for obstacle in obstacles if not isinstance(obstacle, HalfSpace)]
    for obstacle, (low, high) in zip(bodies, (sphere, box, capsule, hull), strict=True):
        np.testing.assert_allclose((low + high) / 2, obstacle.center, atol=1e-3)
    np.testing.assert_allclose(sphere[1] - sphere[0], 3 * [0.4], atol=0.01)
    np.testing.assert_allclose(
        capsule[1] - capsule[0], [0.2, 0.2 + 0.4 * np.sin(1.0), 0.2 + 0.4 * np.cos(1.0)], atol=0.1
    )
    np.testing.assert_allclose(np.add(*tube) / 2, obstacles[2].center, atol=1e-3)
    assert floor == pytest.approx(-0.3)
    assert wall[0][0] == pytest.approx(9.0, abs=0.01)
    assert hull[1] == pytest.approx([-1.8, 3.2, 2.2], abs=1e-3)


def test_the_camera_is_not_behind_a_wall(robot: Robot, scene: Scene) -> None:
    trajectory = plan_case(robot, 1, dt=0.5)
    for normal in ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, -1.0, 0.0)):
        wall = HalfSpace(normal=normal, offset=-6.0)
        middle, camera = viewpoint(robot, scene.model_copy(update={"obstacles": (wall,)}), trajectory)
        assert np.dot(normal, middle + camera) > -6.0
    far = scene.model_copy(update={"obstacles": (Sphere(center=(40.0, 0.0, 3.0), radius=1.0),)})
    assert np.linalg.norm(viewpoint(robot, far, trajectory)[0] - viewpoint(robot, scene, trajectory)[0]) < 2.0


def test_a_page_needs_neither_a_server_nor_the_network(robot: Robot, scene: Scene) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("subprocess.Popen.__init__", None)  # any process would be an error
        page = playback_html(robot, scene, plan_case(robot, 1, dt=0.1))
    assert "http://" not in page.split("</script>")[-2]


def test_pages_can_be_made_in_threads_at_once(robot: Robot, scene: Scene, capsys: pytest.CaptureFixture[str]) -> None:
    trajectory, stdout = plan_case(robot, 1, dt=0.5), sys.stdout
    with ThreadPoolExecutor(3) as pool:
        pages = list(pool.map(lambda _: playback_html(robot, scene, trajectory), range(3)))
    assert sys.stdout is stdout
    assert capsys.readouterr() == ("", "")
    assert all("not certified" in page for page in pages)


def test_a_page_is_served_to_this_machine_until_it_is_enough() -> None:
    with served("<p>\u2013</p>") as url:
        assert url.startswith("http://127.0.0.1:")
        with urlopen(url) as answer:
            assert (answer.status, answer.read().decode()) == (200, "<p>\u2013</p>")
        with pytest.raises(HTTPError, match="404"):
            urlopen(f"{url}other")
    with pytest.raises(URLError):
        urlopen(url)


def test_a_page_that_cannot_be_served_is_an_error_that_says_why(
    robot: Robot, scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_port(*_: object) -> None:
        raise OSError("no port is left")

    monkeypatch.setattr(server, "_Server", no_port)
    with pytest.raises(HumanoidRailError, match=r"playback .*no port is left"):
        show(robot, scene, plan_case(robot, 1, dt=0.5), open_browser=False)


def test_the_caption_says_what_is_certain(robot: Robot, scene: Scene) -> None:
    page = playback_html(robot, scene, plan_case(robot, 3)).split("</script>")
    caption = next(part for part in page if 'id="meshcat-pane"' in part)
    assert "certified free of contact" in caption
    assert "not certified" not in caption
    obstacle, links = r"\w+ \u2013 obstacles\[\d\] \(sphere\), 0\.437 m at \d\.\d\d s", r"\w+ \u2013 \w+, 0\.400 m at"
    assert re.search(f"closest: {obstacle}; {links}", caption)
    for mark in ("linear-gradient", "&lt; 0", ">0<", ">0.1<", ">0.25<", "&ge; 0.5", "clearance from obstacles, m"):
        assert mark in caption

    collided = plan_case(robot, 1)
    page = playback_html(robot, scene, collided)
    t = collided.certificate.contact.t
    assert f"not certified: left_clavicle touches obstacles[0] (sphere) at {t:.2f} s" in page
    assert f"left_clavicle \u2013 obstacles[0] (sphere), {collided.min_clearance:.3f} m at 6.34 s" in page


def test_without_the_engine_the_page_shows_no_closest_pairs(
    robot: Robot, scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    trajectory: Trajectory = changed(plan_case(robot, 1, dt=0.5), certificate=None)
    assert trajectory.clearance.size, "samples are computed when they are asked for"
    monkeypatch.setattr("humanoid_rail._native.why_no_engine", lambda: "not built")
    page = playback_html(robot, scene, trajectory)
    assert "not certified, as there was no native engine" in page
    assert "<p>closest:" not in page
    assert "clearance from obstacles, m" in page
    (motion,) = page_data(page)["motions"]
    assert motion["closest"] == {}
    assert motion["clearance"] is not None


def test_no_page_shows_a_certificate_of_another_scene(robot: Robot, scene: Scene, tmp_path: Path) -> None:
    trajectory = plan_case(robot, 3, dt=0.1)
    other = scene.model_copy(update={"obstacles": (*scene.obstacles, Sphere(center=(-2.0, 0.0, 2.0), radius=0.2))})
    for show_it in (lambda: playback_html(robot, other, trajectory), lambda: view(trajectory, robot, other)):
        with pytest.raises(InvalidInput, match=r"scene.*among which the motion was planned \(trajectory\.scene\)"):
            show_it()
    # A scene that is equal is as good, and other targets are no obstacles.
    assert "certified free of contact" in playback_html(robot, scene.model_copy(deep=True), trajectory)

    write_plan(trajectory, robot, scene, tmp_path)
    (tmp_path / "other.json").write_text(other.model_dump_json(exclude_none=True), encoding="utf-8")
    found = read_plan(tmp_path, str(tmp_path / "other.json"))
    assert found.scene.obstacles == other.obstacles
    with pytest.raises(InvalidInput, match="among which the motion was planned"):
        playback_html(found.robot, found.scene, found.trajectory)


def test_the_page_says_why_there_is_no_path(robot: Robot) -> None:
    scene = load_scene(ROOT / "scenes" / "unsolvable" / "target_in_collision-1.yaml")
    trajectory = plan(robot, scene)
    page = playback_html(robot, scene, trajectory)
    assert f">not reached: target in collision; the motion ends at {trajectory.duration:.2f} s<" in page
    assert ">certified free of contact, as far as the motion goes<" in page
    reached = playback_html(robot, paper_scene(), plan_case(robot, 3, dt=0.1))
    assert ">certified free of contact<" in reached
    assert ">reached in 6." in reached
    assert "the left hand at its target would be 0.35 m inside obstacles[0] (ball)" in page
