"""The distance of the centre from the nearest edge of the face below it: the same as by scipy's convex hull."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from tumble.compare.contact.directions import edge_distance

ROUNDING = 1e-12


@pytest.mark.parametrize("count", [3, 4, 10, 40])
def test_random_points_have_the_hull_of_scipy(count):
    draw = np.random.default_rng(count)
    for _ in range(20):
        points = draw.normal(size=(count, 2)) + draw.normal(scale=0.5, size=2)
        assert abs(edge_distance(points) + ConvexHull(points).equations[:, 2].max()) < ROUNDING


def test_points_on_an_edge_and_inside_change_nothing():
    corners = np.array([(2.0, 1.0), (2.0, -1.0), (-2.0, -1.0), (-2.0, 1.0)])
    points = np.vstack((corners, (corners + np.roll(corners, 1, axis=0)) / 2, [(0.5, 0.5)], corners))
    assert edge_distance(points) == 1.0
    assert edge_distance(points + np.array((0.0, 3.0))) == -2.0
