"""The arrays of this package: double precision, read-only where they are kept."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def frozen(values: ArrayLike) -> Array:
    """Return a read-only copy."""
    array = np.array(values, float)
    array.flags.writeable = False
    return array
