"""Colours of obstacles, as scenes give them."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator

from humanoid_rail.errors import did_you_mean

COLORS = {
    "black": 0x000000,
    "white": 0xFFFFFF,
    "gray": 0x808080,
    "grey": 0x808080,
    "silver": 0xC0C0C0,
    "lightgray": 0xD3D3D3,
    "lightgrey": 0xD3D3D3,
    "darkgray": 0xA9A9A9,
    "darkgrey": 0xA9A9A9,
    "red": 0xFF0000,
    "darkred": 0x8B0000,
    "maroon": 0x800000,
    "tomato": 0xFF6347,
    "salmon": 0xFA8072,
    "pink": 0xFFC0CB,
    "orange": 0xFFA500,
    "gold": 0xFFD700,
    "yellow": 0xFFFF00,
    "beige": 0xF5F5DC,
    "tan": 0xD2B48C,
    "brown": 0xA52A2A,
    "olive": 0x808000,
    "lime": 0x00FF00,
    "green": 0x008000,
    "darkgreen": 0x006400,
    "lightgreen": 0x90EE90,
    "teal": 0x008080,
    "turquoise": 0x40E0D0,
    "cyan": 0x00FFFF,
    "lightblue": 0xADD8E6,
    "skyblue": 0x87CEEB,
    "steelblue": 0x4682B4,
    "blue": 0x0000FF,
    "navy": 0x000080,
    "indigo": 0x4B0082,
    "purple": 0x800080,
    "violet": 0xEE82EE,
    "magenta": 0xFF00FF,
}
"""The names of colours, which are those of CSS: a byte each of red, green and blue."""
_HEX = re.compile(r"#[0-9a-fA-F]{6}")


def _known(color: str) -> str:
    if color not in COLORS and not _HEX.fullmatch(color):
        near = did_you_mean(color.lower(), COLORS)
        raise ValueError(f'"#rrggbb" with six hexadecimal digits, or a name such as red, steelblue or gray{near}')
    return color


Color = Annotated[str, AfterValidator(_known)]
"""A name of :data:`COLORS`, or `#rrggbb`."""


def color_bytes(color: str) -> int:
    """Return a colour as a number: a byte each of red, green and blue."""
    return COLORS[color] if color in COLORS else int(color[1:], 16)
