"""What shows how much is done leaves the streams of the process alone, which belong to all threads."""

from __future__ import annotations

import sys

import pytest

from humanoid_rail.progress import progress, progress_bar


def test_streams_are_not_replaced(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")  # a terminal, as far as rich is concerned
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    streams = sys.stdout, sys.stderr
    with progress("planning"), progress_bar("scenes", 3) as advance:
        assert (sys.stdout, sys.stderr) == streams
        advance(3)
    out, err = capsys.readouterr()
    assert out == ""
    assert "scenes" in err
    assert "3/3" in err
