"""The check of random URDFs: it holds, means something, and finds what is wrong."""

from __future__ import annotations

from collections import Counter
from xml.etree import ElementTree

import pinocchio as pin
import pytest

from humanoid_rail import InvalidInput
from validation import check_urdfs
from validation.check_urdfs import LOADED, main, outcome
from validation.random_urdfs import random_urdf, spoils
from validation.written_bodies import Written, written_bodies

SEED, COUNT = 2020, 400


def test_urdfs_load_whole_or_are_refused() -> None:
    found = Counter(outcome(random_urdf(SEED, index)) for index in range(COUNT))
    # Enough of both for the check to mean something, and refused for many reasons.
    assert 0.2 < found[LOADED] / COUNT < 0.6
    assert len(found) > 100


def test_urdfs_that_are_not_spoiled_load(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("validation.random_urdfs.spoils", (lambda rng, root: None,))
    texts = [random_urdf(SEED, index) for index in range(60)]
    whole = [text for text in texts if _is_plain(text)]
    assert len(whole) > 45
    assert {outcome(text) for text in whole} == {LOADED}
    bodies = [body for text in whole for body in written_bodies(text)]
    assert {body.kind for body in bodies} == {"sphere", "box", "cylinder", "capsule"}
    assert len(spoils) > 5


def _is_plain(text: str) -> bool:
    try:
        ElementTree.fromstring(text)
    except ElementTree.ParseError:
        return False
    return "ENTITY" not in text


def test_urdfs_depend_on_their_number_alone() -> None:
    assert random_urdf(SEED, 7) == random_urdf(SEED, 7) != random_urdf(SEED, 8)


def test_bodies_are_counted_where_they_are_written() -> None:
    text = """<robot name="r"><gazebo><collision/></gazebo><link name="a"><x:Collision/>
      <collision name="c"><origin xyz="1 2 3"/><geometry><cylinder radius="0.1" length="2"/></geometry></collision>
      <collision><geometry><cylinder radius="0.1" length="2"/></geometry></collision>
      <collision_checking><capsule name="c"/></collision_checking></link></robot>"""
    assert written_bodies(text) == [
        Written("a", "capsule", (0.1, 2.0), (1.0, 2.0, 3.0)),
        Written("a", "cylinder", (0.1, 2.0), (0.0, 0.0, 0.0)),
        Written("a", "nothing", (), (0.0, 0.0, 0.0)),
    ]


@pytest.mark.parametrize("wrong", ["lost", "raw", "no"])
def test_the_exit_code_says_whether_all_hold(
    wrong: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With the library as it is, with one that loses a body, and with one that raises what it likes."""
    if wrong != "no":
        build = check_urdfs.robot_from_urdf

        def other(*arguments: object) -> object:
            if wrong == "raw":
                raise RuntimeError("raw")
            robot = build(*arguments)  # type: ignore[arg-type]
            bodies: pin.GeometryModel = robot.collision_model
            bodies.removeGeometryObject(bodies.geometryObjects[0].name)
            return robot

        monkeypatch.setattr(check_urdfs, "robot_from_urdf", other)
    assert main.main(["--urdfs", "10", "--seed", str(SEED)], standalone_mode=False) == int(wrong != "no")
    out = capsys.readouterr().out
    assert ("hold of 10 URDFs out of 10" in out) == (wrong == "no")
    assert ("AssertionError" in out) == (wrong == "lost")
    assert ("RuntimeError" in out) == (wrong == "raw")


@pytest.mark.parametrize("options", [["--urdfs", "0"], ["--first", "-1"], ["--seed", "-1"]])
def test_bad_options_are_refused(options: list[str]) -> None:
    with pytest.raises(InvalidInput, match=options[0][2:]):
        main.main(options, standalone_mode=False)
