"""Motions in notebooks: the page that plays one back, inside the notebook."""

from __future__ import annotations

import html
import tempfile
import webbrowser
from dataclasses import dataclass
from pathlib import Path

from humanoid_rail._files import write_file
from humanoid_rail.errors import check_kind
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.scene import Scene
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.viewer.playback import playback_html

HEIGHT = 640
"""A page in a notebook is so high unless another height is asked for, pixels."""


@dataclass(frozen=True, eq=False)
class Page:
    """A page that plays a motion back. A notebook shows it where it is the last value of a cell."""

    html: str
    """The page: one self-contained file, without network."""
    height: int = HEIGHT
    """How high a notebook shows it, pixels."""

    def __repr__(self) -> str:
        return f"Page({len(self.html)} characters; save it or open it)"

    def _repr_html_(self) -> str:
        """Return the page as a frame, which notebooks show."""
        style = f"width:100%;height:{self.height}px;border:0"
        return f'<iframe srcdoc="{html.escape(self.html)}" style="{style}" allowfullscreen></iframe>'

    def save(self, path: str | Path) -> Path:
        """Write the page to a file and return its path.

        Raises:
            InvalidInput: If it cannot be written.
        """
        return write_file(Path(path), self.html.encode())

    def open(self) -> Path:
        """Open the page in the browser, from a temporary file, and return its path. It does not wait for anything."""
        path = self.save(Path(tempfile.mkdtemp(prefix="humanoid_rail-")) / "playback.html")
        webbrowser.open(path.resolve().as_uri(), new=2)
        return path


def view(
    trajectory: Trajectory, robot: Robot | None = None, scene: Scene | None = None, *, height: int = HEIGHT
) -> Page:
    """Return a page that plays a motion back: in a notebook it is shown, elsewhere `view(...).open()` opens it.

    It is made at once, and nothing is served: the notebook goes on.

    Args:
        trajectory: The motion.
        robot: The robot; the one it was planned for if not given.
        scene: The scene; the one it was planned in if not given.
        height: How high a notebook shows it, pixels.

    Raises:
        InvalidInput: If robot or scene are not given and the trajectory does not know them, or the motion was planned
            among other obstacles than those of the scene that is given.
    """
    check_kind("trajectory", trajectory, Trajectory)
    return Page(playback_html(*trajectory.planned_for(robot, scene), trajectory), height)
