"""No two collision bodies of a robot have one name."""

from __future__ import annotations

from itertools import product

import numpy as np
from arms import ball, long_arm

from humanoid_rail.model.building import read_mechanism
from humanoid_rail.model.collision_bodies import collision_bodies


def test_a_link_may_be_called_as_a_piece_of_another_ones_mesh() -> None:
    mesh = '<collision><geometry><mesh filename="a.stl"/></geometry></collision>'
    urdf = long_arm(links={"l0": mesh, "l1": ball(0.01) * 2}).replace('"l1"', '"l0_0"')
    mechanism = read_mechanism(urdf)
    [body] = mechanism.urdf.links["l0"].collisions
    cube = np.array(list(product((0.0, 0.1), repeat=3)))
    made = collision_bodies(mechanism.model, mechanism.urdf, {body.where: (cube, cube + 1.0)})
    names = [body.name for body in made.geometryObjects]
    assert {"l0_0.0", "l0_0.1", "l0_0_0", "l0_0_1"} <= set(names)
    assert len(set(names)) == len(names)
