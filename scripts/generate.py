"""Write the files that are made from others: the built URDF, JSON Schemas, the types of the extension."""

from __future__ import annotations

import json
import re
from pathlib import Path

from nanobind.stubgen import StubGen

from humanoid_rail import build_urdf, load_robot
from humanoid_rail._native import engine
from humanoid_rail.scene.schema import robot_schema, scene_schema

ROOT = Path(__file__).resolve().parent.parent


def generated() -> dict[Path, str]:
    """Return what the files should hold, by path relative to the repository."""
    return {
        Path("robots/humanoid_rail.urdf"): build_urdf(),
        Path("humanoid_rail/_engine.pyi"): engine_types(),
        Path("humanoid_rail/scene.schema.json"): json.dumps(scene_schema(load_robot()), indent=2) + "\n",
        Path("humanoid_rail/robot.schema.json"): json.dumps(robot_schema(), indent=2) + "\n",
    }


def engine_types() -> str:
    """Return the stub of the native engine."""
    generator = StubGen(engine())
    generator.put(engine())
    stub: str = generator.get()
    # nanobind leaves out what a function takes and returns, which mypy asks for.
    return re.sub(r": Callable\b(?!\[)", ": Callable[..., object]", stub)


if __name__ == "__main__":
    for path, text in generated().items():
        (ROOT / path).write_text(text, encoding="utf-8")
        print(path)
