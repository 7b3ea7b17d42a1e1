"""Scene files become the scenes they say: the catalogue, the defaults, other axes, meshes, and what a scene needs."""

import logging
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from tumble.scenarios import mass
from tumble.scenarios.catalogue import make_mesh_die
from tumble.scenarios.frames import quaternion_product, rotation_matrix, vertices
from tumble.scenarios.impulse import jump, strike_point
from tumble.scenarios.needs import FORCES, needs
from tumble.scenarios.published import VERTEX, table_4_1
from tumble.scenarios.read import CATALOGUE, catalogue, read_scene
from tumble.scenarios.scene import Scene
from tumble.scenarios.surface import read_surface

HEAD = 'title = "a"\nduration = 1.0\nsamples = 4\nstep = 0.1\n'
BOX = 'shape = "box"\nsize = [1.0, 2.0, 3.0]\nmass = 2.0\n'
EPS = np.finfo(float).eps


@pytest.fixture
def read(tmp_path):
    """Read a scene from the text of its [body] and what comes after, and of what comes before."""

    def read_text(body: str = BOX, before: str = "") -> Scene:
        (tmp_path / "a.toml").write_text(f"{HEAD}{before}[body]\n{body}")
        return read_scene(str(tmp_path / "a.toml"))

    return read_text


def struck(scene: Scene) -> np.ndarray:
    states = scene.start
    for impulse in scene.impulses:
        if impulse.time == 0:
            states = jump(impulse, states, scene.body)
    return states


def spun(state: np.ndarray, t: float) -> np.ndarray:
    """Free flight of a cube, whose axis of spin stays where it is."""
    w = np.linalg.norm(state[10:13])
    turn = np.array([np.cos(w * t / 2), *(np.sin(w * t / 2) * state[10:13] / w)])
    return np.concatenate((state[0:3] + t * state[7:10], quaternion_product(turn, state[3:7]), state[7:13]))


# --- the catalogue


@pytest.mark.parametrize("name", catalogue())
def test_a_scene_of_the_catalogue_is_sane(name):
    scene = read_scene(name)
    assert scene.name == name
    assert scene.title
    assert scene.source
    assert len(scene.times) <= 40
    assert scene.duration / scene.step <= 5000
    assert np.isfinite(struck(scene)).all()
    # Steps are for rigid bodies that turn by a visible angle a step at most, or the scene shows only blow-up.
    assert np.linalg.norm(struck(scene)[0, 10:13]) * scene.step < 0.1


def test_what_each_scene_of_the_catalogue_needs():
    assert {name: needs(read_scene(name)) for name in catalogue()} == {
        "brick-tumble": ("gravity", "rotation", "gyroscopic"),
        "die-ray": ("gravity", "rotation"),
        "die-straight": ("gravity",),
        "die-vertex": ("gravity", "rotation"),
        "drag-stiff": ("gravity", "drag", "rotation", "gyroscopic"),
        "dzhanibekov": ("rotation", "gyroscopic"),
        "floor-stiff": ("gravity", "floor", "rotation"),
        "many-throws": ("gravity", "rotation", "gyroscopic", "throws"),
        "mesh-die": ("gravity", "rotation", "gyroscopic"),
        "nesc-brick": ("rotation", "gyroscopic"),
        "rod-stiff": ("gravity", "tether", "rotation", "gyroscopic"),
        "spin-fast": ("rotation", "gyroscopic"),
        "table-4-1": ("rotation",),
        "table-4-1-ray": ("rotation",),
        "tether-critical": ("tether", "rotation"),
        "tether-overdamped": ("tether", "rotation"),
        "tether-undamped": ("tether", "rotation"),
        "two-hits": ("gravity", "rotation", "gyroscopic", "later impulses"),
        "yardstick": ("gravity", "rotation", "gyroscopic"),
    }


def test_table_4_1_is_the_motion_of_the_reports_application():
    scene, printed = read_scene("table-4-1"), table_4_1()
    assert scene.times.tolist() == printed.physics_times.tolist()
    corner = [vertices(spun(scene.start[0], t), scene.body.points)[VERTEX] for t in scene.times]
    # Half a unit of w's second decimal on each axis, 0.0087 rad/s, turns a lever of 4.33 m by 0.019 m in half a second,
    # and the positions are printed to 0.005 m.
    assert np.linalg.norm(corner - printed.application, axis=1).max() < 0.019 + 0.009


def test_the_click_of_table_4_1_gives_the_printed_motion():
    printed, clicked = read_scene("table-4-1"), read_scene("table-4-1-ray")
    (after,) = struck(clicked)
    np.testing.assert_allclose(after[7:10], printed.start[0, 7:10], rtol=1e-14)
    hit = strike_point(clicked.impulses[0], clicked.start[0], clicked.body) - clicked.start[0, 0:3]
    np.testing.assert_allclose(hit, (1.235, 2.160, -2.5), rtol=0, atol=1e-12)
    for t in printed.times:
        apart = vertices(spun(after, t), clicked.body.points) - vertices(spun(printed.start[0], t), printed.body.points)
        assert np.linalg.norm(apart, axis=1).max() < 0.007


def test_the_brick_has_the_energy_and_inertia_its_benchmark_states():
    scene = read_scene("brick-tumble")
    v, w = scene.start[0, 7:10], scene.start[0, 10:13]
    # As in boxes.cc, which gives the moments to 8 decimals; its energy has them to 6 (3.3e-7 off, times 5^2 / 2).
    np.testing.assert_allclose(scene.body.moments, (0.80833333, 0.68333333, 0.14166667), rtol=0, atol=5e-9)
    assert (scene.body.mass * v @ v + scene.body.moments @ w**2) / 2 == pytest.approx(368.5464125, rel=0, abs=5e-6)


def test_the_nesc_brick_is_the_nominal_box_to_the_digits_its_comment_says():
    body = read_scene("nesc-brick").body
    size = np.array([8.0, 4.0, 2.25]) * 0.0254
    np.testing.assert_allclose(body.points, mass.box_corners(size), rtol=1e-14)
    off = np.abs(body.moments / np.diag(mass.box(body.mass, size).tensor) - 1).max()
    assert 1e-8 < off < 1.5e-7
    assert np.rad2deg(read_scene("nesc-brick").start[0, 10:13]).tolist() == pytest.approx([10, 20, 30], rel=1e-15)


def test_the_t_handle_is_a_bar_and_a_cylinder_that_balance_where_they_meet():
    bar, handle = 2.0, 1.0
    assert bar * 0.02 + handle * -0.04 == pytest.approx(0, abs=1e-17)
    own = mass.box(bar, np.array([0.04, 0.08, 0.6])).tensor
    across = handle / 12 * (0.08**2 + 3 * 0.02**2)
    cylinder = np.diag([handle / 2 * 0.02**2, across, across])
    arms = (bar * 0.02**2 + handle * 0.04**2) * np.diag([0, 1, 1])
    body = read_scene("dzhanibekov").body
    np.testing.assert_allclose(body.moments, np.diag(own + cylinder + arms), rtol=0, atol=1e-16)
    assert np.argsort(body.moments).tolist() == [2, 0, 1], "the handle, x, is the middle axis"


def test_the_script_writes_the_committed_mesh():
    written = make_mesh_die.stl(make_mesh_die.triangles_mm()).encode("ascii")
    assert written == (CATALOGUE / "mesh_die.stl").read_bytes()


def test_the_mesh_die_is_a_cube_less_its_corners():
    scene = read_scene("mesh-die")
    corners_mm3 = sum(np.prod(cut) / 6 for cut in make_mesh_die.CUTS_MM.values())
    points, faces = scene.body.points, scene.body.faces
    solid = mass.mesh(scene.body.mass, points, faces)
    assert solid.volume == pytest.approx((16**3 - corners_mm3) * 1e-9, rel=1e-13)
    assert len(faces) < 100
    # The body's own axes: centre at the origin, no products left.
    assert np.abs(solid.centre).max() < 16 * EPS * 0.05
    np.testing.assert_allclose(solid.tensor, np.diag(scene.body.moments), rtol=0, atol=1e-14 * scene.body.moments.max())


def test_the_mesh_die_stands_as_its_file_does():
    # The file's axes are the world's (no orientation is given): moved to its own centre, the mesh is as in the file.
    scene = read_scene("mesh-die")
    in_file = make_mesh_die.triangles_mm() / 1000
    in_world = vertices(scene.start[0], scene.body.points)[scene.body.faces]
    shift = in_file - in_world
    np.testing.assert_allclose(shift, np.broadcast_to(shift[0, 0], shift.shape), rtol=0, atol=1e-16)
    assert scene.body.file_axes[0] < 0.99, "a mesh in its principal axes already would show nothing"
    # point_body is along the file's axes too, and these are the world's here.
    assert strike_point(scene.impulses[0], scene.start[0], scene.body) == pytest.approx(
        [0.0005, -0.0085, -0.0004], abs=1e-17
    )


# --- keys and defaults


def test_what_is_left_out_is_at_rest_at_the_origin_and_unpulled(read):
    scene = read()
    assert scene.start.tolist() == [[0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0]]
    assert (scene.gravity, scene.impulses, scene.tethers, scene.drag, scene.floor) == (None, (), (), None, None)
    assert scene.source == ""
    assert scene.times.tolist() == [0.25, 0.5, 0.75, 1.0]
    assert scene.body.file_axes.tolist() == [1, 0, 0, 0]
    assert needs(scene) == ()


def test_a_force_of_no_strength_is_not_there(read):
    scene = read(
        f"{BOX}[[tether]]\nvertex = 0\nanchor = [0, 1, 0]\nstiffness = 0\n[drag]\n[floor]\nstiffness = 0\n"
        "[[impulse]]\nmagnitude = 0\ndirection = [1, 0, 0]\nvertex = 1\n",
        before="gravity = [0, 0, -0.0]\n",
    )
    assert (scene.gravity, scene.impulses, scene.tethers, scene.drag, scene.floor) == (None, (), (), None, None)


def test_every_force_arrives_with_its_numbers(read):
    scene = read(
        f"{BOX}[[tether]]\nvertex = 7\nanchor = [0, 2, 0]\nstiffness = 80\ndamping = 0.6\nrest_length = 0.25\n"
        "[drag]\nlinear = 0.3\nangular = 0.02\n"
        "[floor]\nheight = -1\nstiffness = 2e4\ndamping = 15\nnormal = [0, 0, 4]\n"
        "[plane]\npoint = [0, -5, 0]\nnormal = [0, 3, 4]\nrestitution = 0.5\nfriction = 0.3\n",
        before="gravity = [0, -9.81, 0]\n",
    )
    (tether,) = scene.tethers
    assert tether.point_body.tolist() == [0.5, 1.0, 1.5]
    assert tether.anchor.tolist() == [0, 2, 0]
    assert (tether.stiffness, tether.damping, tether.rest_length) == (80, 0.6, 0.25)
    assert scene.drag is not None
    assert (scene.drag.linear, scene.drag.angular) == (0.3, 0.02)
    assert scene.floor is not None
    assert (scene.floor.height, scene.floor.stiffness, scene.floor.damping) == (-1, 2e4, 15)
    assert scene.floor.normal.tolist() == [0, 0, 1]
    assert scene.plane is not None
    assert (scene.plane.point.tolist(), scene.plane.normal.tolist()) == ([0, -5, 0], [0, 0.6, 0.8])
    assert (scene.plane.restitution, scene.plane.friction) == (0.5, 0.3)
    assert needs(scene) == (*FORCES, "rotation", "gyroscopic")


def test_a_floor_looks_up_along_y_unless_told(read):
    floor = read(f"{BOX}[floor]\nstiffness = 1\n").floor
    assert floor is not None
    assert floor.normal.tolist() == [0, 1, 0]


@pytest.mark.parametrize("scale", [1e-320, 1e-200, 1, 1e200])
def test_orientation_and_direction_are_normalised_at_any_scale(read, scale):
    scene = read(
        f"{BOX}orientation = [{scale}, {scale}, {scale}, {scale}]\n"
        f"[[impulse]]\nmagnitude = 5\ndirection = [0, {3 * scale}, {-4 * scale}]\nvertex = 0\n"
    )
    assert scene.start[0, 3:7].tolist() == [0.5, 0.5, 0.5, 0.5]
    # 3e-320 and 4e-320 have four digits.
    np.testing.assert_allclose(scene.impulses[0].value, [0, 3, -4], rtol=1e-3 if scale == 1e-320 else 4 * EPS)


def test_impulses_act_in_order_of_time_and_then_as_listed(read):
    hits = "".join(
        f"[[impulse]]\ntime = {time}\nvalue = [{number}, 0, 0]\nvertex = 0\n"
        for number, time in enumerate((0.5, 0, 0.5, 0.25, 0), start=1)
    )
    scene = read(BOX + hits)
    assert [(impulse.time, impulse.value[0]) for impulse in scene.impulses] == [
        (0, 2), (0, 5), (0.25, 4), (0.5, 1), (0.5, 3),
    ]  # fmt: skip


def test_a_later_ray_waits_for_the_flight(read):
    ray = "ray = { origin = [50, 0, 9], direction = [0, 0, -1] }"
    scene = read(f"{BOX}[[impulse]]\ntime = 0.5\nmagnitude = 2\n{ray}\n")
    assert scene.impulses[0].value.tolist() == [0, 0, -2]
    assert "rotation" in needs(scene)


def test_a_scene_cannot_be_altered(read):
    scene = read(f"{BOX}[[impulse]]\nvalue = [1, 0, 0]\nvertex = 0\n", before="gravity = [0, -9.81, 0]\n")
    for array in (scene.start, scene.times, scene.gravity, scene.body.points, scene.body.moments, scene.body.faces):
        assert array is not None
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    with pytest.raises(ValueError, match="read-only"):
        scene.impulses[0].value[0] = 0


# --- needs


@pytest.mark.parametrize(
    ("impulse", "turns"),
    [
        ("value = [1, 2, 3]\npoint_body = [0, 0, 0]", False),
        ("value = [1, 2, 3]\npoint = [0, 0, 0]", False),
        ("value = [0, 0, 3]\npoint_body = [0, 0, 1.5]", False),
        ("time = 0.5\nvalue = [0, 0, 3]\npoint_body = [0, 0, 1.5]", False),
        ("value = [0, 0, 3]\npoint_body = [0, 0.1, 1.5]", True),
        ("time = 0.5\nvalue = [0, 0, 3]\npoint = [0, 0, 0]", True),
    ],
)
def test_only_a_blow_beside_the_centre_turns_a_body_at_rest(read, impulse, turns):
    scene = read(f"{BOX}velocity = [1, 0, 0]\n[[impulse]]\n{impulse}\n")
    assert ("rotation" in needs(scene)) == turns
    assert ("later impulses" in needs(scene)) == ("time" in impulse)


def test_a_spinning_cube_needs_no_gyroscopic_term(read):
    cube = 'shape = "box"\nsize = [2.0, 2.0, 2.0]\nmass = 2.0\nangular_velocity = [1, 2, 3]\n'
    assert needs(read(cube)) == ("rotation",)
    assert needs(read(cube.replace("2.0]", "2.1]"))) == ("rotation", "gyroscopic")


# --- axes


quaternions = st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda q: np.linalg.norm(q) > 0.1)


@settings(derandomize=True, deadline=None, max_examples=40)
@given(turn=quaternions, orientation=quaternions)
def test_a_body_given_in_turned_axes_is_the_same_body(turn, orientation, tmp_path_factory):
    """Turn the file's axes by R, and the orientation back by it: points, blow and spin in the world stay."""
    q = np.array(turn) / np.linalg.norm(turn)
    moments, points = np.diag([1.0, 1.6, 2.1]), np.array([[0.3, 0.1, -0.2], [-0.5, 0.4, 0.6], [0.0, -0.7, 0.2]])
    axes = rotation_matrix(q)
    tensor = axes @ moments @ axes.T

    def scene(inertia, points, orientation, spot) -> Scene:
        file = tmp_path_factory.getbasetemp() / "turned.toml"
        file.write_text(
            f'{HEAD}[body]\nshape = "rigid"\nmass = 2.0\ninertia = {inertia.tolist()}\npoints = {points.tolist()}\n'
            f"orientation = {orientation.tolist()}\nangular_velocity = [1, 2, 3]\n"
            f"[[impulse]]\nvalue = [1, 2, -3]\npoint_body = {spot.tolist()}\n"
            "[[tether]]\nvertex = 2\nanchor = [0, 0, 0]\nstiffness = 1\n"
        )
        return read_scene(str(file))

    plain = scene(moments, points, np.array(orientation), points[1])
    turned = scene(
        (tensor + tensor.T) / 2,
        points @ axes.T,
        quaternion_product(np.array(orientation), q * (1, -1, -1, -1)),
        axes @ points[1],
    )
    for ours, theirs in ((plain.start, turned.start), (struck(plain), struck(turned))):
        # Rounding of the tensor, 2e-16, over the gap of its moments, 0.5, turns the axes by as little.
        np.testing.assert_allclose(
            vertices(theirs, turned.body.points), vertices(ours, plain.body.points), rtol=0, atol=1e-14
        )
        np.testing.assert_allclose(theirs[:, 10:13], ours[:, 10:13], rtol=0, atol=1e-14)
    (pulled,), (pulled_too,) = plain.tethers, turned.tethers
    np.testing.assert_array_equal(pulled.point_body, plain.body.points[2])
    np.testing.assert_array_equal(pulled_too.point_body, turned.body.points[2])


def test_a_diagonal_tensor_keeps_the_files_axes_exactly(read):
    points = [[0.1, 0.2, 0.3], [1.0, 0.0, 0.0]]
    scene = read(f'shape = "rigid"\nmass = 1\ninertia = [[3, 0, 0], [0, 1, 0], [0, 0, 2.5]]\npoints = {points}\n')
    assert scene.body.moments.tolist() == [3, 1, 2.5]
    assert scene.body.points.tolist() == points
    assert scene.body.file_axes.tolist() == [1, 0, 0, 0]
    assert scene.body.faces.shape == (0, 3)


def test_a_plate_passes_with_the_rounding_of_its_decimals(read):
    # A plate has A + B = C, and its decimals may round to a hair less.
    inertia = "[[0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.3000000000001]]"
    scene = read(f'shape = "rigid"\nmass = 1\ninertia = {inertia}\npoints = [[0, 0, 0]]\n')
    assert scene.body.moments[0] + scene.body.moments[1] < scene.body.moments[2]


# --- meshes


TETRAHEDRON = [(0, 0, 0), (4, 0, 0), (0, 2, 0), (0, 0, 1)]
OUTWARD = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def ascii_stl(faces: list[tuple[int, ...]]) -> str:
    return make_mesh_die.stl(1000 * np.array([[TETRAHEDRON[i] for i in face] for face in faces]))


def off(faces: list[tuple[int, ...]]) -> str:
    rows = [f"OFF\n{len(TETRAHEDRON)} {len(faces)} 0", *(f"{x} {y} {z}" for x, y, z in TETRAHEDRON)]
    return "\n".join(rows + ["3 {} {} {}".format(*face) for face in faces]) + "\n"


def ply(faces: list[tuple[int, ...]]) -> str:
    header = f"ply\nformat ascii 1.0\nelement vertex {len(TETRAHEDRON)}\n" + "".join(
        f"property double {axis}\n" for axis in "xyz"
    )
    header += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = [f"{x} {y} {z}" for x, y, z in TETRAHEDRON] + ["3 {} {} {}".format(*face) for face in faces]
    return header + "\n".join(rows) + "\n"


def mesh_scene(read, tmp_path: Path, name: str, text: str) -> Scene:
    (tmp_path / name).write_text(text)
    return read(f'shape = "mesh"\nfile = "{name}"\nmass = 3.0\n')


@pytest.mark.parametrize(("write", "name"), [(ascii_stl, "a.stl"), (off, "a.off"), (ply, "a.ply")])
def test_a_mesh_of_each_format(read, tmp_path, write, name):
    scene = mesh_scene(read, tmp_path, name, write(OUTWARD))
    # As the triangles first name them: 0, 2, 1, 3; the file's origin is the tetrahedron's own corner.
    placed = vertices(scene.start[0], scene.body.points)
    np.testing.assert_allclose(placed - placed[0], np.array(TETRAHEDRON)[[0, 2, 1, 3]], rtol=0, atol=1e-14)
    assert np.abs(scene.body.points.mean(axis=0)).max() < 1e-14, "a tetrahedron's centre is the mean of its corners"
    assert scene.body.size is None


def test_a_mesh_turned_inside_out_is_turned_back(read, tmp_path):
    scene = mesh_scene(read, tmp_path, "a.stl", ascii_stl([face[::-1] for face in OUTWARD]))
    assert mass.mesh(3.0, scene.body.points, scene.body.faces).volume == pytest.approx(4 / 3)


def test_a_triangle_with_two_corners_in_one_is_dropped(read, tmp_path):
    needle = "facet normal 0 0 0\nouter loop\nvertex 9 9 9\nvertex 4 0 0\nvertex 4 0 0\nendloop\nendfacet\n"
    text = ascii_stl(OUTWARD).replace("solid die\n", f"solid die\n{needle}", 1)
    scene = mesh_scene(read, tmp_path, "a.stl", text)
    assert len(scene.body.faces) == 4
    assert len(scene.body.points) == 4, "a corner that no triangle has left is no vertex of the body"


def test_zero_and_minus_zero_are_one_corner(read, tmp_path):
    text = ascii_stl(OUTWARD).replace("vertex 0 0 0", "vertex -0 0 -0", 1)
    assert "vertex 0 0 0" in text
    assert len(mesh_scene(read, tmp_path, "a.stl", text).body.points) == 4


def test_corners_that_one_sum_cannot_tell_apart_stay_apart(tmp_path):
    # Beside 1e17 in x, nothing of y and z is left in a sum of the three.
    points = np.array([(1e17, 0, 0), (1e17 + 64, 0, 0), (1e17, 2, 0), (1e17, 0, 1)])
    triangles = points[np.array(OUTWARD)]
    (tmp_path / "a.stl").write_text("\n".join("vertex {} {} {}".format(*point) for point in triangles.reshape(-1, 3)))
    read_points, faces = read_surface(tmp_path / "a.stl")
    assert len(read_points) == len(points)
    np.testing.assert_array_equal(read_points[faces], triangles)


def test_only_meshes_pay_for_trimesh():
    code = (
        "import sys; from tumble.scenarios.read import read_scene; "
        "read_scene('die-vertex'); print('trimesh' in sys.modules)"
    )
    assert subprocess.check_output([sys.executable, "-c", code], text=True) == "False\n"


@pytest.mark.parametrize("dent", [0.0, 0.2])
def test_above_a_plane_it_is_said_that_a_mesh_is_taken_as_its_hull(tmp_path, caplog, dent):
    box = trimesh.creation.box(extents=(1, 1, 1)).subdivide()
    middle = int(np.argmin(np.linalg.norm(box.vertices - (0, 0, 0.5), axis=1)))
    box.vertices[middle, 2] -= dent
    box.export(tmp_path / "a.stl")
    plane = "position = [0, 2, 0]\n[plane]\nfriction = 0.1\nrestitution = 0.5\n"
    (tmp_path / "a.toml").write_text(f'{HEAD}[body]\nshape = "mesh"\nfile = "a.stl"\nmass = 1.0\n{plane}')
    with caplog.at_level(logging.INFO):
        read_scene(str(tmp_path / "a.toml"))
    assert ("a: the mesh is not convex" in caplog.text) == (dent > 0)
