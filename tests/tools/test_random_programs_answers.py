"""What the scorer takes an answer to mean is what the answer means: its programs move as the project's models do."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from drawn_brick import BRICK

from tools.confusion import planted_value, written
from tools.random_programs import answers
from tools.random_programs.contact import Claim
from tools.random_programs.dialect import POSE, VERTICES, Dialect
from tools.random_programs.names import BACK
from tools.random_programs.program import Case, Planted, Program, apart_from, truth_of
from tools.random_programs.scene import Impulse, Tether, box_inertia, corners, toml
from tools.random_programs.scheme import Damping, Scheme
from tools.random_programs.simulation import BlownUp
from tumble.compare.grade.hypotheses.explanation import Explanation, Mistake
from tumble.compare.grade.hypotheses.hypothesis import Context
from tumble.compare.grade.hypotheses.mistakes import hypotheses
from tumble.compare.grade.model.program_model import correct_program
from tumble.compare.grade.results import values
from tumble.scenarios.read import read_scene

ROWS, SPACING = 20, 0.025
THROWN = replace(BRICK, duration=ROWS * SPACING, x=np.array((0.2, 1.0, -0.4)), v=np.array((0.4, 2.0, -0.7)))
SCENES = {
    "hit": replace(
        THROWN,
        impulses=(
            Impulse(0.0, np.array((0.7, -0.3, 1.1)), vertex=5),
            Impulse(0.213, np.array((-0.7, 0.5, 0.4)), point_body=np.array((0.2, 0.1, -0.05))),
        ),
    ),
    "weightless": replace(THROWN, gravity=np.zeros(3)),
    "hung": replace(THROWN, tethers=(Tether(7, np.array((0.0, 2.0, 0.0)), 60.0, 0.4),), drag=(0.8, 0.01)),
    "sprung": replace(THROWN, tethers=(Tether(2, np.array((0.1, 1.6, -0.2)), 40.0, 0.5, rest_length=0.4),)),
}
# A cap holds at every instant or at the end of each step, and a force that ends at a length, or with a lever of metres,
# has its error too; the runs of far too large impulses differ by their rounding.
ROUGH = {
    "spin-cap", "speed-cap", "spin-cap-of-components", "speed-cap-of-components", "speed-threshold", "spin-threshold",
    "tether-pulls-only", "tether-lever-from-origin",
}  # fmt: skip
TOLERANCE_M, ROUGH_M = 1e-6, 2e-2
# The first shears the body: no program here has a matrix that is not one of a rotation.  The second ends a run at an
# instant that the run itself finds: runs without a step of their own begin again only at instants known before.
UNTRANSLATED = {"matrix-euler", "bounce-at-zero"}


def claim_of(hypothesis, value):
    """Return what the JSON of `tumble grade` has of a mistake."""
    one = Explanation((Mistake(hypothesis, value),), 0.0, 0.0, True, False, 0.0, 0.0)
    return Claim(hypothesis.name, {parameter: said for _, parameter, said, _ in values(one)})


def value_of(hypothesis):
    """Return a value, near the neutral one where it may be any; of a step, half a row interval.

    A far smaller inertia spins so fast after an impulse that two right programs differ.  Each hypothesis has its own
    random numbers: a new one changes no other's value.
    """
    if hypothesis.part == "steps":
        return SPACING / 2
    value = planted_value(np.random.default_rng([*hypothesis.text.encode()]), hypothesis)
    is_factor = hypothesis.neutral == 1.0 or hypothesis.name == "wrong-inertia"
    return 1.0 + 0.2 * np.tanh(value) if is_factor else value


@pytest.mark.parametrize(("name", "kind"), [(n, k) for n in SCENES for k in (POSE, VERTICES)])
def test_an_answer_is_the_program_that_it_means(name, kind, tmp_path):
    """Of what an answer leaves open, one possibility is; every mistake that is tried in the scene is an answer."""
    scene = SCENES[name]
    (tmp_path / "a.toml").write_text("step = 0.001\n" + toml(scene), encoding="utf-8")
    own = read_scene(str(tmp_path / "a.toml"))
    program = correct_program(own, 0)
    times = SPACING * np.arange(ROWS + 1)
    first = np.array((0.3, 1.2, -0.35, 0.5, -0.1, 0.7, 0.5))
    context = Context(own, program, kind, len(times), scene.duration, 0.3, SPACING, first)
    case = Case(0, 0, scene, Program(Scheme(SPACING, SPACING)), Dialect(17, kind=kind, vertices=tuple(range(8))))
    wrong = []
    for hypothesis in hypotheses(context):
        if hypothesis.name in UNTRANSLATED:
            continue
        value = value_of(hypothesis)
        right = written(hypothesis.change(program, value), times, own.body.points)
        allowed_m = (ROUGH_M if hypothesis.name in ROUGH else TOLERANCE_M) * max(1.0, np.abs(right).max())
        if not is_file(case, claim_of(hypothesis, value), right, allowed_m):
            wrong.append(hypothesis.text_with(value))
    assert wrong == []


def is_file(case, claim, right, allowed_m):
    """Whether a program that the claim means moves as right; if that leaves all numbers, whether the program does."""
    for candidate in answers.candidates(case, [claim]):
        try:
            seen = case.dialect.seen(candidate.rows(case.scene), case.scene)
        except BlownUp:
            if not np.isfinite(right).all():
                return True
            continue
        if np.abs(seen - right).max() < allowed_m:
            return True
    return False


def test_every_name_can_be_translated():
    page = (Path(__file__).parents[2] / "docs" / "mistakes.md").read_text(encoding="utf-8").partition("\n## ")[0]
    names = {line.split("`")[1] for line in page.splitlines() if line.startswith("| `")}
    names = {name for name in names if not name.startswith(("sensor-", "contact-", "one-impulse-", "floor-"))}
    assert len(names) > 90
    assert names - answers.OWN.keys() - BACK.keys() - answers.IN_SCHEME == UNTRANSLATED


def test_claims_together_are_one_program():
    """Two mistakes and a scheme; a third that is not made is another file."""
    scheme = Scheme(1 / 60, 1 / 60, gyroscopic="implicit", damping=Damping(0.1))
    case = Case(0, 0, SCENES["hit"], Program(scheme, (Planted("impulse doubled"), Planted("conjugate"))), Dialect(9))
    truth = truth_of(case)
    claims = [
        Claim("impulse-wrong-magnitude", {"factor": "2"}),
        Claim("symplectic-euler", {"step": "0.0166666667", "gyroscopic": "implicit", "rotation": "exponential"}),
        Claim(
            "linear-damping", {"rate": "0.1", "damping-form": "by c dt", "damping-place": "after the forces of a step"}
        ),
        Claim("attitude-inverted"),
    ]

    def nearest(claims):
        return min(apart_from(case, one, truth.rows, truth.noise_m) for one in answers.candidates(case, claims))

    assert nearest(claims) < 1
    assert nearest([*claims, Claim("wrong-length-unit", {"choice": "cm for m"})]) > 1e3
    assert nearest(claims[:-1]) > 1e3


def test_two_names_of_one_scheme_are_one_program():
    """A cube's explicit step with the new velocity for x is a symplectic one: w changes by damping at its end alone."""
    size = np.full(3, 0.4)
    cube = replace(THROWN, size=size, inertia=box_inertia(2.0, size), points=corners(size))
    own = Scheme(0.0025, 0.025, gyroscopic="explicit", damping=Damping(0.0, 0.1, "after"))
    case = Case(0, 0, cube, Program(own), Dialect(9))
    truth = truth_of(case)
    damping = {"rate": "0.1", "damping-form": "by c dt", "damping-place": "after a step has moved the body"}
    claims = [Claim("angular-damping", damping), Claim("explicit-euler", {"step": "0.0025", "rotation": "exponential"})]

    def nearest(claims):
        return min(apart_from(case, one, truth.rows, truth.noise_m) for one in answers.candidates(case, claims))

    assert nearest([*claims, Claim("wrong-position-update")]) < 1
    assert nearest([*claims[:1], Claim("symplectic-euler", {"step": "0.0025", "rotation": "exponential"})]) < 1
    assert nearest(claims) > 1e3
