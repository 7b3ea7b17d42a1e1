"""Maps, limits and their theory, on a hand-written engine with a known limit and on the real ones; and going on."""

import math
import shutil
from collections.abc import Mapping
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tumble.compare.run.running_engines import RunningEngine, launched
from tumble.compare.run.truths import Answer
from tumble.compare.stability import tasks
from tumble.compare.stability.columns import (
    FACTORS,
    PROBED,
    RADIANS,
    ROWS,
    Column,
    Question,
    columns,
    natural_parameter,
    truth_of,
)
from tumble.compare.stability.modes import Mode, stiffest_mode
from tumble.compare.stability.study import map_scenes
from tumble.compare.stability.tasks import STIFF
from tumble.compare.stability.theory import (
    damping_implicit_euler,
    held_parabola,
    limit_of,
    runge_kutta_4,
    semi_implicit_euler,
    theory,
)
from tumble.compare.stability.trials import STEPS, Effort, Piece, Trials, edge
from tumble.scenarios.read import BadScene, read_scene
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import truth

SPRINGS = str(Path(__file__).parents[2] / "plugins" / "springs.py")
TETHER = read_scene("tether-undamped")
SPIN = read_scene("spin-fast")

CELL_COLUMNS = "scene,engine,method,dt_s,parameter,value,status,why,verdict,max_error_m,energy_ratio,resolution_m"


def known(answer) -> Future:
    future: Future = Future()
    future.set_result(answer)
    return future


def ask(scene: Scene, *contestants: str, factors=(1.0,), true: bool = False) -> dict[str, Piece]:
    """Return the pieces of some contestants, held against a truth or against the energy alone."""
    own = columns(scene, factors)
    truths = [known(Answer(truth(column.scene_of(ROWS)) if true else None, "")) for column in own]
    found = {}
    with launched(contestants, 60.0) as running_engines:
        for running_engine in running_engines:
            for method in running_engine.methods:
                piece = Trials(running_engine, method, Question(scene, own, truths)).piece()
                found[f"{running_engine.title}:{method}"] = piece
    return found


# Modes and theory.


def test_the_stiffest_mode_of_the_tethered_cube_is_the_known_one():
    """1/m + |r x e|^2/I = 1 + 4.5 for a pull across the diagonal of a unit cube: w = sqrt(5.5 k) (m = 1, I = 1/6)."""
    mode = stiffest_mode(TETHER)
    # The stretch of 12 mm adds its tension to the stiffness: 0.012 m |r| 6 / 5.5 = 1 %, half of that in w.
    assert mode.rate == pytest.approx(math.sqrt(5.5e6), rel=6e-3)
    assert mode.damping == 0.0
    critical = stiffest_mode(read_scene("tether-critical"))
    assert critical.damping / (2 * math.sqrt(critical.stiffness)) == pytest.approx(1.0, rel=6e-3)


def test_the_mode_of_a_free_body_is_its_spin():
    assert stiffest_mode(SPIN).rate == pytest.approx(np.linalg.norm(SPIN.start[0, 10:13]))
    assert stiffest_mode(read_scene("die-vertex")).rate > 0, "an impulse at t = 0 spins it"


def test_the_mode_of_a_hanging_body_and_of_drag():
    assert stiffest_mode(read_scene("rod-stiff")).rate == pytest.approx(math.sqrt(1e6 / 2.4), rel=1e-4)
    drag = read_scene("drag-stiff")
    assert stiffest_mode(drag).rate == pytest.approx(drag.drag.angular / drag.body.moments.min(), rel=5e-3)


@pytest.mark.parametrize("zeta", [0.0, 0.3, 1.0, 5.0])
def test_limits_of_schemes_are_the_closed_ones(zeta):
    """Jury's conditions for u'' + 2 z w u' + w^2 u = 0, worked out by hand for each scheme."""
    w = 7.0
    mode = Mode(w, 2 * zeta * w, w * w)
    assert limit_of(semi_implicit_euler, mode) == pytest.approx(2 * (math.sqrt(zeta**2 + 1) - zeta), rel=1e-5)
    assert limit_of(damping_implicit_euler, mode) == pytest.approx(2 * (math.sqrt(zeta**2 + 1) + zeta), rel=1e-5)
    held = min(4 * zeta, 1 / zeta) if zeta else 0.0
    assert limit_of(held_parabola, mode) == pytest.approx(held, rel=1e-5)
    if zeta == 0.0:
        assert limit_of(runge_kutta_4, mode) == pytest.approx(2 * math.sqrt(2), rel=1e-5)
    if zeta == 1.0:
        assert limit_of(runge_kutta_4, mode) == pytest.approx(2.7852935634, rel=1e-4)  # a double root: slower to see


def test_theory_knows_bullet_and_says_nothing_of_strangers():
    mode = stiffest_mode(SPIN)
    with launched(["pybullet", "tumble", SPRINGS]) as (bullet, ours, springs):
        assert theory(bullet, "rigidbody", SPIN, mode).w_dt == math.pi / 4
        assert theory(bullet, "rigidbody+defaults", SPIN, mode).w_dt == math.pi / 4
        assert theory(bullet, "multibody", SPIN, mode).w_dt == 0.0
        cube = replace(SPIN, body=replace(SPIN.body, moments=np.ones(3)))
        assert theory(bullet, "multibody", cube, mode).w_dt == math.pi / 4
        assert theory(ours, "splitting", SPIN, mode).w_dt == math.inf
        assert theory(ours, "rk4", SPIN, mode) is None
        assert theory(springs, "symplectic", SPIN, mode) is None
        assert theory(springs, "symplectic", TETHER, stiffest_mode(TETHER)) is None


@pytest.mark.parametrize("limit", [1.0, 1.003, 1.5, 1.995])
@pytest.mark.parametrize("near", [None, 0.0, 1.0, 1.003, 1.4, 1.5, 1.993, 3.0, math.inf])
def test_a_limit_is_found_wherever_it_was_expected(limit, near):
    """Within 1 %, as by bisection alone; where it was expected, two runs are enough."""
    tried = []
    found = edge(1.0, 2.0, lambda dt: tried.append(dt) or dt <= limit, 0.01, near)
    assert limit / 1.01 <= found <= limit
    assert len(set(tried)) == len(tried)
    if near == limit == 1.5:
        assert len(tried) == 2
    # By bisection 7, as ln 2 / ln 1.01 = 70 < 2^7; else 2 where it was expected, 3 farther away, and the rest.
    assert len(tried) <= (7 if near is None or not 1 < near < 2 else 2 + 3 + 6)


# Which number, and which flights.


@pytest.mark.parametrize(
    ("name", "parameter"),
    [
        ("tether-undamped", "tether stiffness [N/m]"),
        ("tether-overdamped", "tether damping [N s/m]"),
        ("rod-stiff", "tether stiffness [N/m]"),
        ("drag-stiff", "angular drag [N m s/rad]"),
        ("floor-stiff", "floor stiffness [N/m]"),
        ("spin-fast", "spin [rad/s]"),
    ],
)
def test_the_natural_parameter_is_what_makes_a_scene_stiff(name, parameter):
    scene = read_scene(name)
    assert name in STIFF
    found = natural_parameter(scene)
    assert found.name == parameter
    assert found.value(found.scaled(scene, 3.0)) == pytest.approx(3.0 * found.value(scene))


def test_a_body_at_rest_has_nothing_to_be_stable_in():
    with pytest.raises(BadScene, match="nothing limits the step"):
        columns(read_scene("die-straight"))


def test_every_column_turns_as_far_and_steps_divide_its_rows():
    for column in columns(TETHER):
        assert column.seconds * column.mode.rate == pytest.approx(RADIANS)
        for steps in STEPS:
            flown = column.scene_of(steps)
            assert len(flown.times) == min(steps, ROWS)
            assert flown.times[-1] == flown.duration
            assert set(flown.times) <= set(column.scene_of(ROWS).times)
        probe = column.probe(1e-3 / 3, PROBED)
        np.testing.assert_allclose(probe.times / (1e-3 / 3), np.round(probe.times / (1e-3 / 3)), rtol=0, atol=1e-9)


def test_the_truth_of_few_rows_is_that_of_the_same_instants():
    (column,) = columns(SPIN, [1.0])
    whole = truth(column.scene_of(ROWS))
    few = truth_of(column.scene_of(4), whole)
    np.testing.assert_array_equal(few.times, column.scene_of(4).rows)
    np.testing.assert_array_equal(few.states[2], whole.states[ROWS // 2])


# Limits, measured.


def test_bisection_finds_the_limit_of_a_hand_written_engine():
    piece = ask(TETHER, f"{SPRINGS}:symplectic")["springs:symplectic"]
    assert piece.limit.w_dt_limit == pytest.approx(2.0, rel=0.03)
    assert piece.limit.beyond in ("diverged", "drifting")
    assert piece.limit.dt_stable_s == pytest.approx(2.0 / math.sqrt(5.5e6), rel=0.03)
    assert [row.verdict for row in piece.rows[:3]] == ["diverged"] * 3, "the longest steps come first"
    assert piece.rows[-1].verdict == "stable"
    assert piece.limit.theory_w_dt is None


# In w = sqrt(5.5 k), each found before by a bisection of its own: 2500 steps, energy below 1000 times the start's.
KNOWN = {
    "tether-undamped": {
        "mujoco:euler": 2.0,
        "mujoco:rk4": 2.83,
        "mujoco:rk4+held": 0.0,
        "mujoco:implicitfast": 2.0,
        "mujoco:discrete": math.inf,
        "pybullet:multibody+defaults": 2.0,
        "tumble:rk4": 2.83,
        "tumble:symplectic-euler": 2.0,
    },
    "tether-critical": {
        "mujoco:euler": 0.84,
        "mujoco:rk4+held": 1.0,
        "mujoco:implicitfast": 4.8,
        "mujoco:discrete": math.inf,
        "pybullet:rigidbody+held": 0.84,
    },
}


@pytest.mark.parametrize("name", list(KNOWN))
def test_the_known_limits_come_out(name):
    for contestant, piece in ask(read_scene(name), *KNOWN[name]).items():
        w_dt, w = piece.limit.w_dt_limit, piece.limit.w_rad_s / math.sqrt(5.5e6)
        assert w_dt / w == pytest.approx(KNOWN[name][contestant], rel=0.03), contestant
        if piece.limit.theory_w_dt is not None:
            assert w_dt == pytest.approx(piece.limit.theory_w_dt, rel=0.03), contestant
        assert piece.limit.beyond == ("clamped" if "defaults" in contestant else piece.limit.beyond)


def test_a_free_spin_is_held_against_the_truth():
    pieces = ask(SPIN, "tumble:rk4", "tumble:exact", "pybullet:rigidbody", true=True)
    rk4, exact, bullet = pieces.values()
    size = float(np.linalg.norm(SPIN.body.points, axis=1).max())
    assert rk4.limit.dt_1mm_s < rk4.limit.dt_1pct_s or 0.01 * 2 * size < 1e-3
    errors = {row.dt_s: row.max_error_m for row in rk4.rows}
    inside = [dt for dt, error in errors.items() if error <= 1e-3]
    assert max(inside) <= rk4.limit.dt_1mm_s < 2 * max(inside)
    assert exact.limit.note == "chooses its own steps"
    assert all(row.max_error_m <= 10 * row.resolution_m for row in exact.rows)
    turned = {row.verdict for row in bullet.rows if row.dt_s * bullet.limit.w_rad_s > 1.0}
    assert turned == {"under-rotated"}
    assert bullet.limit.w_dt_limit == pytest.approx(math.pi / 4, rel=0.1)


# Continuing an interrupted study.

CONTESTANTS = ("tumble:splitting", "tumble:magnus6", "tumble:exact")


@pytest.fixture
def counted(monkeypatch) -> list[str]:
    """Return the methods whose pieces are measured, as they are; with few steps, which is quicker."""
    measured: list[str] = []

    def counting(running_engine: RunningEngine, method: str, question: Question, _: Effort) -> Trials:
        measured.append(method)
        return Trials(running_engine, method, question, Effort(STEPS[:4], 0.1))

    monkeypatch.setattr(tasks, "Trials", counting)
    return measured


@contextmanager
def interrupt(total: float = 0.0, doing: str = "running"):
    """Display that stops the study, as Ctrl-C does, after its first piece."""

    def after_one(what: str, share: float = 1.0) -> None:
        raise KeyboardInterrupt

    yield after_one


def interrupted(folder: Path, scene: Scene, *contestants: str, **how) -> None:
    shown: list[Mapping] = []
    with pytest.raises(KeyboardInterrupt, match="run the same command again to continue"):
        map_scenes([scene], contestants, folder=folder, display=interrupt, ended=shown.append, **how)
    assert [len(tables["limits.csv"]) for tables in shown] == [1], "what was finished is passed on"
    assert not list(folder.glob("*.csv")), "a map that is not complete is not written"


def files(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()}


def test_an_interrupted_study_continues_to_the_same_tables(tmp_path, counted):
    interrupted(tmp_path / "parts", SPIN, *CONTESTANTS)
    assert counted == ["splitting"]
    map_scenes([SPIN], CONTESTANTS, folder=tmp_path / "parts")
    assert counted == ["splitting", "magnus6", "exact"]
    map_scenes([SPIN], CONTESTANTS, folder=tmp_path / "whole")
    assert files(tmp_path / "parts") == files(tmp_path / "whole")
    (header, *_) = files(tmp_path / "whole")["stability.csv"].splitlines()
    assert header == CELL_COLUMNS


def test_results_of_other_circumstances_are_not_used(tmp_path, counted):
    plugins = shutil.copytree(Path(SPRINGS).parent, tmp_path / "plugins")
    engine = plugins / "springs.py"
    asked = (f"{engine}:symplectic", f"{engine}:clamped")
    heavier = replace(SPIN, body=replace(SPIN.body, mass=3.0))
    interrupted(tmp_path / "out", SPIN, *asked)
    interrupted(tmp_path / "out", heavier, *asked)
    interrupted(tmp_path / "out", SPIN, *asked, time_limit=30.0)
    interrupted(tmp_path / "out", SPIN, *asked, memory_limit=2**33)
    interrupted(tmp_path / "out", SPIN, asked[0])
    with engine.open("a") as file:
        file.write("# another law\n")
    interrupted(tmp_path / "out", SPIN, *asked)
    assert len(counted) == 5, "the first one's result is used for a contestant alone"
    map_scenes([SPIN], asked, folder=tmp_path / "out")
    assert len(counted) == 6, "only the last one's result is used"


def test_a_folder_that_cannot_be_written_is_one_line(tmp_path, tumble):
    (tmp_path / "out").write_text("a file")
    done = tumble("stability", "spin-fast", "-e", "tumble:exact", "-o", "out")
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith("tumble: out")
    assert "Traceback" not in done.stderr


def test_a_user_s_mistake_is_one_line(tumble):
    done = tumble("stability", "die-straight", "-e", "tumble:rk4")
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "nothing limits the step" in done.stderr


def test_columns_are_given_for_every_factor():
    assert [column.factor for column in columns(SPIN)] == list(FACTORS)
    assert isinstance(columns(SPIN)[0], Column)
