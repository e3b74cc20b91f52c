"""The JSON Schemas of scene files and robot files, which editors use for completion and checks."""

from __future__ import annotations

from typing import Any

from humanoid_rail._validation import FIELDS_HEADING
from humanoid_rail.model.robot import Robot
from humanoid_rail.model.robot_file import RobotFile
from humanoid_rail.scene.scene import Scene
from humanoid_rail.scene.targets import Step


def scene_schema(robot: Robot) -> dict[str, Any]:
    """Return the JSON Schema of scene files, in which scenes that name no robot are for a given one."""
    schema = Scene.model_json_schema()
    hands = {
        "properties": dict.fromkeys((*Step.model_fields, *robot.hand_names), True),
        # Where joints have to be somewhere, hands need not be named.
        "anyOf": [{"required": list(robot.hand_names)}, {"required": ["joints"]}, {"required": ["posture"]}],
        "additionalProperties": False,
    }
    schema["if"] = {"properties": {"robot": {"type": "null"}}}
    schema["then"] = {
        "properties": {
            "targets": {"if": {"type": "array"}, "then": {"items": hands}, "else": hands},
            "initial": {"minItems": robot.n, "maxItems": robot.n},
        }
    }
    return _finished(schema)


def robot_schema() -> dict[str, Any]:
    """Return the JSON Schema of robot files."""
    return _finished(RobotFile.model_json_schema())


def _finished(schema: dict[str, Any]) -> dict[str, Any]:
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
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
