"""What a step keeps: how it is written, and one clear line for what is not right."""

from __future__ import annotations

from typing import Any

import pytest

from humanoid_rail import InvalidInput, Robot, make_scene, plan


def scene(keep: Any) -> Any:
    return make_scene({"name": "kept", "targets": {"left": [-1.0, -1.2, 3.2], "right": None, "keep": keep}})


@pytest.mark.parametrize(
    ("keep", "said"),
    [
        ([{"uprigt": "left"}], "targets.keep[0].uprigt is 'left'; valid: one of upright.*did you mean upright"),
        ([{"upright": "left", "point": "right"}], "each in an entry of its own"),
        ([{}], "each in an entry of its own"),
        ([{"distance": ["left", "left"]}], "two hands, not one twice"),
        ([{"relative": {"hands": ["left", "right"], "what": "pos"}}], "keep[0].relative.what is 'pos'"),
        ([{"upright": {"hand": "left", "axis": [0, 0, 0]}}], "keep[0].upright.axis"),
        (3, "targets.keep is 3; valid: a list"),
    ],
)
def test_what_makes_no_sense_is_refused(keep: Any, said: str) -> None:
    with pytest.raises(InvalidInput, match=said.replace("[", r"\[").replace("]", r"\]")):
        scene(keep)


def test_a_hand_has_to_be_one_of_the_robot(robot: Robot) -> None:
    with pytest.raises(InvalidInput, match=r"targets.keep\[0\] is 'lfet'.*did you mean left"):
        plan(robot, scene([{"upright": "lfet"}]))


def test_an_axis_that_is_not_upright_at_the_start_is_named(robot: Robot) -> None:
    with pytest.raises(InvalidInput, match=r"constraints\[0\].*the direction of the hand left is .* m off there"):
        plan(robot, scene({"upright": {"hand": "left", "axis": [1, 0, 0]}}))


def test_one_thing_need_not_be_a_list() -> None:
    assert scene({"upright": "left"}).steps[0].keep == scene([{"upright": {"hand": "left"}}]).steps[0].keep
