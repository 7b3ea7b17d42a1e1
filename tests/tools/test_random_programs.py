"""The generator: right programs are right, every scheme converges to the right motion, every branch can be drawn."""

import ast
import json
import sys
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from drawn_brick import BRICK

from tools.random_programs import __main__ as command
from tools.random_programs import contact, dialect, drawn_scenes, measurement, scheme
from tools.random_programs import program as programs
from tools.random_programs.dialect import AXES, EULER, MATRIX, VERTICES, Dialect
from tools.random_programs.gyroscopic import SCHEMES
from tools.random_programs.mistakes import KINDS
from tools.random_programs.names import names
from tools.random_programs.program import Case, Planted, Program, truth_of
from tools.random_programs.reference import reference
from tools.random_programs.scene import Impulse, Tether, box_inertia, corners, read, toml
from tools.random_programs.scheme import SPLIT, TABLEAUS, VERLET, Damping, Reading, Scheme
from tools.random_programs.simulation import BlownUp, Simulation
from tools.random_programs.turning import TURNINGS

FOLDER = Path(command.__file__).parent
STRUCK = replace(
    BRICK,
    impulses=(
        Impulse(0.0, np.array((0.5, -0.3, 0.2)), vertex=3),
        Impulse(0.4, np.array((-0.6, 0.5, 0.4)), point_body=np.array((0.2, -0.1, 0.05))),
    ),
)
PULLED = replace(
    STRUCK,
    tethers=(Tether(5, np.array((0.0, 2.0, 0.0)), 30.0, 0.6, 0.4), Tether(2, np.array((1.0, 0.0, 0.5)), 8.0, 0.2)),
    drag=(0.4, 0.01),
)


def right(scene, dt=0.001):
    return Program(Scheme(dt, 0.05, "order 4"))


def off(scene, own):
    """Return how far off the vertices of a scheme are at the end [m]."""
    rows = Program(own).rows(scene)
    return np.linalg.norm(rows.vertices[-1] - reference(scene, rows.t).vertices[-1], axis=1).max()


# --- right programs are right ---------------------------------------------------------------------------------------


def test_it_shares_nothing_with_the_project():
    """Only numpy, scipy and itself: what it measures has no part in the measure."""
    known = {*sys.stdlib_module_names, "numpy", "scipy"}
    for file in FOLDER.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            modules = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            modules += [node.module] if isinstance(node, ast.ImportFrom) else []
            for module in modules:
                assert module.split(".")[0] in known or module.startswith("tools.random_programs"), (file, module)


@pytest.mark.parametrize("keeps", ["world", "body", "momentum"])
@pytest.mark.parametrize("seed", range(4))
def test_its_two_right_programs_agree(seed, keeps):
    """Order 4 in world axes against DOP853 in body axes; two of the four scenes have forces."""
    scene = (BRICK, STRUCK, PULLED, drawn_scenes.drawn(np.random.default_rng(1)))[seed]
    rows = Program(Scheme(0.0005, 0.05, "order 4", keeps=keeps)).rows(scene)
    assert np.abs(rows.vertices - reference(scene, rows.t).vertices).max() < 1e-9


@pytest.mark.parametrize("name", ["pulled", "two-hits", "dzhanibekov", "die-vertex", "skewed"])
def test_right_programs_are_what_tumble_calls_the_truth(name, tmp_path):
    """In 17 digits.  Of scenes with forces `tumble grade` has the right motion to some 1e-8 m, and order 4 does."""
    skewed = np.array(((0.03, 0.004, -0.002), (0.004, 0.04, 0.003), (-0.002, 0.003, 0.05)))
    own = {"pulled": PULLED, "skewed": replace(STRUCK, size=None, inertia=skewed)}
    scene = own.get(name) or read(contact.scene_text(name), name)
    scene = replace(scene, duration=min(scene.duration, 2.0))
    case = Case(0, 0, scene, right(scene, 0.0005), Dialect(17))
    truth = truth_of(case)
    by_order_4 = contact.graded(*command.written(case, truth, tmp_path))
    exact = replace(truth, rows=reference(scene, truth.rows.t))
    by_reference = contact.graded(*command.written(case, exact, tmp_path))
    known_m = 2e-8 if scene.tethers or any(scene.drag) else 2e-11
    assert by_reference.max_error_m < known_m
    assert by_order_4.max_error_m == pytest.approx(truth.error_m, rel=0.01, abs=known_m)
    assert truth.error_m < 2e-8


@pytest.mark.parametrize(
    "own",
    [
        Dialect(9, fixed=True, clock="6", unit="cm", t_unit="ms", separator=";", decimal=","),
        Dialect(8, names="own", scalar_last=True, shuffled=3, velocities=True, separator="\t"),
        Dialect(7, names="none", kind=MATRIX, separator=" "),
        Dialect(7, kind=VERTICES, vertices=(0, 1, 2, 6), start=10.0),
        Dialect(6, kind=EULER, names="own"),
        *(Dialect(9, axes=axes, velocities=True) for axes in AXES),
        Dialect(9, json=True),
    ],
    ids=str,
)
def test_every_dialect_is_read_as_it_is_meant(own, tmp_path):
    """A right file is off by no more than its digits, as this package counts them."""
    case = Case(0, 0, BRICK, right(BRICK), own)
    truth = truth_of(case)
    answer = contact.graded(*command.written(case, truth, tmp_path))
    assert not answer.failure
    assert answer.is_correct
    assert answer.max_error_m <= truth.noise_m.max()


def test_the_noise_is_what_digits_and_precision_leave():
    """Rows read back from the file are within it, and less than ten times as near."""
    for own in (Dialect(5), Dialect(7, fixed=True), Dialect(6, kind=VERTICES, vertices=tuple(range(8)))):
        case = Case(0, 0, BRICK, right(BRICK), own)
        truth = truth_of(case)
        cells = [line.split(",") for line in own.text(truth.rows).splitlines()[1:]]
        printed = np.array(cells, float)
        if own.kind == VERTICES:
            vertices = printed[:, 1:].reshape(len(printed), -1, 3)
        else:
            vertices = replace(truth.rows, x=printed[:, 1:4], q=printed[:, 4:8]).vertices
        moved = np.linalg.norm(vertices - truth.rows.vertices, axis=2).max(axis=1)
        assert (moved <= truth.noise_m * 1.0001).all()
        assert moved.max() > 0.1 * truth.noise_m.max()
    single = Case(0, 0, BRICK, right(BRICK).with_scheme(single=True), Dialect(9))
    assert truth_of(single).noise_m[-1] > 10 * truth_of(replace(single, program=right(BRICK))).noise_m[-1]
    assert truth_of(single).error < programs.DIGITS.seen


# --- measurement noise ----------------------------------------------------------------------------------------------

CORNERS = tuple(range(8))


def read_back(case, rows):
    """Return the vertices in the file of a case, in poses or vertices of ten digits."""
    cells = [line.split(",") for line in case.text(rows).splitlines()[1:]]
    printed = np.array(cells, float)[:, 1:]
    if case.dialect.kind == VERTICES:
        return printed.reshape(len(printed), -1, 3)
    return replace(rows, x=printed[:, :3], q=printed[:, 3:7]).vertices


@pytest.mark.parametrize("own", [Dialect(10), Dialect(10, kind=VERTICES, vertices=CORNERS)], ids=str)
def test_a_measured_file_has_the_noise_that_is_said(own):
    """On the whole: no offset, the right size, another draw in each file, and the same when drawn again."""
    case = Case(0, 3, replace(BRICK, duration=10.0), right(BRICK), own, noise=1e-3)
    truth = truth_of(case)
    moved = read_back(case, truth.rows) - truth.rows.vertices
    size_m = np.sqrt(np.square(moved).sum(axis=2).mean())
    assert size_m == pytest.approx(np.median(truth.noise_m), rel=0.1)
    assert size_m == pytest.approx(1e-3 * np.ptp(BRICK.points, axis=0).max() * np.sqrt(3), rel=0.5)
    assert np.abs(moved.mean(axis=0)).max() < 0.3 * size_m
    assert case.text(truth.rows) == case.text(truth.rows) != replace(case, number=1).text(truth.rows)


def test_a_measured_matrix_has_the_noise_of_its_quaternion():
    """Angles and matrices are written of the same pose; the rows of a mistake in the matrix stay mistaken."""
    truth = truth_of(Case(0, 3, BRICK, right(BRICK), Dialect(10)))
    rows = replace(truth.rows, own_axes=1.1 * truth.rows.axes)
    noisy = measurement.measured(rows, BRICK, 1e-3, False, np.random.default_rng(1))
    assert noisy.own_axes == pytest.approx(1.1 * replace(noisy, own_axes=None).axes, abs=1e-12)
    assert 1e-4 < np.abs(noisy.own_axes - rows.own_axes).max() < 1e-2


def test_a_fifth_of_the_programs_is_measured_over_the_whole_range():
    random = np.random.default_rng(5)
    noises = np.array([measurement.drawn(random) for _ in range(4000)])
    some = noises[noises > 0]
    assert len(some) == pytest.approx(0.2 * len(noises), rel=0.15)
    assert (some.min(), some.max()) == (pytest.approx(1e-5, rel=0.1), pytest.approx(1e-3, rel=0.1))
    assert (some < 1e-4).mean() == pytest.approx(0.5, abs=0.06)


def test_cases_with_noise_and_without_are_drawn():
    cases = [programs.drawn(number, 9, CATALOGUE)[0] for number in range(25)]
    assert {bool(case.noise) for case in cases} == {False, True}
    assert not any(case.dialect.velocities for case in cases if case.noise)


def test_a_mistake_below_three_times_the_noise_does_not_count_as_planted():
    """The root mean square over rows and vertices: a velocity of 0.1 m/s along z moves all by 0.1 t, 58 mm in 1 s."""
    still = replace(BRICK, gravity=np.zeros(3), w=np.zeros(3), v=np.array((0.0, 0.0, 0.1)), duration=1.0)
    program = Program(Scheme(0.001, 0.01, "order 4"), (Planted("start velocity missing"),))
    size_m = np.ptp(BRICK.points, axis=0).max()

    def planted(times):
        noise = 0.1 / np.sqrt(3) / (np.sqrt(3) * size_m * times)
        case = Case(0, 0, still, program, Dialect(9, kind=VERTICES, vertices=CORNERS), noise=noise)
        (fact,) = (fact for fact in truth_of(case).significant or truth_of(case).facts if fact.mistake)
        return fact.effect, bool(truth_of(case).significant)

    assert planted(2.9) == (pytest.approx(2.9, rel=0.02), False)
    assert planted(3.1) == (pytest.approx(3.1, rel=0.02), True)


def test_a_right_program_with_noise_is_correct_to_its_noise(tmp_path):
    for own in (Dialect(7), Dialect(7, kind=VERTICES, vertices=CORNERS)):
        case = Case(0, 0, replace(BRICK, duration=2.0), right(BRICK), own, noise=1e-4)
        truth = truth_of(case)
        answer = contact.graded(*command.written(case, truth, tmp_path))
        assert truth.error < programs.MEASUREMENT.seen
        assert answer.verdict == "correct to its noise"
        assert np.median(truth.noise_m) < answer.max_error_m < 6 * np.median(truth.noise_m)


# --- every scheme converges, at its order ---------------------------------------------------------------------------


@pytest.mark.parametrize("method", [*TABLEAUS, VERLET])
def test_methods_are_of_their_order(method):
    """Verlet's kicks have the gyroscopic term at the w that they change: with it the method is of order 1."""
    order = {"explicit Euler": 1, VERLET: 1, "order 3": 3, "order 3, Shu and Osher": 3}.get(method, 2)
    order = 4 if method.startswith("order 4") else order
    steps = (0.01, 0.005) if order > 2 else (0.002, 0.001)
    for keeps in ("world", "body", "momentum") if method != VERLET else ("world",):
        coarse, finer = (off(STRUCK, Scheme(dt, 0.1, method, keeps=keeps)) for dt in steps)
        assert np.log2(coarse / finer) == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize(
    ("gyroscopic", "turning"), [*product(SCHEMES, ["exponential"]), *product(["explicit"], TURNINGS)]
)
def test_split_schemes_converge(gyroscopic, turning):
    """To first order; without a gyroscopic term a triaxial body never turns right."""
    coarse, finer = (off(STRUCK, Scheme(dt, 0.1, gyroscopic=gyroscopic, turning=turning)) for dt in (0.002, 0.0005))
    if gyroscopic == "none":
        assert finer > 0.9 * coarse > 1e-3
    else:
        assert 1e-5 < finer < coarse / 3


@pytest.mark.parametrize(
    "changes",
    [
        {"keeps": "body"},
        {"keeps": "momentum"},
        {"moves": "old"},
        {"moves": "old, all"},
        {"moves": "parabola"},
        {"centre": 4},
        {"substeps": 4},
        {"idle": 1},
        {"asleep": 1},
        {"velocity": "body"},
        {"velocity": "screw"},
        {"recovers": True},
        {"reading": Reading(1)},
        {"reading": Reading(-1)},
        {"reading": Reading(1, "held")},
        {"reading": Reading(0, "straight")},
        {"reading": Reading(0, "arcs")},
        {"reading": Reading(0, "ahead")},
        {"reading": Reading(0, "smooth")},
    ],
    ids=str,
)
def test_parts_of_a_scheme_vanish_with_the_step(changes):
    """All of them cost the less the shorter a step is; rows between ticks at a spacing that ticks do not divide."""
    spacing = 0.013 if "reading" in changes and changes["reading"].between else 0.1
    coarse, finer = (off(replace(STRUCK, impulses=()), Scheme(dt, spacing, **changes)) for dt in (0.004, 0.001))
    assert finer < coarse / 2.5


@pytest.mark.parametrize("how", ["1 - c dt", "exp", "1/(1 + c dt)"])
@pytest.mark.parametrize("where", ["before", "between", "after"])
def test_damping_is_of_its_rate(where, how):
    scene = replace(BRICK, gravity=np.zeros(3), inertia=np.eye(3) * 0.1)
    own = Scheme(0.0005, 0.1, damping=Damping(0.5, 0.2, where, how))
    rows = Program(own).rows(scene)
    assert rows.v[-1] == pytest.approx(scene.v * np.exp(-0.5), rel=1e-3)
    assert rows.w[-1] == pytest.approx(scene.w * np.exp(-0.2), rel=1e-3)


def test_places_and_kinds_of_damping_differ():
    damped = [
        Damping(0.5, 0.2, w, h) for w in ("before", "between", "after") for h in ("1 - c dt", "exp", "1/(1 + c dt)")
    ]
    ends = [Program(Scheme(0.01, 0.1, damping=d)).rows(BRICK).x[-1] for d in damped]
    assert all(np.linalg.norm(a - b) > 1e-5 for n, a in enumerate(ends) for b in ends[:n])


# --- every branch can be drawn --------------------------------------------------------------------------------------


def test_every_branch_of_the_grammar_is_drawn():
    random = np.random.default_rng(5)
    schemes = [own for own in (scheme.drawn(random, 2.0) for _ in range(4000)) if own]
    splits = [own for own in schemes if own.method == SPLIT]
    assert {own.gyroscopic for own in splits} == set(SCHEMES)
    assert {own.turning for own in splits} == set(TURNINGS)
    assert {own.method for own in schemes} == {SPLIT, VERLET, *TABLEAUS}
    damped = [own.damping for own in splits if own.damping.linear or own.damping.angular]
    assert {(d.where, d.how) for d in damped} == set(
        product(("before", "between", "after"), ("1 - c dt", "exp", "1/(1 + c dt)"))
    )
    assert {bool(d.linear) for d in damped} == {bool(d.angular) for d in damped} == {False, True}
    assert {own.reading for own in schemes} == {Reading(late) for late in (-1, 0, 1, 2)} | {
        Reading(late, between) for between in ("held", "straight", "arcs") for late in (0, 1)
    } | {Reading(0, "ahead")}
    ticks = {round(1 / own.dt) for own in schemes if own.reading.between}
    assert ticks == {50, 60, 100, 120}
    for part, values in {
        "keeps": {"world", "body", "momentum"},
        "moves": {"new", "old", "old, all", "parabola"},
        "substeps": {1, 2, 4, 8},
        "centre": {1, 4},
        "normalises": {0, 1, 10, 20},
        "idle": {0, 1, 2},
        "asleep": {0, 1, 2, 5},
        "velocity": {"world", "body", "screw"},
        "recovers": {False, True},
        "single": {False, True},
    }.items():
        assert {getattr(own, part) for own in schemes} == values, part


def test_every_way_to_write_a_file_is_drawn():
    random = np.random.default_rng(5)
    drawn = [dialect.drawn(random, BRICK) for _ in range(1500)]
    assert {own.digits for own in drawn} == {5, 6, 7, 8, 9}
    for part, values in {
        "kind": {"pose", MATRIX, EULER, VERTICES},
        "names": {"canonical", "own", "none"},
        "separator": {",", ";", "\t", " "},
        "decimal": {".", ","},
        "clock": {"", "5", "6", "9"},
        "axes": {"", *AXES},
        "unit": {"m", "cm"},
        "t_unit": {"s", "ms"},
        "json": {False, True},
        "fixed": {False, True},
        "velocities": {False, True},
        "scalar_last": {False, True},
    }.items():
        assert {getattr(own, part) for own in drawn} == values, part
    assert any(own.kind == VERTICES and len(own.vertices) < 8 for own in drawn)


def test_scenes_of_every_kind_are_drawn():
    random = np.random.default_rng(5)
    drawn = [drawn_scenes.drawn(random) for _ in range(400)]
    skewed = [np.abs(scene.inertia - np.diag(np.diag(scene.inertia))).max() > 1e-6 for scene in drawn]
    for test in (
        lambda scene: scene.size is None,
        lambda scene: scene.is_triaxial,
        lambda scene: scene.gravity.any(),
        lambda scene: scene.tethers,
        lambda scene: any(tether.rest_length for tether in scene.tethers),
        lambda scene: any(scene.drag),
        lambda scene: scene.w.any(),
        lambda scene: len(scene.impulses) > 1,
        lambda scene: any(impulse.time > 0 for impulse in scene.impulses),
        lambda scene: any(impulse.vertex is not None for impulse in scene.impulses),
        lambda scene: any(impulse.point_body is not None for impulse in scene.impulses),
        lambda scene: any(impulse.point is not None for impulse in scene.impulses),
    ):
        assert {bool(test(scene)) for scene in drawn} == {False, True}
    assert {*map(bool, skewed)} == {False, True}


def test_a_scene_file_says_the_scene():
    random = np.random.default_rng(2)
    for _ in range(40):
        scene = drawn_scenes.drawn(random)
        again = read(toml(scene), scene.name)
        times = np.array((0.0, scene.duration))
        assert again.impulses.__len__() == len(scene.impulses)
        assert reference(again, times).vertices == pytest.approx(reference(scene, times).vertices, abs=1e-9)


def made(label, scenes, schemes):
    """Return by how much a mistake moves [m] and turns [rad] the body in a scene and upon a scheme in which it does."""
    random = np.random.default_rng(3)
    largest = -1.0
    for scene, own in product(scenes, schemes):
        if not KINDS[label].where(scene, own):
            continue
        planted = Planted(label, KINDS[label].drawn(random, scene, own))
        try:
            wrong, clean = Program(own, (planted,)).rows(scene), Program(own).rows(scene)
        except BlownUp:
            continue
        count = min(len(wrong.t), len(clean.t))
        cosine = np.abs((wrong.q[:count] * clean.q[:count]).sum(axis=1)).clip(0, 1)
        turned = np.sqrt(2 * (1 - cosine)).max()
        largest = max(largest, np.abs(wrong.x[:count] - clean.x[:count]).max() + turned)
        if largest > 1e-3:
            break
    return largest


LONG = replace(BRICK, duration=2.0, w=np.array((3.0, -6.0, 4.0)))
SKEWED = replace(
    LONG, size=None, inertia=np.array(((0.03, 0.004, -0.002), (0.004, 0.04, 0.003), (-0.002, 0.003, 0.05)))
)
ONCE = replace(STRUCK, impulses=STRUCK.impulses[1:])
AT_ONCE = replace(STRUCK, impulses=STRUCK.impulses[:1])
SLOW = replace(BRICK, w=np.array((0.3, -0.2, 0.1)))
PLACES = (LONG, SLOW, SKEWED, STRUCK, ONCE, AT_ONCE, PULLED, replace(LONG, gravity=np.zeros(3)))
UPON = (Scheme(1 / 60, 1 / 60, "order 4", keeps="world"), Scheme(1 / 60, 1 / 60, gyroscopic="explicit"))


@pytest.mark.parametrize("label", KINDS)
def test_every_mistake_can_be_made_and_moves_the_body(label):
    assert made(label, PLACES, UPON) > 1e-3


def test_there_are_mistakes_with_names_and_without():
    random = np.random.default_rng(0)
    params = {label: _any_params(kind, random) for label, kind in KINDS.items()}
    without = [label for label in KINDS if not names(label, params[label])]
    assert len(KINDS) - len(without) >= 30
    assert len(without) >= 30


def _any_params(kind, random):
    for scene, own in product(PLACES, UPON):
        if kind.where(scene, own):
            return kind.drawn(random, scene, own)
    raise AssertionError(kind.label)


# --- draws ----------------------------------------------------------------------------------------------------------

CATALOGUE = {"brick": BRICK, "struck": STRUCK}


def test_a_seed_gives_its_programs_again_each_by_itself():
    both = [programs.drawn(number, 9, CATALOGUE) for number in (3, 4)]
    case, truth = programs.drawn(4, 9, CATALOGUE)
    assert case.dialect.text(truth.rows) == both[1][0].dialect.text(both[1][1].rows)
    assert case.dialect.text(truth.rows) != both[0][0].dialect.text(both[0][1].rows)
    assert (
        programs.drawn(4, 10, CATALOGUE)[1].rows.t.tolist() != truth.rows.t.tolist()
        or programs.drawn(4, 10, CATALOGUE)[0].program != case.program
    )


def test_what_is_not_to_be_seen_is_said():
    """A cube's gyroscopic term makes no difference; a tenth of a damping's effect is a tenth."""
    cube = replace(
        BRICK, size=np.full(3, 0.4), inertia=box_inertia(2.0, np.full(3, 0.4)), points=corners(np.full(3, 0.4))
    )
    own = Scheme(1 / 60, 1 / 60, gyroscopic="none", damping=Damping(0.1))

    def facts(scene, digits=9, damping=0.1):
        program = Program(replace(own, damping=Damping(damping)))
        return {fact.label: fact.effect for fact in truth_of(Case(0, 0, scene, program, Dialect(digits))).facts}

    assert facts(cube)["gyroscopic term missing"] < programs.DIGITS.seen
    assert facts(BRICK)["gyroscopic term missing"] > 1e5
    assert facts(BRICK, damping=0.01)["linear damping"] == pytest.approx(0.1 * facts(BRICK)["linear damping"], rel=0.1)
    assert facts(BRICK, digits=6)["linear damping"] == pytest.approx(1e-3 * facts(BRICK)["linear damping"], rel=0.7)


def test_a_program_is_simulated_in_its_precision():
    sim = Simulation(PULLED, Scheme(1 / 60, 1 / 60, single=True), np.float32)
    sim.rows()
    assert {type(part) for vector in (sim.x, sim.q, sim.v, sim.w) for part in vector} == {np.float32}


def test_files_are_drawn_from_the_command_line(tmp_path, capsys):
    assert command.main(["--seed", "7", "--count", "2", "--draw", "-o", str(tmp_path)]) == 0
    assert sorted(file.suffix for file in (tmp_path / "files").iterdir() if "0001" in file.name)[-1] == ".toml"
    assert capsys.readouterr().out.startswith("seed 7\n")


def test_stored_answers_are_assessed_again(tmp_path, capsys, monkeypatch):
    """Without asking again, unless the file is another one now."""
    words = ["--seed", "7", "--count", "2", "--processes", "1", "-o", str(tmp_path)]
    assert command.main([*words, "--draw"]) == 0
    answer = {"verdict": "correct", "engines": [], "diagnosis": [], "max_error_m": 0.0, "cpu_s": 1.0}
    for number in range(2):
        (tmp_path / "files" / f"000{number}.answer.json").write_text(json.dumps(answer))
    asked = []
    monkeypatch.setattr(contact, "asked", lambda *files: asked.append(files[0]) or answer)
    assert command.main([*words, "--evaluate"]) == 0
    assert not asked
    first = next(file for file in (tmp_path / "files").glob("0000.*") if file.suffix in (".csv", ".jsonl"))
    first.write_text("another file")
    assert command.main([*words, "--evaluate"]) == 0
    assert asked == [first]
    page = (tmp_path / "random-programs.md").read_text(encoding="utf-8")
    assert capsys.readouterr().out.endswith(f"{page}\n")
    assert len((tmp_path / "random-programs.csv").read_text().splitlines()) == 3
