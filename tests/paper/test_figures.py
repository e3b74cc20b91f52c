"""The pictures of motions: nothing is cut off, and what lines and marks mean is said."""

from __future__ import annotations

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from humanoid_rail import Robot, Scene, plan_case
from humanoid_rail.paper.figures import motion_figure


@pytest.mark.parametrize("case", [1, 3])
def test_labels_are_inside_the_picture_and_the_legend_names_every_sign(robot: Robot, scene: Scene, case: int) -> None:
    figure = motion_figure(robot, scene, plan_case(robot, case, dt=0.05), "a case")
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    whole, (axes,) = figure.bbox, figure.axes
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        box = axis.label.get_window_extent(canvas.get_renderer())
        assert box.width > 0
        assert whole.x0 <= box.x0 < box.x1 <= whole.x1
        assert whole.y0 <= box.y0 < box.y1 <= whole.y1
    (legend,) = figure.legends
    said = [text.get_text() for text in legend.get_texts()]
    signs = ["start", "end", "between", "way of a hand", "target", "obstacle"]
    assert said == ["left arm", "right arm", *signs]
    drawn = {line.get_linestyle() for line in axes.lines}
    assert {line.get_linestyle() for line in legend.get_lines()[:4]} <= drawn
