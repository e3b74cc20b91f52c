"""What all obstacles of a scene have in common."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import AfterValidator, ConfigDict, Field, PrivateAttr, ValidationInfo

from humanoid_rail._validation import Frozen, Vector
from humanoid_rail.scene.colors import Color

LONGEST_NAME = 80
"""The name of an obstacle has at most so many characters."""


def _require_type(schema: dict[str, Any]) -> None:
    """A file names the type of every obstacle, although Python code need not."""
    schema["required"] = ["type", *schema.get("required", [])]


class ObstacleBase(Frozen):
    """The fields that every obstacle has."""

    model_config = ConfigDict(json_schema_extra=_require_type)

    velocity: Vector = (0.0, 0.0, 0.0)
    """How fast it moves without turning, from where it is at t = 0, m/s."""
    name: Annotated[str, Field(min_length=1, max_length=LONGEST_NAME)] | None = None
    """What messages and pictures call it; several may have the same name."""
    color: Color | None = None
    """Its colour in pictures: a name as in CSS, such as `steelblue`, or `#rrggbb`."""
    _called: str | None = PrivateAttr(default=None)

    @property
    def called(self) -> str | None:
        """What messages call it where it is one of a part of a scene's obstacles: as in the whole scene."""
        return self._called

    def to_be_called(self, name: str) -> Self:
        """Return the same obstacle, which messages call so wherever it is."""
        copied = copy(self)
        copied._called = name
        return copied

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy with some fields changed, validated like any other, which messages call the same."""
        copied = super().model_copy(update=update, deep=deep)
        copied._called = self._called
        return copied


def _existing(file: str, info: ValidationInfo) -> str:
    folder = (info.context or {}).get("folder", Path.cwd())
    path = Path(folder) / file
    try:
        exists = path.is_file()
    except (OSError, ValueError):  # a name too long, a folder that may not be looked into, a NUL
        exists = False
    if not exists:
        raise ValueError(f"an existing file, relative to {Path(folder).resolve()}")
    return str(path)


File = Annotated[str, AfterValidator(_existing)]
"""A file that is there, its path relative to the folder of the scene."""
