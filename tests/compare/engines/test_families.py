"""How engines take the gyroscopic torque, found blind from flights, is what their sources say; docs/gyroscopic.md."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from apart import engine, throw
from gyroscopic_scheme import gyroscopic_scheme

from tumble.compare.judge import mechanics
from tumble.compare.run.engines.brick import scene
from tumble.compare.run.running_engines import launched
from tumble.scenarios.read import read_scene

DOCS = Path(__file__).parents[3] / "docs"
QUESTION = replace(
    scene(throw(w=(0.2, 1.0, 0.3)), mass=1.0, moments=(1.0, 2.0, 3.0)), duration=10.0, times=np.linspace(1, 10, 10)
)
STEP = 1 / 64
# What the sources say: GYROSCOPIC of each engine's file; those of higher order state none.
SAID = {
    "pybullet:multibody": "explicit",
    "mujoco:euler": "explicit",
    "drake:discrete": "explicit",
    "dart:semi-implicit-euler": "explicit",
    "ammo:rigidbody": "explicit",
    "ode:step": "implicit",
    "box3d:semi-implicit-euler": "implicit",
    "pybullet:rigidbody": "implicit",
    "mujoco:implicit": "implicit",
    "mujoco:implicitfast": "implicit",
    "physx:pgs": "rescaled",
    "rapier:tgs": "rescaled",
    "rapier-js:tgs": "rescaled",
    "jolt:semi-implicit-euler": "rescaled",
    "mujoco@3.10.0:implicitfast": "midpoint",
    "cannon:semi-implicit-euler": "none",
    "havok:semi-implicit-euler": "none",
    "jolt:semi-implicit-euler+defaults": "none",
    "ammo:rigidbody+defaults": "none",
    "mujoco:rk4": "",
    "drake:rk5": "",
}
DAMPED = {"jolt:semi-implicit-euler+defaults"}
RESCALED = ("physx:pgs", "rapier:tgs", "jolt:semi-implicit-euler")


@pytest.fixture(scope="module")
def running_engines():
    for name in {contestant.partition(":")[0] for contestant in SAID} - {"pybullet", "mujoco"}:
        with engine(name):
            pass
    with launched(SAID) as found:
        yield {f"{each.engine}:{method}": each for each in found for method in each.methods}


@pytest.mark.parametrize("contestant", [name for name in SAID if name not in DAMPED])
def test_found_blind_it_is_what_the_source_says(contestant, running_engines):
    ours, method = running_engines[contestant], contestant.partition(":")[2]
    assert ours.info.gyroscopic.get(method, "") == SAID[contestant]
    coarse, fine = (ours.simulate(QUESTION, method, dt).states[:, 0] for dt in (STEP, STEP / 2))
    found = gyroscopic_scheme(coarse, fine, QUESTION.body, round(QUESTION.duration / STEP), ours.rounding)
    # The midpoint rule keeps both, as does all that keeps the momentum: its order tells it, and its notes.
    assert found == SAID[contestant].replace("midpoint", "keeps-momentum") or (contestant, found) == (
        "drake:rk5",
        "keeps-momentum",
    )


@pytest.mark.parametrize("contestant", RESCALED)
@pytest.mark.parametrize(("which", "towards"), [("least", -1), ("largest", 1)])
def test_who_rescales_the_angular_momentum_drifts_to_the_middle_axis(contestant, which, towards, running_engines):
    """2 T B / L^2 is B/A = 2 about the least axis, 2/3 about the largest, 1 at the separatrix of the middle one."""
    question = read_scene(str(DOCS / "gyroscopic" / f"near-the-{which}.toml"))
    ours, method = running_engines[contestant], contestant.partition(":")[2]
    states = ours.simulate(question, method, question.step).states[:, 0]
    length = np.linalg.norm(mechanics.angular_momentum(states, question.body), axis=-1)
    middle = 2 * mechanics.spin_energy(states, question.body) * np.sort(question.body.moments)[1] / length**2
    assert (middle[0] - 1) * towards < 0, "it begins on the other side"
    assert (middle[-1] - middle[0]) * towards > 0.1
    assert abs(middle[-1] - 1) < 0.5 * abs(middle[0] - 1)
    page = (DOCS / "gyroscopic.md").read_text(encoding="utf-8")
    row = re.search(rf"\| {re.escape(contestant)} \| {which} \| ([\d.]+) \| ([\d.]+) \|", page)
    assert row, "the page has its figures"
    assert [float(each) for each in row.groups()] == pytest.approx([middle[0], middle[-1]], abs=0.02)
