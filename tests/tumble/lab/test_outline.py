"""What is drawn of a body: its faces look outward, and only real edges are edges."""

import numpy as np
import pytest

from tumble.lab.outline import edges, faces, normals
from tumble.scenarios.read import read_scene


@pytest.mark.parametrize(("name", "count"), [("two-hits", 12), ("table-4-1", 12), ("nesc-brick", 12)])
def test_a_box_has_twelve_edges_whether_it_is_one_or_only_its_corners(name, count):
    assert len(edges(read_scene(name).body)) == count


@pytest.mark.parametrize("name", ["two-hits", "mesh-die", "nesc-brick"])
def test_faces_look_outward(name):
    body = read_scene(name).body
    middles = body.points[faces(body)].mean(axis=1) - body.points.mean(axis=0)
    assert (np.einsum("ij,ij->i", normals(body.points, faces(body)), middles) > 0).all()


def test_points_that_lie_in_a_plane_are_joined_by_lines():
    body = read_scene("dzhanibekov").body
    assert len(edges(body)) > 0
