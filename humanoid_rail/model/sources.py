"""Where the files of a robot are: by path, or by the name of an installed package that has models."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path

from humanoid_rail.errors import InvalidInput, did_you_mean
from humanoid_rail.model.xacro import without_xacro

SUFFIXES = (".urdf", ".xacro", ".xml")
"""Files with these endings hold URDFs, as they are or for xacro to make."""
DESCRIPTIONS = "robot_descriptions"
"""The package whose modules know where robots are, or fetch them."""


@dataclass(frozen=True, eq=False)
class Source:
    """The texts of a robot, and where the files are that they name."""

    urdf: str
    """URDF text, made by xacro if need be."""
    srdf: str | None = None
    """SRDF text, if there is one."""
    folder: Path = field(default_factory=Path.cwd)
    """Relative names in the URDF begin here."""
    packages: tuple[Path, ...] = ()
    """Folders of packages, or folders that hold them."""
    found: tuple[str, ...] = ()
    """What was found and not given, in sentences."""


def find_source(
    urdf: str | Path,
    srdf: str | Path | None = None,
    packages: Sequence[str | Path] = (),
    xacro_arguments: Mapping[str, object] | None = None,
) -> Source:
    """Return the texts of a robot.

    Args:
        urdf: URDF or xacro: its text, its path, or a name: `PACKAGE:ROBOT` for a file in an installed Python package
            with models, by its name or its path there; `NAME_description` for what `robot_descriptions` has.
        srdf: SRDF text or its path; that which lies beside a named robot if not given.
        packages: Folders of ROS packages, or folders that hold them, for `package://` and `$(find ...)`.
        xacro_arguments: Arguments of the xacro.

    Raises:
        InvalidInput: If there is no such robot, or a file cannot be read.
    """
    places = tuple(Path(place).absolute() for place in packages)
    for place in places:
        if not is_there(place, Path.is_dir):
            raise InvalidInput("packages", str(place), "folders of packages that are there")
    if isinstance(urdf, str) and "<" in urdf:
        text = without_xacro(urdf, Path.cwd(), places, xacro_arguments)
        return Source(text, None if srdf is None else _srdf_text(srdf), packages=places)
    file = find_file(urdf)
    text = without_xacro(_text("urdf", file), file.parent, places, xacro_arguments, file)
    found = () if _is_path(urdf) else (f"The URDF is {file.name} of {str(urdf).partition(':')[0]}.",)
    beside = _beside(file) if srdf is None and not _is_path(urdf) else None
    if beside is not None:
        srdf, found = beside, (*found, f"The SRDF is {beside.name}, which is beside the URDF.")
    return Source(text, None if srdf is None else _srdf_text(srdf), file.parent, places, found)


def find_file(name: str | Path, field: str = "urdf") -> Path:
    """Return the file that a path or the name of a robot means.

    Raises:
        InvalidInput: If there is none; the error names what there is.
    """
    if isinstance(name, Path) or _is_path(name):
        file = Path(name)
        if not is_there(file):
            raise InvalidInput(field, str(name), "a file that is there, or the name of a robot as PACKAGE:ROBOT")
        return file
    if not isinstance(name, str):
        raise InvalidInput(field, name, "the path of a URDF, its text, or a name as PACKAGE:ROBOT")
    package, separator, robot = name.partition(":")
    if package == DESCRIPTIONS or (not separator and name.endswith("_description")):
        return _described(field, robot or name)
    if not (package and separator and robot):
        valid = "a file that is there, its text, a name as PACKAGE:ROBOT, or one of the robots in docs/robots.md"
        raise InvalidInput(field, name, valid)
    return _named(field, package, robot)


def is_there(path: str | Path, kind: Callable[[Path], bool] = Path.is_file) -> bool:
    """Return whether there is a file of a name, or something else by `kind`; there is none of what cannot be a name."""
    try:
        return kind(Path(path))
    except (OSError, ValueError):  # too long, a folder that may not be looked into, a NUL
        return False


def package_root(package: str) -> Path:
    """Return the folder that the files of an installed Python package with models are in.

    Raises:
        InvalidInput: If it is not installed, or has no models.
    """
    files = _models(package)
    folders = [file.parent for file in files]
    root = folders[0]
    while not all(folder.is_relative_to(root) for folder in folders):
        root = root.parent
    return root


def _is_path(name: str | Path) -> bool:
    said = str(name)
    return isinstance(name, Path) or is_there(said) or (Path(said).suffix in SUFFIXES and ":" not in said)


def _models(package: str) -> list[Path]:
    """Return the URDF and xacro files of an installed Python package."""
    try:
        distribution = metadata.distribution(package)
    except (metadata.PackageNotFoundError, ValueError):
        valid = f"an installed Python package with models: python -m pip install {package}"
        raise InvalidInput("package", package, valid) from None
    files = [file for file in distribution.files or () if file.suffix in SUFFIXES[:2]]
    models = sorted(Path(str(distribution.locate_file(file))).resolve() for file in files)
    if not models:
        raise InvalidInput("package", package, "a Python package with URDF files")
    return models


def model_names(package: str) -> tuple[str, ...]:
    """Return the names of the robots of an installed Python package, each as short as it can be told from others.

    Raises:
        InvalidInput: If it is not installed, or has no models.
    """
    root, models = package_root(package), _models(package)
    stems = [file.name.partition(".")[0] for file in models]
    paths = [file.relative_to(root).as_posix() for file in models]
    return tuple(stem if stems.count(stem) == 1 else path for stem, path in zip(stems, paths, strict=True))


def _named(field: str, package: str, robot: str) -> Path:
    """Return the file of a package that is called as a robot, lies there, or lies in a folder that is called so."""
    models = _models(package)
    if (file := (package_root(package) / robot).resolve()) in models:
        return file
    stems = {file.name.partition(".")[0] for file in models}
    for wanted in (robot, f"{robot}_robot"):
        found = [file for file in models if file.name.partition(".")[0] == wanted]
        urdfs = [file for file in found if file.suffix == SUFFIXES[0]] or found
        if len(urdfs) == 1:
            return urdfs[0]
        if urdfs:
            paths = ", ".join(file.relative_to(package_root(package)).as_posix() for file in urdfs)
            raise InvalidInput(field, f"{package}:{robot}", f"the path of one of these: {paths}")
    homes = [file for file in models if any(_is_home(part, robot) for part in file.parts)]
    found = homes or [file for file in models if file.stem.startswith((f"{robot}_", f"{robot}-"))]
    if len(found) == 1:
        return found[0]
    if found:
        names = ", ".join(sorted(file.stem for file in found))
        raise InvalidInput(field, f"{package}:{robot}", f"one robot; these are several: {names}")
    valid = f"a robot of {package}{did_you_mean(robot, sorted(stems))}: {', '.join(sorted(stems))}"
    raise InvalidInput(field, f"{package}:{robot}", valid)


def _is_home(folder: str, robot: str) -> bool:
    return folder in (robot, f"{robot}_description", f"{robot}_robot_model", f"{robot}_data")


def _described(field: str, name: str) -> Path:
    """Return the file of a robot of `robot_descriptions`, which may fetch it."""
    try:
        module = importlib.import_module(f"{DESCRIPTIONS}.{name}")
    except ModuleNotFoundError as error:
        has_package = error.name != DESCRIPTIONS
        valid = "the name of a robot there" if has_package else f"installed: python -m pip install {DESCRIPTIONS}"
        raise InvalidInput(field, f"{DESCRIPTIONS}:{name}", valid) from error
    except Exception as error:  # fetching may fail in any way
        raise InvalidInput(field, f"{DESCRIPTIONS}:{name}", f"one that can be fetched ({error})") from error
    path = getattr(module, "URDF_PATH", None) or getattr(module, "XACRO_PATH", None)
    if path is None:
        raise InvalidInput(field, f"{DESCRIPTIONS}:{name}", "a robot with a URDF; this one has none")
    return Path(path)


def _beside(urdf: Path) -> Path | None:
    """Return the SRDF that goes with the URDF of a package: the one whose name is nearest, in its folder or in srdf."""
    name = urdf.name.partition(".")[0]
    files = [*sorted(urdf.parent.glob("*.srdf")), *sorted((urdf.parent.parent / "srdf").glob("*.srdf"))]
    for fits in (
        [file for file in files if file.stem == name],
        sorted((file for file in files if name.startswith(f"{file.stem}_")), key=lambda file: -len(file.stem)),
        [file for file in files if file.stem.startswith(f"{name}_")],
    ):
        if fits:
            return fits[0]
    return None


def _text(field: str, file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8-sig")
    except (OSError, ValueError) as error:
        raise InvalidInput(field, str(file), f"a file that can be read ({error})") from error


def _srdf_text(srdf: str | Path) -> str:
    if isinstance(srdf, str) and "<" in srdf:
        return srdf
    if not isinstance(srdf, str | Path):
        raise InvalidInput("srdf", srdf, "the path of an SRDF, or its text")
    return _text("srdf", Path(srdf))
