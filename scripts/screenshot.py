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
from humanoid_rail.viewer.caption import HINT
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


def browser_path() -> str | None:
    """Return where Chromium is installed, if it is."""
    return next((path for name in BROWSERS if (path := shutil.which(name))), None)


@contextmanager
def opened(page_file: Path, size: tuple[int, int] = (1280, 760)) -> Iterator[tuple[Page, list[str]]]:
    """Open a playback page; yields it, and the list of what went wrong in it: errors and requests to the network.

    Args:
        page_file: The page.
        size: Width and height of the window, pixels.
    """
    path = browser_path()
    if path is None:
        raise HumanoidRailError(f"no browser: install one of {', '.join(BROWSERS)}")
    troubles: list[str] = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=ARGUMENTS)
        page = browser.new_page(viewport={"width": size[0], "height": size[1]})
        page.on("console", lambda message: troubles.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: troubles.append(str(error)))
        page.on("request", lambda request: troubles.append(request.url) if request.url.startswith("http") else None)
        page.goto(page_file.resolve().as_uri())
        # meshcat takes its commands in one after the other; the animation comes with the first.
        page.wait_for_function("() => viewer.animator.actions.length > 0")
        page.wait_for_timeout(1000)
        yield page, troubles
        browser.close()


def seek(page: Page, t: float) -> None:
    """Stop the animation at a time in s."""
    page.evaluate("t => { viewer.animator.pause(); viewer.animator.seek(t); viewer.render(); }", t)
    page.wait_for_timeout(200)


ONLY_A_PICTURE = f"""() => {{
    viewer.gui.domElement.remove();
    const hint = document.querySelector(".{HINT}").parentElement;
    hint.parentElement.style.maxWidth = "96vw";
    hint.remove();
}}"""
"""Leaves out what is for those who use the page: its controls, and how to use them."""


@click.command()
@click.argument("picture", type=click.Path(path_type=Path))
@click.option("--case", default=3, show_default=True, help="Case of the paper.")
@click.option("--scene", "scene_file", help="A scene file instead, planned by auto for its robot and retimed.")
@click.option("--at", type=float, help="Time of the motion, s; its end if not given.")
@click.option("--size", default=(1280, 760), show_default=True, type=(int, int), help="Width and height, pixels.")
def main(picture: Path, case: int, scene_file: str | None, at: float | None, size: tuple[int, int]) -> None:
    """Plan a case of the paper and write a PICTURE of its playback page."""
    check_file(picture)
    scene = paper_scene() if scene_file is None else load_scene(scene_file)
    robot = load_robot_of_scene(scene)
    motion = plan_case(robot, case) if scene_file is None else retime(plan(robot, scene), robot, scene)
    with tempfile.TemporaryDirectory() as folder:
        page_file = Path(folder) / "playback.html"
        page_file.write_text(playback_html(robot, scene, motion), encoding="utf-8")
        with opened(page_file, size) as (page, _):
            page.evaluate(ONLY_A_PICTURE)
            seek(page, motion.duration if at is None else at)
            taken = page.screenshot()
    write_file(picture, taken)
    console().print(f"{picture}", soft_wrap=True)


if __name__ == "__main__":
    run(main)
