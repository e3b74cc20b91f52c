"""The errors this package raises on purpose."""

from __future__ import annotations

import difflib
import math
import reprlib
from collections.abc import Iterable
from numbers import Real
from typing import Any


class HumanoidRailError(Exception):
    """Base class of every error this package raises on purpose."""


class InvalidInput(HumanoidRailError, ValueError):
    """An input that cannot be used.

    Attributes:
        field: Path of the offending field, for example ``obstacles[0].radius``.
        value: What was given.
        valid: What would have been right, in words.
        source: File the field was read from, if any.
    """

    def __init__(self, field: str, value: object, valid: str, source: str | None = None) -> None:
        self.field = field
        self.value = value
        self.valid = valid
        self.source = source
        super().__init__(field, value, valid, source)

    def __str__(self) -> str:
        where = f"{self.source}: " if self.source else ""
        return _one_line(f"{where}{self.field} is {short(self.value)}; valid: {self.valid}")


class EngineMissing(HumanoidRailError, ImportError):
    """The native engine is needed and is not there.

    Attributes:
        why: Why it is not there, and what to install.
    """

    def __init__(self, why: str) -> None:
        self.why = why
        super().__init__(why)

    def __str__(self) -> str:
        return (
            f"the native engine is missing: {self.why}. Without it only gradient projection works, by "
            'GradientProjection(engine="python") or --method gradient-projection --engine python'
        )


class Missing:
    """Stands for the value of a field that is not there."""

    def __repr__(self) -> str:
        return "missing"


MISSING = Missing()
"""The value of a field that was not given."""


def checked_number(
    field: str, value: Any, *, above: float = -math.inf, least: float = -math.inf, most: float = math.inf
) -> float:
    """Return a finite number greater than `above`, not less than `least` and not more than `most`.

    Raises:
        InvalidInput: If the value is not one.
    """
    try:
        number = float(value) if isinstance(value, Real) and not isinstance(value, bool) else math.nan
    except OverflowError:
        number = math.nan
    if not math.isfinite(number) or number <= above or number < least or number > most:
        said = [("greater than", above), ("not less than", least), ("not more than", most)]
        bounds = [f"{what} {told_apart(bound, number)}" for what, bound in said if math.isfinite(bound)]
        raise InvalidInput(field, value, ", ".join(["a finite number", *bounds]))
    return number


def told_apart(bound: float, value: float, digits: int = 6) -> str:
    """Return a bound as text, with as many digits as it takes to tell it from a value.

    Args:
        bound: The bound.
        value: What is beyond it, or not.
        digits: At least so many digits.
    """
    while digits < 17 and bound != value and f"{bound:.{digits}g}" == f"{value:.{digits}g}":
        digits += 1
    return f"{bound:.{digits}g}"


def check_kind(field: str, value: object, kind: type) -> None:
    """Check that an argument is of a class.

    Raises:
        InvalidInput: If it is not.
    """
    if not isinstance(value, kind):
        raise InvalidInput(field, value, f"a {kind.__name__}")


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """Return what to add to the message about a name that is not known: the known name most like it, if one is."""
    near = difflib.get_close_matches(name, list(known), n=1) if isinstance(name, str) else []
    return f"; did you mean {near[0]}?" if near else ""


def short(value: object) -> str:
    """Return the representation of a value, cut to a readable length."""
    shortener = reprlib.Repr()
    shortener.maxstring = shortener.maxother = shortener.maxlong = 60
    shortener.maxlevel = 2
    try:
        return shortener.repr(value)
    except Exception:  # a foreign __repr__ may raise anything, and must not hide the error it is quoted in
        return f"<{type(value).__name__}>"


def _one_line(text: str) -> str:
    return " ".join(text.split())
