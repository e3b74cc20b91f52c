"""The JSON Schema of scene files, which editors use for completion and checks."""

from __future__ import annotations

from typing import Any

from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.scene import Scene


def scene_schema(robot: Robot) -> dict[str, Any]:
    """Return the JSON Schema of scene files for a robot, which editors use for completion and checks."""
    schema = Scene.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["required"].remove("name")
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
    return schema
