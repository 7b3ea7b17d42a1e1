"""The truth of many throws at once, in 32 digits, against the many-digit closed form."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from mpmath import MPContext

from tumble.scenarios import truth as rooms
from tumble.scenarios.mass import BOX_FACES
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Body, Scene, frozen_array
from tumble.scenarios.truth import truth
from tumble.scenarios.truth.bulk import flight as bulk
from tumble.scenarios.truth.bulk.bodies import bodies, readings
from tumble.scenarios.truth.rational import Fraction
from tumble.scenarios.truth.rotation import exact

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * (0.2, 0.075, 0.05)


def body(*moments):
    return Body("box", 2.4, frozen_array(moments), frozen_array(CORNERS), frozen_array(BOX_FACES, int))


def spun(seed, throws, along=(0.0, 0.0, 0.0), spread=3.0, turned=True):
    random = np.random.default_rng(seed)
    q = random.normal(size=(throws, 4)) if turned else np.tile((1.0, 0.0, 0.0, 0.0), (throws, 1))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    spins = np.array(along) + spread * random.normal(size=(throws, 3))
    return np.hstack((random.normal(size=(throws, 3)), q, random.normal(size=(throws, 3)), spins))


def a_scene(body, starts, *times, gravity=(0.0, -9.81, 0.0)):
    # A few throws as often as it takes to be many.
    starts = np.tile(starts, (-(-rooms.MANY // len(starts)), 1))
    times = frozen_array(times)
    return Scene("case", "", "", float(times[-1]), times, 1e-3, body, frozen_array(starts), frozen_array(gravity))


# Moments, starts and the last instant: every inertia order, symmetric to the last bit and not quite, near the axes and
# the separatrix, and as many turns as a double can tell apart.
CASES = {
    "brick": (body(3.0, 4.0, 6.0), spun(1, 4), 10.0),
    "brick, its axes in another order": (body(6.0, 3.0, 4.0), spun(2, 4), 10.0),
    "cube": (body(2.0, 2.0, 2.0), spun(3, 4), 10.0),
    "rod": (body(0.1, 2.0, 2.0), spun(4, 4), 10.0),
    "disc": (body(2.0, 4.0, 2.0), spun(5, 4), 10.0),
    "moments that differ in their last bits": (body(2.0, 2.0000000000000004, 2.000000000000001), spun(6, 4), 10.0),
    "needle": (body(1e-6, 1.0, 1.0), spun(7, 4), 1.0),
    "about the middle axis": (body(3.0, 4.0, 6.0), spun(8, 4, (0.0, 3.0, 0.0), 1e-7, turned=False), 6.0),
    "about the least axis": (body(3.0, 4.0, 6.0), spun(9, 4, (3.0, 0.0, 0.0), 1e-12, turned=False), 10.0),
    "exactly about an axis": (body(3.0, 4.0, 6.0), spun(10, 4, (0.0, 0.0, 3.0), 0.0, turned=False), 10.0),
    "still": (body(3.0, 4.0, 6.0), spun(11, 4, spread=0.0), 10.0),
    "a million radians": (body(3.0, 4.0, 6.0), spun(12, 4), 2e5),
    "far away and fast": (body(3.0, 4.0, 6.0), spun(14, 4, (1e11, 2e11, -1e11)) + 1e10 * np.eye(13)[0], 1.0),
}


@pytest.mark.parametrize(("body", "starts", "end"), CASES.values(), ids=CASES)
def test_many_throws_are_the_same_as_one_by_one(body, starts, end):
    scene = a_scene(body, starts, end / 7, end)
    many, one_by_one = truth(scene), truth(replace(scene, start=scene.start[: len(starts)]))
    assert many.how == "exact"
    assert (many.vertices[:, : len(starts)] == many.vertices[:, len(starts) : 2 * len(starts)]).all()
    # Both are right far below a last bit, so what is stored is the same but for ties, and numbers that are all but 0.
    off = abs(many.vertices[:, : len(starts)] - one_by_one.vertices)
    assert (off <= np.spacing(abs(one_by_one.vertices)) + 1e-30).all()
    assert (off == 0).mean() > 0.95
    assert abs(many.states[:, : len(starts)] - one_by_one.states).max() <= 1e-15 * abs(one_by_one.states).max()
    # Other patterns of signs: of eight, as of any eight, the largest lies between 1 and 2.7 times the root mean square.
    assert (many.input_error[:, : len(starts)] <= 2.7 * one_by_one.input_error).all()
    assert (many.input_error[:, : len(starts)] >= one_by_one.input_error / 2.7).all()


@pytest.mark.parametrize("case", ["brick", "needle", "about the middle axis", "a million radians"])
def test_errors_are_what_they_are_said_to_be(case):
    body, starts, end = CASES[case]
    scene = a_scene(body, starts, end)
    mp = MPContext()
    mp.prec = bulk.BITS
    inputs = bulk.signed(bodies(mp, readings(scene, 0), np.array((scene.rows, 0 * scene.rows))[..., np.newaxis]))
    vertices, _, floor = bulk.simulate(bulk.as_written(scene.start[:1]), inputs)
    off = bulk.off_by(mp, scene, 0, vertices[:, :, 0])
    assert (off <= bulk.SHARE_OF_FLOOR * floor[:, 0]).all()
    # The second double counts: with one alone they would not be.
    assert not (
        bulk.off_by(mp, scene, 0, vertices[:, :, 0] * [[[[1.0]]], [[[0.0]]]]) <= bulk.SHARE_OF_FLOOR * floor[:, 0]
    ).all()


def test_many_throws_tell_how_many_are_done(monkeypatch):
    # The start and two rows of eight corners: sixteen throws at a time, of MANY.
    monkeypatch.setattr(bulk, "AT_A_TIME", 3 * 8 * 16)
    shares = []
    truth(a_scene(*CASES["brick"][:2], 1.0, 10.0), on_share=shares.append)
    assert shares == [0.25, 0.5, 0.75, 1.0]


def test_a_wrong_flight_is_seen_on_the_sample(monkeypatch):
    scene = a_scene(*CASES["brick"][:2], 10.0)
    assert bulk.all_flights(MPContext(), scene) is not None

    def off_by_little(*arguments):
        made = bodies(*arguments)
        made.numbers[..., 0, 0] *= 1 + 1e-15
        return made

    monkeypatch.setattr(bulk, "bodies", off_by_little)
    assert bulk.all_flights(MPContext(), scene) is None


def test_throws_too_delicate_for_32_digits_are_worked_out_one_by_one():
    starts = spun(13, rooms.MANY)
    # On the separatrix whether it falls at all is not known, 20 e-folds later; it has to be so to all its digits.
    starts[1] = np.concatenate((np.zeros(3), (1, 0, 0, 0), np.zeros(3), (2.0, 0.1, 1.0)))
    scene = a_scene(body(3.0, 4.0, 6.0), starts, 0.1, 80.0)
    flights = bulk.all_flights(MPContext(), scene)
    assert flights is not None
    assert np.flatnonzero(np.isnan(flights.input_error).any(axis=0)).tolist() == [1]
    answer, alone = truth(scene), truth(replace(scene, start=scene.start[1:2]))
    assert (answer.input_error[:, 1] == alone.input_error[:, 0]).all()
    assert (answer.vertices[:, 1] == alone.vertices[:, 0]).all()
    assert answer.horizon == alone.horizon == 0.1


def dense(file, samples, **changed):
    scene = read_scene(file)
    return replace(scene, times=frozen_array(np.linspace(0, scene.duration, samples + 1)[1:]), **changed)


@pytest.mark.parametrize("file", ["two-hits", "die-ray", "dzhanibekov", "mesh-die"])
def test_many_instants_are_the_same_as_a_few(file):
    scene = dense(file, 2 * rooms.MANY_INSTANTS)
    every = scene.times[99::100]
    assert len(every) + 1 < rooms.MANY_INSTANTS
    many, few = truth(scene), truth(replace(scene, times=every))
    of_few = np.searchsorted(many.times, few.times)
    off = abs(many.vertices[of_few] - few.vertices)
    assert (off <= np.spacing(abs(few.vertices)) + 1e-30).all()
    assert (off == 0).mean() > 0.95
    # Of q and -q each takes the one near to the row before, which is another row here.
    turned = np.sign((many.states[of_few, :, 3:7] * few.states[..., 3:7]).sum(axis=-1, keepdims=True))
    few.states[..., 3:7] *= turned
    assert abs(many.states[of_few] - few.states).max() <= 1e-15 * abs(few.states).max()
    assert (many.bound[of_few] <= 1.01 * few.bound).all()
    # The same patterns of signs, so the same derivative.
    assert many.input_error[of_few] == pytest.approx(few.input_error, rel=1e-3)


def test_instants_beyond_the_horizon_are_left_where_it_lies():
    start = np.concatenate((np.zeros(3), (1, 0, 0, 0), np.zeros(3), (2.0, 0.1, 1.0)))[np.newaxis]
    times = frozen_array(np.linspace(0, 80.0, 801)[1:])
    scene = Scene("case", "", "", 80.0, times, 1e-3, body(3.0, 4.0, 6.0), frozen_array(start))
    many, few = truth(scene), truth(replace(scene, times=times[310:325]))
    assert many.known < len(many.times)
    assert "last bit" in many.why
    assert many.horizon == few.horizon
    assert np.isinf(many.bound[-1, 0])
    assert np.isnan(many.vertices[-1]).all()


def test_fractions_that_are_taken_as_they_are_leave_no_memory_behind():
    """Very many throws are worked out by one process: gmpy2's `as_integer_ratio` lost 160 bytes each time."""
    number = Fraction(2**100 + 1, 3**60)
    exact(number)
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        for _ in range(1000):
            assert exact(number) == number
        assert tracemalloc.get_traced_memory()[0] - before < 10_000
    finally:
        tracemalloc.stop()
