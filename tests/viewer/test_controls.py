"""The controls of the playback page in a real browser: keys, timeline, plots, names, and its form on a phone."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROOT, plan
from pages import needs_browser, page_data, unpacked
from screenshot import opened, seek

from humanoid_rail import Robot, Scene, Trajectory, load_scene, retime
from humanoid_rail.viewer.playback import playback_html

NAME = "<img src=x onerror=alert(1)> & more"
VISIBLE = "name => playback.figures[0].find(name).visible"
CLOCK = "() => [playback.clock.t, playback.clock.playing, playback.clock.speed]"


@pytest.fixture(scope="module")
def picks(robot: Robot) -> tuple[Scene, Trajectory]:
    scene = load_scene(ROOT / "scenes" / "picks.yaml").model_copy(update={"name": NAME})
    return scene, retime(plan(robot, scene), robot, scene)


@pytest.fixture(scope="module")
def file(robot: Robot, picks: tuple[Scene, Trajectory], tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("pages") / "page.html"
    path.write_text(playback_html(robot, *picks), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def opened_page(file: Path) -> Iterator[tuple[Any, list[str]]]:
    with opened(file) as (page, troubles):
        yield page, troubles


@pytest.fixture
def page(opened_page: tuple[Any, list[str]]) -> Iterator[Any]:
    """The page as it opens, but standing still at 2 s."""
    page, troubles = opened_page
    page.evaluate("() => { playback.clock.pause(); playback.clock.setSpeed(1); playback.clock.seek(2); }")
    yield page
    assert not troubles


@needs_browser
def test_keys_play_step_jump_and_change_the_speed(page: Any, picks: tuple[Scene, Trajectory]) -> None:
    _, trajectory = picks

    def pressed(key: str) -> tuple[float, bool, float]:
        page.keyboard.press(key)
        return tuple(page.evaluate(CLOCK))

    assert pressed("ArrowRight")[0] == pytest.approx(2 + 1 / 30)
    assert pressed("ArrowLeft")[0] == pytest.approx(2)
    assert pressed("Shift+ArrowRight")[0] == pytest.approx(min(t for t in trajectory.arrivals if t > 2))
    assert pressed("Shift+ArrowLeft")[0] == pytest.approx(max(t for t in trajectory.arrivals if t < 2))
    assert pressed("End") == (pytest.approx(trajectory.duration), False, 1)
    assert pressed("Home") == (0, False, 1)
    assert pressed("+")[2] == 2
    assert pressed("-")[2] == 1
    assert pressed("-")[2] == 0.5
    assert pressed(" ")[1]
    page.wait_for_function("() => playback.clock.t > 0.2")
    assert not pressed(" ")[1]


@needs_browser
def test_keys_show_and_hide_what_the_help_lists(page: Any) -> None:
    assert page.locator("#help").is_hidden()
    page.keyboard.press("?")
    assert page.locator("#help").is_visible()
    listed = page.locator("#help [data-view] kbd").all_inner_texts()
    assert len(set(listed)) == len(listed) == len(page.evaluate("Object.keys(playback.views)"))
    for key, name in {"M": "robot", "B": "bodies", "C": "closest", "T": "traces", "A": "axes"}.items():
        before = page.evaluate(VISIBLE, name)
        page.keyboard.press(key.lower())
        assert page.evaluate(VISIBLE, name) != before
        page.locator(f"[data-view={name}]").click()
        assert page.evaluate(VISIBLE, name) == before
    page.keyboard.press("p")
    assert page.locator("#plots").is_hidden()
    page.keyboard.press("p")
    page.keyboard.press("Escape")
    assert page.locator("#help").is_hidden()
    at = page.evaluate("playback.camera.middle.distanceTo(viewer.camera.position)")
    page.keyboard.press("f")
    assert page.evaluate("playback.camera.middle.distanceTo(viewer.camera.position)") < 0.9 * at
    hands = "() => viewer.controls.target.toArray()"
    target = np.array(page.evaluate(hands))
    seek(page, 4.0)
    assert np.linalg.norm(np.array(page.evaluate(hands)) - target) > 0.2, "the camera does not follow"
    page.keyboard.press("f")
    assert page.evaluate("playback.camera.middle.distanceTo(viewer.camera.position)") == pytest.approx(at)


@needs_browser
def test_the_timeline_scrubs(page: Any, picks: tuple[Scene, Trajectory]) -> None:
    scene, trajectory = picks
    box = page.locator("#track").bounding_box()
    y = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + 0.2 * box["width"], y)
    page.mouse.down()
    assert page.evaluate("playback.clock.t") == pytest.approx(0.2 * trajectory.duration, abs=0.02)
    page.mouse.move(box["x"] + 0.7 * box["width"], y, steps=4)
    page.mouse.up()
    t = page.evaluate("playback.clock.t")
    assert t == pytest.approx(0.7 * trajectory.duration, abs=0.02)
    said = page.inner_text("#time")
    assert said.startswith(f"{t:.2f} / {trajectory.duration:.2f} s")
    segment = 1 + sum(arrival < t for arrival in trajectory.arrivals)
    assert f"target {segment} of {len(scene.steps)}" in said
    marks = page.evaluate("[...document.querySelectorAll('.mark-at')].map(mark => parseFloat(mark.style.left))")
    np.testing.assert_allclose(marks, 100 * np.array(trajectory.arrivals) / trajectory.duration, atol=1e-3)


@needs_browser
def test_plots_have_the_values_of_the_trajectory(page: Any, file: Path, picks: tuple[Scene, Trajectory]) -> None:
    _, trajectory = picks
    (motion,) = page_data(file.read_text(encoding="utf-8"))["motions"]
    moments = unpacked(motion["t"])
    samples = np.array([i for i, t in enumerate(trajectory.t) if abs(moments - t).min() < 1e-6])
    assert len(samples) > 100
    read = page.evaluate(
        """times => ["clearance", "manipulability", "speed", "hands"].map(id =>
            times.map(t => playback.plots.read(id, t)[0].values))""",
        trajectory.t[samples].tolist(),
    )
    clearance, manipulability, speed, _ = (np.array(values) for values in read)
    np.testing.assert_allclose(clearance[:, 0], trajectory.clearance[samples].min(axis=1), atol=1e-6)
    np.testing.assert_allclose(manipulability[:, 0], trajectory.manipulability[samples], rtol=1e-6)
    limits = [peak.velocity_limit for peak in trajectory.timing.peaks]
    np.testing.assert_allclose(speed, abs(trajectory.timing.velocity[samples]) / limits, atol=1e-6)


@needs_browser
def test_plots_are_read_by_hovering_and_a_click_goes_there(page: Any, picks: tuple[Scene, Trajectory]) -> None:
    _, trajectory = picks
    box = page.locator("#plot-clearance canvas").bounding_box()
    x, y = box["x"] + 0.6 * box["width"], box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    t = 0.6 * trajectory.duration
    said = page.inner_text("#plot-clearance .value")
    expected = np.interp(t, trajectory.t, trajectory.clearance.min(axis=1))
    assert float(said.split()[0]) == pytest.approx(expected, abs=0.02)
    assert "obstacles[" in said, "which pair it is"
    assert page.evaluate("playback.clock.t") == 2, "hovering does not move the robot"
    page.mouse.click(x, y)
    assert page.evaluate("playback.clock.t") == pytest.approx(t, abs=0.02)
    page.mouse.move(10, 10)
    inked = """() => { const canvas = document.querySelector("#plot-clearance canvas");
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        return data.filter((value, i) => i % 4 === 3 && value > 128).length / (data.length / 4); }"""
    assert 0.01 < page.evaluate(inked) < 0.5


@needs_browser
def test_the_wheel_zooms_to_the_pointer(page: Any) -> None:
    place = """() => playback.camera.inView(playback.figures[0].hands[0].toArray())
        .project(viewer.camera).toArray().slice(0, 2)"""
    box = page.locator("#meshcat-pane").bounding_box()
    page.evaluate("() => playback.camera.fit()")
    page.wait_for_timeout(100)
    before = np.array(page.evaluate(place))
    x = box["x"] + (before[0] + 1) / 2 * box["width"]
    y = box["y"] + (1 - before[1]) / 2 * box["height"]
    distance = page.evaluate("viewer.camera.position.distanceTo(viewer.controls.target)")
    page.mouse.move(x, y)
    page.mouse.wheel(0, -600)
    page.wait_for_function(
        "before => viewer.camera.position.distanceTo(viewer.controls.target) < 0.7 * before", arg=distance
    )
    np.testing.assert_allclose(page.evaluate(place), before, atol=0.12)
    page.keyboard.press("r")
    assert page.evaluate("viewer.camera.position.distanceTo(viewer.controls.target)") == pytest.approx(distance)


@needs_browser
def test_names_are_text_whatever_is_in_them(page: Any) -> None:
    assert page.inner_text("h1") == NAME
    assert page.title().startswith(NAME)
    assert page.locator("img").count() == 0
    page.keyboard.press("n")
    page.wait_for_function("() => document.querySelectorAll('#labels .names:not([hidden])').length > 5")
    shown = page.locator("#labels .names:visible").all_inner_texts()
    assert {"left", "right", "obstacles[3] (box)"} <= set(shown)
    page.keyboard.press("n")
