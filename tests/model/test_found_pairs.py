"""Which pairs of any robot are checked, and how far apart those that are always near are kept."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from arms import ball, box, fixed, long_arm

from humanoid_rail import InvalidInput, Robot, Safety, load_robot
from humanoid_rail.collision.edge_checker import EdgeChecker
from humanoid_rail.model.building import read_mechanism
from humanoid_rail.model.collision_bodies import collision_bodies
from humanoid_rail.model.found_pairs import KEPT, FoundPairs, find_pairs
from humanoid_rail.model.robot_file import PairsEntry
from humanoid_rail.model.survey import ALWAYS_NEAR, POSTURES, Survey

POST = fixed("stand", "base", "post", "0.1 0.1 0", box(0.05, 0.03))
"""In the way of l0 at j0 = 0.8 rad."""


def why(robot: Robot) -> dict[frozenset[str], str]:
    return {frozenset((pair.link, pair.other)): pair.why for pair in robot.left_out}


def test_what_is_fixed_to_the_base_is_checked_against_the_first_link() -> None:
    robot = load_robot(long_arm(links={"base": box(0.02, 0.05)}, more=POST))
    left_out = why(robot)
    assert frozenset(("l0", "post")) not in left_out
    assert left_out[frozenset(("base", "post"))] == "no joint moves them relative to each other"
    assert left_out[frozenset(("base", "l0"))].startswith("neighbours at the joint j0; they touch in 100% of 400 ")
    q = np.zeros(6)
    assert EdgeChecker(robot, (), 0.001).is_valid(q)
    q[0] = 0.8
    assert not EdgeChecker(robot, (), 0.001).is_valid(q)


def test_neighbours_over_links_without_bodies_are_neighbours() -> None:
    robot = load_robot(long_arm(links={"l1": "", "l2": ""}))
    left_out = why(robot)
    assert left_out[frozenset(("l0", "l3"))].startswith("neighbours at the joints j1, j2, j3; ")
    assert set(left_out) == {frozenset(pair) for pair in (("l0", "l3"), ("l3", "l4"), ("l4", "l5"))}


def test_links_on_a_common_parent_without_a_body_are_no_neighbours() -> None:
    other = (
        '<link name="twin">' + box(0.2, 0.02) + '</link><joint name="k" type="revolute"><parent link="base"/>'
        '<child link="twin"/><origin xyz="0 0.3 0"/><axis xyz="0 0 1"/>'
        '<limit lower="-1.5" upper="1.5" velocity="2" effort="9"/></joint>'
    )
    robot = load_robot(
        long_arm(more=other), hands={"hand": {"frame": "l5"}}, joints=[*(f"j{i}" for i in range(6)), "k"]
    )
    assert frozenset(("l0", "twin")) not in why(robot)


def test_a_pair_that_always_touches_is_left_out() -> None:
    inside = fixed("in", "l2", "extra", "0 0 0", ball(0.5))
    left_out = why(load_robot(long_arm(more=inside), hands={"hand": {"frame": "l5"}}))
    assert left_out[frozenset(("l1", "extra"))] == "they touch in 100% of 400 random postures; not checked anywhere"


def test_links_that_leave_no_start_free_are_named() -> None:
    """l0 can get away from each of two balls, but is then at the other one."""
    spots = {"one": -0.7, "two": 0.7}
    balls = "".join(
        fixed(f"{name}_stand", "base", name, f"{0.12 * np.cos(at)} {0.12 * np.sin(at)} 0", ball(0.085))
        for name, at in spots.items()
    )
    urdf = long_arm(joints={"j0": 'lower="-0.8" upper="0.8" velocity="1"'}, more=balls)
    with pytest.raises(InvalidInput, match=r"initial .*none is free.*l0 and (one|two) in \d\d%.*pairs\.left_out"):
        load_robot(urdf)
    pairs = [("one", "l0"), ("two", "l0")]
    freed = why(load_robot(urdf, pairs={"left_out": [{"links": pair, "why": "as it is built"} for pair in pairs]}))
    assert freed[frozenset(("l0", "one"))].startswith("as it is built; they touch in ")
    assert freed[frozenset(("l0", "l1"))].startswith("neighbours at the joint j1")


def test_pairs_that_are_complete_are_all_there_are() -> None:
    given = {"left_out": [{"links": ["l0", "l1"]}], "complete": True}
    srdf = '<robot name="long"><disable_collisions link1="l2" link2="l4"/></robot>'
    urdf = long_arm(links={f"l{i}": ball(0.01) for i in range(6)})
    with pytest.warns(UserWarning, match=r"pairs\.complete.*SRDF"):
        robot = load_robot(urdf, srdf=srdf, pairs=given)
    assert set(why(robot)) == {frozenset(("l0", "l1"))}
    added = why(load_robot(urdf, srdf=srdf, pairs={"left_out": given["left_out"]}))
    assert {frozenset(("l0", "l1")), frozenset(("l2", "l4")), frozenset(("l4", "l5"))} < set(added)


def found(
    distances: list[list[float]], links: dict[str, str] | None = None
) -> tuple[FoundPairs, list[tuple[int, int]]]:
    """Return what is found of l0's bodies and l2's where their distances are as given in all random postures."""
    mechanism = read_mechanism(long_arm(links=links))
    bodies = collision_bodies(mechanism.model, mechanism.urdf, {})
    names = [mechanism.model.frames[body.parentFrame].name for body in bodies.geometryObjects]
    of = {link: [i for i, name in enumerate(names) if name == link] for link in ("l0", "l2")}
    pairs = [(i, j) for i in of["l0"] for j in of["l2"]]
    rows = np.resize(np.array(distances), (POSTURES, len(pairs)))
    seen = Survey(np.zeros((POSTURES, 6)), tuple(pairs), rows)
    return find_pairs(mechanism.model, bodies, mechanism.urdf, None, seen, PairsEntry()), pairs


@pytest.mark.parametrize(
    ("distances", "kept"),
    [
        ([[0.004], [0.009]], KEPT),
        ([[0.0008], [0.009]], 0.0004),  # half the least, as they never touch
        ([[0.0], [0.00009], [0.009]], KEPT),  # they do, so the least that is positive says nothing
        ([[0.0], [0.0005]], 0.00025),  # less than there ever is
        ([[0.004], [0.0141]], None),  # not always nearer than the safety distance
        ([[0.004], [np.inf]], None),
    ],
)
def test_what_is_always_near_is_kept_at_a_distance_that_it_can_have(distances: list[list[float]], kept: float) -> None:
    pairs, [pair] = found(distances)
    assert pairs.distances == ({} if kept is None else {pair: pytest.approx(kept)})
    assert not pairs.left_out
    assert Safety().safety_distance == ALWAYS_NEAR


def test_a_distance_is_that_of_two_bodies_not_of_their_links() -> None:
    two = {"l0": ball(0.01) + ball(0.05), "l2": ball(0.01) + ball(0.05)}
    pairs, [near, *_] = found([[0.005, np.inf, np.inf, np.inf]], two)
    assert pairs.distances == {near: KEPT}


def test_distances_of_bodies_are_given_and_saved(tmp_path: Path) -> None:
    two = {"l0": ball(0.01) + ball(0.02), "l2": ball(0.01) + ball(0.02)}
    given = {"complete": True, "distances": [{"links": ["l2", "l0"], "bodies": [1, 0], "distance": 0.003}]}
    more = {"links": ["l0", "l3"], "distance": 0.004}
    given["distances"].append(more)  # type: ignore[attr-defined]
    urdf = long_arm(links=two | {f"l{i}": ball(0.01) for i in (1, 3, 4, 5)})
    robot = load_robot(urdf, pairs=given)
    bodies = [body.name for body in robot.collision_model.geometryObjects]
    named = {(bodies[i], bodies[j]): apart for (i, j), apart in robot.pair_distances.items()}
    assert named == {("l0_0", "l2_1"): 0.003, ("l0_0", "l3_0"): 0.004, ("l0_1", "l3_0"): 0.004}
    robot.save(tmp_path)
    assert load_robot(tmp_path).pair_distances == robot.pair_distances
    given["distances"] = [{"links": ["l2", "l0"], "bodies": [2, 0], "distance": 0.003}]
    with pytest.raises(InvalidInput, match=r"pairs\.bodies is 2.*less than 2, the bodies of l2"):
        load_robot(urdf, pairs=given)


def test_a_pair_of_links_is_said_once() -> None:
    two = {"l0": box(0.2, 0.02) + ball(0.02), "l1": box(0.2, 0.02) + ball(0.02)}
    pairs = [frozenset((pair.link, pair.other)) for pair in load_robot(long_arm(links=two)).left_out]
    assert len(set(pairs)) == len(pairs) == 5
