"""Names beside bodies: who is named together, where, and never over one another."""

from itertools import combinations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tumble.lab.eye import Eye
from tumble.lab.labels import LISTED, box_of, labels, text

EYE = Eye.of(np.array([0.0, 0.0, 5.0]), np.zeros(3), np.array([0.0, 1.0, 0.0]), np.deg2rad(45.0), 612.0, 720.0)
CUBE = np.array(list(np.ndindex(2, 2, 2))) - 0.5
APART = 0.01


def test_bodies_that_are_one_to_the_eye_have_no_labels():
    assert labels({"truth": CUBE, "a": CUBE + 0.005}, APART, EYE, "truth") == []


def test_a_label_lies_on_the_side_of_its_body_that_is_away_from_the_others():
    down = np.array([0.0, -0.4, 0.0])
    one, other = labels({"truth": CUBE, "a": CUBE + down, "b": CUBE + down}, APART, EYE, "truth", "x 10")
    assert (one.words, other.words) == ("truth", "a\nb\nx 10")
    assert one.place[1] > CUBE[:, 1].max()
    assert other.place[1] < (CUBE + down)[:, 1].min()
    assert any(np.array_equal(other.tip, vertex) for vertex in CUBE + down)


def test_of_many_names_some_are_listed():
    lines = text([f"n{number}" for number in range(LISTED + 3)], "x 10").split("\n")
    assert lines == ["n0", "n1", "n2", "and 4 more", "x 10"]
    assert len(text([str(number) for number in range(LISTED)]).split("\n")) == LISTED


Move = st.tuples(st.floats(-0.8, 0.8), st.floats(-0.8, 0.8), st.floats(-0.8, 0.8))


@settings(max_examples=300)
@given(st.lists(Move, min_size=1, max_size=2))
def test_no_label_lies_over_another(moves):
    bodies = {"truth": CUBE, **{f"engine:method{n}": CUBE + np.array(move) for n, move in enumerate(moves)}}
    found = labels(bodies, APART, EYE, "truth", "error x 100")
    covered = [EYE.covered(one.place, box_of(one.words, one.anchor)) for one in found]
    for (left, right, low, high), other in combinations(covered, 2):
        assert right <= other[0] + 1e-6 or left >= other[1] - 1e-6 or high <= other[2] + 1e-6 or low >= other[3] - 1e-6
