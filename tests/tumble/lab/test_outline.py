"""What is drawn of a body: its faces look outward, and only real edges are edges."""

import numpy as np
import pytest

from tumble.lab.outline import Outline, edges, faces, normals
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


def test_a_ball_is_drawn_round_with_its_great_circles_wherever_its_points_are():
    body = read_scene("ball-slip-to-roll").body
    outline = Outline.of(body)
    turned = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    points = outline.points(body.points @ turned + (3.0, -2.0, 1.0)) - (3.0, -2.0, 1.0)
    assert np.linalg.norm(points, axis=1) == pytest.approx(np.full(len(points), body.radius))
    middles = points[outline.faces].mean(axis=1)
    outwards = np.einsum("ij,ij->i", normals(points, outline.faces), middles)
    assert (outwards > 0.98 * np.linalg.norm(middles, axis=1)).all()
    ends = points[outline.edges]
    assert (np.abs(ends).min(axis=2) < 1e-12).all(), "an edge that lies in no plane of two axes"
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()
    assert length == pytest.approx(3 * 2 * np.pi * body.radius, rel=0.01)


def test_a_disc_is_drawn_round_with_its_rims_wherever_its_points_are():
    body = read_scene("disc-rolls").body
    outline = Outline.of(body)
    turned = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    points = (outline.points(body.points @ turned + (3.0, -2.0, 1.0)) - (3.0, -2.0, 1.0)) @ turned.T
    rims = np.hypot(points[:, 0], points[:, 1]) > 1e-9
    assert np.hypot(*points[rims, :2].T) == pytest.approx(np.full(rims.sum(), body.disc.radius))
    assert np.abs(points[:, 2]) == pytest.approx(np.full(len(points), body.disc.thickness / 2))
    middles = points[outline.faces].mean(axis=1)
    assert (np.einsum("ij,ij->i", normals(points, outline.faces), middles) > 0).all()
