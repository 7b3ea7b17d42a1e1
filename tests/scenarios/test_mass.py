"""Mass properties against formulas from books, against trimesh's own integrals, and under moving and turning."""

from itertools import permutations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from tumble.scenarios import mass
from tumble.scenarios.frames import rotation_matrix

# The sums have a few dozen terms of the size of the result: some tens of roundings of 1.1e-16.
ROUNDING = 1e-14

TETRAHEDRON = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
TETRAHEDRON_FACES = np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
SHEAR = np.array([(1.0, 0.6, -0.3), (0.0, 0.8, 0.5), (0.0, 0.0, 1.3)])

lengths = st.floats(0.1, 10)
quaternions = st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda q: np.linalg.norm(q) > 0.1)


def turn_of(q: list[float]) -> np.ndarray:
    return rotation_matrix(np.array(q) / np.linalg.norm(q))


def close(value, expected, relative=ROUNDING):
    np.testing.assert_allclose(value, expected, rtol=0, atol=relative * np.abs(expected).max())


def sheared_box() -> np.ndarray:
    """A leaning box off its origin: every product of inertia is there."""
    return mass.box_corners(np.array([1.0, 2.0, 3.0])) @ SHEAR.T + np.array([5.0, -7.0, 3.0])


def lumpy() -> tuple[np.ndarray, np.ndarray]:
    """A body that is not convex: a ball of 320 triangles with its northern half pushed in and stretched."""
    ball = trimesh.creation.icosphere(subdivisions=2)
    points = np.array(ball.vertices)
    points[:, 2] = np.where(points[:, 2] > 0, 0.5 * points[:, 0] ** 2 - 0.2 * points[:, 2], points[:, 2] - 0.3)
    return points + np.array([0.3, 0.2, -0.4]), np.array(ball.faces)


def test_vertices_of_a_box_are_in_the_order_of_the_scene_file():
    corners = mass.box_corners(np.array([2.0, 4.0, 6.0]))
    assert corners[[0, 1, 2, 4, 7]].tolist() == [[-1, -2, -3], [-1, -2, 3], [-1, 2, -3], [1, -2, -3], [1, 2, 3]]


def test_faces_of_a_box_close_and_look_outwards():
    corners = mass.box_corners(np.array([2.0, 4.0, 6.0]))
    a, b, c = np.moveaxis(corners[mass.BOX_FACES], 1, 0)
    normals = np.cross(b - a, c - a)
    assert (np.einsum("ij,ij->i", normals, a + b + c) > 0).all()
    assert np.linalg.norm(normals, axis=1).sum() / 2 == 2 * (2 * 4 + 4 * 6 + 6 * 2)
    assert trimesh.Trimesh(corners, mass.BOX_FACES, process=False).is_watertight


def test_a_box_by_the_formula_and_by_its_surface():
    size = np.array([0.4, 0.15, 0.1])
    by_formula = mass.box(2.4, size)
    by_surface = mass.mesh(2.4, mass.box_corners(size), mass.BOX_FACES)
    close(np.diag(by_formula.tensor), [0.2 * (0.15**2 + 0.1**2), 0.2 * (0.1**2 + 0.4**2), 0.2 * (0.4**2 + 0.15**2)])
    close(by_surface.tensor, by_formula.tensor)
    close(by_surface.volume, by_formula.volume)
    assert np.abs(by_surface.centre).max() < ROUNDING


def test_a_right_tetrahedron():
    # Of the corner x + y + z < 1 with mass 1: mean of x^2 is 1/10, of x y 1/20; about the centre (1/4, 1/4, 1/4) they
    # are 1/10 - 1/16 = 3/80 and 1/20 - 1/16 = -1/80.  So A = 6/80 and -H = 1/80 (CE1051A report, eqs. 2.6-2.8).
    solid = mass.mesh(1.0, TETRAHEDRON, TETRAHEDRON_FACES)
    close(solid.volume, 1 / 6)
    close(solid.centre, np.full(3, 1 / 4))
    close(solid.tensor, (np.full((3, 3), 1) + 5 * np.eye(3)) / 80)


def test_a_sheared_box_has_the_products_its_shear_gives():
    # r = S r0 + d takes the mean of r0 r0^T, diag(size^2) / 12, to S diag S^T: an affine map keeps density uniform.
    second = SHEAR @ np.diag(np.array([1.0, 2.0, 3.0]) ** 2 / 12) @ SHEAR.T
    solid = mass.mesh(7.0, sheared_box(), mass.BOX_FACES)
    close(solid.tensor, 7.0 * (np.trace(second) * np.eye(3) - second))
    close(solid.centre, (5.0, -7.0, 3.0))
    close(solid.volume, 6.0 * np.linalg.det(SHEAR))


@pytest.mark.parametrize(("points", "faces"), [(sheared_box(), mass.BOX_FACES), lumpy()], ids=["sheared box", "lumpy"])
def test_trimesh_integrates_to_the_same(points, faces):
    other = trimesh.Trimesh(points, faces, process=False)
    other.density = 3.0 / other.volume
    solid = mass.mesh(3.0, points, faces)
    # trimesh takes its moments about the file's origin and then moves them: more roundings than ours.
    close(solid.volume, other.volume, 1e-13)
    close(solid.centre, other.center_mass, 1e-13)
    close(solid.tensor, other.moment_inertia, 1e-12)


@settings(derandomize=True, deadline=None, max_examples=50)
@given(q=quaternions, shift=st.lists(st.floats(-10, 10), min_size=3, max_size=3))
def test_moving_moves_the_centre_and_turning_turns_the_tensor(q, shift):
    points, faces = lumpy()
    turn, solid = turn_of(q), mass.mesh(2.0, points, faces)
    moved = mass.mesh(2.0, points @ turn.T + shift, faces)
    close(moved.volume, solid.volume, 1e-13)
    # Moving by 10 rounds the points of a body of 2 by 1e-15.
    np.testing.assert_allclose(moved.centre, turn @ solid.centre + shift, rtol=0, atol=1e-14)
    close(moved.tensor, turn @ solid.tensor @ turn.T, 1e-13)


def test_a_mesh_a_thousand_kilometres_from_its_origin_loses_only_what_its_points_lost():
    points, faces = lumpy()
    far = mass.mesh(2.0, np.round(points * 1024) / 1024 + 2.0**20, faces)  # sums that a float holds exactly
    near = mass.mesh(2.0, np.round(points * 1024) / 1024, faces)
    close(far.tensor, near.tensor)
    close(far.centre - 2.0**20, near.centre, 2**-32)  # a centre at 2^20 is itself rounded to 2^-33


def test_two_halves_make_the_whole_by_the_parallel_axis_theorem():
    whole = mass.box(2.0, np.array([2.0, 1.0, 3.0]))
    halves = np.zeros((3, 3))
    for side in (-0.5, 0.5):
        half = mass.mesh(1.0, mass.box_corners(np.array([1.0, 1.0, 3.0])) + np.array([side, 0, 0]), mass.BOX_FACES)
        arm = half.centre
        halves += half.tensor + (arm @ arm * np.eye(3) - np.outer(arm, arm))
    close(halves, whole.tensor)


def test_inside_out_has_negative_volume_and_the_same_tensor():
    points, faces = lumpy()
    solid, inverted = mass.mesh(2.0, points, faces), mass.mesh(2.0, points, faces[:, ::-1])
    close(inverted.volume, -solid.volume)
    close(inverted.tensor, solid.tensor)


def test_a_needle_keeps_the_digits_of_its_smallest_moment():
    size = np.array([1.0, 1e-6, 1e-6])
    needle = mass.mesh(1.0, mass.box_corners(size), mass.BOX_FACES)
    across = (1 + 1e-12) / 12
    np.testing.assert_allclose(np.diag(needle.tensor), (2e-12 / 12, across, across), rtol=1e-13)


@pytest.mark.parametrize("scale", [1e-100, 1e100])
def test_any_unit_of_length(scale):
    solid, scaled = (mass.mesh(1.0, points, TETRAHEDRON_FACES) for points in (TETRAHEDRON, scale * TETRAHEDRON))
    close(scaled.tensor, scale**2 * solid.tensor)


@pytest.mark.parametrize("points", [TETRAHEDRON * (1, 1, 0), TETRAHEDRON * 0], ids=["flat", "one point"])
def test_no_volume_is_refused(points):
    with pytest.raises(ValueError, match="must enclose a volume"):
        mass.mesh(1.0, points, TETRAHEDRON_FACES)


@settings(derandomize=True, deadline=None, max_examples=100)
@given(q=quaternions, size=st.tuples(lengths, lengths, lengths))
def test_principal_axes_diagonalise_and_turn_least(q, size):
    turn, moments = turn_of(q), np.diag(mass.box(1.0, np.array(size)).tensor)
    tensor = turn @ np.diag(moments) @ turn.T
    tensor = (tensor + tensor.T) / 2
    found, file_axes = mass.principal_axes(tensor)
    axes = rotation_matrix(file_axes)
    close(np.sort(found), np.sort(moments))
    close(axes @ tensor @ axes.T, np.diag(found))
    # No order and no choice of signs of the axes lies nearer: the trace is 1 + 2 cos(angle).
    for order in permutations(range(3)):
        signs = np.sign([axes[order[i], i] for i in range(3)])
        other = signs[:, None] * axes[list(order)]
        if np.linalg.det(other) > 0:
            assert np.trace(other) <= np.trace(axes) + ROUNDING


def test_axes_of_a_diagonal_tensor_stay_exactly():
    tensor = np.diag([3.0, 1.0, 2.0])
    tensor[0, 1] = tensor[1, 0] = 2e-15
    moments, file_axes = mass.principal_axes(tensor)
    assert moments.tolist() == [3.0, 1.0, 2.0]
    assert file_axes.tolist() == [1.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("moments", [(2.0, 2.0, 3.0), (2.0, 1.0, 2.0)])
def test_equal_moments_take_the_axes_nearest_the_file(moments):
    # Tilted by 0.3 rad about z the body has one axis off; the twist about it is free, and none is nearest.
    tilt = rotation_matrix(np.array([np.cos(0.15), np.sin(0.15), 0.0, 0.0]))
    twist_axis = int(np.argmax([moments.count(moment) == 1 for moment in moments]))
    twist = np.zeros(4)
    twist[0], twist[1 + twist_axis] = np.cos(0.7), np.sin(0.7)
    body = tilt @ rotation_matrix(twist)
    found, file_axes = mass.principal_axes(body @ np.diag(moments) @ body.T)
    close(found, moments)
    # The rotation with the least angle that carries one given axis onto another is the one about their normal.
    close(rotation_matrix(file_axes), tilt.T)


def test_a_cube_however_turned_has_its_file_axes_as_principal_ones():
    body = turn_of([0.3, -0.4, 0.5, 0.7])
    found, file_axes = mass.principal_axes(body @ (2.0 * np.eye(3)) @ body.T + 3e-15 * np.ones((3, 3)))
    assert found[0] == found[1] == found[2]
    close(file_axes, [1.0, 0.0, 0.0, 0.0])
