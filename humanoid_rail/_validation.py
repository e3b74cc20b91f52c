"""What data of scenes and robot files have in common: immutable, strictly validated; errors name the field."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Iterator, Mapping
from inspect import Parameter, Signature
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError, PydanticUndefined

from humanoid_rail._arrays import FARTHEST
from humanoid_rail.errors import MISSING, InvalidInput, did_you_mean, short

if TYPE_CHECKING:  # the signatures of the models stay those that pydantic gives them
    from pydantic._internal._model_construction import ModelMetaclass as _Metaclass
else:

    class _Metaclass(type(BaseModel)):
        """Lets `Sphere(radius=-1)` raise the same error as a scene file does, and `help(Sphere)` show what it takes."""

        def __call__(cls, *args: Any, **kwargs: Any) -> Any:
            if args:
                raise InvalidInput(cls.__name__, args, f"arguments by name: {_call_by_name(cls, args)}")
            try:
                return super().__call__(*args, **kwargs)
            except ValidationError as error:
                raise invalid_input(error, root=ROOTS.get(cls.__name__, cls.__name__)) from None

        def __dir__(cls) -> list[str]:
            """Return what is the model's own, without the machinery that pydantic brings."""
            machinery = {*BaseModel.__dict__, *BaseModel.model_fields} - {"model_copy"}
            return [name for name in super().__dir__() if not name.startswith("_") and name not in machinery]


ROOTS = {"Scene": "scene", "RobotFile": "robot"}
"""What errors that are about no field alone call the data of a file."""
LARGEST_ANGLE = 2.0 * math.pi
"""Angles beyond a full turn are mostly degrees, rad."""


def plain(value: object) -> object:
    """Return lists and arrays as tuples, so that strict validation takes them."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    return tuple(value) if isinstance(value, list) else value


def _triple(value: object) -> object:
    value = plain(value)
    if not isinstance(value, tuple) or len(value) != 3:
        raise ValueError("three numbers")
    return value


Number = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST)]
Positive = Annotated[float, Field(gt=0.0, le=FARTHEST)]
Vector = Annotated[tuple[Number, Number, Number], BeforeValidator(_triple)]
Angle = Annotated[float, Field(ge=-LARGEST_ANGLE, le=LARGEST_ANGLE)]
Angles = Annotated[tuple[Angle, Angle, Angle], BeforeValidator(_triple)]
Size = Annotated[tuple[Positive, Positive, Positive], BeforeValidator(_triple)]

FIELDS_HEADING = "\n\nFields:"
"""After this the docstring of a model lists its fields."""


def _call_by_name(model: type[BaseModel], values: tuple[object, ...]) -> str:
    """Return how a model is made of values that were given without names, those of its required fields first."""
    names = sorted(model.model_fields, key=lambda name: not model.model_fields[name].is_required())
    required = [name for name in names if model.model_fields[name].is_required()]
    given = {name: repr(value) for name, value in zip(names, values, strict=False)}
    arguments = [f"{name}={given.get(name, '...')}" for name in names if name in required or name in given]
    return f"{model.__name__}({', '.join(arguments)})"


def _parameter(model: type[BaseModel], name: str) -> Parameter:
    """Return a field as a keyword argument."""
    default = model.model_fields[name].default
    shown = Parameter.empty if default is PydanticUndefined else default
    return Parameter(name, Parameter.KEYWORD_ONLY, default=shown, annotation=_Name(_type_name(model, name)))


def _described_fields(model: type[BaseModel]) -> Iterator[str]:
    """Yield a line for each field: its name, its type and what it is."""
    for name, field in model.model_fields.items():
        described = " ".join((field.description or "The kind of obstacle.").split())
        yield f"\n    {name} ({_type_name(model, name)}): {described}"


def _type_name(model: type[BaseModel], field: str) -> str:
    """Return the type of a field as it is written, in words where that is short."""
    written = next(
        base.__annotations__[field] for base in model.__mro__ if field in vars(base).get("__annotations__", ())
    )
    bare = re.sub(r"Annotated\[((?:[^\[\],]|\[[^\]]*\])+), .*\]", r"\1", str(written))
    return TYPES.get(bare, bare)


TYPES = {
    "Vector": "three numbers",
    "Angles": "three numbers",
    "Angles | None": "three numbers or None",
    "Vector | None": "three numbers or None",
    "Size": "three numbers > 0",
    "Positive": "number > 0",
    "Number": "number",
    "Positive | Size": "number > 0 or three of them",
    "tuple[Number, ...] | None": "numbers or None",
    "SceneObstacles": "obstacles",
    "tuple[Entry, ...]": "obstacles",
    "File": "file",
    "Color | None": "colour or None",
}
"""The types of fields in words."""


class _Name(str):
    """The name of a type, which a signature shows without quotes."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


class Frozen(BaseModel, metaclass=_Metaclass):
    """Immutable; no unknown keys, no conversion between types, no NaN or infinity."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", strict=True, allow_inf_nan=False, use_attribute_docstrings=True
    )

    described_in: ClassVar[str] = "docs/scenes.md"
    """The page that describes the fields."""

    @model_validator(mode="before")
    @classmethod
    def _know_every_key(cls, data: object) -> object:
        """Name the keys that are not fields; mostly they are those that are missing, misspelt."""
        if not isinstance(data, Mapping):
            return data
        left = [name for name in cls.model_fields if name not in data]
        unknown = [(i, key) for i, key in enumerate(data) if isinstance(key, str) and key not in cls.model_fields]
        if unknown:
            missing = [name for name in left if cls.model_fields[name].is_required()]
            valid = f"one of {', '.join(cls.model_fields)}{did_you_mean(unknown[0][1], left)}"
            valid += f"; missing here: {', '.join(missing)}" if missing else f"; see {cls.described_in}"
            others = [f"{short(key)}{did_you_mean(key, left).replace('; ', ', ')}" for _, key in unknown[1:]]
            valid += f"; unknown as well: {', '.join(others)}" if others else ""
            raise PydanticCustomError("unknown_key", "{valid}", {"valid": valid, "number": unknown[0][0]})
        return data

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """Have `help` show the fields with their units, and a signature that can be read."""
        described = inspect.cleandoc(cls.__doc__ or "")
        cls.__doc__ = f"{described}{FIELDS_HEADING}{''.join(_described_fields(cls))}"
        cls.__signature__ = Signature([_parameter(cls, name) for name in cls.model_fields])

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy with some fields changed, validated like any other (which pydantic's own is not).

        Args:
            update: The fields to change.
            deep: Has no effect: nothing here can be changed.

        Raises:
            InvalidInput: If a field is not valid.
        """
        return type(self)(**{name: getattr(self, name) for name in type(self).model_fields} | dict(update or {}))


def invalid_input(error: ValidationError, source: str | None = None, root: str = "scene") -> InvalidInput:
    """Return pydantic's error as ours: which field, what was given, what would be right.

    Of several errors it is the first; it names unknown keys elsewhere too. One that is about no field alone is about
    the `root`.
    """
    first, *others = error.errors(include_url=False)
    field, value, context = _path(first["loc"]) or root, first["input"], first.get("ctx", {})
    match first["type"]:
        case "missing":
            return InvalidInput(field, MISSING, "a value: this field is required", source)
        case "unknown_key":
            key, content = list(value.items())[context["number"]]
            valid, shape = context["valid"], _mapped(field, root) if root == "robot" and field != root else ""
            valid += f"; for example {shape}" if shape else ""
            elsewhere = [
                f"{_path(each['loc'])}.{list(each['input'])[each['ctx']['number']]}"
                for each in others
                if each["type"] == "unknown_key"
            ]
            valid += f"; unknown elsewhere: {', '.join(elsewhere)}" if elsewhere else ""
            return InvalidInput(f"{field}.{key}".removeprefix(f"{root}."), content, valid, source)
        case "union_tag_not_found":
            return InvalidInput(f"{field}.type", MISSING, "a type, such as sphere or box", source)
        case "union_tag_invalid":
            near = did_you_mean(context["tag"], re.findall(r"\w+", context["expected_tags"]))
            return InvalidInput(f"{field}.type", context["tag"], f"one of {context['expected_tags']}{near}", source)
        case "greater_than_equal" if context["ge"] == 0:
            return InvalidInput(field, value, "a number, 0 or more", source)
        case "less_than_equal" | "greater_than_equal":
            bound: float = abs(context.get("le", context.get("ge", 0.0)))
            unit = {FARTHEST: "m; given in millimetres?", LARGEST_ANGLE: "rad; given in degrees?"}.get(bound, "")
            return InvalidInput(field, value, f"a number from {-bound:.6g} to {bound:.6g} {unit}".strip(), source)
        case "value_error" if isinstance(own := context["error"], InvalidInput) and field == root:
            return InvalidInput(own.field, own.value, own.valid, source)
        case "value_error":
            return InvalidInput(field, value, str(context["error"]), source)
        case "mesh_file":
            return InvalidInput(f"{field}.file".removeprefix(f"{root}."), context["file"], first["msg"], source)
        case "dict_type" | "model_type" | "model_attributes_type":
            return InvalidInput(field, value, f"a mapping: {_mapped(field, root)}", source)
        case "too_short":
            return InvalidInput(field, value, f"{context['min_length']} at least", source)
        case "tuple_type":
            return InvalidInput(field, value, "a list", source)
    return InvalidInput(field, value, first["msg"].removeprefix("Input should be ").replace("a valid ", "a "), source)


EXAMPLES = {
    "hands": "{NAME: {frame: FRAME}}",
    "limits": "{JOINT: {acceleration: 8}}",
    "locked": "{JOINT: 0.5}",
    "initial": "{JOINT: 0.5}",
    "postures": "{NAME: {JOINT: 0.5}}",
    "base": "{xyz: [0, 0, 1], rpy: [0, 0, 0]}",
    "pairs": "{left_out: [{links: [LINK, LINK]}], distances: [{links: [LINK, LINK], distance: 0.005}]}",
    "xacro": "{ARGUMENT: VALUE}",
}
"""What mappings of robot files look like."""
MAPPED_IN_STEPS = {
    "grasp": "hands and what they grasp, such as {left: part}",
    "release": "hands and what they let go of, such as {left: part}",
    "contacts": "objects and what they may touch, such as {part: [shelf]}",
    "retreat": "how the hand leaves, such as {direction: [0, 0, 1], distance: 0.1}",
}
"""What mappings of the steps of scenes look like."""


def _mapped(field: str, root: str) -> str:
    """Return what a mapping looks like in a field of a scene or a robot file."""
    name = re.split(r"[.\[]", field.removeprefix("robot."))[0]
    if root == "robot" and name in EXAMPLES:
        return f"{name}: {EXAMPLES[name]}"
    of_steps = MAPPED_IN_STEPS.get(field.rpartition(".")[2])
    if of_steps is not None and "targets" in field:
        return of_steps
    return "the names of the hands and their targets" if "targets" in field else "keys and values"


SHAPES = ("obstacles", "objects", "bodies")
"""Lists of shapes, each of which has a type."""


def _path(location: tuple[int | str, ...]) -> str:
    """Return pydantic's location as a path, without the names of types that it adds."""
    path = ""
    for i, part in enumerate(location):
        # After an index pydantic names the type of the shape; and it names the members of unions.
        in_list = i > 1 and isinstance(location[i - 1], int) and isinstance(part, str)
        is_type = (in_list and location[i - 2] in SHAPES) or "constrained" in str(part) or str(part).startswith("<")
        if not is_type:
            path += f"[{part}]" if isinstance(part, int) else f".{part}"
    return path.lstrip(".")
