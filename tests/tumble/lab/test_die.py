"""The pips: those of a die, on its faces, outside, and none on a body that is no box."""

import numpy as np
import pytest

from tumble.lab.die import CORNERS, pips
from tumble.scenarios.read import read_scene


@pytest.mark.parametrize("name", ["die-ray", "two-hits"])
def test_opposite_faces_have_seven_pips_each_a_disc_just_outside_the_face(name):
    body = read_scene(name).body
    points, triangles = pips(body)
    half = body.size / 2
    counts = {}
    for disc in points.reshape(-1, CORNERS, 3):
        middle = disc.mean(axis=0)
        axis = int(np.argmax(np.abs(middle) / half))
        side = int(np.sign(middle[axis]))
        counts[axis, side] = counts.get((axis, side), 0) + 1
        assert 0 < np.abs(disc[:, axis]).min() - half[axis] < 0.01 * body.reach
        assert (np.abs(np.delete(disc, axis, axis=1)) < np.delete(half, axis)).all()
    assert sorted(counts.values()) == [1, 2, 3, 4, 5, 6]
    assert all(counts[axis, 1] + counts[axis, -1] == 7 for axis in range(3))
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), a) > 0).all(), "a pip looks inwards, and is not seen"


def test_no_other_body_has_pips():
    assert len(pips(read_scene("mesh-die").body)[1]) == 0
