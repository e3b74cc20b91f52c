"""The notebook of the documentation runs, and shows what it says it shows; pages in notebooks."""

from __future__ import annotations

from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import nbformat
import pytest
from conftest import ROOT, changed
from nbclient import NotebookClient

from humanoid_rail import InvalidInput, Robot, Scene, Trajectory, read_trajectory, view, write_trajectory
from humanoid_rail.viewer.playback import playback_html

NOTEBOOK = ROOT / "docs" / "notebook.ipynb"


class Frames(HTMLParser):
    """Keeps the attributes of frames."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[dict[str, str | None]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag == "iframe"
        self.found.append(dict(attrs))


def frame_in(html: str) -> dict[str, str | None]:
    parser = Frames()
    parser.feed(html)
    (frame,) = parser.found
    return frame


def test_the_notebook_runs(tmp_path: Path) -> None:
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "outputs are not kept in the repository"
    NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    tables = [output["data"]["text/html"] for output in shown if "text/html" in output.get("data", {})]
    planned, page, retimed = tables
    for table in (planned, retimed):
        assert "reached" in table
        assert "yes: no clearance below" in table
    assert "of least time" in planned
    assert "retimed" in retimed
    assert "MeshCat.Viewer" in frame_in(page)["srcdoc"]
    printed = "".join(output.get("text", "") for output in shown if output.output_type == "stream")
    assert "True\n" in printed
    assert "t,rail,waist_yaw" in printed


def test_a_page_is_that_of_playback_as_a_frame(
    robot: Robot, free: Scene, planned: Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    named = free.model_copy(update={"name": '<script>"&amp;'})
    page = view(planned, scene=named, height=300)
    # meshcat gives its objects random names, so no two pages are the same.
    assert abs(len(page.html) - len(playback_html(robot, named, planned))) < 2000
    assert "&lt;script&gt;&quot;&amp;amp;: humanoid_rail</title>" in page.html
    frame = frame_in(page._repr_html_())
    assert frame["srcdoc"] == page.html
    assert "height:300px" in str(frame["style"])
    assert page.save(tmp_path / "page.html").read_text(encoding="utf-8") == page.html
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda url, new: opened.append(url))
    path = page.open()
    assert opened == [path.resolve().as_uri()]


def test_a_trajectory_that_does_not_know_its_robot_says_so(planned: Trajectory, tmp_path: Path) -> None:
    write_trajectory(planned, tmp_path)
    alone = read_trajectory(tmp_path)
    for needs in (view, lambda trajectory: trajectory.resample(0.001)):
        with pytest.raises(InvalidInput, match=r"trajectory.robot is missing.*read_plan"):
            needs(alone)


def test_names_are_text_in_tables(planned: Trajectory) -> None:
    provenance = replace(planned.provenance, scene="<b>x</b>")
    html = replace(changed(planned, reason="a < b"), provenance=provenance)._repr_html_()
    assert "<b>" not in html
    assert "&lt;b&gt;x" in html
    assert "a &lt; b" in html
