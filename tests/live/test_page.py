"""The live page in a headless Chromium: a target that is dragged ends in a certified plan, and nothing stays behind."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from conftest import AHEAD
from screenshot import browser_path

from humanoid_rail import InvalidInput, Kinematics, Robot, Scene, Sphere, load_robot
from humanoid_rail.live.server import Live, serving
from humanoid_rail.live.session import Mode

pytest.importorskip("viser", reason="needs the extra live")
sync_api = pytest.importorskip("playwright.sync_api", reason="needs playwright")
needs_browser = pytest.mark.skipif(browser_path() is None, reason="Chromium (Debian: chromium) is not installed")

SPHERE = Sphere(center=(1.5, 2.0, 3.0), radius=0.2)
SCENE = Scene(targets=AHEAD, obstacles=(SPHERE,))
PATIENCE = 60.0
"""A busy machine is waited for this long, s."""


def wait_until(is_so: Callable[[], bool], page: Any = None) -> None:
    end = time.monotonic() + PATIENCE
    while not is_so():
        assert time.monotonic() < end
        page.wait_for_timeout(50) if page is not None else time.sleep(0.05)


@pytest.fixture
def served(robot: Robot) -> Iterator[Live]:
    before = set(threading.enumerate())
    with serving(robot, SCENE, port=18080) as live:
        yield live
    end = time.monotonic() + PATIENCE
    while left := [thread.name for thread in set(threading.enumerate()) - before if "playwright" not in thread.name]:
        assert time.monotonic() < end, left
        time.sleep(0.05)


@pytest.fixture
def browser() -> Iterator[Any]:
    with sync_api.sync_playwright() as playwright:
        path = browser_path()
        started = playwright.chromium.launch(
            executable_path=None if path is None else str(path), args=["--no-sandbox", "--use-gl=swiftshader"]
        )
        yield started
        started.close()


def on_screen(live: Live, page: Any, point: np.ndarray) -> tuple[float, float]:
    """Return where a browser shows a point (3,), px."""
    (client,) = live.page.server.get_clients().values()
    camera, view = client.camera, page.viewport_size
    w, x, y, z = map(float, camera.wxyz)
    local = pin.Quaternion(w, x, y, z).matrix().T @ (point - np.array(camera.position))
    focal = view["height"] / 2.0 / np.tan(float(camera.fov) / 2.0)
    return view["width"] / 2.0 + focal * local[0] / local[2], view["height"] / 2.0 + focal * local[1] / local[2]


@needs_browser
def test_a_target_that_the_mouse_drags_ends_in_a_certified_plan(served: Live, browser: Any) -> None:
    """By the arrow of the gizmo that points up."""
    session = served.session
    page = browser.new_page(viewport={"width": 1000, "height": 700})
    requests: list[str] = []
    page.on("request", lambda request: requests.append(request.url))
    page.goto(served.url)
    page.get_by_text("certified").first.wait_for(timeout=1000 * PATIENCE)
    wait_until(lambda: not session.is_planning, page)
    before, hand = session.world, np.array(AHEAD["left"])
    up = np.array([0.0, 0.0, 1.0])
    page.wait_for_timeout(1000)  # until the camera is where it is told to be
    grip = on_screen(served, page, hand + 0.2 * up)
    there = on_screen(served, page, hand + 0.6 * up)
    page.mouse.move(*grip)
    page.wait_for_timeout(800)  # until the browser has seen what is under the mouse
    page.mouse.down()
    page.wait_for_timeout(200)
    for share in np.linspace(0.0, 1.0, 8):
        page.mouse.move(*(np.add(grip, share * np.subtract(there, grip))))
        page.wait_for_timeout(120)
    page.mouse.up()
    wait_until(lambda: session.world is not before, page)
    page.wait_for_timeout(500)
    wait_until(lambda: not session.is_planning, page)
    target = np.array(session.world.scene.steps[0]["left"])
    assert target[2] > hand[2] + 0.1
    np.testing.assert_allclose(target[:2], hand[:2], atol=1e-6)
    assert session.plan is not None
    assert session.plan.certified
    assert session.plan.trajectory is not None
    np.testing.assert_allclose(session.plan.trajectory.hands[-1, 0], target, atol=0.011)
    outside = [request for request in requests if not request.startswith((served.url, "data:", "blob:"))]
    assert not outside


@needs_browser
def test_an_obstacle_has_a_gizmo_while_it_is_chosen_by_clicks(served: Live, browser: Any) -> None:
    # So wide a window has the sphere beside the panel.
    page = browser.new_page(viewport={"width": 1600, "height": 700})
    page.goto(served.url)
    page.get_by_text("certified").first.wait_for(timeout=1000 * PATIENCE)
    page.wait_for_timeout(1000)  # until the camera is where it is told to be
    assert served.page.chosen is None
    there = on_screen(served, page, np.array(SPHERE.center))
    page.mouse.move(*there)
    page.wait_for_timeout(800)  # until the browser has seen what is under the mouse
    page.mouse.click(*there)
    wait_until(lambda: served.page.chosen == 0, page)
    served.page.choose(0)
    assert served.page.chosen is None


@needs_browser
def test_each_browser_fades_what_hides_the_robot_from_its_own_camera(served: Live, browser: Any, robot: Robot) -> None:
    server, obstacles = served.page.server, served.page.obstacles
    for _ in range(2):
        browser.new_page().goto(served.url)
    wait_until(lambda: len(server.get_clients()) == 2)
    one, other = server.get_clients().values()
    wait_until(lambda: not obstacles.faded(one.client_id))
    rail = Kinematics(robot).stick_figure(robot.initial)[0]
    behind = rail + 2.5 * (np.array(SPHERE.center) - rail)

    def is_faded() -> bool:  # once the browser has taken the first camera that it was told, it takes this one
        one.camera.position, one.camera.look_at = tuple(behind.tolist()), tuple(rail.tolist())
        return obstacles.faded(one.client_id) == {0}

    wait_until(is_faded)
    assert not obstacles.faded(other.client_id)
    served.session.change(lambda world: world.with_obstacle(0, Sphere(center=(1.5, 9.0, 3.0), radius=0.2)))
    wait_until(lambda: not obstacles.faded(one.client_id))


@needs_browser
def test_mode_and_method_are_chosen_in_the_panel(served: Live, browser: Any) -> None:
    page = browser.new_page(viewport={"width": 1000, "height": 700})
    page.goto(served.url)
    page.get_by_text("certified").first.wait_for(timeout=1000 * PATIENCE)
    page.locator('input[value="plan"][role="combobox"]').click()
    page.get_by_role("option", name="follow", exact=True).click()
    wait_until(lambda: served.session.mode is Mode.FOLLOW, page)
    page.get_by_text("stop proven").first.wait_for(timeout=1000 * PATIENCE)
    page.get_by_text("cycle of 1 ms").first.wait_for(timeout=1000 * PATIENCE)


@needs_browser
def test_a_browser_that_goes_away_and_comes_back_finds_the_same(served: Live, browser: Any) -> None:
    session, url = served.session, served.url
    for _ in range(2):
        page = browser.new_page()
        page.goto(url)
        page.get_by_text("certified").first.wait_for(timeout=1000 * PATIENCE)
        page.close()
    assert session.plan is not None
    assert session.plan.certified


def test_only_this_machine_reaches_it(served: Live) -> None:
    url = served.url
    assert url.startswith("http://127.0.0.1:")
    own = socket.gethostbyname(socket.gethostname())
    if own.startswith("127."):
        pytest.skip("this machine has no other address")
    with socket.socket() as other:
        other.settimeout(1.0)
        assert other.connect_ex((own, int(url.rpartition(":")[2]))) != 0


def test_the_command_serves_until_it_is_told_to_end() -> None:
    command = [sys.executable, "-m", "humanoid_rail", "live", "--no-view", "--port", "18090"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        said = next(line for line in process.stdout if line.startswith("Live at"))
        with urllib.request.urlopen(said.split()[2]) as page:
            assert page.status == 200
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE) == 0
        assert not process.stderr.read()


def test_only_the_paper_s_robot_as_it_is_loaded_has_sliders_of_sizes(robot: Robot) -> None:
    """They would bring back the other hand, or other sizes, with the first that is moved."""
    from humanoid_rail.live.page import has_sizes

    assert has_sizes(robot)
    assert not has_sizes(robot.with_hands(["left"]))
    assert not has_sizes(load_robot(l_l2=0.9))


def test_a_scene_of_another_robot_is_refused(robot: Robot) -> None:
    with pytest.raises(InvalidInput, match="targets"), serving(robot, Scene(targets={"tool": (1.0, 0.0, 1.0)})):
        pass
    with pytest.raises(InvalidInput, match="port"), serving(robot, SCENE, port=0):
        pass


@pytest.mark.parametrize("host", ["", "nowhere.invalid", "203.0.113.7", "a" * 300])
def test_an_address_that_is_not_of_this_machine_is_refused(robot: Robot, host: str) -> None:
    with pytest.raises(InvalidInput, match="host"), serving(robot, SCENE, host=host, port=18100):
        pass


def test_a_port_that_is_taken_gives_way_to_the_next_one(robot: Robot) -> None:
    with socket.create_server(("127.0.0.1", 65535)):
        with serving(robot, SCENE, port=18100) as one, serving(robot, SCENE, port=18100) as two:
            assert [live.url[-5:] for live in (one, two)] == ["18100", "18101"]
        with pytest.raises(InvalidInput, match="port"), serving(robot, SCENE, port=65535):
            pass


def test_the_mode_in_the_panel_is_that_of_the_session(served: Live) -> None:
    """Also where it changes by itself: a robot of other sizes is planned for."""
    session, page = served.session, served.page
    session.set_mode(Mode.FOLLOW)
    wait_until(lambda: page.mode.value == "follow")
    session.load_robot(load_robot)
    assert session.mode is Mode.PLAN
    wait_until(lambda: page.mode.value == "plan")


@pytest.mark.parametrize("limits", [(0.001, 0.008), (-1e-5, 1e-5), (0.123456, 0.123456), (-0.523599, 3.665191)])
def test_sliders_are_within_limits_however_narrow(limits: tuple[float, float]) -> None:
    from humanoid_rail.live.page import slider_range

    low, high, digits = slider_range(*limits)
    assert limits[0] <= low <= high <= limits[1]
    if limits[0] < limits[1]:
        assert high - low > 0.9 * (limits[1] - limits[0])
        assert 10.0**-digits <= min(0.01, 0.011 * (limits[1] - limits[0]))


def test_a_robot_with_a_short_joint_is_shown() -> None:
    links = "".join(f'<link name="{name}"/>' for name in ("base", "arm", "wrist"))
    tip = '<link name="tip"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>'
    joints = "".join(
        f'<joint name="{name}" type="prismatic"><parent link="{parent}"/><child link="{child}"/><origin xyz="0.2 0 0"/>'
        f'<axis xyz="0 0 1"/><limit lower="{lower}" upper="{upper}" velocity="1" effort="1"/></joint>'
        for name, parent, child, lower, upper in (
            ("long", "base", "arm", -1.0, 1.0),
            ("longer", "arm", "wrist", -1.0, 2.0),
            ("short", "wrist", "tip", 0.001, 0.008),
        )
    )
    short = load_robot(f'<robot name="short">{links}{tip}{joints}</robot>', hands={"tip": "tip"})
    with serving(short, Scene(targets={"tip": (0.4, 0.0, 0.3)}), port=18110) as live:
        wait_until(lambda: not live.session.is_planning)
        assert live.session.plan is not None


def test_steps_that_share_a_place_have_one_number_until_they_part(robot: Robot) -> None:
    there, elsewhere = {"left": AHEAD["left"], "right": None}, {"left": (-1.6, 0.9, 3.4), "right": None}
    with serving(robot, Scene(targets=(elsewhere, there, there)), port=18080) as live:
        page = live.page
        assert [page.numbers[step, "left"].text for step in range(3)] == ["1", "2, 3", "2, 3"]
        gizmo = page.targets[2, "left"]
        gizmo.position = elsewhere["left"]
        for moved in gizmo._impl_aux.update_cb:  # as if it had been dragged there
            moved(None)
        assert [page.numbers[step, "left"].text for step in range(3)] == ["1, 3", "2", "1, 3"]
