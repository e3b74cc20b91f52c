"""The documentation: its links, its snippets, its commands, and the site that is built of it."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import pytest
from conftest import ROOT
from ruamel.yaml import YAML
from running import Ran

import humanoid_rail

PAGES = ["README.md", *sorted(str(path.relative_to(ROOT)) for path in (ROOT / "docs").glob("*.md"))]
COMMAND = "humanoid-rail"


def text_of(page: str) -> str:
    return (ROOT / page).read_text(encoding="utf-8")


def blocks(language: str) -> list[tuple[str, str]]:
    """Return the blocks of a language, with their pages."""
    pattern = re.compile(rf"```{language}\n(.*?)```", re.DOTALL)
    return [(page, block) for page in PAGES for block in pattern.findall(text_of(page))]


def commands() -> list[str]:
    """Return the lines of the shell blocks that call something of this repository."""
    lines = [line for _, block in blocks("sh") for line in block.replace("\\\n", " ").splitlines()]
    return [line for line in lines if re.match(rf"make |(\.venv/bin/)?{COMMAND} |\S*python scripts/", line)]


@cache
def help_of(*command: str) -> str:
    result = subprocess.run([sys.executable, *command, "--help"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    return result.stdout


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page: str) -> None:
    for target in re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)|src=\"([^\"]+)\"", text_of(page)):
        link = target[0] or target[1]
        if not link.startswith("http"):
            assert ((ROOT / page).parent / link).exists(), link


@pytest.mark.parametrize("page", sorted({page for page, _ in blocks("python")}))
def test_the_python_runs(page: str, tmp_path: Path) -> None:
    """Each block in a namespace of its own; those of a page in one process, which has to import but once."""
    for folder in ("robots", "scenes"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    codes = [code for where, code in blocks("python") if where == page]
    if not find_spec("pybullet"):  # it has no wheels for current Pythons
        codes = [code for code in codes if "import pybullet" not in code]
    for number, code in enumerate(codes):
        (tmp_path / f"block{number}.py").write_text(code, encoding="utf-8")
    run = f"import runpy\nfor number in range({len(codes)}): runpy.run_path(f'block{{number}}.py', run_name='__main__')"
    result = subprocess.run([sys.executable, "-c", run], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr


def test_readme_and_guides_have_python() -> None:
    assert {"README.md", "docs/plan.md", "docs/verify.md", "docs/objective.md"} <= {
        page for page, _ in blocks("python")
    }


@pytest.mark.parametrize("line", commands())
def test_commands_exist_with_their_options(line: str) -> None:
    program, *words = shlex.split(line, comments=True)
    if program == "make":
        targets = set(re.findall(r"^([\w-]+):", text_of("Makefile"), re.MULTILINE))
        assert {word for word in words if "=" not in word} <= targets
        return
    said = help_of("-m", "humanoid_rail", words[0]) if program.endswith(COMMAND) else help_of(words[0])
    for word in words[1:]:
        if word.startswith("-"):
            option = word.split("=")[0]
            assert re.search(rf"(?<![\w-]){option}(?![\w-])", said), f"{option} is no option:\n{said}"
        elif word.startswith(("robots/", "scenes/")):
            assert (ROOT / word).exists(), word


def quick_start() -> list[str]:
    """Return the commands of the README that take a moment, in order."""
    lines = [line for page, block in blocks("sh") if page == "README.md" for line in block.splitlines()]
    slow = re.compile(rf"{COMMAND} (play|live)|--view|--help|scripts/")
    return [line for line in lines if COMMAND in line and not slow.search(line)]


def test_the_commands_of_the_readme_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """One after the other, as they build on each other."""
    for folder in ("robots", "scenes"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    monkeypatch.chdir(tmp_path)
    lines = quick_start()
    assert {"plan", "verify", "export", "robot", "urdf"} <= {shlex.split(line)[1] for line in lines}
    for line in lines:
        ran = Ran(capfd, *shlex.split(line, comments=True)[1:])
        assert ran.code == 0, f"{line}: {ran.err}"


def test_commands_are_found() -> None:
    found = commands()
    assert any(line.startswith("make plan") for line in found)
    assert any("scripts/plan.py" in line for line in found)
    assert any(f"{COMMAND} verify" in line for line in found)


def test_every_public_name_is_on_the_page_of_the_api() -> None:
    named = re.findall(r"^::: humanoid_rail\.(\w+)$", text_of("docs/api.md"), re.MULTILINE)
    assert sorted(named) == humanoid_rail.__all__


def test_every_page_is_in_the_navigation() -> None:
    def leaves(entry: object) -> list[str]:
        if isinstance(entry, str):
            return [entry]
        return [leaf for part in (entry.values() if isinstance(entry, dict) else entry) for leaf in leaves(part)]

    named = leaves(YAML(typ="safe").load(text_of("mkdocs.yml"))["nav"])
    assert len(named) == len(set(named))
    assert {path.name for path in (ROOT / "docs").glob("*.md")} <= set(named)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, in which a link to nowhere, also to a heading, is an error."""
    folder = tmp_path_factory.mktemp("site")
    build = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    result = subprocess.run(build, cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    return folder


def test_the_site_has_every_page_and_picture(site: Path) -> None:
    for path in (ROOT / "docs").rglob("*.*"):
        shown = site / path.relative_to(ROOT / "docs")
        assert shown.with_suffix(".html" if path.suffix == ".md" else path.suffix).is_file()
    for page in site.glob("*.html"):
        for source in re.findall(r"<img[^>]* src=\"([^\"]+)\"", page.read_text(encoding="utf-8")):
            assert (page.parent / source).is_file(), f"{page.name}: {source}"


def test_formulas_are_drawn(site: Path) -> None:
    pages = {page.name: page.read_text(encoding="utf-8") for page in site.glob("*.html")}
    for name, page in pages.items():
        assert "arithmatex" not in page, name
        assert "$$" not in page, name
    for name in ("index.html", "method.html", "objective.html", "readme.html"):
        assert re.search(r'class="formula"><svg [^>]*aria-label="[^"]*J', pages[name]), name


def test_pages_fetch_nothing(site: Path) -> None:
    for page in site.glob("*.html"):
        fetched = r"<(?:script|img|iframe)[^>]* src=\"(?:https?:)?//|<link[^>]*rel=\"(?:stylesheet|preconnect)\"[^>]*//"
        assert not re.search(fetched, page.read_text(encoding="utf-8")), page.name


def test_docstrings_refer_by_links(site: Path) -> None:
    api = (site / "api.html").read_text(encoding="utf-8")
    assert not re.search(r":(?:attr|class|func|meth):", api)
    assert 'href="#humanoid_rail.read_trajectory"' in api
