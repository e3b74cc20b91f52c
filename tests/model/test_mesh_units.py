"""Meshes of robots whose numbers are in another unit than metres."""

from __future__ import annotations

from pathlib import Path

import pytest
import trimesh

from humanoid_rail import load_robot

LIMIT = '<limit lower="-1" upper="1" velocity="1" effort="1"/>'


@pytest.mark.parametrize(("scale", "said"), [("1", "200 m large.*scale 0.001"), ("1e-6", "0.0002 m large.*scale 1")])
def test_they_are_warned_of(scale: str, said: str, tmp_path: Path) -> None:
    file = tmp_path / "ball.stl"
    trimesh.creation.icosphere(1, 100.0).export(file)
    mesh = f'<geometry><mesh filename="{file}" scale="{scale} {scale} {scale}"/></geometry>'
    joint = f'<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>{LIMIT}</joint>'
    urdf = f'<robot name="r"><link name="a"/><link name="b"><collision>{mesh}</collision></link>{joint}</robot>'
    for _ in range(2):  # the second time the body is read from the cache
        with pytest.warns(UserWarning, match=rf"ball\.stl is {said}"):
            load_robot(urdf, hands={"tip": "b"})
