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
from mkdocs.structure.pages import Page
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
API = "api.md"
"""The page that is made of docstrings."""
PLAIN = {
    "d mu / dq": r"\partial\mu/\partial q",
    "d psi / dq": r"\partial\psi/\partial q",
    "d psi/dq": r"\partial\psi/\partial q",
    "de/dq": r"\partial e/\partial q",
    "c_kappa": r"c_\kappa",
    "c_mu": r"c_\mu",
    "f(q)": "f(q)",
    "J_dot": r"\dot J",
    "J#": r"J^\sharp",
    "kappa": r"\kappa",
    "m/s^2": r"\text{m/s}^2",
    "m/s^3": r"\text{m/s}^3",
    "rad/s^2": r"\text{rad/s}^2",
    "rad/s^3": r"\text{rad/s}^3",
    "kg/m^3": r"\text{kg/m}^3",
    "mu": r"\mu",
    "psi": r"\psi",
    "q_dot": r"\dot q",
    "|e|": r"\lvert e \rvert",
}
"""What docstrings, which are read in editors too, write plainly, and how the site draws it."""
SYMBOL = re.compile(
    "|".join(rf"(?<![\w/`.]){re.escape(plain)}(?!\w)" for plain in sorted(PLAIN, key=len, reverse=True))
)
NO_TEXT = re.compile(r"(<(?:pre|code|svg|h\d)\b.*?</(?:pre|code|svg|h\d)>|<[^>]+>)", re.DOTALL)
"""Tags, and what is not prose between them."""

ROLE = re.compile(r":(?:attr|class|func|meth|mod):<code>(?:humanoid_rail\.)?([\w.]+)</code>")


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


def on_page_content(content: str, page: Page, **_: Any) -> str:
    """Draw formulas, also those of docstrings, and turn Sphinx's roles into links where the API page has the name."""
    content = FORMULA.sub(_drawn, content)
    if page.file.src_uri == API:
        parts = NO_TEXT.split(content)
        parts[::2] = [SYMBOL.sub(lambda plain: _svg(PLAIN[plain[0]], "span"), text) for text in parts[::2]]
        content = "".join(parts)
    return ROLE.sub(r'<autoref identifier="humanoid_rail.\1" optional><code>\1</code></autoref>', content)


def _drawn(formula: re.Match[str]) -> str:
    return _svg(html.unescape(formula[2]), formula[1])


def _svg(latex: str, kind: str) -> str:
    """Return a formula as SVG in a `span`, or set off in a `div`."""
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
