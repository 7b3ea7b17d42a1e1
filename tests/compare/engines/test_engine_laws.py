"""The laws of compare.engines, put to every engine file here, to a user's own, and to one that breaks each of them."""

import ast
import importlib.util
import math
from collections.abc import Iterator
from pathlib import Path
from time import monotonic
from types import MappingProxyType, ModuleType

import numpy as np
import pytest

from tumble.compare import engines as contract
from tumble.compare.run.engines import registry
from tumble.compare.run.engines.brick import MOMENTS, THROWS, Broken, prepare, scene
from tumble.compare.run.engines.contract_checks import FUNCTIONS, KnownFailure, check_failure, checks_for
from tumble.compare.run.engines.free_body import moved
from tumble.compare.run.running_engines import launched
from tumble.compare.stability.modes import Mode
from tumble.compare.stability.theory import SCHEMES, theory
from tumble.scenarios.frames import turned_by
from tumble.scenarios.read import read_scene
from tumble.scenarios.truth import truth
from tumble.solver.registry import METHODS

ROOT = Path(__file__).parents[3]
PLUGINS = ROOT / "tests" / "plugins"

# The method of plugins/lawless.py that breaks each law.
BREAKS = {
    "read after write": "changes-what-is-written",
    "steps add up": "depends-on-how-steps-are-asked-for",
    "write forgets": "remembers",
    "throws are apart": "mixes-throws",
    "straight": "slows-down",
    "gravity": "floats",
    "digits": "prints-six-digits",
    "turns": "reads-x-y-z-w",
    "converges": "reverses-the-torque",
    "light": "takes-little-for-nothing",
    "the scene": "alters-the-scene",
    "optional": "needs-its-optional",
    "sensors": "feels-gravity",
}


def engines() -> Iterator[tuple[str, ModuleType | None, str]]:
    """Yield name, module and, where there is none, why.

    Those in environments of their own are asked there, by the tests of each.
    """
    for name in [*registry.usual(), str(PLUGINS / "mine.py")]:
        try:
            yield registry.title(name), registry.load(name), ""
        except registry.Missing as missing:
            if importlib.util.find_spec(name):
                raise  # its package is here, so it is our file that cannot be imported
            yield name, None, str(missing)


# What tests/solver/test_flight.py puts to our free methods, on more bodies, steps and counts of throws.
OF_FLIGHTS = {"read after write", "steps add up", "write forgets", "throws are apart", "straight", "gravity"}


def methods(engine: ModuleType) -> list[str]:
    """Return the engine's methods, and every adaptive one also at a loose tolerance, where its steps are few.

    Our lanes take 64 throws or more: test_flight.py has them.
    """
    plain = [method for method in engine.METHODS if not method.endswith("-lanes")]
    return [*plain, *(f"{method}@1e-3" for method in getattr(engine, "ADAPTIVE", ()))]


def cases() -> Iterator:
    for name, engine, why_not in engines():
        if engine is None:
            yield pytest.param("", "", None, id=name, marks=pytest.mark.skip(reason=why_not))
            continue
        info = registry.engine_info(name, engine)
        for law in checks_for(info):
            elsewhere = METHODS if name == "tumble" and law in OF_FLIGHTS else ()
            free = [method for method in methods(engine) if method not in elsewhere]
            for method in (*free, *(info.contact if elsewhere or law in contract.CONTACT_CHECKS else ())):
                yield pytest.param(law, method, engine, id=f"{law}-{name}:{method}")


@pytest.mark.parametrize(("law", "method", "engine"), list(cases()))
def test_law(law: str, method: str, engine: ModuleType):
    try:
        assert check_failure(engine, law, method) == ""
    except NotImplementedError:  # stated and seen to fail, or a method without a plane
        assert law in contract.CONTACT_CHECKS


@pytest.mark.parametrize("law", contract.CHECKS)
def test_law_is_broken_by_the_lawless(law: str):
    lawless = registry.load(str(PLUGINS / "lawless.py"))
    assert check_failure(lawless, law, BREAKS[law])
    with pytest.raises(Broken):
        FUNCTIONS[law](lawless, BREAKS[law])


# What real engines fail in contact as they ship, and the words of it.
FAILED_IN_CONTACT = {
    "friction": ("pybullet:multibody+defaults", "a ball slows at 0.0877 g where the pair's friction is 0.2"),
    "restitution": ("mujoco:euler+defaults", "a ball rebounds at 0.13 times"),
    "stays above": ("mujoco:euler+defaults", "25 mm below the plane"),
    "holds": ("mujoco:euler", "a box creeps at 1.45 mm/s"),
    "any direction": ("mujoco:euler", "at 22.5 degrees to x friction is -0.319 mu N across the slip"),
    "mirror images": ("pybullet:rigidbody", "a box on an edge differ by"),
}


@pytest.mark.parametrize("check", FAILED_IN_CONTACT)
def test_a_check_of_contact_fails_where_an_engine_has_another_law(check):
    contestant, said = FAILED_IN_CONTACT[check]
    name, _, method = contestant.partition(":")
    with pytest.raises(KnownFailure, match=said):
        check_failure(registry.load(name), check, method)


def test_an_engine_that_gains_energy_in_contact_fails(monkeypatch):
    mujoco = registry.load("mujoco")
    advance = mujoco.advance

    def bounces(world, n, dt):
        for _ in range(n):
            advance(world, 1, dt)
            for one in world.worlds:
                if one.data.ncon:
                    one.data.qvel *= 1.05

    monkeypatch.setattr(mujoco, "advance", bounces)
    assert "% more energy than it began with" in check_failure(mujoco, "adds no energy", "rk4")


def test_what_is_stated_to_fail_and_passes_is_a_failure(monkeypatch):
    mujoco = registry.load("mujoco")
    monkeypatch.setattr(mujoco, "KNOWN_FAILURES", {"mirror images": {"*": "its solver"}})
    assert check_failure(mujoco, "mirror images", "euler") == "it passes, and is stated to fail: its solver"


def lawless_says(law: str, method: str) -> str:
    return check_failure(registry.load(str(PLUGINS / "lawless.py")), law, method)


def test_a_broken_law_of_motion_says_what_is_mistaken():
    assert lawless_says("turns", "reads-x-y-z-w").endswith("its quaternions are x y z w, and must be w x y z")
    assert lawless_says("converges", "reverses-the-torque").endswith(
        "its gyroscopic torque has the wrong sign: I w' = (I w) x w in body axes"
    )
    assert lawless_says("sensors", "feels-gravity").endswith("gravity is subtracted from it: free fall reads nothing")
    assert lawless_says("sensors", "feels-the-centre").endswith("it is the reading of the centre of mass")
    assert lawless_says("sensors", "moves-when-asked") == "sense() alters the motion: by 2e-09 after two steps"
    assert lawless_says("sensors", "slows-down") == ""
    assert lawless_says("digits", "prints-six-digits").startswith(
        "6 digits of a number came back, 17 are needed: x of throw "
    )


# How a mistake of a motion reads the body, and what is said of it.
MISTAKES = {
    "quaternions from world to body": ("q * (1.0, -1.0, -1.0, -1.0), w", "lead from world to body"),
    "angular velocity in body axes": ("q, mine.axes(q) @ w", "is in body axes"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_state_that_is_read_otherwise_is_found_by_how_it_turns(tmp_path, mistake):
    """It writes as it reads, so that nothing else shows it."""
    into, said = MISTAKES[mistake]
    out = into.replace("mine.axes(q)", "mine.axes(q).T")
    (tmp_path / "mine.py").write_text((PLUGINS / "mine.py").read_text())
    (tmp_path / "misread.py").write_text(f"""
import numpy as np
import mine
from mine import METHODS, FEATURES, ABOUT, build, advance
def each(states, read):
    for state in states:
        state[3:7], state[10:13] = read(state[3:7].copy(), state[10:13].copy())
def write(world, states):
    mine.write(world, states)
    each(world.states, lambda q, w: ({into}))
def read(world):
    states = mine.read(world)
    each(states, lambda q, w: ({out}))
    return states
""")
    engine = registry.load(str(tmp_path / "misread.py"))
    assert check_failure(engine, "read after write", "semi-implicit-euler") == ""
    assert said in check_failure(engine, "turns", "semi-implicit-euler")


@pytest.mark.parametrize(("stated", "found"), [(1.0, ""), (1.5, "falls by order 1.0"), (4.0, "falls by order 1.0")])
def test_an_order_that_is_stated_is_held_to(stated, found):
    mine = registry.load(str(PLUGINS / "mine.py"))
    mine.ORDERS = {"semi-implicit-euler": stated}
    said = check_failure(mine, "converges", "semi-implicit-euler")
    assert found in said
    assert bool(said) == bool(found)


def test_what_states_no_gyroscopic_torque_is_not_asked_to_converge():
    mine = registry.load(str(PLUGINS / "mine.py"))
    mine.GYROSCOPIC = {"semi-implicit-euler": "none"}
    with pytest.raises(NotImplementedError, match="leaves the gyroscopic torque out"):
        check_failure(mine, "converges", "semi-implicit-euler")


@pytest.mark.parametrize("form", ["%g", "%.8g", "%.12g", "%.13g"])
@pytest.mark.parametrize("precision", ["double", "single"])
def test_digits_that_are_lost_are_missed(form, precision):
    if precision == "single" and form != "%g":
        return  # eight digits are about what a float has
    mine = registry.load(str(PLUGINS / "mine.py"))
    mine.ABOUT = {**mine.ABOUT, "precision": precision}
    plain = mine.read
    mine.read = lambda world: np.array([[float(form % number) for number in state] for state in plain(world)])
    digits = form.strip("%.g") or "6"
    assert check_failure(mine, "digits", "semi-implicit-euler").startswith(f"{digits} digits of a number came back, ")


def test_the_motion_that_engines_are_compared_with_is_the_truths():
    free = scene()
    true = truth(free)
    for row, time in enumerate(true.times):
        q, w = moved(THROWS[:, 3:7], THROWS[:, 10:13], MOMENTS, float(time))
        assert np.abs(turned_by(q, true.states[row][:, 3:7])).max() < 1e-13
        assert np.abs(w - true.states[row][:, 10:13]).max() < 1e-12


@pytest.mark.parametrize(("name", "engine"), [(name, engine) for name, engine, _ in engines() if engine])
def test_engine_says_what_it_is(name: str, engine: ModuleType):
    info = registry.engine_info(name, engine)
    named = (*info.methods, *info.forced, *info.on_request)
    assert len(set(named)) == len(named)
    assert not any(set(method) & set(" :,") for method in named), "ENGINE:METHOD must be one word"
    assert info.features <= {"gravity", "tether", "drag", "floor", "plane"}
    assert set(engine.ABOUT) <= {"version", "precision", "switched_off", "defaults"}
    assert info.version
    assert info.precision in ("single", "double")
    assert {*info.schemes, *info.gyroscopic} <= set(named), "it states a scheme of a method it has not"
    assert info.shown
    assert set(info.shown) <= set(named), "it shows a method it has not"
    assert set(info.landing) <= {*named, *info.contact}, "it shows a method above a plane that it has not"


def test_a_folder_beside_the_engines_is_none():
    assert "parts" not in registry.names()
    assert (ROOT / "compare" / "engines" / "parts").is_dir()


def test_what_brings_an_engine_is_read_without_running_it(monkeypatch, tmp_path):
    (tmp_path / "none.py").write_text("PACKAGES = ('none-such',)\nPINS = ('none-such==1',)\nimport none_such\n")
    monkeypatch.setattr(contract, "__path__", [str(tmp_path)])
    registry.package.cache_clear()
    assert registry.names() == ["none"]
    assert registry.package("none") == registry.Package(("none-such",), ("none-such==1",))
    registry.package.cache_clear()


# Where `grade` knows engines by what they do and by what they write.
OF_THEIR_FILES = {("hypotheses", "engine_schemes.py"), ("read", "programs.py"), ("read", "conventions.py")}
# The colours of those that most pages have side by side, another takes one that is free; the formats of `--like`.
OF_THEIR_FILES |= {("reports", "hues.py"), ("tumble", "parser.py")}


def test_nobody_outside_names_an_engine():
    """Whoever adds or removes an engine touches its file alone.

    The hand calculation is Table 4.1's, and has a section of the page; the lab opens with four contestants; the laws
    and the file formats that `grade` knows are of engines that need not be here.
    """
    names = {*registry.names()} - {contract.OWN}
    found = []
    for path in (*ROOT.glob("compare/**/*.py"), *ROOT.glob("reports/**/*.py"), *ROOT.glob("tumble/**/*.py")):
        if ROOT / "compare/engines" not in path.parents:
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Constant) and isinstance(node.value, str):
                    engine = node.value.partition(":")[0]
                    if (
                        engine in names
                        and (path.parent.name, engine) != ("reports", "handcalc")
                        and path.name != "lab.py"
                        and (path.parent.name, path.name) not in OF_THEIR_FILES
                    ):
                        found.append(f"{path.relative_to(ROOT)}:{node.lineno}: {node.value}")
    assert not found


def test_every_scheme_that_may_be_named_is_known_to_theory():
    assert {*SCHEMES, "drag-implicit-euler", "a-stable"} == set(contract.SCHEME_NAMES)


OWN_SCHEME = """
import mine
from mine import *
import numpy as np
FEATURES = {"gravity", "tether"}
def leapfrog(s, c, h):  # semi-implicit Euler, written anew
    return np.array([[1 - h * h * s, h - h * h * c], [-h * s, 1 - h * c]])
SCHEMES = {"semi-implicit-euler": leapfrog}
GYROSCOPIC = {"semi-implicit-euler": "explicit"}
"""


def test_a_scheme_may_be_a_function(tmp_path, monkeypatch):
    (tmp_path / "mine.py").write_text((PLUGINS / "mine.py").read_text())
    (tmp_path / "own.py").write_text(OWN_SCHEME)
    with launched([str(tmp_path / "own.py")]) as (running_engine,):
        found = theory(running_engine, "semi-implicit-euler", read_scene("tether-undamped"), Mode(7.0, 0.0, 49.0))
        assert found.w_dt == pytest.approx(2.0, rel=1e-5)
        assert "its own scheme" in found.source
        free = theory(running_engine, "semi-implicit-euler", read_scene("spin-fast"), Mode(7.0))
        assert free.w_dt == 0.0
        (tmp_path / "own.py").unlink()


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (
            "SCHEMES = {'semi-implicit-euler': 'leapfrog'}",
            "SCHEMES: semi-implicit-euler: no 'leapfrog': there are",
        ),
        ("SCHEMES = 3", "SCHEMES must be a dict by method, is 3"),
        ("GYROSCOPIC = {'semi-implicit-euler': 'half'}", "GYROSCOPIC: semi-implicit-euler: no 'half': there are "),
        ("ADAPTIVE = 3", "what it says of itself cannot be read: 3 is not a list of names"),
        ("ADAPTIVE = {'semi-implicit-euler': 'fine'}", "ADAPTIVE must be tolerances by method, is"),
        ("EXEMPT = {'gravitation': 'no'}", "EXEMPT: no check 'gravitation': there are read after write"),
        ("FEATURES = {'gravty', 'tether'}", "./mine.py: unknown feature 'gravty': did you mean 'gravity'?"),
        ("ORDERS = {'semi-implicit-euler': -1}", "ORDERS: semi-implicit-euler: must be a number above 0, is -1"),
        ("ORDERS = {'semi-implicit-euler': 'one'}", "what it says of itself cannot be read: "),
    ],
)
def test_what_an_engine_states_wrongly_is_refused(tumble, tmp_path, line, said):
    (tmp_path / "mine.py").write_text(f"{(PLUGINS / 'mine.py').read_text()}\n{line}\n")
    done = tumble("engines", "-e", "./mine.py")
    assert done.returncode == 2
    assert said in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_the_command_says_which_laws_hold(tumble):
    done = tumble("engines", "--check", str(PLUGINS / "mine.py"))
    assert done.returncode == 0, done.stderr
    head, *lines = done.stdout.splitlines()
    assert head == "mine: semi-implicit-euler"
    assert [line.split("  ")[1].strip() for line in lines] == ["passed"] * (len(contract.CHECKS) - 2) + ["skipped"] * 2
    assert "steps add up      advance(a) then advance(b) = advance(a + b), bit by bit" in done.stdout


def test_the_command_says_which_are_broken_and_fails(tumble):
    done = tumble("engines", "--check", f"{PLUGINS / 'lawless.py'}:remembers", str(PLUGINS / "mine.py"))
    assert done.returncode == 1
    (broken,) = [line for line in done.stdout.splitlines() if "FAILED" in line]
    assert "write forgets" in broken
    assert "remembers: after another flight: x of throw 1 is " in broken


def test_a_law_that_kills_the_engine_is_a_line(tumble, tmp_path):
    text = (PLUGINS / "mine.py").read_text().replace("def read(world):", "def read(world):\n    import os; os._exit(7)")
    (tmp_path / "mine.py").write_text(text)
    done = tumble("engines", "--check", "./mine.py")
    assert done.returncode == 1
    assert "FAILED   read after write  semi-implicit-euler: crashed: its process ended with code 7" in done.stdout
    assert len(done.stdout.splitlines()) == 1 + len(contract.CHECKS)


def test_after_a_timeout_no_more_is_asked(tumble, tmp_path):
    text = (PLUGINS / "mine.py").read_text()
    hangs = "def advance(world, n, dt):\n    import time; time.sleep(100)"
    (tmp_path / "mine.py").write_text(text.replace("def advance(world, n, dt):", hangs))
    begun = monotonic()
    done = tumble("engines", "--check", "./mine.py", "--time-limit", "2")
    # Of a dozen laws ten would wait; a second timeout would take as long again as the rest does.
    assert monotonic() - begun < 60
    assert done.returncode == 1
    assert done.stdout.count("timeout: no answer within 2 s") == 1
    assert done.stdout.count("after a timeout no more is asked") == len(contract.CHECKS) - 5
    assert len(done.stdout.splitlines()) == 1 + len(contract.CHECKS)


class FixedWhenBuilt:
    """An engine that fixes its step when built: exact free fall, in steps of the one it was prepared for."""

    METHODS = ("fixed",)
    ABOUT = MappingProxyType({"version": "1", "precision": "double"})

    class World:
        dt = math.nan

    def build(self, scene, method):
        return self.World()

    def write(self, world, states):
        world.states = states.copy()

    def prepare(self, world, dt):
        world.dt = dt

    def advance(self, world, n, dt):
        assert world.dt == dt, "not prepared for this step"
        for _ in range(n):
            world.states[:, 0:3] += world.dt * world.states[:, 7:10]

    def read(self, world):
        return world.states.copy()


def test_an_engine_that_fixes_its_step_is_told_of_it_before():
    engine = FixedWhenBuilt()
    assert check_failure(engine, "steps add up", "fixed") == ""
    assert check_failure(engine, "straight", "fixed") == ""
    world = engine.build(None, "fixed")
    engine.write(world, np.zeros((1, 13)))
    with pytest.raises(AssertionError):
        engine.advance(world, 1, 0.5)
    prepare(engine, world, 0.5)
    engine.advance(world, 1, 0.5)
