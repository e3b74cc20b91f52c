"""The package as it is installed."""

from __future__ import annotations

import re
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT

from humanoid_rail.engines import why_not_native


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
    code = "import sys, humanoid_rail; print(sorted({'meshcat', 'matplotlib', 'trimesh', 'coacd'} & set(sys.modules)))"
    assert python(code, cwd=tmp_path).strip() == "[]"


def test_every_public_name_exists() -> None:
    import humanoid_rail

    for name in humanoid_rail.__all__:
        assert getattr(humanoid_rail, name).__doc__, name


def test_only_the_oracle_and_the_tests_use_the_oracle() -> None:
    for path in (ROOT / "humanoid_rail").glob("*.py"):
        if path.name != "dh.py":
            assert not re.search(r"import dh|humanoid_rail\.dh", path.read_text(encoding="utf-8")), path
    imports = re.findall(r"^(?:from|import) (\S+)", (ROOT / "humanoid_rail" / "dh.py").read_text(), re.MULTILINE)
    assert set(imports) == {"__future__", "dataclasses", "math", "typing", "numpy", "numpy.typing"}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(folder), str(ROOT)],
        check=True,
    )
    return next(folder.glob("*.whl"))


def test_the_wheel_works_outside_the_checkout(wheel: Path, tmp_path: Path) -> None:
    """The wheel, unpacked elsewhere and put before the checkout on the path."""
    site = tmp_path / "site"
    zipfile.ZipFile(wheel).extractall(site)
    code = """
import humanoid_rail
robot = humanoid_rail.load_robot(link_radius=0.03, l_l3=0.9)
trajectory = humanoid_rail.plan(robot, humanoid_rail.paper_scene(), dt=0.5)
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
        robots | {"humanoid_rail/scenes/paper.yaml", "humanoid_rail/py.typed", "humanoid_rail/scene.schema.json"}
        <= names
    )
    assert not [name for name in names if "dev" in name.split("/")]
    assert any("_engine." in name and name.endswith(".so") for name in names) or why_not_native() is not None
    top = {name.split("/")[0] for name in names}
    assert {name for name in top if not name.endswith(".dist-info")} == {"humanoid_rail"}


@pytest.mark.parametrize("page", ["README.md", *sorted(str(p.relative_to(ROOT)) for p in (ROOT / "docs").glob("*.md"))])
def test_links_of_the_documentation_lead_somewhere(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)|src=\"([^\"]+)\"", text):
        link = target[0] or target[1]
        if not link.startswith("http"):
            assert ((ROOT / page).parent / link).exists(), link


def snippets() -> list[tuple[str, str]]:
    """Return the Python blocks of the documentation, by page."""
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    found = [
        (page.name, re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)) for page in pages
    ]
    return [(name, block) for name, blocks in found for block in blocks]


@pytest.mark.parametrize(("page", "code"), snippets())
def test_the_python_of_the_documentation_runs(page: str, code: str) -> None:
    if "import pybullet" in code:
        pytest.importorskip("pybullet", reason="pybullet has no wheels for current Pythons")
    python(code, cwd=ROOT)


def test_the_readme_has_python() -> None:
    assert "README.md" in {page for page, _ in snippets()}
