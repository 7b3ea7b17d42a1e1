"""What columns mean is read from their names, or asked for in one line with the words that answer."""

import pytest

from tumble.compare.grade.read.columns import MATRIX, BadTrajectory
from tumble.compare.grade.read.header import descriptions, layout

POSE = ["t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"]


def seen(header, mapping=None, by=None, points=8):
    return descriptions("f", header, mapping or {}, layout("f", header, mapping or {}), points, by)


def refusal(header, mapping=None, **words) -> str:
    with pytest.raises(BadTrajectory) as refused:
        seen(header, mapping, **words)
    assert "\n" not in str(refused.value)
    return str(refused.value)


def test_names_say_where_a_quantity_is_and_in_which_unit():
    found = layout("f", ["x_mm", "other", "t_s"], {"other": "y_m"})
    assert {name: (column.place, column.factor) for name, column in found.items()} == {
        "x": (0, pytest.approx(1e-3)),
        "y": (1, 1.0),
        "t": (2, 1.0),
    }


def test_a_column_that_is_ignored_is_not_there():
    assert "x" not in layout("f", POSE, {"x_m": "ignore"})


def test_each_way_to_say_where_the_body_is_is_seen():
    assert [each.kind for each in seen(POSE)] == ["pose"]
    assert [each.kind for each in seen(["t_s", "x_m", "y_m", "z_m", *MATRIX])] == ["matrix"]
    (vertex,) = seen(["t_s", "v3x_m", "v3y_m", "v3z_m"])
    assert (vertex.kind, vertex.vertices) == ("vertices", (3,))
    both = [*POSE, "v3x_m", "v3y_m", "v3z_m"]
    assert [each.kind for each in seen(both)] == ["vertices", "pose"]
    assert [each.kind for each in seen(both, by="pose")] == ["pose"]


@pytest.mark.parametrize(
    ("header", "mapping", "why"),
    [
        (POSE[1:], {}, "t_s"),
        (POSE[:-1], {}, "qz missing"),
        (["t_s", "x_m", "y_m", "z_m"], {}, "the attitude is missing"),
        (["t_s"], {}, "the pose is missing"),
        ([*POSE, "x_mm"], {}, "both x"),
        (["t_s", "q0", "q1", "q2", "q3"], {}, "which is the scalar?"),
        (["t_s", "x", "y", "z", *POSE[4:]], {}, "in which unit?"),
        (["t_s", "v8x_m", "v8y_m", "v8z_m"], {}, "the body has vertices 0 to 7"),
        (POSE, {"xx": "x_m"}, "no column 'xx' to map"),
        (POSE, {"x_m": "x_parsec"}, "must be one of x_m"),
        (["t_s", *(f"r{row}{column}" for row in range(3) for column in range(3))], {}, "must be counted from 1"),
    ],
)
def test_what_is_missing_or_ambiguous_is_asked_for(header, mapping, why):
    assert why in refusal(header, mapping)
