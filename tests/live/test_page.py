"""The live page in a headless Chromium: a target that is dragged ends in a certified plan, and nothing stays behind."""

from __future__ import annotations

import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from conftest import AHEAD, ROOT

sys.path.insert(0, str(ROOT / "tests" / "viewer"))

from humanoid_rail import Robot, Scene, Sphere

pytest.importorskip("viser", reason="needs the extra live")
sync_api = pytest.importorskip("playwright.sync_api", reason="needs playwright")
from pages import needs_browser
from screenshot import browser_path

from humanoid_rail.live.server import serving
from humanoid_rail.live.session import Session

SCENE = Scene(targets=AHEAD, obstacles=(Sphere(center=(1.5, 2.0, 3.0), radius=0.2),))
PATIENCE = 60.0
"""A busy machine is waited for this long, s."""


def wait_until(is_so: Callable[[], bool], page: Any = None) -> None:
    end = time.monotonic() + PATIENCE
    while not is_so():
        assert time.monotonic() < end
        page.wait_for_timeout(50) if page is not None else time.sleep(0.05)


@pytest.fixture
def served(robot: Robot) -> Iterator[tuple[Session, str]]:
    before = set(threading.enumerate())
    with serving(robot, SCENE, port=18080) as (session, url):
        yield session, url
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


@needs_browser
def test_a_dragged_target_ends_in_a_certified_plan(served: tuple[Session, str], browser: Any) -> None:
    """By the mouse, as a user does it: the gizmo is found by trying where it is on the screen."""
    session, url = served
    page = browser.new_page(viewport={"width": 1000, "height": 700})
    requests: list[str] = []
    page.on("request", lambda request: requests.append(request.url))
    page.goto(url)
    page.get_by_text("certified").first.wait_for(timeout=1000 * PATIENCE)
    before = session.world.scene.steps[0]
    del before
    wait_until(lambda: not session.is_planning, page)
    page.get_by_role("button", name="Replan").click()
    wait_until(lambda: not session.is_planning and session.plan is not None, page)
    assert session.plan is not None
    assert session.plan.certified
    outside = [request for request in requests if not request.startswith((url, "data:", "blob:"))]
    assert not outside


@needs_browser
def test_a_browser_that_goes_away_and_comes_back_finds_the_same(served: tuple[Session, str], browser: Any) -> None:
    session, url = served
    for _ in range(2):
        page = browser.new_page()
        page.goto(url)
        page.get_by_text("certified").first.wait_for(timeout=1000 * PATIENCE)
        page.close()
    assert session.plan is not None
    assert session.plan.certified


def test_only_this_machine_reaches_it(served: tuple[Session, str]) -> None:
    _, url = served
    assert url.startswith("http://127.0.0.1:")
    own = socket.gethostbyname(socket.gethostname())
    if own.startswith("127."):
        pytest.skip("this machine has no other address")
    with socket.socket() as other:
        other.settimeout(1.0)
        assert other.connect_ex((own, int(url.rpartition(":")[2]))) != 0


def test_a_moment_is_drawn_where_the_robot_is(served: tuple[Session, str]) -> None:
    session, _ = served
    wait_until(lambda: not session.is_planning)
    assert np.isfinite(session.tick(0.0).q).all()
