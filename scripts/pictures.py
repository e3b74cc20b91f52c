"""Make the pictures of the playback page for the documents, and the moving one of the README. `make picture`."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import click
import numpy as np
from aisle import aisle
from live_picture import live_page
from PIL import Image
from playwright.sync_api import Page
from screenshot import PHONE, page_of, seek

from humanoid_rail import (
    Auto,
    HumanoidRailError,
    Robot,
    Scene,
    Trajectory,
    load_robot,
    load_robot_of_scene,
    load_scene,
    paper_scene,
    plan,
    plan_case,
    retime,
)
from humanoid_rail._files import check_folder, write_file
from humanoid_rail.cli.console import console, run
from humanoid_rail.progress import progress
from humanoid_rail.viewer.playback import motions_html, playback_html

SCENES = Path(__file__).resolve().parent.parent / "scenes"
RATE, REST = 12.0, 1.0
"""The moving picture has so many frames a second, 1/s, and rests so long at the end, s."""
MOVING = (800, 500)
"""Size of the moving picture, pixels."""
COLOURS = 255
"""It has so many colours."""
STRONG, SAMPLED = 70, 50_000
"""From this difference of red, green and blue, in 255ths, colours are strong; so many pixels make the palette."""
LARGEST = 3_000_000
"""It is not larger, bytes."""
GAP = 12
"""Between pictures that are put beside each other, pixels."""


@click.command()
@click.option("--out", default="docs/pictures", show_default=True, type=click.Path(path_type=Path), help="Folder.")
@click.option("--only", multiple=True, metavar="NAME", help="Make this picture alone; can be given again.")
def main(out: Path, only: tuple[str, ...]) -> None:
    """Make the pictures."""
    check_folder(out, [])
    robot = load_robot()
    for name, make in PICTURES.items():
        if only and name not in only:
            continue
        with progress(name):
            content = make(robot)
        write_file(out / name, content)
        console().print(f"{out / name}: {len(content) / 1e6:.2f} MB", soft_wrap=True)


def case3(robot: Robot) -> bytes:
    """Return the page of the paper's third case."""
    with page_of(playback_html(robot, paper_scene(), plan_case(robot, 3))) as page:
        return taken(page, 1.9)


def case3_times(robot: Robot) -> bytes:
    """Return the scene of the paper's third case at three times, side by side."""
    motion = plan_case(robot, 3)
    with page_of(playback_html(robot, paper_scene(), motion), (800, 800)) as page:
        parts = []
        for t in (0.0, 1.2, motion.duration):
            seek(page, t)
            parts.append(Image.open(BytesIO(page.locator("#stage").screenshot())).convert("RGB"))
    return beside(parts)


def picks(robot: Robot) -> bytes:
    """Return the page of a round of picks."""
    with page_of(playback_html(*kitting())) as page:
        return taken(page, 1.6)


def picks_help(robot: Robot) -> bytes:
    """Return the page of a round of picks with collision bodies, and with the help open."""
    with page_of(playback_html(*kitting())) as page:
        for key in ("b", "m", "?"):
            page.keyboard.press(key)
        return taken(page, 1.6)


def kit(robot: Robot) -> bytes:
    """Return the page of a kitting round in which parts are carried."""
    scene = load_scene(SCENES / "kit.yaml")
    own = load_robot_of_scene(scene)
    with page_of(playback_html(own, scene, plan(own, scene))) as page:
        return taken(page, 4.3)


def aisle_page(robot: Robot) -> bytes:
    """Return the page of an aisle of more than a thousand boxes."""
    with page_of(playback_html(robot, *retimed(robot, aisle()))) as page:
        return taken(page, 2.9)


def compared(robot: Robot) -> bytes:
    """Return the page of two plans for the same picks."""
    rounds = [(f"seed {seed}", *kitting(seed)) for seed in (0, 5)]
    with page_of(motions_html(rounds[0][1], [(name, scene, motion) for name, _, scene, motion in rounds])) as page:
        return taken(page, 3.6)


def failed(robot: Robot) -> bytes:
    """Return the page of a plan that failed: the doors of a cupboard are shut."""
    scene = load_scene(SCENES / "unsolvable" / "stuck-4.yaml")
    with page_of(playback_html(robot, scene, plan(robot, scene))) as page:
        return taken(page, 0.0)


def phone(robot: Robot) -> bytes:
    """Return pages on a phone, side by side."""
    parts = []
    for shown, t in ((kitting(), 1.6), ((robot, *retimed(robot, aisle())), 2.9)):
        with page_of(playback_html(*shown), PHONE) as page:
            parts.append(Image.open(BytesIO(taken(page, t))).convert("RGB"))
    return beside(parts)


def moving(robot: Robot) -> bytes:
    """Return a round of picks as a moving picture.

    Raises:
        HumanoidRailError: If it is too large.
    """
    own, scene, motion = kitting()
    with page_of(playback_html(own, scene, motion)) as page:
        times = np.arange(0.0, motion.duration, 1.0 / RATE)
        frames = [
            Image.open(BytesIO(taken(page, t))).convert("RGB").resize(MOVING, Image.Resampling.LANCZOS) for t in times
        ]
    palette = palette_of(frames[:: len(frames) // 6])
    reduced = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    lasting = [int(1000 / RATE)] * len(reduced)
    lasting[-1] += int(1000 * REST)
    content = BytesIO()
    reduced[0].save(
        content, "GIF", save_all=True, append_images=reduced[1:], duration=lasting, loop=0, optimize=True, disposal=1
    )
    if (size := len(content.getvalue())) > LARGEST:
        raise HumanoidRailError(f"the moving picture has {size} bytes, more than {LARGEST}")
    return content.getvalue()


def palette_of(frames: list[Image.Image]) -> Image.Image:
    """Return one palette for all frames, or else what does not move would flicker.

    Half of what it is made of are pixels of strong colours, which are few: robot, targets and curves.
    """
    pixels = np.vstack([np.asarray(frame).reshape(-1, 3) for frame in frames])
    strong = pixels[np.ptp(pixels.astype(int), axis=1) > STRONG]
    half = [each[:: max(len(each) // SAMPLED, 1)][:SAMPLED] for each in (pixels, strong)]
    return Image.fromarray(np.vstack(half)[None]).quantize(COLOURS)


PICTURES: dict[str, Callable[[Robot], bytes]] = {
    "case3.png": case3,
    "case3_times.png": case3_times,
    "picks.png": picks,
    "help.png": picks_help,
    "kit.png": kit,
    "aisle.png": aisle_page,
    "compare.png": compared,
    "failed.png": failed,
    "phone.png": phone,
    "live.png": live_page,
    "moving.gif": moving,
}
"""How each picture is made."""


def retimed(robot: Robot, scene: Scene, seed: int = 0) -> tuple[Scene, Trajectory]:
    """Return a scene, and a motion in it that is timed for a drive."""
    return scene, retime(plan(robot, scene, Auto(seed=seed)), robot, scene)


def kitting(seed: int = 0) -> tuple[Robot, Scene, Trajectory]:
    """Return the robot of the kitting round, the scene, and a motion that is timed for a drive."""
    scene = load_scene(SCENES / "picks.yaml")
    robot = load_robot_of_scene(scene)
    return robot, *retimed(robot, scene, seed)


def taken(page: Page, t: float) -> bytes:
    """Return a picture of a page at a time in s."""
    seek(page, t)
    content: bytes = page.screenshot()
    return content


def beside(parts: list[Image.Image]) -> bytes:
    """Return pictures beside each other, as PNG."""
    width = sum(part.width for part in parts) + GAP * (len(parts) - 1)
    whole, x = Image.new("RGB", (width, max(part.height for part in parts)), "white"), 0
    for part in parts:
        whole.paste(part, (x, 0))
        x += part.width + GAP
    content = BytesIO()
    whole.save(content, "PNG", optimize=True)
    return content.getvalue()


if __name__ == "__main__":
    run(main)
