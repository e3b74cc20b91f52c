"""Where the optimisation begins: a spline along a path."""

from __future__ import annotations

import numpy as np

from humanoid_rail._arrays import Array


def along(path: Array, rise: float, degree: int, intervals: int) -> Array:
    """Return control points (M + d, m) on a path, as a motion that rises to a speed, keeps it and falls would pass it.

    Args:
        path: Points (K, m), s, not all the same.
        rise: How long a joint needs to come to its speed limit, s.
        degree: d.
        intervals: M.
    """
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    end, count = float(s[-1]), intervals + degree
    # At full speed the path takes as many seconds as it is long.
    duration = end + rise if end > rise else 2.0 * float(np.sqrt(end * rise))
    share = min(rise / duration, 0.5)
    at = np.clip((np.arange(count) - (degree - 1) / 2.0) / intervals, 0.0, 1.0)
    before, after = np.minimum(at, share), np.minimum(1.0 - at, share)
    # The integral of a trapezoid of height 1 / (1 - share).
    rising, falling = before**2 / (2.0 * share), after**2 / (2.0 * share)
    progress = np.where(at > 1.0 - share, 1.0 - falling / (1.0 - share), (rising + at - before) / (1.0 - share))
    control = np.column_stack([np.interp(progress * end, s, column) for column in path.T])
    control[:degree], control[-degree:] = path[0], path[-1]
    return control
