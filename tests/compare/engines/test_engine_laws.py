"""What every engine must keep, put to every file in compare/engines and to a user's own.

Each law is also put to an engine that breaks it (plugins/lawless.py), so that it is known to be able to fail.
"""

import importlib.util
import pickle
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from triaxial import GRAVITY, THROWS, scene

from compare.run import registry
from scenarios.frames import Array

PLUGINS = Path(__file__).parents[2] / "plugins"
EPS = np.finfo(float).eps


def flown(engine: ModuleType, method: str, states: Array, *steps: tuple[int, float], gravity=None) -> Array:
    """Return the states after the steps (n, dt), in a world of its own."""
    world = engine.build(scene(states, gravity), method)
    engine.write(world, states)
    for n, dt in steps:
        engine.advance(world, n, dt)
    return engine.read(world)


def with_signs_of(reference: Array, states: Array) -> Array:
    """Return the states with q or -q, which are one attitude, whichever is nearer to the reference's."""
    alike = states.copy()
    alike[:, 3:7] *= np.sign(np.sum(states[:, 3:7] * reference[:, 3:7], axis=1, keepdims=True))
    return alike


def reads_what_was_written(engine: ModuleType, method: str) -> None:
    states = with_signs_of(THROWS, flown(engine, method, THROWS))
    # Turning w into body axes and back, or normalising q, costs a few ulp of numbers up to 40.
    np.testing.assert_allclose(states, THROWS, rtol=8 * EPS, atol=16 * EPS)


def steps_add_up(engine: ModuleType, method: str) -> None:
    at_once = flown(engine, method, THROWS, (11, 0.1 / 11), (28, 0.003))
    in_parts = flown(engine, method, THROWS, (3, 0.1 / 11), (8, 0.1 / 11), (1, 0.003), (27, 0.003))
    np.testing.assert_array_equal(in_parts, at_once)


def forgets(engine: ModuleType, method: str) -> None:
    fresh = flown(engine, method, THROWS, (50, 0.01))
    world = engine.build(scene(), method)
    engine.write(world, THROWS[::-1])
    engine.advance(world, 37, 0.07)
    engine.write(world, THROWS)
    engine.advance(world, 50, 0.01)
    np.testing.assert_array_equal(engine.read(world), fresh)


def goes_straight(engine: ModuleType, method: str) -> None:
    start = THROWS.copy()
    start[:, 10:13] = 0.0
    states = flown(engine, method, start, (150, 0.01), (50, 0.02))
    expected = start.copy()
    expected[:, 0:3] += 2.5 * start[:, 7:10]
    # One rounding a step of the largest number in hand.  It leaves room for MuJoCo's angular velocity too, where the
    # rounding of v x m v over the moment of inertia makes 2e-13 rad/s of nothing.
    np.testing.assert_allclose(with_signs_of(start, states), expected, rtol=0, atol=200 * EPS * np.abs(expected).max())


def falls_by_gravity(engine: ModuleType, method: str) -> None:
    states = flown(engine, method, THROWS, (100, 0.01), gravity=GRAVITY)
    gained = states[:, 7:10] - THROWS[:, 7:10]
    np.testing.assert_allclose(gained, np.broadcast_to(GRAVITY, (3, 3)), rtol=0, atol=100 * EPS * 10)
    fallen = states[:, 0:3] - THROWS[:, 0:3] - THROWS[:, 7:10]
    # A method of order one is off by g t dt / 2.
    np.testing.assert_allclose(fallen, np.broadcast_to(GRAVITY, (3, 3)) / 2, rtol=0.0101, atol=1e-12)


def leaves_the_scene_alone(engine: ModuleType, method: str) -> None:
    question = scene()
    before = pickle.dumps(question)
    world = engine.build(question, method)
    engine.write(world, question.start)
    engine.advance(world, 5, 0.01)
    engine.read(world)
    assert pickle.dumps(question) == before


def throws_are_apart(engine: ModuleType, method: str) -> None:
    together = flown(engine, method, THROWS, (100, 0.01))
    for i, start in enumerate(THROWS):
        alone = flown(engine, method, start[np.newaxis], (100, 0.01))
        np.testing.assert_array_equal(together[i], alone[0])


def spares_are_spare(engine: ModuleType, method: str) -> None:
    bare = flown(engine, method, THROWS, (50, 0.01))
    plain, _, tolerance = method.partition("@")
    # A term that is nothing may be added, and round another way; or one's own steps be other ones.
    off = 100 * float(tolerance or 1e-9) if plain in getattr(engine, "ADAPTIVE", ()) else 1e-13
    for keep in [*((name,) for name in engine.OPTIONAL), engine.OPTIONAL]:
        try:
            world = engine.build(scene(), method, keep)
        except NotImplementedError:
            continue
        engine.write(world, THROWS)
        engine.advance(world, 50, 0.01)
        np.testing.assert_allclose(engine.read(world), bare, rtol=0, atol=off, err_msg=f"with {keep}")


Law = Callable[[ModuleType, str], None]

LAWS: dict[Law, str] = {  # and the method of plugins/lawless.py that breaks it
    reads_what_was_written: "changes-what-is-written",
    steps_add_up: "depends-on-how-steps-are-asked-for",
    forgets: "remembers",
    goes_straight: "slows-down",
    falls_by_gravity: "floats",
    leaves_the_scene_alone: "alters-the-scene",
    throws_are_apart: "mixes-throws",
    spares_are_spare: "needs-its-optional",
}


def bound_by(law: Law, name: str, engine: ModuleType) -> bool:
    if law is falls_by_gravity:
        return "gravity" in engine.FEATURES
    if law is spares_are_spare:
        return hasattr(engine, "OPTIONAL")
    # The hand calculation takes v for an acceleration and turns the body about the world's origin: mistakes of the
    # report that it is there to show.
    return not (law is goes_straight and name == "handcalc")


def engines() -> Iterator[tuple[str, ModuleType | None, str]]:
    """Yield name, module and, where there is none, why."""
    for name in [*registry.names(), str(PLUGINS / "mine.py")]:
        try:
            yield registry.title(name), registry.load(name), ""
        except registry.Missing as missing:
            if importlib.util.find_spec(name):
                raise  # its package is here, so it is our file that cannot be imported
            yield name, None, str(missing)


def methods(engine: ModuleType) -> list[str]:
    """Return the engine's methods, and every adaptive one also at a loose tolerance, where its steps are few.

    Our lanes take 64 throws or more; tests/solver/test_flight.py puts the same laws to them.
    """
    plain = [method for method in engine.METHODS if not method.endswith("-lanes")]
    return [*plain, *(f"{method}@1e-3" for method in getattr(engine, "ADAPTIVE", ()))]


def cases() -> Iterator:
    for name, engine, why_not in engines():
        if engine is None:
            yield pytest.param(None, "", None, id=name, marks=pytest.mark.skip(reason=why_not))
            continue
        for law in LAWS:
            if bound_by(law, name, engine):
                for method in methods(engine):
                    yield pytest.param(law, method, engine, id=f"{law.__name__}-{name}:{method}")


@pytest.mark.parametrize(("law", "method", "engine"), list(cases()))
def test_law(law: Law, method: str, engine: ModuleType):
    law(engine, method)


@pytest.mark.parametrize("law", list(LAWS), ids=lambda law: law.__name__)
def test_law_is_broken_by_the_lawless(law: Law):
    lawless = registry.load(str(PLUGINS / "lawless.py"))
    with pytest.raises(AssertionError):
        law(lawless, LAWS[law])


@pytest.mark.parametrize(("name", "engine"), [(name, engine) for name, engine, _ in engines() if engine])
def test_engine_says_what_it_is(name: str, engine: ModuleType):
    info = registry.engine_info(name, engine)
    named = (*info.methods, *info.forced, *info.on_request)
    assert len(set(named)) == len(named)
    assert not any(set(method) & set(" :,") for method in named), "ENGINE:METHOD must be one word"
    assert info.features <= {"gravity", "tether", "drag", "floor"}
    assert set(engine.ABOUT) == {"version", "precision", "switched_off"}
    assert info.version
    assert info.precision in ("single", "double")
