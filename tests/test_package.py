"""The package as it is installed."""

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
from humanoid_rail.planning.engines import why_not_native


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


def test_import_loads_neither_meshcat_nor_matplotlib(tmp_path: Path) -> None:
    code = """
import sys
from humanoid_rail import *
heavy = {'meshcat', 'matplotlib', 'trimesh', 'coacd', 'mujoco', 'toppra', 'ruckig', 'scipy.signal'}
print(sorted(heavy & set(sys.modules)))
"""
    assert python(code, cwd=tmp_path).strip() == "[]"


def test_every_public_name_exists() -> None:
    import humanoid_rail

    for name in humanoid_rail.__all__:
        assert getattr(humanoid_rail, name).__doc__, name


def test_functions_that_are_called_like_their_modules_are_the_functions() -> None:
    import humanoid_rail

    assert callable(humanoid_rail.verify)
    assert callable(humanoid_rail.retime)


def test_only_the_oracle_and_the_tests_use_the_oracle() -> None:
    for path in (ROOT / "humanoid_rail").rglob("*.py"):
        if path.name != "dh.py":
            assert not re.search(r"import dh|humanoid_rail\.dh", path.read_text(encoding="utf-8")), path
    imports = re.findall(r"^(?:from|import) (\S+)", (ROOT / "humanoid_rail" / "dh.py").read_text(), re.MULTILINE)
    assert set(imports) == {"__future__", "dataclasses", "math", "typing", "numpy", "numpy.typing"}


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
    code = """
import humanoid_rail
robot = humanoid_rail.load_robot(link_radius=0.03, l_l3=0.9)
trajectory = conftest.plan(robot, humanoid_rail.paper_scene(), dt=0.5)
print(humanoid_rail.__file__)
print(trajectory.status, trajectory.engine)
"""
    where, status, engine = python(code, cwd=tmp_path, site=site).split()
    assert Path(where).is_relative_to(site)
    assert (status, engine) == ("reached", "native" if why_not_native() is None else "python")


def test_the_wheel_holds_what_it_should(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    robots = {f"humanoid_rail/robots/humanoid_rail.{suffix}" for suffix in ("urdf", "urdf.xacro", "srdf")}
    assert (
        robots
        | {
            "humanoid_rail/scenes/paper.yaml",
            "humanoid_rail/scenes/picks.yaml",
            "humanoid_rail/py.typed",
            "humanoid_rail/scene.schema.json",
        }
        <= names
    )
    assert not [name for name in names if "dev" in name.split("/")]
    assert {"humanoid_rail/commands/plan.py", "humanoid_rail/comparison/methods.py"} <= names
    top = {name.split("/")[0] for name in names}
    assert {name for name in top if not name.endswith(".dist-info")} == {"humanoid_rail"}
