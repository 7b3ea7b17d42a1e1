"""`tumble scenes FILE` prints a scene of one's own, and what follows from its body, held against formulas."""

import tomllib

import numpy as np
import pytest

from tumble.__main__ import main

BOX = """title = "Box"
duration = 1.0
samples = 4
[body]
shape = "box"
size = [0.4, 0.2, 0.1]
mass = 2.4
"""
MESH = """title = "Corner"
duration = 1.0
samples = 4
[body]
shape = "mesh"
file = "corner.stl"
mass = 6.0
"""
# A corner cut off a cube, its three edges along the axes, moved away from the origin.
EDGE, AT = 0.6, np.array([2.0, -1.0, 0.5])


@pytest.fixture
def shown(tmp_path, capsys):
    """Return a function that writes a scene and gives what is printed of it, and the comments by their first word."""
    corners = AT + EDGE * np.vstack((np.zeros(3), np.eye(3)))
    facets = [corners[list(face)] for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))]
    lines = ["solid corner"]
    for facet in facets:
        lines += ["facet normal 0 0 0", "outer loop", *("vertex {} {} {}".format(*point) for point in facet)]
        lines += ["endloop", "endfacet"]
    (tmp_path / "corner.stl").write_text("\n".join([*lines, "endsolid corner"]) + "\n")

    def run(text):
        path = tmp_path / "mine.toml"
        path.write_text(text)
        assert main(["scenes", str(path)]) == 0
        out = capsys.readouterr().out
        comments = [line.removeprefix("# ").split(maxsplit=1) for line in out.splitlines() if line.startswith("# ")]
        return out, dict(comments)

    return run


def numbers(line):
    return [float(part) for part in line[line.index("[") + 1 : line.index("]")].split(",")]


def test_of_a_box(shown):
    out, said = shown(BOX)
    assert tomllib.loads(out) == tomllib.loads(BOX), "it is still the scene"
    assert said["mass"] == "2.4 kg"
    assert float(said["volume"].split()[0]) == pytest.approx(0.008, rel=1e-8)
    a, b, c = (0.4**2, 0.2**2, 0.1**2)
    assert numbers(said["moments"]) == pytest.approx([0.2 * (b + c), 0.2 * (a + c), 0.2 * (a + b)], rel=1e-8)


def test_of_a_mesh(shown):
    out, said = shown(MESH)
    assert tomllib.loads(out) == tomllib.loads(MESH)
    assert float(said["volume"].split()[0]) == pytest.approx(EDGE**3 / 6, rel=1e-6)
    assert float(said["volume"].split()[3]) == pytest.approx(6.0 / (EDGE**3 / 6), rel=1e-5)
    assert numbers(said["centre"]) == pytest.approx((AT + EDGE / 4).tolist(), rel=1e-6)
    assert numbers(said["extent"]) == pytest.approx([EDGE] * 3, rel=1e-6)
    # About the centre: m a^2 3/40 on the diagonal and m a^2 / 80 beside it, so twice a sum and once a difference.
    unit = 6.0 * EDGE**2
    assert sorted(numbers(said["moments"])) == pytest.approx(
        sorted(np.linalg.eigvalsh(unit * (np.eye(3) * (3 / 40 - 1 / 80) + 1 / 80))), rel=1e-5
    )


def test_a_scene_of_the_catalogue_is_printed_as_it_is_written(capsys):
    assert main(["scenes", "two-hits"]) == 0
    assert "What follows" not in capsys.readouterr().out
