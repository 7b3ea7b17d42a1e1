"""Euler angles and other programs' axes through `tumble grade`, in files that scipy's Rotation converted."""

import csv
import re
import shlex
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tumble.__main__ import main
from tumble.compare.grade.read.conventions import matrix_of
from tumble.scenarios.read import read_scene

SCENE = "two-hits"
# What takes our vectors to theirs.
THEIRS = {
    "unity": np.diag([1.0, 1.0, -1.0]),
    "unreal": np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]),
    "godot": np.eye(3),
    "blender": np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
    "ros": np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
}


def their_angles(name, rotation):
    """Return the angles about x, y, z [deg] that a program shows, (n, 3)."""
    if name in ("unity", "godot"):
        return rotation.as_euler("YXZ", degrees=True)[:, [1, 0, 2]]
    angles = rotation.as_euler("ZYX", degrees=True)[:, ::-1]
    return angles * (-1, -1, 1) if name == "unreal" else angles


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """A right flight: t (n,), x, v, w (n, 3), and the attitudes."""
    path = tmp_path_factory.mktemp("right") / "right.csv"
    assert main(["run", SCENE, "-e", "tumble:exact", "-o", str(path)]) == 0
    with path.open(newline="") as file:
        rows = [{name: float(cell) for name, cell in row.items()} for row in csv.DictReader(file)]

    def of(*names):
        return np.array([[row[name] for name in names] for row in rows])

    vectors = of("x_m", "y_m", "z_m"), of("vx_m_s", "vy_m_s", "vz_m_s"), of("wx_rad_s", "wy_rad_s", "wz_rad_s")
    return of("t_s")[:, 0], *vectors, Rotation.from_quat(of("qx", "qy", "qz", "qw"))


@pytest.fixture
def grade(tmp_path, capsys):
    def run(names, columns, *words, form=repr, scene=SCENE):
        path = tmp_path / "their.csv"
        rows = [",".join(map(form, row)) for row in np.column_stack(columns).tolist()]
        path.write_text("\n".join((",".join(names), *rows)) + "\n")
        code = main(["grade", str(path), "--scene", scene, *words])
        return code, *capsys.readouterr()

    return run


def moved(name, flown):
    """Return t, positions, velocities, spins and attitudes as a program has them."""
    t, x, v, w, rotation = flown
    to = THEIRS[name]
    turned = Rotation.from_matrix(to @ rotation.as_matrix() @ to.T)
    return t, x @ to.T, v @ to.T, np.linalg.det(to) * w @ to.T, turned


@pytest.mark.parametrize("name", THEIRS)
def test_angles_and_axes_by_name(grade, flown, name):
    t, x, _, _, turned = moved(name, flown)
    columns = t, x, their_angles(name, turned)
    names = ["t_s", "x_m", "y_m", "z_m", "rx_deg", "ry_deg", "rz_deg"]
    code, out, err = grade(names, columns, "--euler", name, "--axes", name)
    assert code == 0, err
    assert "\nCorrect" in out
    code, out, _ = grade(names, columns, "--euler", name, "--axes", "x,-y,-z", "--tolerance", "1e-3")
    assert code == 1, "other axes are another flight"


@pytest.mark.parametrize("order", ["zxy", "xyz", "yzx", "ZXY", "XYZ", "extrinsic-zyx", "Intrinsic:yxz"])
def test_orders_as_scipy_has_them(grade, flown, order):
    t, x, _, _, rotation = flown
    letters = order[-3:].upper() if order[0] in "IXZ" else order[-3:]
    angles = rotation.as_euler(letters)[:, np.argsort(list(letters.lower()))]
    names = ["t_s", "x_m", "y_m", "z_m", "roll_rad", "pitch_rad", "yaw_rad"]
    code, out, err = grade(names, (t, x, angles), "--euler", order)
    assert code == 0, err
    assert "\nCorrect" in out


@pytest.mark.parametrize("name", ["unity", "unreal", "blender"])
@pytest.mark.parametrize("kind", ["pose", "matrix", "vertices"])
def test_every_description_is_brought_into_our_world(grade, flown, name, kind):
    t, x, v, w, turned = moved(name, flown)
    names, columns = ["t_s"], [t]
    if kind == "vertices":
        half = np.array([0.4, 0.15, 0.1]) / 2
        for number in (1, 4, 6):
            corner = half * [1 if number & bit else -1 for bit in (4, 2, 1)]
            names += [f"v{number}{axis}_m" for axis in "xyz"]
            columns.append((flown[1] + flown[4].apply(corner)) @ THEIRS[name].T)
    else:
        names += ["x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s", "wx_rad_s", "wy_rad_s", "wz_rad_s"]
        columns += [x, v, w]
        if kind == "pose":
            names += ["qx", "qy", "qz", "qw"]
            columns.append(turned.as_quat())
        else:
            names += [f"r{i}{j}" for i in "123" for j in "123"]
            columns.append(turned.as_matrix().reshape(-1, 9))
    code, out, err = grade(names, columns, "--axes", name)
    assert code == 0, err
    assert "\nCorrect" in out
    if kind != "vertices":
        drifts = [float(each) for each in re.findall(r"([-+]?\d\.\de[-+]\d+)", out.partition("energy")[2])[:3]]
        assert max(map(abs, drifts)) < 1e-9, "velocities and spins are those of the same run"
        assert "Also: the angular velocity" not in out


@pytest.mark.parametrize("name", ["unity", "unreal", "ros"])
def test_what_fits_is_offered_and_the_offer_grades_it(grade, flown, name):
    t, x, _, _, turned = moved(name, flown)
    names = ["t_s", "x_m", "y_m", "z_m", "rx", "ry", "rz"]
    columns = t, x, their_angles(name, turned)
    code, out, err = grade(names, columns, form="{:.4f}".format)
    assert (code, out) == (2, "")
    offer = re.search(r"rx, ry, rz fit as (\w+)( or \w+)?'s: (--euler .*)$", err)
    assert offer, err
    assert name in (offer[1] + (offer[2] or "")).lower()
    code, out, err = grade(names, columns, *shlex.split(offer[3]), form="{:.4f}".format)
    assert code == 0, err
    assert "Correct to the printed digits" in out


def test_the_unit_is_part_of_the_offer(grade, flown):
    t, x, _, _, turned = moved("godot", flown)
    angles = np.radians(their_angles("godot", turned))
    _, _, err = grade(["t_s", "x_m", "y_m", "z_m", "rx", "ry", "rz"], (t, x, angles))
    assert "--map rx=rx_rad --map ry=ry_rad --map rz=rz_rad" in err


def test_angles_that_fit_no_convention_are_reported(grade, flown):
    t, x, _, _, _ = flown
    angles = np.random.default_rng(3).uniform(-180, 180, (len(t), 3))
    code, _, err = grade(["t_s", "x_m", "y_m", "z_m", "rx_deg", "ry_deg", "rz_deg"], (t, x, angles))
    assert code == 2
    assert "no convention of rx_deg, ry_deg, rz_deg fits two-hits" in err


@pytest.mark.parametrize("places", [2, 4])
def test_printed_digits_of_angles_are_carried_through(grade, flown, places):
    t, x, _, _, turned = moved("unity", flown)
    columns = t, x, their_angles("unity", turned)
    names = ["t_s", "x_m", "y_m", "z_m", "rx_deg", "ry_deg", "rz_deg"]
    code, out, err = grade(names, columns, "--euler", "unity", "--axes", "unity", form=f"{{:.{places}f}}".format)
    assert code == 0, err
    assert "Correct to the printed digits" in out


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("--euler", "xyx"), "--euler 'xyx': must be unity, unreal"),
        (("--euler", "xYz"), "--euler 'xYz': must be"),
        (("--axes", "x,y,y"), "--axes 'x,y,y': must be unity"),
        (("--axes", "max"), "--axes 'max': must be"),
        (("--euler", "unity"), "--euler: rx, ry, rz missing"),
    ],
)
def test_a_bad_option_is_one_line(grade, flown, words, why):
    t, x, _, _, rotation = flown
    code, out, err = grade(["t_s", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw"], (t, x, rotation.as_quat()), *words)
    assert (code, out) == (2, "")
    assert why in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("name", [*THEIRS, "Unity"])
@pytest.mark.parametrize("up", [1, 2])
def test_a_named_programs_up_is_the_scenes_up(name, up):
    scene = replace(read_scene(SCENE), gravity=np.where(np.arange(3) == up, -9.81, 0.0))
    to_world = matrix_of(name, scene)
    their_up = 1 if name.lower() in ("unity", "godot") else 2
    assert to_world[:, their_up].tolist() == np.eye(3)[up].tolist()
    assert np.linalg.det(to_world) == (-1.0 if name.lower() in ("unity", "unreal") else 1.0)
