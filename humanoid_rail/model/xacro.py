"""Makes URDF text of xacro."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from humanoid_rail.errors import InvalidInput, did_you_mean
from humanoid_rail.geometry.mesh_names import package_folders

_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_XACRO = re.compile(r"<xacro:|\$[({]")


class _Arguments(dict[str, str]):
    """The arguments of a xacro, which know the names that it asks for or declares."""

    def __init__(self, arguments: Mapping[str, object]) -> None:
        super().__init__({name: _written(value) for name, value in arguments.items()})
        self.asked: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.asked.add(str(name))
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.asked.add(name)
        return super().__getitem__(name)


def without_xacro(
    text: str,
    folder: Path,
    packages: tuple[Path, ...],
    arguments: Mapping[str, object] | None,
    file: Path | None = None,
) -> str:
    """Return the URDF that xacro makes of a text; a text without anything of xacro as it is.

    Args:
        text: URDF or xacro.
        folder: Where `$(find ...)` begins to look.
        packages: Folders of ROS packages, or folders that hold them.
        arguments: Arguments of the xacro.
        file: The file that the text is from, if any.

    Raises:
        InvalidInput: If it cannot be processed, or does not have an argument.
    """
    given = _Arguments(arguments or {})
    if not _XACRO.search(_COMMENT.sub("", text)):
        for name, value in given.items():
            raise InvalidInput(f"xacro.{name}", value, "none: the file has nothing of xacro")
        return text
    import xacro
    from xacro import substitution_args

    missing: list[InvalidInput] = []

    def find(package: str) -> str:
        places = list(dict.fromkeys(package_folders(package, folder, packages)))
        for place in places:
            if place.is_dir():
                return str(place)
        looked = ", ".join(map(str, places))
        valid = f"a package that is there, such as one in a folder that packages names; looked at: {looked}"
        missing.append(InvalidInput("urdf", f"$(find {package})", valid))
        raise missing[0]

    before = substitution_args._eval_find
    substitution_args._eval_find = find  # the one of xacro needs ROS
    try:
        xacro.init_stacks(str(file) if file else None)
        document = xacro.parse(text, str(file) if file else None)
        xacro.process_doc(document, mappings=given)
    except Exception as error:  # xacro raises whatever the expressions in the file do
        if missing:
            raise missing[0] from None
        raise InvalidInput("urdf", str(file or text), f"xacro that can be processed ({error})") from error
    finally:
        substitution_args._eval_find = before
    if not document.getElementsByTagName("link"):
        raise InvalidInput("urdf", str(file or text), "a xacro that makes links; one with macros alone is for others")
    for name, value in given.items():
        if name not in given.asked:
            known = sorted(given.asked)
            valid = f"an argument of the xacro{did_you_mean(name, known)}: {', '.join(known) or 'it has none'}"
            raise InvalidInput(f"xacro.{name}", value, valid)
    made: str = document.toprettyxml(indent="  ")
    return made


def _written(value: object) -> str:
    """Return an argument as it is written in a xacro."""
    return str(value).lower() if isinstance(value, bool) else str(value)
