"""The error of an observable of contact against run time: planted laws, whose errors are known."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tests.support import planted_contact
from tests.support.planted_contact import BALL, SLIDE
from tumble.compare.contact.study import ask
from tumble.compare.judge.cost import Timed
from tumble.compare.judge.errors import RunAnswer
from tumble.compare.run.local import LocalEngine
from tumble.compare.run.running_engines import launched
from tumble.compare.run.timing.readings import Reading
from tumble.compare.run.timing.timer import Ready
from tumble.compare.sweep.observable import LADDER, BadObservable, observed_in, with_observable
from tumble.compare.sweep.work_precision import Sweep
from tumble.scenarios.read import read_scene, scene_of
from tumble.scenarios.truth import truth

STEP_NS = 50.0


def swept(text, *methods, name=None):
    """Return the rows of planted laws whose steps take 50 ns, by method, the longest step first."""
    scene = scene_of(text, Path("planted.toml"), "planted")
    engine = LocalEngine("planted", SimpleNamespace(**{**vars(planted_contact), "METHODS": methods}))
    with launched([engine]) as running:
        runs = [
            RunAnswer.of(running[0], method, scene.step, running[0].simulate(scene, method, scene.step)).run(
                scene, "planted", truth(scene)
            )
            for method in methods
        ]
        timed = [Timed(run, 0.0, Reading(np.full(8, STEP_NS)), True, Ready(0.0, 0.0, 0.0, 0)) for run in runs]
        observed = observed_in(scene, name, 60.0)
        found = with_observable(Sweep(scene, tuple(timed), ()), observed, ask(running, [observed.question])).observed
    return {method: [row for row in found if row.method == method] for method in methods}


def test_the_error_of_a_right_law_falls_with_the_step_and_that_of_a_wrong_one_stays():
    found = swept(SLIDE, "right", "diamond", "another-friction")
    right, wrong = found["right"], found["another-friction"]
    assert {row.observable for row in right} == {"distance until it stops"}, "the scene's main one"
    assert [row.dt_s for row in right] == pytest.approx([0.004 * factor for factor in LADDER.ladder])
    assert [row.run_us for row in right] == pytest.approx([0.6 / row.dt_s * STEP_NS / 1e3 for row in right], rel=0.02)
    # Semi-implicit Euler loses v dt / 2 of the way; what is left at the last sample is read off as exact.
    assert [row.error for row in right] == pytest.approx([np.sqrt(1.25) * row.dt_s / 2 for row in right], rel=0.15)
    # With mu 1.25 times as large it stops after 0.8 of the way.
    assert wrong[-1].error_share == pytest.approx(0.2, abs=2e-3)
    assert found["diamond"][-1].error_share > 0.1
    assert all(row.pareto_front for row in right[3:]), "none is cheaper and nearer"
    assert not any(row.pareto_front for row in wrong[-3:])


def test_of_an_impact_it_is_a_vector_and_the_worst_position_in_a_step():
    found = swept(BALL, "right", "e-squared", "by-the-step", name="velocity after impact")
    assert found["right"][-1].error_share < 2e-3
    # Of a velocity of 0.6 v, which is 0.36 v instead; and of e (0.5 + x) where x is 0.3 and 0.8 of a step.
    assert found["e-squared"][-1].error_share == pytest.approx(0.4, abs=2e-3)
    assert found["by-the-step"][-1].error_share == pytest.approx(0.3, abs=0.01)
    assert {(row.blow, row.unit) for row in found["right"]} == {(1, "m/s")}


def test_an_observable_that_a_scene_has_not_is_refused_in_one_line():
    with pytest.raises(BadObservable, match=r"has no observable 'distance': there are .*, distance until it stops, "):
        observed_in(read_scene("box-slide-0"), "distance", 60.0)
    with pytest.raises(BadObservable, match="two-hits has no plane"):
        observed_in(read_scene("two-hits"), "distance", 60.0)
