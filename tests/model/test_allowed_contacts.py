"""What objects may touch, in words."""

from __future__ import annotations

from humanoid_rail.model.allowed_contacts import allowed_contacts, may_touch
from humanoid_rail.model.attached import MAY_TOUCH
from humanoid_rail.model.pairs import NO_JOINT, UncheckedPair


def test_contacts_are_told_by_object_and_time() -> None:
    pairs = [
        UncheckedPair("palm", "part", f"{MAY_TOUCH}, 1 to 2 s"),
        UncheckedPair("finger", "part", f"{MAY_TOUCH}, 1 to 2 s"),
        UncheckedPair("part", "table", f"{MAY_TOUCH}, 3 to 4 s"),
        UncheckedPair("forearm", "part", NO_JOINT),
    ]
    assert [may_touch(pair) for pair in pairs] == [True, True, True, False]
    assert allowed_contacts(pairs, {"part"}) == ("part with palm and finger, 1 to 2 s", "part with table, 3 to 4 s")


def test_contacts_of_a_whole_motion_have_no_time() -> None:
    assert allowed_contacts([UncheckedPair("palm", "part", MAY_TOUCH)], {"part"}) == ("part with palm",)
