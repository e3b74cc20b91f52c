"""The collision bodies that are written in a URDF, counted without the package: nothing but SAX and `float`."""

from __future__ import annotations

from typing import NamedTuple
from xml.sax import parseString
from xml.sax.handler import ContentHandler
from xml.sax.xmlreader import AttributesImpl


class Written(NamedTuple):
    """A collision body."""

    link: str
    kind: str
    sizes: tuple[float, ...]
    """As URDF has them: radius and length, or the three sides of a box, m."""
    at: tuple[float, ...]
    """Its place in the frame of its link, m."""


class _Bodies(ContentHandler):
    def __init__(self) -> None:
        super().__init__()
        self.path: list[str] = []
        self.link = ""
        self.bodies: list[dict[str, str]] = []
        self.capsules: set[tuple[str, str]] = set()

    def startElement(self, name: str, attrs: AttributesImpl) -> None:
        given, tag = dict(attrs.items()), name.rpartition(":")[2].lower()
        if len(self.path) == 1:
            self.link = given.get("name", "") if tag == "link" else ""
        extension = len(self.path) > 1 and self.path[1] not in ("link", "joint")
        self.path.append(tag)
        if extension:
            return
        if tag == "collision":
            self.bodies.append({"link": self.link, "name": given.get("name", "")})
        elif self.path[2:] == ["collision_checking", "capsule"]:
            self.capsules.add((self.link, given["name"]))
        elif self.path[2:-1] == ["collision", "geometry"]:
            self.bodies[-1] |= {"kind": tag, **given}
        elif self.path[2:] == ["collision", "origin"]:
            self.bodies[-1]["xyz"] = given.get("xyz", "0 0 0")

    def endElement(self, name: str) -> None:
        self.path.pop()


def written_bodies(text: str) -> list[Written]:
    """Return what collision bodies a URDF has, sorted; those in extensions at its outermost level do not count."""
    handler = _Bodies()
    parseString(text.encode(), handler)
    found = []
    for body in handler.bodies:
        kind = body.get("kind", "nothing")
        if kind == "cylinder" and (body["link"], body["name"]) in handler.capsules:
            kind = "capsule"
        sizes = " ".join(body.get(name, "") for name in ("radius", "length", "size"))
        found.append(Written(body["link"], kind, _numbers(sizes), _numbers(body.get("xyz", "0 0 0"))))
    return sorted(found)


def _numbers(text: str) -> tuple[float, ...]:
    return tuple(float(x) for x in text.split())
