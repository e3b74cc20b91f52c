"""The arrays of this package: double precision, read-only where they are kept."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

FARTHEST = 1e4
"""Beyond this distance double precision no longer resolves the clearances that matter to a robot, m."""


def frozen(values: ArrayLike) -> Array:
    """Return a read-only copy."""
    array = np.array(values, float)
    array.flags.writeable = False
    return array


def triple(vector: Array) -> tuple[float, float, float]:
    """Return a vector (3,) as a tuple."""
    x, y, z = vector.tolist()
    return x, y, z


class FrozenArrays:
    """Base of frozen dataclasses whose arrays stay read-only when they are copied or pickled."""

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        for name, value in state.items():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False
            object.__setattr__(self, name, value)
