"""The arrays of this package: double precision, read-only where they are kept."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from humanoid_rail.errors import InvalidInput

Array = NDArray[np.float64]

FARTHEST = 1e4
"""Beyond this distance double precision no longer resolves the clearances that matter to a robot, m."""
SHORTEST = 1e-6
"""Vectors that are directions have at least this length, as their own unit."""


def frozen(values: ArrayLike) -> Array:
    """Return a read-only copy."""
    array = np.array(values, float)
    array.flags.writeable = False
    return array


def triple(vector: Array) -> tuple[float, float, float]:
    """Return a vector (3,) as a tuple."""
    x, y, z = vector.tolist()
    return x, y, z


def checked_array(
    field: str, value: object, shape: tuple[int, ...], valid: str | None = None, *, most: float = np.inf
) -> Array:
    """Return finite numbers of a shape, none of them larger in size than `most`.

    Args:
        field: What errors call them.
        value: What was given.
        shape: The shape that they have to have.
        valid: What errors call right; made of the shape if not given.
        most: The largest number.

    Raises:
        InvalidInput: If the value is anything else.
    """
    try:
        array: Array = np.asarray(value).astype(float, casting="same_kind")
    except (TypeError, ValueError):  # no numbers, complex ones, or rows of different lengths
        array = np.empty(0)
    if array.shape != shape or not np.isfinite(array).all() or (abs(array) > most).any():
        size = " x ".join(map(str, shape))
        bounds = f" from {-most:g} to {most:g}" if np.isfinite(most) else ""
        raise InvalidInput(field, value, valid or f"{size} finite numbers{bounds}")
    return array


class FrozenArrays:
    """Base of frozen dataclasses whose arrays stay read-only when they are copied or pickled."""

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        for name, value in state.items():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False
            object.__setattr__(self, name, value)
