"""What Python shows of scenes: `help` and signatures."""

from __future__ import annotations

import inspect
import pydoc
from typing import Any

import pytest

from humanoid_rail import Box, Capsule, HalfSpace, Mesh, Pose, Scene, Sphere


@pytest.mark.parametrize("kind", [Box, Capsule, HalfSpace, Mesh, Sphere, Scene, Pose])
def test_help_shows_fields_and_units(kind: Any) -> None:
    text = pydoc.render_doc(kind, renderer=pydoc.plaintext)
    for name, field in kind.model_fields.items():
        assert f"{name} (" in text
        assert field.description is None or " ".join(field.description.split()) in " ".join(text.split())
    for machinery in ("model_dump", "model_fields", "__pydantic", "FieldInfo", "BeforeValidator"):
        assert machinery not in text


def test_signatures_of_obstacles_are_readable() -> None:
    assert str(inspect.signature(Sphere)) == (
        "(*, velocity: three numbers = (0.0, 0.0, 0.0), name: str | None = None, color: colour or None = None, "
        "type: Literal['sphere'] = 'sphere', center: three numbers, radius: number > 0)"
    )
