"""Playing motions back: as a page in one file, or in a browser until interrupted."""

from __future__ import annotations

import webbrowser
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

from humanoid_rail._signals import END_ASKED, interruptible
from humanoid_rail.errors import InvalidInput

# meshcat, SciPy and what draws with them are imported where they are used: the command line imports this module first.
if TYPE_CHECKING:
    from humanoid_rail.model.robot import Robot
    from humanoid_rail.scene.scene import Scene
    from humanoid_rail.trajectory import Trajectory

SCRIPTS = (
    "kinematics.js",
    "arrays.js",
    "clock.js",
    "stage.js",
    "camera.js",
    "figure.js",
    "obstacles.js",
    "labels.js",
    "miss.js",
    "plots.js",
    "timeline.js",
    "keys.js",
    "playback.js",
)
"""The scripts of the page in `web/`; each of them has one job."""


def playback_html(robot: Robot, scene: Scene, trajectory: Trajectory) -> str:
    """Return a page that plays a motion back: one self-contained file, no server needed.

    Without the native engine it does not show which bodies are closest.

    Args:
        robot: The robot.
        scene: The scene the motion was planned in.
        trajectory: The motion.

    Raises:
        InvalidInput: If the motion was planned among other obstacles: what the page says of it would not be true.
    """
    return motions_html(robot, [(scene.name, scene, trajectory)])


def motions_html(robot: Robot, motions: Sequence[tuple[str, Scene, Trajectory]]) -> str:
    """Return a page that plays one motion back, or two at the same time: the robot of the second one is translucent.

    Args:
        robot: The robot.
        motions: What each motion is called, the scene it was planned in, and the motion. The scene of the first one is
            drawn; the page says so where the second one has another.

    Raises:
        InvalidInput: If a motion was planned among other obstacles than those of the scene beside it.
    """
    import meshcat

    from humanoid_rail.viewer.camera import best_view
    from humanoid_rail.viewer.caption import caption, legend, other_scene
    from humanoid_rail.viewer.closest_pairs import closest_of_all
    from humanoid_rail.viewer.held_objects import draw_objects, objects_data
    from humanoid_rail.viewer.miss import draw_miss, miss_data, miss_panel
    from humanoid_rail.viewer.motion_data import motion_data, scene_data
    from humanoid_rail.viewer.page import CommandList, page_html
    from humanoid_rail.viewer.playback_body import playback_body
    from humanoid_rail.viewer.series import series
    from humanoid_rail.viewer.view import draw_motion, draw_scene, floor_height
    from humanoid_rail.viewer.visual_meshes import robot_visuals

    for _, own, trajectory in motions:
        _check_obstacles(own, trajectory)
    drawn, visuals = CommandList(), robot_visuals(robot)
    world = meshcat.Visualizer(window=drawn)["world"]
    _, scene, first = motions[0]
    draw_scene(world, robot, scene)
    view = best_view(robot, scene, *(trajectory for _, _, trajectory in motions))
    data = scene_data(robot, scene, view, floor_height(robot, scene, visuals))
    data["motions"], captions, panels = [], [], list[str]()
    for number, (name, own, trajectory) in enumerate(motions):
        found = series(robot, own, trajectory)
        draw_motion(world[f"motion{number}"], robot, visuals, trajectory, found.pairs, is_second=number > 0)
        draw_objects(world[f"motion{number}/objects"], own)
        draw_miss(world[f"motion{number}/miss"], robot, own, visuals, trajectory)
        data["motions"].append({**motion_data(name, trajectory, found), "miss": miss_data(trajectory.diagnosis)})
        data["motions"][-1]["objects"] = objects_data(robot, own, trajectory)
        if trajectory.diagnosis is not None:
            heading = "Why it failed" if len(motions) == 1 else name
            panels.append(miss_panel(heading, trajectory.reason, trajectory.diagnosis))
        captions.append(
            caption(
                name,
                trajectory,
                closest_of_all(robot, own, trajectory, found.pairs),
                mark=f'<span class="mark mark{number}"></span>' if len(motions) > 1 else "",
                note=other_scene(scene, own),
            )
        )
    title = f"{', '.join(name for name, _, _ in motions)}: humanoid_rail"
    body = playback_body("".join(captions), legend(first), "".join(panels), data)
    return page_html(title, body, drawn, data, style="playback.css", scripts=SCRIPTS)


def _check_obstacles(scene: Scene, trajectory: Trajectory) -> None:
    planned = trajectory.scene
    if planned is not None and planned.obstacles != scene.obstacles:
        valid = f"{planned.name!r} with the obstacles among which the motion was planned (trajectory.scene)"
        raise InvalidInput("scene", scene.name, f"{valid}: its certificate and clearances are about these")


def show(
    robot: Robot,
    scene: Scene,
    trajectory: Trajectory,
    *,
    open_browser: bool = True,
    on_ready: Callable[[str], None] = lambda url: None,
) -> None:
    """Play a motion back in a browser until interrupted (Ctrl-C, or the signals TERM and HUP).

    Args:
        robot: The robot.
        scene: The scene the motion was planned in.
        trajectory: The motion.
        open_browser: Whether to open the page in the user's browser.
        on_ready: Called with the URL of the page once it is served.

    Raises:
        InvalidInput: If the motion was planned among other obstacles.
        HumanoidRailError: If no port can be served.
    """
    with interruptible(), suppress(KeyboardInterrupt):
        show_page(playback_html(robot, scene, trajectory), open_browser=open_browser, on_ready=on_ready)


def show_page(page: str, *, open_browser: bool = True, on_ready: Callable[[str], None] = lambda url: None) -> None:
    """Serve a page to browsers on this machine until interrupted, as :func:`show` does.

    Args:
        page: The page, as HTML.
        open_browser: Whether to open the page in the user's browser.
        on_ready: Called with the URL of the page once it is served.

    Raises:
        HumanoidRailError: If no port can be served.
    """
    from humanoid_rail.viewer.server import served

    with interruptible(), suppress(KeyboardInterrupt), served(page) as url:
        on_ready(url)
        if open_browser:
            webbrowser.open(url, new=2)
        while not END_ASKED.wait(0.5):
            pass
