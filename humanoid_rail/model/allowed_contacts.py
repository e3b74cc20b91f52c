"""What objects may touch along a motion, in words: the pairs that a certificate leaves out for that."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from humanoid_rail.model.attached import MAY_TOUCH
from humanoid_rail.model.pairs import UncheckedPair


def may_touch(pair: UncheckedPair) -> bool:
    """Return whether a pair is left out as an object may touch something then."""
    return pair.why.startswith(MAY_TOUCH)


def allowed_contacts(pairs: Sequence[UncheckedPair], objects: Collection[str]) -> tuple[str, ...]:
    """Return what each object may touch and when, such as `part with left_hand and left_finger, 0.86 to 3.43 s`.

    Args:
        pairs: Pairs that a certificate leaves out.
        objects: The names of the objects.
    """
    found: dict[tuple[str, str], list[str]] = {}
    for pair in pairs:
        if may_touch(pair):
            # Both may be objects; then the second one is where the first one is put.
            one, other = (pair.other, pair.link) if pair.other in objects else (pair.link, pair.other)
            found.setdefault((one, pair.why.removeprefix(MAY_TOUCH).removeprefix(", ")), []).append(other)
    return tuple(f"{one} with {_listed(names)}" + (f", {when}" if when else "") for (one, when), names in found.items())


def _listed(names: Sequence[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if names[1:] else names)
