"""Elements of a URDF, read strictly: what is not there or cannot be read is an error that says where."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import FARTHEST, SHORTEST, Array
from humanoid_rail.errors import MISSING, InvalidInput, checked_number

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_NAMES = ("name", "link", "joint", "filename")
"""Attributes in which blanks count; in all others a line break is a blank, and blanks around a value do not count."""
_SIMILAR = 0.75
"""An unknown tag as similar as this to a known one is a misspelling, by the ratio of `difflib`, and no extension."""


@dataclass(frozen=True, eq=False)
class Node:
    """An element of a URDF and where it is."""

    element: Element
    where: str
    """Path of the element in errors, for example `link b.collision[0].origin`."""
    version: float
    """Version of URDF that the file names, 1.0 if it names none."""

    def child(self, tag: str) -> Node | None:
        """Return the only child with a tag, or None.

        Raises:
            InvalidInput: If there are several, of which URDF readers take one.
        """
        found = self.element.findall(tag)
        if len(found) > 1:
            raise InvalidInput(f"{self.where}.{tag}", f"{len(found)} elements", f"one <{tag}> at most")
        return Node(found[0], f"{self.where}.{tag}", self.version) if found else None

    def needed(self, tag: str) -> Node:
        """Return the only child with a tag.

        Raises:
            InvalidInput: If there is none, or several.
        """
        found = self.child(tag)
        if found is None:
            raise InvalidInput(f"{self.where}.{tag}", MISSING, f"one <{tag}>")
        return found

    def children(self, tag: str) -> list[Node]:
        """Return all children with a tag."""
        found = self.element.findall(tag)
        return [Node(element, f"{self.where}.{tag}[{i}]", self.version) for i, element in enumerate(found)]

    def text(self, attribute: str, default: str | None = None) -> str:
        """Return an attribute.

        Raises:
            InvalidInput: If it is not there and has no default.
        """
        value = self.element.get(attribute, default)
        if value is None:
            raise InvalidInput(f"{self.where}.{attribute}", MISSING, f"the attribute {attribute} of <{self.tag}>")
        return value

    def number(
        self,
        attribute: str,
        default: float | None = None,
        *,
        above: float = -np.inf,
        least: float = -FARTHEST,
        most: float = FARTHEST,
    ) -> float:
        """Return an attribute that is a number, greater than `above`, not less than `least` and not more than `most`.

        Raises:
            InvalidInput: If it is not there and has no default, or is no such number.
        """
        if default is not None and attribute not in self.element.attrib:
            return default
        text = self.text(attribute)
        value = float(text) if _NUMBER.fullmatch(text) else text
        least = -np.inf if above > -np.inf else least
        return checked_number(f"{self.where}.{attribute}", value, above=above, least=least, most=most)

    def numbers(self, attribute: str, count: int, default: Sequence[float] | None = None) -> Array:
        """Return an attribute that is several numbers (count,) of at most `FARTHEST`, with blanks between them.

        Raises:
            InvalidInput: If it is not there and has no default, or is no such numbers.
        """
        if default is not None and attribute not in self.element.attrib:
            return np.array(default)
        text = self.text(attribute)
        values = np.array([float(x) if _NUMBER.fullmatch(x) else np.nan for x in text.split()])
        if values.shape != (count,) or not (abs(values) <= FARTHEST).all():
            valid = f"{count} numbers with blanks between them, from {-FARTHEST:g} to {FARTHEST:g}"
            raise InvalidInput(f"{self.where}.{attribute}", text, valid)
        return values

    def direction(self, attribute: str, count: int) -> Array:
        """Return an attribute that is a direction or a quaternion (count,), made to length 1.

        Raises:
            InvalidInput: If it cannot be read, or is no longer than `SHORTEST`.
        """
        values = self.numbers(attribute, count)
        length = float(np.linalg.norm(values))
        if length < SHORTEST:
            raise InvalidInput(f"{self.where}.{attribute}", self.text(attribute), f"longer than {SHORTEST:g}")
        return np.array(values / length)

    def origin(self) -> pin.SE3:
        """Return the placement that the child `<origin>` describes, m and rad; the identity without one.

        Raises:
            InvalidInput: If it cannot be read, or `quat_xyzw` (URDF 1.1) is not alone, has no length, or the file
                does not name that version.
        """
        origin = self.child("origin")
        if origin is None:
            return pin.SE3.Identity()
        origin.check_attributes(("xyz", "rpy", "quat_xyzw"))
        xyz = origin.numbers("xyz", 3, (0.0, 0.0, 0.0))
        if "quat_xyzw" not in origin.element.attrib:
            return pin.SE3(pin.rpy.rpyToMatrix(origin.numbers("rpy", 3, (0.0, 0.0, 0.0))), xyz)
        origin.need_version(1.1, "quat_xyzw")
        if "rpy" in origin.element.attrib:
            raise InvalidInput(f"{origin.where}.quat_xyzw", origin.text("quat_xyzw"), "no rpy beside it")
        return pin.SE3(pin.Quaternion(origin.direction("quat_xyzw", 4)).matrix(), xyz)

    def need_version(self, version: float, what: str) -> None:
        """Check that the file names a version of URDF that has something; others ignore it.

        Raises:
            InvalidInput: If it does not.
        """
        if self.version < version:
            valid = f'in a <robot version="{version}"> or later; others are read without it'
            raise InvalidInput(f"{self.where}.{what}", f"{what} in version {self.version}", valid)

    def check_children(self, tags: Sequence[str]) -> None:
        """Check that no child is nearly called as one that URDF has, as readers would ignore it.

        Raises:
            InvalidInput: If one is.
        """
        for tag in (child.tag for child in self.element if child.tag not in tags):
            prefix, _, plain = tag.rpartition(":")
            if close := get_close_matches(plain.lower(), tags, 1, 1.0 if prefix else _SIMILAR):
                raise InvalidInput(f"{self.where}.{tag}", f"<{tag}>", f"<{close[0]}>")

    def check_attributes(self, names: Sequence[str]) -> None:
        """Check that there are no attributes but these and those with a prefix, such as `drake:acceleration`.

        Raises:
            InvalidInput: If there are.
        """
        for name in self.element.attrib:
            if name not in names and ":" not in name:
                raise InvalidInput(f"{self.where}.{name}", self.text(name), f"no attribute but {', '.join(names)}")

    def check_misspelt(self, names: Sequence[str]) -> None:
        """Check that no attribute is nearly called as one of these; warn of others, which are not read.

        Raises:
            InvalidInput: If one is.
        """
        for name in self.element.attrib:
            if name in names or ":" in name:
                continue
            has_a_name_of_its_own = any(part in names for part in name.split("_"))  # such as gear_velocity
            if not has_a_name_of_its_own and (close := get_close_matches(name.lower(), names, 1, _SIMILAR)):
                raise InvalidInput(f"{self.where}.{name}", self.text(name), f"{close[0]}, if that is meant")
            warnings.warn(f"the attribute {name} of <{self.tag}> is not read, as at {self.where}", stacklevel=2)

    @property
    def tag(self) -> str:
        """Name of the element."""
        return self.element.tag


def read_text(field: str, source: str | Path) -> str:
    """Return the text of a file, or a text as it is.

    Args:
        field: Name of the argument, for errors.
        source: The text, or the path of a file in UTF-8.

    Raises:
        InvalidInput: If it is neither, or the file cannot be read.
    """
    if isinstance(source, Path):
        try:
            return source.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError) as error:
            raise InvalidInput(field, str(source), f"a file that can be read ({error})") from error
    if not isinstance(source, str) or "<" not in source:
        raise InvalidInput(field, source, f"the text of a {field.upper()}; of a file, pathlib.Path(...)")
    return source


def parse_xml(field: str, text: str) -> Element:
    """Return the root of XML, with prefixes as they are written: `drake:acceleration`, as URDF readers see it.

    Raises:
        InvalidInput: If it is no well-formed XML, or declares entities, which URDF readers do not know.
    """
    builder, parser = TreeBuilder(), expat.ParserCreate()

    def start(tag: str, attributes: dict[str, str]) -> None:
        values = {name: value if name in _NAMES else " ".join(value.split()) for name, value in attributes.items()}
        builder.start(tag, values)

    def entity(name: str, *_: object) -> None:
        raise InvalidInput(field, f"<!ENTITY {name}>", "no entities of its own")

    parser.StartElementHandler, parser.EndElementHandler = start, builder.end
    parser.CharacterDataHandler, parser.EntityDeclHandler = builder.data, entity
    try:
        parser.Parse(text.removeprefix("\ufeff"), True)
    except (expat.ExpatError, UnicodeEncodeError) as error:
        raise InvalidInput(field, text, f"well-formed XML ({error})") from error
    return builder.close()
