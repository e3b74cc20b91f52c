"""Certificates of the parts of a motion as one."""

from __future__ import annotations

from dataclasses import replace

from humanoid_rail import Certificate, Contact
from humanoid_rail.collision.certificate import combined
from humanoid_rail.model.pairs import UncheckedPair

FREE = Certificate(True, 0.3, 0.2, 0.1999, None)
PAIR = UncheckedPair("a", "b", "they may touch there")


def touching(t: float) -> Certificate:
    return Certificate(False, -0.01, 0.4, -0.0101, Contact(t, "a", "b", (0.0, 0.0, 0.0)))


def test_one_part_is_the_whole() -> None:
    assert combined([FREE]) is FREE


def test_the_whole_is_certified_if_all_parts_are() -> None:
    assert combined([FREE, FREE]).certified
    assert not combined([FREE, touching(1.0), FREE]).certified


def test_the_first_contact_and_the_smallest_distances_count() -> None:
    whole = combined([FREE, touching(2.0), touching(1.0)])
    assert whole.contact is not None
    assert whole.contact.t == 1.0
    assert (whole.min_clearance_obstacles, whole.min_clearance_self, whole.clearance_bound) == (-0.01, 0.2, -0.0101)


def test_parts_with_nothing_to_touch_do_not_count() -> None:
    nothing = Certificate(True, None, None, None, None)
    assert combined([nothing, FREE]).clearance_bound == FREE.clearance_bound
    assert combined([nothing, nothing]).clearance_bound is None


def test_where_one_part_was_not_looked_at_nothing_is_bounded() -> None:
    stopped = replace(FREE, certified=False, clearance_bound=None, reason="budget used up")
    whole = combined([FREE, stopped])
    assert (whole.certified, whole.clearance_bound, whole.reason) == (False, None, "budget used up")


def test_pairs_that_were_left_out_anywhere_are_named_once() -> None:
    parts = [replace(FREE, unchecked_pairs=(PAIR,)), FREE, replace(FREE, unchecked_pairs=(PAIR,))]
    assert combined(parts).unchecked_pairs == (PAIR,)
