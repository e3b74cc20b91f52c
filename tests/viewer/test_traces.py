"""The traces of the hands on the playback page, coloured by clearance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from conftest import plan
from pages import page_data, rgb, trace

from humanoid_rail import Kinematics, Robot, Scene, plan_case
from humanoid_rail.viewer.colours import CLEARANCE_SCALE as SCALE
from humanoid_rail.viewer.colours import PENETRATION_COLOUR
from humanoid_rail.viewer.playback import playback_html


def test_traces_show_the_clearance(robot: Robot, scene: Scene) -> None:
    trajectory = plan_case(robot, 1)  # from afar into a sphere
    clearance = trajectory.clearance.min(axis=1)
    page = playback_html(robot, scene, trajectory)
    for i, hand in enumerate(trajectory.hand_names):
        beads, colours = trace(page, hand)
        sample = np.linalg.norm(beads[:, None] - trajectory.hands[None, :, i], axis=2).argmin(axis=1)
        inside, far, near = clearance[sample] < -0.02, clearance[sample] > 0.52, abs(clearance[sample] - 0.05) < 0.02
        assert min(inside.sum(), far.sum(), near.sum()) > 3
        np.testing.assert_allclose(colours[inside], np.tile(rgb(PENETRATION_COLOUR), (inside.sum(), 1)), atol=0.1)
        np.testing.assert_allclose(colours[far], np.tile(rgb(SCALE[-1][1]), (far.sum(), 1)), atol=0.1)
        red, green, blue = colours[near].T
        assert (red > 200).all()
        assert (green < 140).all()
        assert (blue < 60).all()


def test_colours_of_clearances_differ_in_lightness() -> None:
    def lightness(colour: int) -> float:
        linear = (np.array(rgb(colour)) / 255) ** 2.2
        return float(116 * (linear @ [0.2126, 0.7152, 0.0722]) ** (1 / 3) - 16)

    contact, near, further, far = (lightness(colour) for _, colour in SCALE)
    assert lightness(PENETRATION_COLOUR) + 20 < contact
    assert contact + 10 < near < further - 10
    assert SCALE[0][0] == 0.0
    assert SCALE[-1][0] == 0.5
    assert far < 70, "it has to be seen on the light background"


def test_without_obstacles_traces_show_the_clearance_of_links(robot: Robot, scene: Scene) -> None:
    empty = scene.model_copy(update={"obstacles": ()})
    trajectory = plan(robot, empty)
    page = playback_html(robot, empty, trajectory)
    assert "clearance from other links" in page
    assert [*page_data(page)["motions"][0]["closest"]] == ["links"]
    links = Kinematics(robot).measure(trajectory.q[0]).self_clearance.min()
    share = (links - SCALE[2][0]) / (SCALE[3][0] - SCALE[2][0])
    assert 0 < share < 1
    expected = (1 - share) * np.array(rgb(SCALE[2][1])) + share * np.array(rgb(SCALE[3][1]))
    np.testing.assert_allclose(trace(page, "left")[1][0], expected, atol=0.5)

    bare = replace(robot, self_collision_pairs=())
    page = playback_html(bare, empty, plan(bare, empty))
    assert page_data(page)["motions"][0]["closest"] == {}
    assert page_data(page)["motions"][0]["clearance"] is None
    left, right = (trace(page, hand)[1] for hand in ("left", "right"))
    assert len(np.unique(left, axis=0)) == len(np.unique(right, axis=0)) == 1
    assert abs(left[0] - right[0]).max() > 50
