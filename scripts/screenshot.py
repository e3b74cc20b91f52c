"""Take a picture of a playback page with headless Chromium: those of the documents are made by this."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click
from playwright.sync_api import Page, sync_playwright

from humanoid_rail import HumanoidRailError, load_robot_of_scene, load_scene, paper_scene, plan, plan_case, retime
from humanoid_rail._files import check_file, write_file
from humanoid_rail.cli.console import console, run
from humanoid_rail.viewer.playback import playback_html

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
# WebGL in software; no look-ups on the network.
ARGUMENTS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
]
DESKTOP, PHONE = (1280, 800), (390, 844)
"""Sizes of windows, pixels."""


def browser_path() -> str | None:
    """Return where Chromium is installed, if it is."""
    return next((path for name in BROWSERS if (path := shutil.which(name))), None)


@contextmanager
def window(size: tuple[int, int] = DESKTOP) -> Iterator[Page]:
    """Open an empty window of a size, or of a phone if it is narrow."""
    path = browser_path()
    if path is None:
        raise HumanoidRailError(f"no browser: install one of {', '.join(BROWSERS)}")
    width, height = size
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=ARGUMENTS)
        yield browser.new_page(viewport={"width": width, "height": height}, has_touch=width < height)
        browser.close()


@contextmanager
def opened(page_file: Path, size: tuple[int, int] = DESKTOP) -> Iterator[tuple[Page, list[str]]]:
    """Open a page in a window of a size, or of a phone if it is narrow.

    Yields the page, and the list of what went wrong in it: errors and requests to the network.
    """
    troubles: list[str] = []
    with window(size) as page:
        page.on("console", lambda message: troubles.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: troubles.append(str(error)))
        page.on("request", lambda request: troubles.append(request.url) if request.url.startswith("http") else None)
        page.goto(page_file.resolve().as_uri())
        page.wait_for_function("() => window.playback !== undefined || window.isReady")
        page.wait_for_timeout(300)
        yield page, troubles


@contextmanager
def page_of(text: str, size: tuple[int, int] = DESKTOP) -> Iterator[Page]:
    """Open a page in a window of a size; nothing may go wrong in it."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "page.html"
        file.write_text(text, encoding="utf-8")
        with opened(file, size) as (page, troubles):
            yield page
            if troubles:
                raise HumanoidRailError(f"the page has troubles: {troubles}")


def seek(page: Page, t: float) -> None:
    """Stop the motion of a page at a time in s, and wait until that is drawn and what hides the robot has faded."""
    page.evaluate("t => { playback.clock.pause(); playback.clock.seek(t); }", t)
    settle(page)


def settle(page: Page) -> None:
    """Wait until what hides the robot has faded and all is drawn."""
    page.wait_for_function("() => playback.obstacles.isSettled && !viewer.needs_render")


@click.command()
@click.argument("picture", type=click.Path(path_type=Path))
@click.option("--case", default=3, show_default=True, help="Case of the paper.")
@click.option("--scene", "scene_file", help="A scene file instead, planned by auto for its robot and retimed.")
@click.option("--at", type=float, help="Time of the motion, s; its end if not given.")
@click.option("--size", default=DESKTOP, show_default=True, type=(int, int), help="Width and height, pixels.")
@click.option("--stage", is_flag=True, help="Of the scene alone, without what is around it.")
def main(
    picture: Path, case: int, scene_file: str | None, at: float | None, size: tuple[int, int], stage: bool
) -> None:
    """Plan a case of the paper and write a PICTURE of its playback page."""
    check_file(picture)
    scene = paper_scene() if scene_file is None else load_scene(scene_file)
    robot = load_robot_of_scene(scene)
    motion = plan_case(robot, case) if scene_file is None else retime(plan(robot, scene), robot, scene)
    with page_of(playback_html(robot, scene, motion), size) as page:
        if stage:
            page.add_style_tag(content="#caption, #plots, #timeline, #help-button { display: none !important; }")
        seek(page, motion.duration if at is None else at)
        taken = page.locator("#stage").screenshot() if stage else page.screenshot()
    write_file(picture, taken)
    console().print(f"{picture}", soft_wrap=True)


if __name__ == "__main__":
    run(main)
