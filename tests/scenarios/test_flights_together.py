"""Flights as lanes of one integration, against the same flights one by one."""

from random import Random

import numpy as np
import pytest

from tumble.scenarios.read import read_scene, scene_of, scene_path
from tumble.scenarios.truth import truth
from tumble.scenarios.truth.forced import resolution
from tumble.scenarios.truth.forced.flight import Budget, Integration
from tumble.scenarios.truth.forced.resolution import FINE, PLAIN
from tumble.scenarios.truth.forced.together import side_by_side
from tumble.scenarios.truth.throw import changing, read_throw

# Half last bits: the doubles' rounding is a millionth of what so large a change does.
SHARE = 2.0**26
BLOW = "\n[[impulse]]\ntime = 0.0523\nvalue = [0.3, -0.2, 0.1]\nvertex = 0\n"
ROD = scene_path("rod-stiff")


def changed_throws(scene, count):
    return [read_throw(scene, 0), *(read_throw(scene, 0, changing(Random(n), SHARE)) for n in range(count - 1))]


@pytest.mark.parametrize(
    "scene",
    [
        read_scene("tether-critical"),
        read_scene("drag-stiff"),
        scene_of(ROD.read_text(encoding="utf-8") + BLOW, ROD, "rod-stiff"),
    ],
    ids=["point", "drag", "line-and-blow"],
)
@pytest.mark.parametrize("count", [2, 8])
def test_changes_do_the_same_as_in_flights_of_their_own(scene, count):
    throws = changed_throws(scene, count)
    together = [flight.rows[:, 0] for flight in side_by_side(throws, PLAIN, Budget()).run()]
    alone = [Integration(throw, PLAIN, Budget()).run().rows[:, 0] for throw in throws]
    for one, other in zip(together[1:], alone[1:], strict=True):
        moved = other - alone[0]
        assert np.abs(one - together[0] - moved).max() <= 1e-4 * np.abs(moved).max()


def test_flights_that_cannot_be_one_are_not():
    tether, floor, drag = (changed_throws(read_scene(n), 2) for n in ("tether-critical", "floor-stiff", "drag-stiff"))
    assert side_by_side(tether, PLAIN, Budget()) is not None
    assert side_by_side(tether, FINE, Budget()) is None
    assert side_by_side(tether[:1], PLAIN, Budget()) is None
    assert side_by_side(tether * 5, PLAIN, Budget()) is None
    assert side_by_side(floor, PLAIN, Budget()) is None
    assert side_by_side([tether[0], drag[0]], PLAIN, Budget()) is None


@pytest.mark.parametrize("name", ["tether-critical", "drag-stiff", "rod-stiff"])
def test_the_input_error_is_that_of_single_flights(name, monkeypatch):
    found = truth(read_scene(name)).input_error
    monkeypatch.setattr(resolution, "side_by_side", lambda *_: None)
    assert np.allclose(found, truth(read_scene(name)).input_error, rtol=1e-4, atol=0.0)


def test_time_that_is_up_ends_all_flights_at_the_same_row(monkeypatch):
    throws, budget = changed_throws(read_scene("tether-overdamped"), 3), Budget()
    monkeypatch.setattr(budget, "is_up", lambda: True)
    flights = side_by_side(throws, PLAIN, budget).run()
    assert len({len(flight.rows) for flight in flights}) == 1
    assert 0 < len(flights[0].rows) < len(throws[0].times)
    assert all(np.isfinite(flight.rows).all() and "were up" in flight.why for flight in flights)
