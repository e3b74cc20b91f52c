"""The line between the nearest points of the closest bodies, which the page's script puts in place."""

from __future__ import annotations

from typing import Any

import meshcat
import meshcat.geometry as mg
import numpy as np

from humanoid_rail.viewer.colours import CLOSEST_COLOUR

_ENDS = ("one", "two")
"""Nodes of the spheres at the nearest points."""


class _OnTop(mg.Mesh):  # type: ignore[misc]  # meshcat has no types
    """A mesh of one colour that is seen through everything else."""

    def __init__(self, geometry: mg.Geometry, colour: int, order: int) -> None:
        super().__init__(geometry, mg.MeshBasicMaterial(color=colour, transparent=True, depthTest=False))
        self._order = order

    def lower(self) -> dict[str, Any]:
        data: dict[str, Any] = super().lower()
        data["object"]["renderOrder"] = self._order
        return data


def draw_connection(view: meshcat.Visualizer, emphasised: bool, scale: float = 1.0) -> None:
    """Draw a line of length 1 along y and two spheres for its ends, at the origin.

    They are seen through bodies, or else they would be hidden where it matters: where two touch. An emphasised one is
    thicker and outlined in white, so that it is seen in front of what is dark.

    Args:
        view: The node to draw into.
        emphasised: Whether it is the one that matters.
        scale: Thickness and spheres are as much larger than for the paper's robot.
    """
    line, sphere = scale * np.array([0.008, 0.025] if emphasised else [0.005, 0.016])
    layers = [(0.008 * scale, 0xFFFFFF)] if emphasised else []
    for order, (outline, colour) in enumerate([*layers, (0.0, CLOSEST_COLOUR)], start=1):
        view[f"line/{order}"].set_object(_OnTop(mg.Cylinder(1.0, line + outline), colour, order))
        for end in _ENDS:
            view[f"{end}/{order}"].set_object(_OnTop(mg.Sphere(sphere + outline), colour, order))
