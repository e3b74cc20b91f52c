"""The package as it is installed, and what importing it loads."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import zipfile
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT

import humanoid_rail
from humanoid_rail._native import why_no_engine

HEAVY = {"scipy", "pydantic", "ruamel", "ompl", "toppra", "meshcat", "rich", "click", "pinocchio", "coal", "numpy"}
"""None of these is loaded before it is used."""


def python(code: str, *, cwd: Path, site: Path | None = None) -> str:
    """Run code; given a folder of packages, with those and all that are installed, but without editable installs."""
    options = []
    if site is not None:
        installed = Path(np.__file__).parent.parent
        cmeel = installed / "cmeel.prefix" / "lib" / f"python{sys.version_info[0]}.{sys.version_info[1]}"
        paths = [str(path) for path in (site, installed, cmeel / "site-packages")]
        options, code = ["-S"], f"import sys; sys.path[:0] = {paths!r}\n{code}"
    result = subprocess.run(
        [sys.executable, *options, "-c", code], cwd=cwd, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    return result.stdout


def loaded_by(code: str, cwd: Path) -> set[str]:
    """Return the packages that are loaded after some code ran in a fresh process."""
    said = python(f"import sys\n{code}\nprint(*{{name.partition('.')[0] for name in sys.modules}})", cwd=cwd)
    return set(said.splitlines()[-1].split())


def test_importing_the_package_loads_next_to_nothing(tmp_path: Path) -> None:
    assert not HEAVY & loaded_by("import humanoid_rail", tmp_path)


def test_the_help_of_the_console_command_loads_only_click(tmp_path: Path) -> None:
    code = """
from humanoid_rail.cli import main
sys.argv = ["humanoid-rail", "--help"]
try:
    main()
except SystemExit as ended:
    assert ended.code == 0
"""
    assert HEAVY & loaded_by(code, tmp_path) == {"click"}


def test_the_public_names_load_neither_viewers_nor_what_exports_need(tmp_path: Path) -> None:
    heavy = {"meshcat", "matplotlib", "trimesh", "coacd", "mujoco", "toppra", "ruckig", "click", "rich"}
    assert not heavy & loaded_by("from humanoid_rail import *", tmp_path)


def test_every_public_name_exists() -> None:
    for name in humanoid_rail.__all__:
        assert getattr(humanoid_rail, name).__doc__, name


def test_no_public_function_is_called_like_a_module() -> None:
    modules = {path.stem for path in (ROOT / "humanoid_rail").glob("*.py")}
    modules |= {path.name for path in (ROOT / "humanoid_rail").iterdir() if path.is_dir()}
    assert not modules & set(humanoid_rail.__all__)


def test_only_the_oracle_and_the_tests_use_the_oracle() -> None:
    oracle = ROOT / "humanoid_rail" / "paper" / "dh_table.py"
    for path in (ROOT / "humanoid_rail").rglob("*.py"):
        if path != oracle:
            imports = re.findall(r"^\s*(?:from|import) .*$", path.read_text(encoding="utf-8"), re.MULTILINE)
            assert not [line for line in imports if "dh_table" in line], path
    imports = re.findall(r"^(?:from|import) (\S+)", oracle.read_text(encoding="utf-8"), re.MULTILINE)
    assert set(imports) <= {"__future__", "collections.abc", "dataclasses", "math", "typing", "numpy", "numpy.typing"}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, but for the native engine: compiling that once more would take as long as a fifth of all tests."""
    folder = tmp_path_factory.mktemp("wheel")
    options = ["--quiet", "--no-deps", "--wheel-dir", str(folder), "--config-settings=wheel.cmake=false"]
    subprocess.run([sys.executable, "-m", "pip", "wheel", *options, str(ROOT)], check=True)
    return next(folder.glob("*.whl"))


def test_the_wheel_works_outside_the_checkout(wheel: Path, tmp_path: Path) -> None:
    """The wheel, unpacked elsewhere and put before the checkout on the path."""
    site = tmp_path / "site"
    zipfile.ZipFile(wheel).extractall(site)
    if (extension := find_spec("humanoid_rail._engine")) is not None and extension.origin is not None:
        shutil.copy(extension.origin, site / "humanoid_rail")
    engine = "native" if why_no_engine() is None else "python"
    code = f"""
import humanoid_rail
robot = humanoid_rail.load_robot(link_radius=0.03, l_l3=0.9)
method = humanoid_rail.GradientProjection(dt=0.5, engine={engine!r})
trajectory = humanoid_rail.plan(robot, humanoid_rail.paper_scene(), method)
print(humanoid_rail.__file__)
print(trajectory.status, trajectory.engine, trajectory.certified)
"""
    where, status, found, certified = python(code, cwd=tmp_path, site=site).split()
    assert Path(where).is_relative_to(site)
    assert (status, found, certified) == ("reached", engine, str(engine == "native"))


def test_the_wheel_holds_what_it_should(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    assert {f"humanoid_rail/robots/humanoid_rail.{suffix}" for suffix in ("urdf", "urdf.xacro", "srdf")} <= names
    assert {f"humanoid_rail/scenes/{name}.yaml" for name in ("paper", "picks")} <= names
    assert {
        f"humanoid_rail/{name}" for name in ("__init__.pyi", "py.typed", "scene.schema.json", "cli/plan.py")
    } <= names
    assert not [name for name in names if {"dev", "benchmarks", "validation"} & set(name.split("/"))]
    top = {name.split("/")[0] for name in names}
    assert {name for name in top if not name.endswith(".dist-info")} == {"humanoid_rail"}
