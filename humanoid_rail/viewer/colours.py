"""The colours of the pictures: of hands, the same everywhere, and of clearances."""

from __future__ import annotations

import numpy as np

from humanoid_rail._arrays import Array

HANDS = (0x1F70CC, 0xE86B1A, 0x2E9E5B, 0x8E44AD)
"""The colour of each hand in turn; here as everywhere a byte each of red, green and blue."""
CLEARANCE_SCALE = ((0.0, 0xD7191C), (0.1, 0xF07F1B), (0.25, 0xEFBF1D), (0.5, 0x6F9DBF))
"""Colours by clearance in m, linear in between: red near contact, blue far from it.

Red, orange and yellow differ in lightness, and blue from them in hue, so that eyes that do not tell red from green can
read the scale too."""
PENETRATION_COLOUR = 0x4A0014
"""The colour where the clearance is negative."""
OBSTACLE_COLOURS = (0xA9BACB, 0xDCCBA6, 0xAFC4A8, 0xD3B0A6, 0xB9AECB, 0x9FC0C0, 0xC9C2B4)
"""Obstacles have these colours in turn, but for half-spaces: calm ones, beside which the robot stands out."""
WALL_COLOUR = 0x7C8792
"""Half-spaces, which fill much of a picture, have this colour."""
PLAIN = (0.7, 0.7, 0.7, 1.0)
"""Bodies of a robot without a colour of their own have this one, red, green, blue and opacity from 0 to 1."""
CLOSEST_COLOUR = 0x11151C
"""The colour of the line between the closest bodies."""


def hand_colour(i: int) -> int:
    """Return the colour of the i-th hand of a robot."""
    return HANDS[i % len(HANDS)]


def rgb(colour: int) -> Array:
    """Return red, green and blue (3,), from 0 to 1."""
    return np.array([colour >> 16 & 0xFF, colour >> 8 & 0xFF, colour & 0xFF]) / 255.0


def colour_of(rgb: Array) -> int:
    """Return a colour of red, green and blue, the first of some numbers from 0 to 1; those beyond count as 0 or 1."""
    red, green, blue = (255 * np.clip(rgb[:3], 0, 1)).round().astype(int).tolist()
    return int(red) << 16 | int(green) << 8 | int(blue)


def clearance_colours(clearance: Array) -> Array:
    """Return the colours (..., 3) of clearances (...) in m: red, green and blue from 0 to 1."""
    at, colours = [x for x, _ in CLEARANCE_SCALE], np.array([rgb(colour) for _, colour in CLEARANCE_SCALE])
    scaled = np.stack([np.interp(clearance, at, channel) for channel in colours.T], axis=-1)
    return np.where((clearance < 0)[..., None], rgb(PENETRATION_COLOUR), scaled)
