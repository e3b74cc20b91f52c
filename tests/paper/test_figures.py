"""The figure of a motion, of the paper's robot and of others: nothing is cut off, and signs are explained."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import package_robot, plan
from matplotlib.backends.backend_agg import FigureCanvasAgg

from humanoid_rail import Box, Kinematics, Robot, Scene, plan_case
from humanoid_rail.paper.figures import _faces, motion_figure
from humanoid_rail.scene.shapes import placed_shapes
from humanoid_rail.viewer.sizes import bounds


def lines_of(figure: object) -> list[np.ndarray]:
    (axes,) = figure.axes
    return [np.array(line.get_data_3d()).T for line in axes.lines]


def test_links_of_the_papers_robot_are_its_bones(robot: Robot, scene: Scene) -> None:
    trajectory = plan_case(robot, 3, dt=0.1)
    lines = lines_of(motion_figure(robot, scene, trajectory, "case 3"))
    np.testing.assert_allclose(lines[: len(robot.link_names)], Kinematics(robot).bones(robot.initial))


def test_links_of_other_robots_are_lines_from_joint_to_joint_and_hand() -> None:
    robot = package_robot("example-robot-data:panda")
    (name,) = robot.hand_names
    box = Box(center=(0.5, 0.0, 0.1), size=(0.2, 0.3, 0.1))
    scene = Scene(name="over a box", targets={name: (0.5, 0.1, 0.4)}, obstacles=(box,))
    trajectory = plan(robot, scene)
    figure = motion_figure(robot, scene, trajectory, "over a box")
    lines = lines_of(figure)
    kinematics = Kinematics(robot)
    at, size = trajectory.configuration(trajectory.duration), robot.model.njoints - 1
    first, last = lines[:size], lines[6 * size : 7 * size]
    np.testing.assert_allclose(first[-1][1], kinematics.hand_positions(trajectory.q[0])[0])
    np.testing.assert_allclose(last[-1][1], kinematics.hand_positions(at)[0])
    np.testing.assert_allclose([a[1] for a in last[:-1]], kinematics.stick_figure(at)[1:size])
    np.testing.assert_allclose([line[1] for line in last[:-1]], [line[0] for line in last[1:]])
    assert len(figure.axes[0].collections) == 2, "the box and the target"


@pytest.mark.parametrize("rpy", [(0.0, 0.0, 0.0), (0.3, -1.0, 2.0)])
def test_faces_of_a_box_are_those_of_coals(rpy: tuple[float, float, float]) -> None:
    box = Box(center=(1.0, 2.0, 3.0), size=(0.2, 0.4, 0.6), rpy=rpy)
    faces, (placed,) = _faces(box), placed_shapes(box)
    np.testing.assert_allclose([faces.min(axis=(0, 1)), faces.max(axis=(0, 1))], bounds(placed), atol=1e-12)
    corners, times = np.unique(faces.reshape(-1, 3).round(9), axis=0, return_counts=True)
    assert (len(corners), set(times)) == (8, {3})
    one, two, three = faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 1], faces[:, 3] - faces[:, 0]
    np.testing.assert_allclose(two, three, atol=1e-12)
    assert np.linalg.norm(np.cross(one, two), axis=1).sum() == pytest.approx(2 * (0.08 + 0.12 + 0.24))


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
