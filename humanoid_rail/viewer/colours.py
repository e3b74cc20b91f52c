"""The colours of hands, the same in every picture."""

from __future__ import annotations

import numpy as np

from humanoid_rail._arrays import Array

HANDS = (0x1F70CC, 0xE86B1A, 0x2E9E5B, 0x8E44AD)
"""Of each hand in turn, red, green and blue in a byte each."""


def hand_colour(i: int) -> int:
    """Return the colour of the i-th hand of a robot."""
    return HANDS[i % len(HANDS)]


def rgb(colour: int) -> Array:
    """Return red, green and blue (3,), from 0 to 1."""
    return np.array([colour >> 16 & 0xFF, colour >> 8 & 0xFF, colour & 0xFF]) / 255.0
