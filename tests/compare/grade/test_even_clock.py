"""Clocks that are even but for their printed digits are read as k / rate, unless something speaks against it."""

from pathlib import Path

import numpy as np
import pytest
from programs import Program, fly, read, write

from tumble.compare.grade.grade import grade
from tumble.compare.grade.measure.errors import measure
from tumble.compare.grade.model.reference import Reference
from tumble.compare.grade.read.even_clock import even_clock, intended_interval
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.compare.grade.verdicts import CORRECT_TO_DIGITS, EXPLAINED_WHOLLY
from tumble.scenarios.read import read_scene, scene_path

SCENE = "two-hits"


def clock_of(instants, places, start=0.0):
    """Return the clock of instants that were printed to so many places."""
    printed = np.round(instants, places)
    return even_clock(printed[:200], printed[200::37], lambda times: np.full(len(times), 0.5 * 10.0**-places), start)


@pytest.mark.parametrize(
    ("rate", "places"),
    [(rate, places) for rate in (24, 60, 72, 90, 120, 144, 240) for places in (3, 5, 9)] + [(60, 2), (1000, 3)],
)
def test_a_rate_is_found_from_its_rounded_instants(rate, places):
    instants = np.arange(2000) / rate
    printed = np.round(instants, places)
    clock = clock_of(instants, places)
    if rate == 1000:
        assert clock is None, "these are exact"
        return
    assert clock.interval == pytest.approx(1 / rate, rel=1e-14)
    assert clock.unknown == 0.0
    times, unknown = clock.read(printed)
    np.testing.assert_allclose(times, instants, rtol=0, atol=1e-12)
    assert not unknown.any()


@pytest.mark.parametrize(("interval", "places"), [(0.01666, 4), (0.0167, 3), (1 / 59.94, 5)])
def test_an_interval_of_few_digits_is_taken_for_itself(interval, places):
    assert clock_of(np.arange(1500) * interval, places).interval == pytest.approx(interval, rel=1e-12)


def test_an_interval_of_no_name_is_known_to_within_what_rows_show():
    interval = np.pi / 200
    instants = np.arange(150) * interval
    clock = clock_of(instants, 4)
    times, unknown = clock.read(np.round(instants, 4))
    assert 0 < clock.unknown < 0.5e-4
    assert (np.abs(times - instants) <= unknown + 1e-12).all()


def test_lost_rows_and_other_starts_are_of_the_same_clock():
    lost = np.delete(np.arange(300) / 60, [5, 6, 40, 111])
    assert clock_of(lost, 5).interval == pytest.approx(1 / 60)
    late = 3.42 + np.arange(300) / 60
    clock = clock_of(late, 5, start=3.42)
    assert (clock.first, clock.interval) == (3.42, pytest.approx(1 / 60))
    # Nothing says that the start is a tick: the first row is one.
    assert clock_of(late, 5).first == pytest.approx(3.42, abs=1e-12)


@pytest.mark.parametrize(
    "instants",
    [
        np.arange(200) * 0.02,  # exact
        np.cumsum(np.random.default_rng(1).uniform(0.012, 0.021, 200)),  # frames of a game
        np.array([0.05, 0.25, 1.0, 2.5, 4.0]),
        np.arange(3) / 60,  # too few
    ],
)
def test_what_is_exact_or_uneven_has_no_such_clock(instants):
    assert clock_of(instants, 4) is None


def test_rows_that_are_not_the_clocks_stay_as_they_are_printed():
    clock = clock_of(np.arange(300) / 60, 5)
    times, unknown = clock.read(np.array([0.01667, 0.0404, 0.05]))
    assert times.tolist() == [pytest.approx(1 / 60, rel=1e-12), 0.0404, pytest.approx(0.05)]
    assert unknown.tolist() == [0.0, 0.5e-5, 0.0]


def test_bounds_in_which_many_numbers_lie_mean_none():
    assert intended_interval(1 / 60 - 1e-6, 1 / 60 + 1e-6) == pytest.approx(1 / 60)
    assert intended_interval(0.01, 0.02) is None
    assert intended_interval(0.0123, 0.0124) is None


def rows_at(path, instants, moved_to, places):
    """Write the right places at some instants, under printed ones."""
    states = Reference(read_scene(SCENE)).states(0, moved_to)
    with path.open("w") as file:
        file.write("t_s,x_m,y_m,z_m,qw,qx,qy,qz\n")
        for t, state in zip(instants, states, strict=True):
            file.write(f"{t:.{places}f}," + ",".join(f"{part:.9f}" for part in state[:7]) + "\n")
    return path


@pytest.mark.parametrize("places", [2, 3, 5])
@pytest.mark.parametrize("rounded_first", [False, True])
def test_a_right_file_is_right_whichever_was_rounded(tmp_path, places, rounded_first):
    """Most programs round what they print; one that rounds its instants before it works out the places is right too."""
    even = np.arange(121) / 60
    printed = np.unique(np.round(even, places))
    instants = printed if rounded_first else even
    file = rows_at(tmp_path / "rows.csv", instants, instants, places)
    found = grade(file, read_scene(SCENE), {})
    assert found.verdict == CORRECT_TO_DIGITS
    assert found.measured.half_m < 1e-8, "nothing is left open by the clock"


def test_the_rounding_of_a_clock_hides_nothing(tmp_path):
    """1 mm off is seen where half a hundredth of a second would be 5 cm."""
    even = np.arange(121) / 60
    file = rows_at(tmp_path / "rows.csv", even, even, 2)
    lines = file.read_text().splitlines()
    wrong = [line.split(",") for line in lines[1:]]
    for cells in wrong:
        cells[1] = f"{float(cells[1]) + 0.001:.9f}"
    file.write_text("\n".join([lines[0], *map(",".join, wrong)]) + "\n")
    scene = read_scene(SCENE)
    assert measure(Trajectory(file, scene, {}), scene).excess_m > 0.9e-3


@pytest.mark.parametrize("scene", ["brick-tumble", "dzhanibekov"])
def test_five_decimals_of_a_clock_say_as_much_as_nine(tmp_path, scene):
    """3.21667 at 60 Hz: a scheme of an engine leaves rounding, and not the millimetre of a clock that is 3 us off."""
    throw = read(scene_path(scene))
    program = Program(dt=1 / 60, every=1, method="symplectic", axes="body", turn="exponential", until=3.3)
    rows = fly(scene_path(scene), program)
    left = []
    for places in (9, 5):
        printed = [(float(f"{t:.{places}f}"), *rest) for t, *rest in rows]
        file = write(tmp_path / f"{places}.csv", printed, throw.vertices, form="{:.9g}".format)
        found = grade(Path(file), read_scene(scene), {})
        assert found.verdict == EXPLAINED_WHOLLY
        assert found.diagnosis.engines
        left.append(found.diagnosis.best.max_m)
    assert left[1] < 2 * left[0] < 1e-6
