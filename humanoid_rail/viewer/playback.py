"""Playing a motion back: as a page in one file, or in a browser until interrupted."""

from __future__ import annotations

import signal
import threading
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import TYPE_CHECKING

from humanoid_rail._signals import END_ASKED
from humanoid_rail.errors import EngineMissing

# meshcat, SciPy and what draws with them are imported where they are used: the command line imports this module first.
if TYPE_CHECKING:
    from humanoid_rail.model.robot import Robot
    from humanoid_rail.scene.scene import Scene
    from humanoid_rail.trajectory import Trajectory
    from humanoid_rail.viewer.closest_pairs import ClosestPairs


def playback_html(robot: Robot, scene: Scene, trajectory: Trajectory) -> str:
    """Return a page that plays a motion back: one self-contained file, no server needed.

    Without the native engine it does not show which bodies are closest.

    Args:
        robot: The robot.
        scene: The scene the motion was planned in.
        trajectory: The motion.
    """
    import meshcat

    from humanoid_rail.viewer.caption import caption
    from humanoid_rail.viewer.closest_pairs import closest_of_all
    from humanoid_rail.viewer.page import CommandList, page_html
    from humanoid_rail.viewer.view import fill_view

    pairs, drawn = _closest_pairs(robot, scene, trajectory), CommandList()
    fill_view(meshcat.Visualizer(window=drawn), robot, scene, trajectory, pairs)
    said = caption(scene.name, trajectory, pairs, closest_of_all(robot, scene, trajectory, pairs))
    return page_html(f"{scene.name}: humanoid_rail", said, drawn)


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
        HumanoidRailError: If meshcat's server does not start.
    """
    from humanoid_rail.viewer.server import meshcat_server
    from humanoid_rail.viewer.view import fill_view

    with _interruptible(), suppress(KeyboardInterrupt), meshcat_server() as view:
        fill_view(view, robot, scene, trajectory, _closest_pairs(robot, scene, trajectory))
        on_ready(view.url())
        if open_browser:
            webbrowser.open(view.url(), new=2)
        while not END_ASKED.wait(0.5):
            pass


def _closest_pairs(robot: Robot, scene: Scene, trajectory: Trajectory) -> ClosestPairs:
    """Return the closest pairs at each frame of the animation; none without the native engine, which finds them."""
    from humanoid_rail.viewer.closest_pairs import ClosestPairs, closest_pairs
    from humanoid_rail.viewer.frames import frame_times

    try:
        return closest_pairs(robot, scene, trajectory, frame_times(trajectory))
    except EngineMissing:
        return ClosestPairs()


@contextmanager
def _interruptible() -> Iterator[None]:
    """Let INT, TERM and HUP raise KeyboardInterrupt, INT also where a shell has it ignored, as for background jobs."""

    def interrupt(_signal: int, _frame: FrameType | None) -> None:
        END_ASKED.set()
        raise KeyboardInterrupt

    signals = {signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)}
    if threading.current_thread() is not threading.main_thread():
        signals = set()  # Python lets only the main thread handle them
    before = {s: signal.signal(s, interrupt) for s in signals}
    try:
        yield
    finally:
        END_ASKED.clear()
        for s, handler in before.items():
            signal.signal(s, handler)
