"""The scorer assesses answers made by hand, right and wrong in every way."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from drawn_brick import BRICK

from tools.random_programs import contact, pages, score, table
from tools.random_programs.contact import FIRM, PARTLY, Answer, Claim
from tools.random_programs.dialect import Dialect
from tools.random_programs.mistakes import KINDS
from tools.random_programs.names import BACK, MISTAKES, SCHEME, STEPS, names
from tools.random_programs.program import Case, Planted, Program, truth_of
from tools.random_programs.scene import Impulse, Tether, box_inertia, corners
from tools.random_programs.scheme import Damping, Reading, Scheme

DOCS = Path(__file__).parents[2] / "docs"
HIT_BRICK = replace(BRICK, impulses=(Impulse(0.4, np.array((-0.6, 0.5, 0.4)), vertex=3),))
CUBE = replace(
    HIT_BRICK, size=np.full(3, 0.4), inertia=box_inertia(2.0, np.full(3, 0.4)), points=corners(np.full(3, 0.4))
)
FINE = Scheme(0.001, 0.02, "order 4")
ENGINE = Scheme(1 / 60, 1 / 60, gyroscopic="implicit", damping=Damping(0.1, 0.05))
GRAVITY = Claim("gravity-doubled")
STEP = Claim("symplectic-euler", {"step": "0.016666666", "gyroscopic": "implicit", "rotation": "exponential"})
LINEAR = Claim("linear-damping", {"rate": "0.1", "damping-form": "by c dt"})
ANGULAR = Claim("angular-damping", {"rate": "0.0501"})


def said(verdict, *explanations, confidence=None, failure=""):
    return Answer(verdict, explanations, (), confidence, 1.0, 0.0, 1.0, failure)


def assessed(program, answer, scene=HIT_BRICK, digits=9, noise=0.0):
    """Return what a file is, and what an answer to it is."""
    case = Case(0, 0, scene, program, Dialect(digits), noise)
    truth = truth_of(case)
    kind = score.kind_of(case, truth)
    return kind, score.assessed(case, truth, answer, kind)


def planted(label, own=FINE, **params):
    return Program(own, (Planted(label, params),))


DOUBLED = planted("gravity doubled")
MAGNUS = planted("Magnus force", by=0.1)


@pytest.mark.parametrize(
    ("answer", "right"),
    [
        (said(FIRM, [GRAVITY]), score.RIGHT),
        (said(FIRM, [GRAVITY, LINEAR]), score.EXTRAS),
        (said(FIRM, [LINEAR], [GRAVITY]), score.ALIKE),
        (said(FIRM, [Claim("gravity-wrong-magnitude", {"factor": "2"})]), score.SAME),
        (said(FIRM, [Claim("gravity-wrong-magnitude", {"factor": "1.9"})]), score.WRONG),
        (said(FIRM, [Claim("constant-acceleration")]), score.SAME),
        (said(FIRM, [Claim("clock-rate", {"factor": "1.41"})]), score.WRONG),
        (said(PARTLY, [GRAVITY]), score.PARTLY),
        (said(PARTLY, [LINEAR]), score.HONEST),
        (said("not explained", [LINEAR]), score.HONEST),
        (said("too little to explain"), score.HONEST),
        (said("correct to its noise"), score.FALSE_CORRECT),
        (said("", failure="exit 3"), score.FAILED),
    ],
)
def test_answers_to_a_mistake_with_a_name(answer, right):
    assert assessed(DOUBLED, answer) == (score.NAMED, right)


def of_tether(part, factor):
    return Claim(f"tether-{part}-wrong-magnitude", {"factor": factor})


@pytest.mark.parametrize(
    ("damping", "claims", "right"),
    [
        (2.0, [of_tether("stiffness", "1.25"), of_tether("damping", "1.25")], score.RIGHT),
        (2.0, [of_tether("stiffness", "1.25"), of_tether("damping", "0.8")], score.EXTRAS),
        (2.0, [of_tether("stiffness", "0.8")], score.WRONG),
        (0.0, [of_tether("stiffness", "1.25")], score.RIGHT),
    ],
)
def test_all_of_a_tethers_force_is_that_of_its_spring_and_of_its_damper(damping, claims, right):
    hung = replace(HIT_BRICK, tethers=(Tether(0, np.array((0.5, 1.5, 0.0)), 40.0, damping, 0.0),))
    wrong = planted("tether of another stiffness", factor=1.25)
    assert assessed(wrong, said(FIRM, claims), hung) == (score.NAMED, right)


@pytest.mark.parametrize(
    ("answer", "right"),
    [
        (said(FIRM, [ANGULAR]), score.WRONG),
        (said(PARTLY, [ANGULAR]), score.HONEST),
        (said("not explained"), score.HONEST),
        (said("correct to the printed digits"), score.FALSE_CORRECT),
    ],
)
def test_answers_to_a_mistake_without_a_name(answer, right):
    assert assessed(MAGNUS, answer) == (score.UNNAMED, right)


@pytest.mark.parametrize(
    ("answer", "right"),
    [
        (said("correct to the printed digits"), score.RIGHT),
        (said("not explained"), score.FALSE_ALARM),
        (said(PARTLY, [GRAVITY]), score.FALSE_ALARM),
        (said(FIRM, [GRAVITY]), score.WRONG),
    ],
)
def test_answers_to_a_right_program(answer, right):
    assert assessed(Program(FINE), answer) == (score.NOTHING, right)


@pytest.mark.parametrize(
    ("claims", "right"),
    [
        ([STEP, LINEAR, ANGULAR], score.RIGHT),
        ([STEP, LINEAR], score.PARTLY),
        ([STEP, LINEAR, ANGULAR, GRAVITY], score.EXTRAS),
        ([STEP, LINEAR, Claim("angular-damping", {"rate": "0.06"})], score.WRONG),
        ([replace(STEP, parameters=STEP.parameters | {"gyroscopic": ""}), LINEAR, ANGULAR], score.RIGHT),
        ([replace(STEP, parameters=STEP.parameters | {"gyroscopic": "rescaled"}), LINEAR, ANGULAR], score.WRONG),
        ([replace(STEP, parameters=STEP.parameters | {"rotation": "first order"}), LINEAR, ANGULAR], score.WRONG),
        ([replace(STEP, parameters=STEP.parameters | {"step": "0.02"}), LINEAR, ANGULAR], score.WRONG),
    ],
)
def test_answers_to_a_scheme(claims, right):
    assert assessed(Program(ENGINE), said(FIRM, claims)) == (score.NAMED, right)


def test_what_cannot_be_seen_need_not_be_named_and_may_be():
    """A cube turns alike with any gyroscopic scheme, and few digits show no small damping."""
    program = Program(replace(ENGINE, damping=Damping()))
    other = replace(STEP, parameters=STEP.parameters | {"gyroscopic": "rescaled"})
    assert assessed(program, said(FIRM, [other]), CUBE) == (score.NAMED, score.SAME)
    assert assessed(program, said(FIRM, [other])) == (score.NAMED, score.WRONG)
    weak = Program(replace(ENGINE, damping=Damping(1e-4)))
    for claims in ([STEP], [STEP, Claim("linear-damping", {"rate": "0.0003"})]):
        assert assessed(weak, said(FIRM, claims), digits=5)[1] == score.RIGHT


def test_what_the_noise_hides_need_not_be_named_and_may_be():
    """A damping of 0.003/s moves the brick by less than 3 times a noise of 1e-3; the mistake beside it is due."""
    program = Program(FINE, (*DOUBLED.planted, Planted("linear damping", {"rate": 0.003})))
    for claims in ([GRAVITY], [GRAVITY, Claim("linear-damping", {"rate": "0.002"})]):
        assert assessed(program, said(FIRM, claims), noise=1e-3) == (score.NAMED, score.RIGHT)
    assert assessed(program, said(FIRM, [GRAVITY]))[1] != score.RIGHT
    weak = replace(program, planted=program.planted[1:])
    assert assessed(weak, said("correct to its noise"), noise=1e-3) == (score.FAINT, score.RIGHT)
    assert assessed(weak, said(FIRM, [GRAVITY]), noise=1e-3) == (score.FAINT, score.WRONG)
    damping = Claim("linear-damping", {"rate": "0.002"})
    assert assessed(weak, said(FIRM, [GRAVITY], [damping]), noise=1e-3) == (score.FAINT, score.RIGHT)
    assert assessed(weak, said(FIRM, [GRAVITY], [GRAVITY, damping]), noise=1e-3) == (score.FAINT, score.WRONG)


def test_late_and_interpolated_rows_are_named_by_one_claim_or_two():
    program = Program(replace(FINE, dt=1 / 50, spacing=1 / 60, reading=Reading(1, "arcs")))
    between = Claim("interpolated-rows", {"step": "0.02"})
    late = Claim("log-lag", {"time": "0.02"})
    # An engine's rows that are late and interpolated have the one name, with the tick as their time.
    for claims in ([between], [between, late], [late]):
        assert assessed(program, said(FIRM, claims), digits=5) == (score.NAMED, score.RIGHT)
    assert assessed(program, said(FIRM, [Claim("interpolated-rows", {"step": "0.01"})]), digits=5)[1] == score.WRONG


def test_a_torque_that_damps_is_a_damping_where_moments_are_equal_only():
    damping = planted("drag torque", share=0.2)
    said_so = said(FIRM, [Claim("angular-damping", {"rate": "0.2"})])
    assert assessed(damping, said_so, CUBE, 6) == (score.NAMED, score.SAME)
    assert assessed(damping, said_so, digits=6) == (score.NAMED, score.WRONG)


def test_an_explanation_that_makes_the_same_motion_is_simulated():
    """A cube without the gyroscopic term, an inertia of a sphere: nothing else is wrong, and the file is of a step."""
    program = Program(Scheme(1 / 60, 1 / 60, gyroscopic="none"), (Planted("impulse doubled", {}),))
    plain = Claim("symplectic-euler", {"step": "0.0166666667"})
    twice = Claim("impulse-wrong-magnitude", {"factor": "2.000000"})
    missing = Claim("gyroscopic-term-missing")
    assert assessed(program, said(FIRM, [plain, twice, missing]))[1] == score.SAME
    assert assessed(program, said(FIRM, [plain, twice]))[1] in (score.WRONG, score.PARTLY)


def test_claims_are_read_from_rows_of_json():
    rows = [
        {"rank": 1, "mistake": "symplectic-euler", "parameter": "step", "value": "0.01", "residual_m": 0.5},
        {"rank": 1, "mistake": "symplectic-euler", "parameter": "rotation", "value": "first order", "residual_m": 0.5},
        {"rank": 1, "mistake": "linear-damping", "parameter": "rate", "value": "0.1", "residual_m": 0.5},
        {"rank": 1, "mistake": "linear-damping", "parameter": "rate", "value": "0.2", "residual_m": 0.5},
        {"rank": 2, "mistake": "attitude-inverted", "parameter": "", "value": "", "residual_m": 0.5},
    ]
    whole = {"verdict": FIRM, "engines": [], "diagnosis": rows, "max_error_m": 2.0, "cpu_s": 3.5}
    answer = contact.answer_of(whole)
    assert [str(claim) for claim in answer.best] == [
        "symplectic-euler (0.01, first order)",
        "linear-damping (0.1)",
        "linear-damping (0.2)",
    ]
    assert [claim.name for claim in answer.explanations[1]] == ["attitude-inverted"]
    assert (answer.confidence, answer.residual_m, answer.cpu_s) == (None, 0.5, 3.5)
    assert contact.answer_of(whole | {"confidence": 0.9}).confidence == 0.9
    assert contact.answer_of(whole | {"diagnosis": [row | {"confidence": "0.8"} for row in rows]}).confidence == 0.8
    assert contact.answer_of(whole | {"verdict": "not explained"}).best == ()


def test_the_names_are_those_that_tumble_has():
    """What is renamed there is renamed in the table."""
    page = (DOCS / "mistakes.md").read_text(encoding="utf-8").partition("\n## ")[0]
    used = {name.name for entries in (*MISTAKES.values(), *SCHEME.values()) for name in entries}
    used |= {f"wrong-body-size-along-{axis}" for axis in "xyz"} | set(STEPS.values()) | set(BACK)
    used |= {name.name for how in ("held", "arcs") for name in names("rows between ticks", {"how": how, "tick": 0.01})}
    used |= {name.name for every in (0, 10) for name in names("normalised", {"every": every})}
    assert [name for name in sorted(used) if f"`{name}`" not in page] == []
    assert set(MISTAKES) <= set(KINDS)


# --- the page -------------------------------------------------------------------------------------------------------


def row(number, kind, assessed, cpu_s=1.0, confidence=None, true='["gravity doubled"]', noise=0.0):
    return table.Row(
        number, "brick", kind, assessed, "explained", true, "gravity-doubled", "", "", 500.0, 1.0, 1.0, 0.5,
        confidence, cpu_s, 50, noise, 1e-3 if noise else 2e-3, 7, "single", "pose", "split", "none", "exponential",
        "none", "each tick",
        '["gravity doubled"]', "",
    )  # fmt: skip


ROWS = [
    *(row(n, score.NAMED, score.RIGHT, confidence=0.9) for n in range(8)),
    row(8, score.NAMED, score.WRONG, 7.0, 0.9),
    row(9, score.NAMED, score.ALIKE, 2.0, 0.6),
    row(10, score.UNNAMED, score.HONEST),
    row(11, score.UNNAMED, score.FALSE_CORRECT),
    row(12, score.NOTHING, score.RIGHT, true="[]"),
    row(13, score.NAMED, score.RIGHT, confidence=0.9, noise=2e-5),
    row(14, score.NAMED, score.PARTLY, 4.0, noise=2e-4),
    row(15, score.UNNAMED, score.HONEST, noise=1e-3),
]


def test_the_page_counts():
    page = table.markdown(ROWS, 5)
    for line in (
        "| programs | 13 | 3 | 16 |  |",
        "| with names: right | 8 of 10 (80.0 %) | 1 of 2 (50.0 %) | 9 of 12 (75.0 %) | 90 % |",
        "| without a name: honest (or the same motion) | 1 of 2 (50.0 %) | 1 of 1 (100.0 %) | 2 of 3 (66.7 %) | 90 % |",
        '| false "correct" | 1 | 0 | 1 | 0 |',
        "| firmly wrong | 1 of 13 (7.7 %) | 0 of 3 (0.0 %) | 1 of 16 (6.2 %) | at most 1 % |",
        "| answers within 3 s of processor time | 12 of 13 (92.3 %) | 2 of 3 (66.7 %) | 14 of 16 (87.5 %) | 95 % |",
        "| digits alone | 0.85 to 0.95 | 9 | 0.90 | 89 % |",
        "| digits alone | 0.5 to 0.7 | 1 | 0.60 | 100 % |",
        "| with noise | 0.85 to 0.95 | 1 | 0.90 | 100 % |",
        "| 1e-05 to 0.0001 | 1 | 1 |",
        "16 programs, seed 5: `python -m tools.random_programs --count 16 --seed 5`.",
    ):
        assert line in page, page
    assert "| 8 | brick | none | firmly wrong | gravity doubled |" in page


def test_rows_are_read_as_they_are_written():
    assert table.read(table.csv_text(ROWS)) == ROWS


def test_a_file_that_the_command_measures_otherwise_is_listed():
    assert "None:" in table.markdown(ROWS, 5)
    odd = replace(ROWS[0], graded_error_m=1.5)
    assert "- program 0, brick: 1.5 m for 1 m" in table.markdown([odd], 5)


def test_the_figures_are_written_into_the_pages_and_nothing_else_is_changed():
    page = "# Title\n\nsome words\n\n## Random programs\n\nold figures\n\n## Held out: files\n\nother figures\n"
    made = pages.in_confusion(page, ROWS, 5)
    assert made.startswith("# Title\n\nsome words\n\n## Random programs\n")
    assert made.endswith("\n\n## Held out: files\n\nother figures\n")
    assert "old figures" not in made
    assert "--count 16 --seed 5 --docs" in made
    assert "| 1 | 9 of 10 (90.0 %) | 1 of 2 (50.0 %) |" in made
    assert pages.in_confusion(made, ROWS, 5) == made
    guide = f"before\n\n{pages.PARAGRAPH} of old\nfigures\n\nafter\n"
    made = pages.in_guide(guide, ROWS, 5)
    assert made.startswith(f"before\n\n{pages.PARAGRAPH} `python -m tools.random_programs --count 16 --seed 5`")
    assert made.endswith("\n\nafter\n")
    assert "figures\n" not in made
    words = " ".join(made.split())
    for said in (
        "rightly in 9 of 10 cases: 9 of 10 with one mistake, 0 of 0 with two",
        "they were in 1 of 2.",
        "no name, 2 of 3 were reported as not explained",
        "called explained, 10 of 15 were right; 1 wrong file was called correct",
    ):
        assert said in words, words
    assert pages.in_guide(made, ROWS, 5) == made


def test_the_figures_of_the_documentation_are_those_of_its_rows():
    confusion, guide = ((DOCS / name).read_text(encoding="utf-8") for name in ("confusion.md", "grade.md"))
    seed = int(re.search(r"random_programs --count \d+ --seed (\d+)", confusion)[1])
    rows = table.read((DOCS / "random-programs.csv").read_text(encoding="utf-8"))
    assert pages.in_confusion(confusion, rows, seed) == confusion
    assert pages.in_guide(guide, rows, seed) == guide
