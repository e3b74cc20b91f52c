"""Hooks of the documentation site (mkdocs.yml): pages from the root, formulas, and references in docstrings.

Formulas are drawn when the site is built, as SVG: they look the same everywhere, no script and no font is fetched.
"""

from __future__ import annotations

import html
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import tostring

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from ziamath.config import config as drawing
from ziamath.zmath import Latex

ROOT = Path(__file__).resolve().parent.parent

FROM_ROOT = {
    "README.md": "readme.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
    "CITATION.cff": "CITATION.cff",
}
"""Files beside docs/ that belong to the site, and what they are there."""

EM, SIZE = 16.0, 18.0
"""Sizes of text and of formulas: letters of the formulas' font are the smaller ones."""
drawing.math.color = "currentColor"
drawing.svg2 = False

NAMED = re.compile(r"\[(?:docs/)?(\w+\.md)\]\(")
FORMULA = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.DOTALL)
ROLE = re.compile(r":(?:attr|class|func|meth):<code>(?:humanoid_rail\.)?([\w.]+)</code>")


def on_files(files: Files, config: MkDocsConfig, **_: Any) -> Files:
    """Add the files from the root."""
    for source, target in FROM_ROOT.items():
        files.append(File.generated(config, target, content=(ROOT / source).read_text(encoding="utf-8")))
    return files


def on_page_markdown(markdown: str, config: MkDocsConfig, **_: Any) -> str:
    """Turn links between docs/ and the root, which are right in the repository, into those of the site.

    A link whose text is a file of docs/ gets the page's title from the navigation.
    """
    titles = dict(_titles(config.nav))
    markdown = NAMED.sub(lambda link: f"[{titles.get(link[1], link[1])}](", markdown)
    markdown = re.sub(r'(\]\(|src=")docs/', r"\1", markdown)
    for source, target in FROM_ROOT.items():
        markdown = re.sub(rf"\]\((?:\.\./)?{re.escape(source)}(?=[#)])", f"]({target}", markdown)
    return markdown


def _titles(nav: Any) -> Iterator[tuple[str, str]]:
    """Yield the pages of a navigation with their titles."""
    for entry in nav:
        for title, below in entry.items():
            if isinstance(below, str):
                yield below, title
            else:
                yield from _titles(below)


def on_page_content(content: str, **_: Any) -> str:
    """Draw formulas, and turn Sphinx's roles in docstrings into links where the API page has the name."""
    content = FORMULA.sub(_drawn, content)
    return ROLE.sub(r'<autoref identifier="humanoid_rail.\1" optional><code>\1</code></autoref>', content)


def _drawn(formula: re.Match[str]) -> str:
    kind, latex = formula[1], html.unescape(formula[2])
    svg = Latex(latex, size=SIZE, inline=kind == "span").svgxml()
    _, top, width, height = (float(number) / EM for number in svg.attrib["viewBox"].split())
    svg.attrib |= {
        "role": "img",
        "aria-label": latex,
        "width": f"{width:.3f}em",
        "height": f"{height:.3f}em",
        "style": f"vertical-align: {-(height + top):.3f}em",
    }
    return f'<{kind} class="formula">{tostring(svg, encoding="unicode")}</{kind}>'
