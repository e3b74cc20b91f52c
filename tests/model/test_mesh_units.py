"""Meshes of robots whose numbers are in another unit than metres."""

from __future__ import annotations

from pathlib import Path

import pytest
import trimesh

from humanoid_rail import load_robot


@pytest.mark.parametrize(("scale", "said"), [("1", "200 m large.*scale 0.001"), ("1e-6", "0.0002 m large.*scale 1")])
def test_they_are_warned_of(scale: str, said: str, tmp_path: Path) -> None:
    file = tmp_path / "ball.stl"
    trimesh.creation.icosphere(1, 100.0).export(file)
    mesh = f'<geometry><mesh filename="{file}" scale="{scale} {scale} {scale}"/></geometry>'
    links = "".join(f'<link name="l{i}"/>' for i in range(3)) + f'<link name="l3"><collision>{mesh}</collision></link>'
    joints = "".join(
        f'<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
        for i in range(3)
    )
    for _ in range(2):  # the second time the body is read from the cache
        with pytest.warns(UserWarning, match=rf"ball\.stl is {said}"):
            load_robot(f'<robot name="r">{links}{joints}</robot>', hands={"tip": "l3"})
