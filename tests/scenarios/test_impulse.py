"""The jump of an impulse: where it lands, what it changes, and the first surface a ray meets."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tumble.scenarios import mass
from tumble.scenarios.frames import rotation_matrix, vertices
from tumble.scenarios.impulse import RayMissed, jump, strike_point
from tumble.scenarios.ray import first_hit
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Body, Impulse, Ray
from tumble.scenarios.truth import truth

SIZE = np.array([0.4, 0.15, 0.1])
BRICK = Body("box", 2.4, np.diag(mass.box(2.4, SIZE).tensor), mass.box_corners(SIZE), mass.BOX_FACES, SIZE)
# Turned, moving and spinning: nothing along an axis, nothing zero.
TURNED = np.array([[0.3, -1.2, 0.7, 0.8, 0.2, -0.4, 0.4, 0.5, 3.0, -1.0, 0.2, -0.1, 0.4]])
BLOW = np.array([-3.1, 0.9, 2.2])

vectors = st.lists(st.floats(-5, 5), min_size=3, max_size=3).map(np.array)
quaternions = st.lists(st.floats(-1, 1), min_size=4, max_size=4).map(np.array).filter(lambda q: np.linalg.norm(q) > 0.1)


def world_tensor(state: np.ndarray) -> np.ndarray:
    axes = rotation_matrix(state[3:7])
    return axes @ np.diag(BRICK.moments) @ axes.T


def ray_to(spot: np.ndarray, direction: np.ndarray, distance: float = 3.0) -> Ray:
    unit = direction / np.linalg.norm(direction)
    return Ray(spot - distance * unit, unit)


def test_the_ways_to_name_one_spot_agree(tmp_path):
    # The blow at vertex 3 goes into the brick there, so a ray along it meets that vertex first.
    spot = vertices(TURNED[0], BRICK.points)[3]
    inward = TURNED[0, 0:3] - spot
    origin = (spot - 2 * inward).tolist()
    landings = (
        "vertex = 3",
        f"point = {spot.tolist()}",
        f"point_body = {BRICK.points[3].tolist()}",
        f"ray = {{ origin = {origin}, direction = {inward.tolist()} }}",
    )
    after = []
    for number, landing in enumerate(landings):
        file = tmp_path / f"{number}.toml"
        file.write_text(
            f"""
            title = "one spot"
            duration = 1.0
            samples = 1
            step = 0.1
            body = {{ shape = "box", size = {SIZE.tolist()}, mass = 2.4, position = {TURNED[0, 0:3].tolist()},
                orientation = [0.8, 0.2, -0.4, 0.4], velocity = {TURNED[0, 7:10].tolist()},
                angular_velocity = {TURNED[0, 10:13].tolist()} }}
            impulse = [{{ value = {BLOW.tolist()}, {landing} }}]
        """.replace("\n                ", " ")
        )
        scene = read_scene(str(file))
        after.append(jump(scene.impulses[0], scene.start, scene.body))
    for other in after[1:]:
        # The spin is some 70 rad/s: roundings of the lever, of 2e-16 m in 0.2, show as 1e-13 rad/s.
        np.testing.assert_allclose(other, after[0], rtol=0, atol=1e-12)
    assert np.abs(after[0][0, 10:13]).max() > 10, "a blow that hardly turns the brick shows nothing"


def test_through_the_centre_it_does_not_turn():
    struck = jump(Impulse(0.0, BLOW, point_body=np.zeros(3)), TURNED, BRICK)
    assert struck[0, 10:13].tolist() == TURNED[0, 10:13].tolist()
    np.testing.assert_allclose(struck[0, 7:10], TURNED[0, 7:10] + BLOW / 2.4, rtol=1e-15)


@settings(derandomize=True, deadline=None, max_examples=100)
@given(q=quaternions, x=vectors, v=vectors, w=vectors, r=vectors, blow=vectors)
def test_momentum_gains_the_blow_and_angular_momentum_its_moment(q, x, v, w, r, blow):
    before = np.concatenate((x, q / np.linalg.norm(q), v, w))
    (after,) = jump(Impulse(0.0, blow, point_world=r), before[None], BRICK)
    assert after[0:7].tolist() == before[0:7].tolist(), "a jump does not move the body"
    np.testing.assert_allclose(2.4 * (after[7:10] - before[7:10]), blow, rtol=0, atol=1e-14)
    # Levers and blows up to 10 and 5 give spins of 1e4 rad/s on the thinnest axis, taken back through the tensor.
    gained = world_tensor(before) @ (after[10:13] - before[10:13])
    np.testing.assert_allclose(gained, np.cross(r - x, blow), rtol=0, atol=1e-12)


def test_every_throw_is_struck_where_it_stands():
    throws = np.repeat(TURNED, 2, axis=0)
    throws[1, 0:7] = (1.0, 2.0, 3.0, 0.5, 0.5, 0.5, 0.5)
    impulse = Impulse(0.0, BLOW, point_body=BRICK.points[6])
    struck = jump(impulse, throws, BRICK)
    assert struck[0].tolist() == jump(impulse, throws[:1], BRICK)[0].tolist()
    assert struck[1].tolist() == jump(impulse, throws[1:], BRICK)[0].tolist()
    assert throws[0].tolist() == TURNED[0].tolist(), "the states before are left alone"


@settings(derandomize=True, deadline=None, max_examples=100)
@given(
    q=quaternions,
    direction=vectors.filter(lambda d: np.linalg.norm(d) > 0.1),
    spot=st.lists(st.floats(-0.99, 0.99), min_size=3, max_size=3).map(np.array),
)
def test_a_ray_stops_at_the_first_surface(q, direction, spot):
    state = np.concatenate((TURNED[0, 0:3], q / np.linalg.norm(q), np.zeros(6)))
    axes = rotation_matrix(state[3:7])
    inside = state[0:3] + axes @ (spot * SIZE / 2)
    ray = ray_to(inside, direction)
    hit = axes.T @ (strike_point(Impulse(0.0, BLOW, ray=ray), state, BRICK) - state[0:3])
    # On the surface, and the slab method's entry: the last of the three slabs to be entered.
    assert np.abs(np.abs(hit) / (SIZE / 2)).max() == pytest.approx(1, abs=1e-12)
    towards = axes.T @ ray.direction
    start = axes.T @ (ray.origin - state[0:3])
    with np.errstate(divide="ignore"):
        entry = ((-np.sign(towards) * SIZE / 2 - start) / towards)[towards != 0].max()
    np.testing.assert_allclose(hit, start + entry * towards, rtol=0, atol=1e-13)


@pytest.mark.parametrize("target", [(0.0, 0.0), (0.2, 0.075), (0.2, 0.0), (-0.2, 0.075), (0.1, 0.0375)])
def test_nothing_slips_past_an_edge(target):
    # The middle and the corners lie on the face's diagonal, the others on its rim.
    spot = np.array([*target, 0.05])
    for aslant in ((0.0, 0.0, -1.0), (-0.1, -0.2, -1.0), (-1e-3, -1e-3, -1.0)):
        ray = ray_to(spot, np.array(aslant))
        hit = first_hit(ray.origin, ray.direction, BRICK.points, BRICK.faces)
        assert hit is not None
        assert not hit.from_inside
        assert hit.distance == pytest.approx(3, abs=1e-14)


def test_from_a_thousand_kilometres_nothing_slips_between_the_halves_of_a_face():
    # So far off the ray itself is only good to 1e-10 m; but both triangles must see the same ray.
    for part in np.linspace(-0.9, 0.9, 101):
        ray = ray_to(np.array([0.2 * part, 0.075 * part, 0.05]), np.array([-0.3, 0.2 * part, -1.1]), 1e6)
        hit = first_hit(ray.origin, ray.direction, BRICK.points, BRICK.faces)
        assert hit is not None
        assert not hit.from_inside
        assert hit.distance == pytest.approx(1e6, abs=1e-9)


@pytest.mark.parametrize(
    ("origin", "direction", "reason"),
    [
        ((0.21, 0.0, 1.0), (0.0, 0.0, -1.0), "misses"),
        ((0.0, 0.0, 1.0), (0.0, 0.0, 1.0), "misses"),
        ((0.0, 1.0, 0.0500001), (0.0, -1.0, 0.0), "misses"),
        ((0.0, 0.0, 0.04), (0.0, 0.0, -1.0), "inside"),
        ((0.19, 0.07, 0.0), (0.3, 0.2, 0.1), "inside"),
    ],
    ids=["beside", "away", "just above, edge-on", "inside", "inside, aslant"],
)
def test_no_hit_is_said_with_its_reason(origin, direction, reason):
    rest = np.array([0.0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0])
    unit = np.array(direction) / np.linalg.norm(direction)
    with pytest.raises(RayMissed, match=reason):
        strike_point(Impulse(0.0, BLOW, ray=Ray(np.array(origin), unit)), rest, BRICK)


def test_a_ray_in_the_plane_of_a_face_meets_the_side_it_runs_into():
    hit = first_hit(np.array([1.0, 0.0, 0.05]), np.array([-1.0, 0.0, 0.0]), BRICK.points, BRICK.faces)
    assert hit is not None
    assert hit.distance == pytest.approx(0.8, abs=1e-15)
    assert not hit.from_inside


def test_a_ray_that_starts_on_the_surface_strikes_there():
    for z in np.linspace(0.03, 0.07, 41):
        thick = mass.box_corners(np.array([0.4, 0.15, 2 * z]))
        hit = first_hit(np.array([0.1, 0.02, z]), np.array([0.6, 0.0, -0.8]), thick, BRICK.faces)
        assert hit is not None
        assert not hit.from_inside
        assert hit.distance == pytest.approx(0, abs=1e-13)


def test_a_silhouette_edge_is_struck_from_outside():
    # The ray touches the edge x = 0.2, z = 0.05 where one face looks at it and the other away.
    spot, along = np.array([0.2, 0.01, 0.05]), np.array([1.0, 0.0, 1.0])
    for direction in (along, -along):
        ray = ray_to(spot, direction * (1, 1, -1))
        hit = first_hit(ray.origin, ray.direction, BRICK.points, BRICK.faces)
        assert hit is not None
        assert not hit.from_inside


def test_a_mesh_with_a_hollow_is_struck_on_its_near_wall():
    # Two boxes side by side as one surface: a ray along both must stop at the nearer, whatever the order of faces.
    near, far = (mass.box_corners(np.ones(3)) + np.array([x, 0.0, 0.0]) for x in (2.0, -2.0))
    for first, second in ((near, far), (far, near)):
        points, faces = np.concatenate((first, second)), np.concatenate((mass.BOX_FACES, mass.BOX_FACES + 8))
        hit = first_hit(np.array([9.0, 0.1, 0.2]), np.array([-1.0, 0.0, 0.0]), points, faces)
        assert hit is not None
        assert hit.distance == pytest.approx(6.5, abs=1e-14)
        assert not hit.from_inside
        between = first_hit(np.array([0.0, 0.1, 0.2]), np.array([-1.0, 0.0, 0.0]), points, faces)
        assert between is not None
        assert between.distance == pytest.approx(1.5, abs=1e-14)


@pytest.mark.parametrize("time", [0.0, 0.25])
def test_a_ray_meets_a_sphere_where_the_closed_form_says(tmp_path, time):
    """A ray beside the centre by b meets it sqrt(r^2 - b^2) before the middle, wherever it turns: torque is b J."""
    file, b, J = tmp_path / "a.toml", 0.3, 1.5
    text = f"""
        title = "a"
        duration = 1.0
        samples = 4
        step = 0.1
        body = {{ shape = "sphere", radius = 0.5, mass = 2.0, position = [1.0, 2.0, 3.0],
            orientation = [0.9, 0.1, 0.2, 0.3], angular_velocity = [0.0, 0.0, 4.0] }}
        impulse = [{{ time = {time}, magnitude = {J}, ray = {{ origin = [1.0, {2 + b}, 9], direction = [0, 0, -2] }} }}]
    """.replace("\n            ", " ")
    file.write_text(text)
    scene = read_scene(str(file))
    impulse, state = scene.impulses[0], scene.start[0]
    spot = strike_point(impulse, state, scene.body)
    np.testing.assert_allclose(spot, (1.0, 2 + b, 3 + 0.4), rtol=1e-14)
    spin = (-b * J / (0.4 * 2.0 * 0.25), 0.0, 4.0)
    np.testing.assert_allclose(jump(impulse, scene.start, scene.body)[0, 10:13], spin, rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(truth(scene).states[-1, 0, 10:13], spin, rtol=1e-15, atol=1e-15)
    for origin, why in ((2 + 0.6, "misses"), (2 + b, "inside")):
        start = 3.0 if why == "inside" else 9.0
        with pytest.raises(RayMissed, match=why):
            strike_point(
                Impulse(0.0, BLOW, ray=Ray(np.array([1.0, origin, start]), impulse.ray.direction)), state, scene.body
            )
        if time:
            file.write_text(text.replace(", 9]", f", {start}]").replace(f"{2 + b}", str(origin)))
            with pytest.raises(RayMissed, match=why):
                truth(read_scene(str(file)))
