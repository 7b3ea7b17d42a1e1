"""Errors of very many throws: parts that are added up are what all throws together are, in any number of parts."""

from dataclasses import replace

import numpy as np
import pytest

from tumble.compare.judge.errors import Run
from tumble.compare.judge.spread import BIN_ERROR, WORST, Spread, added, bins_of, middle, spread_of
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.status import Failure, Status
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import frozen_array
from tumble.scenarios.truth import Truth

SCENE = read_scene("die-straight")
ROWS, POINTS = len(SCENE.rows), len(SCENE.body.points)


def run_of(errors: np.ndarray) -> Run:
    """Return the run of throws whose vertices are all off by an error, at each sample by more, along x."""
    throws, share = len(errors), np.linspace(0, 1, ROWS)
    truth = Truth(SCENE.rows, **blank(throws), how="exact")
    vertices = np.zeros((ROWS, throws, POINTS, 3))
    vertices[..., 0] = (share[:, None] * np.where(np.isfinite(errors), errors, np.nan))[..., None]
    states = np.where(np.isfinite(vertices[:, :, 0, :1]), truth.states, np.nan)
    scene = replace(SCENE, start=frozen_array(np.repeat(SCENE.start, throws, axis=0)))
    return Run(scene, "mine", "still", 0.01, Trajectory(SCENE.rows, states, vertices, 100, 0.5, ()), truth)


def blank(throws: int) -> dict:
    return {
        "states": np.repeat(SCENE.start[None], ROWS, axis=0).repeat(throws, axis=1),
        "vertices": np.zeros((ROWS, throws, POINTS, 3)),
        "bound": np.full((ROWS, throws), 1e-9),
        "input_error": np.zeros((ROWS, throws)),
    }


def in_parts(errors: np.ndarray, cuts: list[int]) -> Spread:
    found, first = Spread(0), 0
    for part in np.split(errors, cuts):
        if len(part):
            found = added(found, spread_of(run_of(part), first))
        first += len(part)
    return found


def test_the_middle_of_a_bin_is_near_all_that_is_in_it():
    errors = np.exp(np.random.default_rng(1).uniform(-700, 700, 10_000))
    assert (abs(middle(bins_of(errors)) / errors - 1) <= BIN_ERROR).all()
    assert middle(bins_of(np.array([np.inf]))).tolist() == [np.inf]
    assert middle(bins_of(np.array([0.0])))[0] < 1e-300


def test_parts_add_up_to_the_whole():
    random = np.random.default_rng(2)
    errors = np.exp(random.normal(-12, 3, 1500))
    errors[[17, 900]] = np.inf  # which diverged
    whole = spread_of(run_of(errors), 0)
    for cuts in ([700], sorted(random.integers(0, 1500, 9).tolist()), [*range(1, 40)]):
        parts = in_parts(errors, cuts)
        for exact in ("throws", "lost", "known", "status", "steps"):
            assert getattr(parts, exact) == getattr(whole, exact)
        for same in ("bins", "counts", "worst", "worst_m", "worst_resolution_m", "limits_m"):
            assert np.array_equal(getattr(parts, same), getattr(whole, same)), same
        for near in ("mean_m", "deviation_m", "vertex_squares"):
            assert getattr(parts, near) == pytest.approx(getattr(whole, near), rel=1e-12, nan_ok=True)
    own = np.maximum(errors, 1e-9)
    finite = own[np.isfinite(own)]
    assert whole.mean_m == pytest.approx(finite.mean(), rel=1e-12)
    assert whole.deviation_m == pytest.approx(finite.std(ddof=1), rel=1e-12)
    assert whole.worst.tolist() == np.argsort(-errors, kind="stable")[:WORST].tolist()
    assert whole.status is Status.DIVERGED
    for share in (0.01, 0.5, 0.95, 0.998):
        assert whole.quantile(share) == pytest.approx(np.quantile(own, share, method="inverted_cdf"), rel=BIN_ERROR)
    assert whole.quantile(0.9999) == np.inf


def test_size_is_that_of_few_throws_and_a_part_that_failed_fails_all():
    def size(spread: Spread) -> int:
        return sum(value.nbytes for value in vars(spread).values() if isinstance(value, np.ndarray))

    random = np.random.default_rng(3)
    few, many = Spread(0), Spread(0)
    for part in range(20):
        one = spread_of(run_of(np.exp(random.uniform(-3, 0, 300))), 300 * part)
        few = added(few, one) if part < 2 else few
        many = added(many, one)
    assert many.throws == 10 * few.throws == 6_000
    assert size(many) < 1.2 * size(few)
    failed = replace(run_of(np.ones(3)), answer=Failure(Status.TIMEOUT, "no answer within 60 s"))
    both = added(added(many, spread_of(failed, 6_000)), one)
    assert (both.throws, both.known, str(both.status), both.why) == (6_303, 0, "timeout", "no answer within 60 s")


def test_throws_without_a_reference_are_counted():
    unknown = replace(run_of(np.ones(5)), truth=None)
    both = added(spread_of(unknown, 0), spread_of(run_of(np.full(7, 0.5)), 5))
    assert (both.throws, both.unknown, both.known, both.quantile(0.5)) == (12, 5, 7, pytest.approx(0.5, rel=BIN_ERROR))
