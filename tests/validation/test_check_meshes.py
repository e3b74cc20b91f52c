"""Random meshes against formulas of their parts: a few of them, and what the check is able to notice."""

from __future__ import annotations

import numpy as np
import pytest

from humanoid_rail.geometry.convex_decomposition import convex_pieces
from humanoid_rail.geometry.coverage import winding_numbers
from humanoid_rail.geometry.mesh_files import Triangles
from humanoid_rail.scene import obstacles
from validation.check_meshes import check, check_all, points_around, summary
from validation.random_meshes import FORMATS, make_mesh

SEED = 36


def test_random_meshes_of_every_format() -> None:
    outcomes = check_all(range(len(FORMATS)), SEED)
    assert [outcome for outcome in outcomes if outcome.broken] == []
    assert {outcome.suffix for outcome in outcomes} == set(FORMATS)
    assert sum(outcome.inside for outcome in outcomes) > 500
    assert "hold of 6 meshes out of 6" in summary(outcomes)


def test_formulas_of_parts_are_those_of_their_triangles() -> None:
    seen = 0
    for index in range(30):
        mesh, rng = make_mesh(SEED, index), np.random.default_rng(index)
        points = points_around(mesh, rng)[::20]
        for part in mesh.parts:
            placed = part.placed()
            inside = abs(winding_numbers(points, Triangles(np.array(placed.vertices), np.array(placed.faces)))) > 0.5
            np.testing.assert_array_equal(part.contains(points), inside)
            seen += inside.sum()
    assert seen > 100


def test_wrong_pieces_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(obstacles, "convex_pieces", lambda *arguments: [0.8 * p for p in convex_pieces(*arguments)])
    assert any("outside of all pieces" in outcome for outcome in check(SEED, 0).broken)
    monkeypatch.setattr(obstacles, "convex_pieces", lambda *arguments: [1.3 * p for p in convex_pieces(*arguments)])
    assert any("outside is in a piece" in outcome for outcome in check(SEED, 0).broken)
