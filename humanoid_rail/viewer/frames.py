"""When the frames of the animation are."""

from __future__ import annotations

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.trajectory import Trajectory

FRAMES_PER_SECOND = 30
"""The animation has this many frames a second."""
HOLD = 1.5
"""How long the view rests on the last configuration before the animation starts over, s."""


def frame_times(trajectory: Trajectory) -> Array:
    """Return the time in the motion of each frame of the animation (F,), s: at the end all rests."""
    frames = int(np.ceil((trajectory.duration + HOLD) * FRAMES_PER_SECOND)) + 1
    return np.minimum(np.arange(frames) / FRAMES_PER_SECOND, trajectory.duration)
