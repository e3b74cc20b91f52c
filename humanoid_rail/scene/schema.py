"""The JSON Schema of scene files, which editors use for completion and checks."""

from __future__ import annotations

from typing import Any

from humanoid_rail._validation import FIELDS_HEADING
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.scene import Scene


def scene_schema(robot: Robot) -> dict[str, Any]:
    """Return the JSON Schema of scene files for a robot, which editors use for completion and checks."""
    schema = Scene.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    once, steps = schema["properties"]["targets"]["oneOf"]
    target = once.pop("additionalProperties")
    once |= {
        "properties": dict.fromkeys(robot.hand_names, target),
        "required": list(robot.hand_names),
        "additionalProperties": False,
    }
    steps["items"] = once
    start = schema["properties"]["initial"]["anyOf"][0]
    start |= {"minItems": robot.n, "maxItems": robot.n}
    stripped: dict[str, Any] = _without_fields(schema)
    return stripped


def _without_fields(schema: Any) -> Any:
    """Return a schema whose descriptions do not list the fields, which the schema has itself."""
    match schema:
        case dict():
            return {name: _without_fields(value) for name, value in schema.items()}
        case list():
            return [_without_fields(value) for value in schema]
        case str():
            return schema.partition(FIELDS_HEADING)[0]
        case _:
            return schema
