"""The contact methods against the contact truth, on the catalogue and random scenes, and against laws without one."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from mpmath import MPContext
from numba import njit
from random_contact import FAMILIES, drawn

from tumble.compare.engines import tumble
from tumble.compare.judge import mechanics
from tumble.compare.run.flight import simulate
from tumble.scenarios.read import contact_catalogue, read_scene
from tumble.scenarios.scene import frozen_array
from tumble.scenarios.truth import NoTruth, truth
from tumble.scenarios.truth.contact.impact import _with_friction
from tumble.solver.body import Body
from tumble.solver.contact.compliant import softness_of
from tumble.solver.contact.flight import ContactFlight
from tumble.solver.contact.impact import velocity_after
from tumble.solver.contact.methods import CONTACT_METHODS
from tumble.solver.flight import Flight

# Doubles beside 100 bits: what 1e4 operations and a growth of some hundred by the impacts may leave, over the size.
ROUNDING = 1e-12


def off(scene, true, method, dt=None):
    """How far vertices are off at most [m], over body and distance, where the truth is known; and the trajectory."""
    flight = simulate(tumble, scene, method, dt or scene.duration)
    known = np.isfinite(true.vertices).all(axis=(1, 2, 3))
    apart = np.linalg.norm(flight.vertices - true.vertices, axis=-1)[known]
    size = scene.body.reach + np.abs(true.vertices[known]).max()
    return float(apart.max()) / size, flight


@pytest.mark.parametrize("name", [name for name in contact_catalogue() if name != "top"])
def test_events_has_no_error_but_rounding(name):
    scene = read_scene(name)
    true = truth(scene, False)
    error, flight = off(scene, true, "events")
    assert error < ROUNDING
    ends = true.contacts[0].ended_s
    if np.isfinite(ends):
        assert f"{ends:.6g} s" in flight.notes[0]


@pytest.mark.parametrize("family", [family for family in FAMILIES if family != "top"])
def test_events_on_random_scenes(family, tmp_path):
    path, tried = tmp_path / "drawn.toml", 0
    for seed in range(40, 42):
        path.write_text(drawn(family, seed), encoding="utf-8")
        scene = read_scene(str(path))
        try:
            true = truth(scene, False)
        except NoTruth:
            continue
        assert off(scene, true, "events")[0] < ROUNDING, seed
        tried += 1
    assert tried


@pytest.mark.parametrize("moments", [(0.3, 0.7, 0.7), (0.7, 0.3, 0.7), (0.7, 0.7, 0.3)])
def test_a_symmetric_body_turns_as_the_exact_method_has_it(moments):
    start = np.random.default_rng(27).normal(size=(20, 13))
    start[:, 3:7] /= np.linalg.norm(start[:, 3:7], axis=1, keepdims=True)
    states = []
    for flight in (ContactFlight(Body(1.3, moments), "events", None, None), Flight(Body(1.3, moments), "exact")):
        flight.write(start)
        flight.advance(1, 3.0)
        states.append(flight.read())
    apart = np.abs(states[0] - states[1])
    apart[:, 3:7] = np.minimum(apart[:, 3:7], np.abs(states[0] + states[1])[:, 3:7])
    assert apart.max() < 1e-13


def test_a_method_without_contact_says_so():
    with pytest.raises(NotImplementedError, match="rk4 has no plane"):
        tumble.build(read_scene("ball-drop-half"), "rk4")


@pytest.mark.parametrize("name", ["ball-drop-half", "die-corner-sticks"])
def test_moreau_is_of_its_order(name):
    scene = read_scene(name)
    true = truth(scene, False)
    # Where in a step an impact falls is chance: the mean over steps that differ a little is not.
    shares = 1.0 + 0.37 * np.arange(6) / 6
    steps = scene.step * np.array((1.0, 1 / 4, 1 / 16))
    means = [np.mean([off(scene, true, "moreau", dt * share)[0] for share in shares]) for dt in steps]
    assert abs(np.polyfit(np.log(steps), np.log(means), 1)[0] - CONTACT_METHODS["moreau"].order) < 0.2, means


def law_error(name, method, first, last):
    """How far a vector of observables is from the truth, relative, where the step is a 20th of the scene's."""
    scene = read_scene(name)
    values = {one.name: one.value for one in truth(scene, False).contacts[0].observables}
    names = [f"{first}, {axis}" for axis in "xyz"] if first not in values else [first]
    true = np.array([values[one] for one in names])
    impact = truth(scene, False).contacts[0].events[0].time_s
    flight = simulate(tumble, replace(scene, times=frozen_array([impact + last])), method, scene.step / 20)
    found = flight.states[-1, 0, 10:13] if len(true) == 3 else flight.states[-1, 0, 7:10] @ scene.plane.normal
    return float(np.linalg.norm(found - true) / np.linalg.norm(true))


@pytest.mark.parametrize("method", CONTACT_METHODS)
def test_restitution_and_friction_of_an_impact_are_the_laws_where_that_is_claimed(method):
    claims = CONTACT_METHODS[method]
    # Spin, which gravity does not change, just after a corner has struck; a cube's stays what it is in world axes.
    smooth = law_error("die-corner-smooth", method, "spin after impact 1", 1e-5)
    planar = law_error("die-corner-planar", method, "spin after impact 1", 1e-3)
    assert (smooth < 1e-2) is claims.restitution, smooth
    assert (planar < 1e-2) is claims.follows_slip, planar


@pytest.mark.parametrize("method", CONTACT_METHODS)
def test_what_rests_below_the_critical_angle_holds_or_creeps_by_its_own_law(method):
    scene = read_scene("box-incline-holds")
    flight = simulate(tumble, scene, method, scene.step)
    way = flight.states[-1, 0, :3] - flight.states[10, 0, :3]
    speed = np.linalg.norm(way) / (flight.times[-1] - flight.times[10])
    if CONTACT_METHODS[method].holds:
        assert speed < 1e-13
        return
    slope = (3 / 4) / scene.plane.friction  # tan(angle) / mu
    slow = softness_of(tumble.build(scene, method).flight.ground).slow
    assert speed == pytest.approx(slow * slope / np.sqrt(1 - slope**2), rel=1e-3)


def test_compliant_gives_a_ball_the_restitution_that_its_damper_is_chosen_for():
    scene = replace(read_scene("ball-drop-half"), times=frozen_array([0.5]), duration=0.5)
    after = simulate(tumble, scene, "compliant", 1e-3).states[-1, 0, 8]
    rebound = after + 9.81 * (0.5 - np.sqrt(2 / 9.81))
    assert rebound / np.sqrt(2 * 9.81) == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize("method", CONTACT_METHODS)
def test_a_turn_about_the_normal_turns_the_motion(method):
    scene = read_scene("die-corner-space")
    angle = 0.7
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array(((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)))
    half = np.array((np.cos(angle / 2), np.sin(angle / 2)))
    start = scene.start.copy()
    w, x, y, z = scene.start[0, 3:7]
    start[0, 3:7] = half[0] * np.array((w, x, y, z)) + half[1] * np.array((-y, z, w, -x))
    for first in (0, 7, 10):
        start[0, first : first + 3] = turn @ scene.start[0, first : first + 3]
    plain = simulate(tumble, scene, method, scene.step).vertices
    turned = simulate(tumble, replace(scene, start=frozen_array(start)), method, scene.step).vertices
    assert np.abs(turned - plain @ turn.T).max() < 1e-9 * scene.body.reach
    assert np.abs(turned - plain).max() > 0.1 * scene.body.reach


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_events_takes_of_a_flat_landing_an_outcome_of_the_laws_set(friction, tmp_path):
    path = tmp_path / "flat.toml"
    path.write_text(
        'title = "box"\nstep = 0.001\nduration = 2.0\nsamples = 200\ngravity = [0.0, -9.81, 0.0]\n'
        '[body]\nshape = "box"\n'
        "size = [0.2, 0.1, 0.3]\nmass = 1.0\nposition = [0.0, 0.5, 0.0]\nvelocity = [0.7, 0.0, 0.2]\n"
        f"[plane]\nrestitution = 0.5\nfriction = {friction}\n"
    )
    scene = read_scene(str(path))
    several = truth(scene, False).contacts[0].several
    flight = simulate(tumble, scene, "events", 2.0)
    after = flight.states[31, 0]
    gained = 9.81 * (flight.times[31] - np.sqrt(0.9 / 9.81)) * np.array((0.0, 1.0, 0.0))
    assert several.is_in_set(after[7:10] + gained, after[10:13])
    assert not several.is_in_set(1.1 * (after[7:10] + gained), after[10:13])
    assert "hit the plane at once" in flight.remark
    assert flight.states[-1, 0, 1] == pytest.approx(0.05, abs=1e-13)
    assert flight.vertices[..., 1].min() > -1e-13


@pytest.mark.parametrize(("name", "duration", "height"), [("die-thrown", 6.0, None), ("tilted", 3.0, 0.05)])
def test_events_goes_on_by_time_steps_where_a_corner_slides(name, duration, height, tmp_path):
    """The motion is exact up to there; from there on it loses energy until the body rests on a face."""
    path = tmp_path / "tilted.toml"
    path.write_text(
        'title = "box"\nstep = 0.001\nsamples = 9\nduration = 3.0\ngravity = [0.0, -9.81, 0.0]\n[body]\nshape = "box"\n'
        "size = [0.2, 0.1, 0.3]\nmass = 1.0\nposition = [0.0, 0.5, 0.0]\norientation = [0.97, 0.1, 0.05, 0.2]\n"
        "velocity = [0.7, 0.0, 0.2]\n[plane]\nrestitution = 0.0\nfriction = 0.3\n"
    )
    scene = read_scene(str(path) if name == "tilted" else name)
    scene = replace(scene, duration=duration, times=frozen_array(np.linspace(0.05, duration, 120)))
    flight = simulate(tumble, scene, "events", duration)
    begins = float(flight.notes[0].split()[1])
    assert "Moreau's time steps" in flight.notes[0]
    assert 0 < begins < duration - 1
    lowest = flight.vertices[:, 0, :, 1].min(axis=1) - scene.plane.point[1]
    energy = mechanics.kinetic_energy(flight.states[:, 0], scene.body) + scene.body.mass * 9.81 * flight.states[:, 0, 1]
    assert np.isfinite(flight.states).all()
    assert np.diff(energy).max() < 1e-6 * energy[0], "no time step adds energy"
    assert lowest.min() > -1e-3 * scene.body.reach
    end = flight.states[-1, 0]
    assert np.abs(end[7:13]).max() < 1e-12, "it rests"
    heights = np.sort(flight.vertices[-1, 0, :, 1])
    assert np.ptp(heights[:4]) < 1e-4 * scene.body.reach, "it rests on a face"
    assert height is None or end[1] == pytest.approx(height, abs=1e-4)


def test_time_steps_of_events_do_not_depend_on_the_instants_asked_for():
    scene = replace(read_scene("die-thrown"), duration=4.0)
    ends = []
    for count in (1, 8):
        world = tumble.build(scene, "events")
        world.flight.write(scene.start)
        for _ in range(count):
            world.flight.advance(8 // count, 0.5)
        ends.append(world.flight.read())
    assert "Moreau" in world.flight.findings[0]
    np.testing.assert_array_equal(*ends)


@njit
def after(K, u, restitution, friction):
    """The velocity of the point after one impact, as `events` has it."""
    return velocity_after(K, u, restitution, friction)


def random_impact(rng, kind):
    """K, the velocity before, restitution and friction; unit of velocity: the approach."""
    moments = np.sort(10 ** rng.uniform(-1.5, 1.0, 3))
    moments[2] = min(moments[2], 0.9 * (moments[0] + moments[1]))
    if kind == "cube":
        moments[:] = moments[0]
    axes, lever = np.linalg.qr(rng.normal(size=(3, 3)))[0], rng.normal(size=3) * 10 ** rng.uniform(-0.5, 0.3)
    arm = np.cross(np.eye(3), lever)
    xx, xy, xz, _, yy, yz, _, _, zz = (np.eye(3) + arm @ (axes / moments @ axes.T) @ arm.T).ravel()
    speed, angle = 10 ** (rng.uniform(-9, -3) if kind == "hardly slips" else rng.uniform(-3, 1.5)), rng.uniform(0, 7)
    if kind == "keeps its direction":
        # Nearly along d, which for a cube is kept, towards it or against: the second slips back or sticks.
        angle = np.arctan2(yz, xz) + rng.choice((0, np.pi)) + 10 ** rng.uniform(-12, 0)
    u = (speed * np.cos(angle), speed * np.sin(angle), -1.0)
    return (xx, yy, zz, xy, xz, yz), u, rng.uniform(), 10 ** rng.uniform(-2, 1)


def true_impact(K, u, restitution, friction):
    """The same by the truth's series in 110 bits, and the modes."""
    mp = MPContext()
    mp.prec = 110
    xx, yy, zz, xy, xz, yz = map(mp.mpf, K)
    law: Any = SimpleNamespace(mp=mp, friction=mp.mpf(friction), restitution=mp.mpf(restitution))
    matrix = np.array(((zz, xz, yz), (xz, xx, xy), (yz, xy, yy)))
    (n, x, y), modes = _with_friction(law, matrix, np.array([mp.mpf(u[axis]) for axis in (2, 0, 1)]))
    return np.array((x, y, n), dtype=float), modes


def test_random_impacts_are_the_truths_to_rounding():
    """Slips that go on, end, stick, turn round and begin again; in the first, one term of the end's series is small."""
    rng, seen = np.random.default_rng(27), set()
    K = (44.68143611187435, 8.090192811303943, 46.68726853053749, 13.678518007261445, -3.400274636323729)
    impacts: list = [((*K, 10.226602646034422), (-0.219024305080985, -0.3514501773536, -1.0), 0.51, 1.445652489842623)]
    for kind in ("any", "cube", "hardly slips", "keeps its direction"):
        impacts += [random_impact(rng, kind) for _ in range(15)]
    for K, u, restitution, friction in impacts:
        true, modes = true_impact(K, u, restitution, friction)
        seen.add(modes)
        error = np.abs(np.array(after(K, u, restitution, friction)) - true).max()
        assert error < 1e-14 * np.linalg.norm(u), (modes, K, u, restitution, friction)
    assert len(seen) >= 3, seen


def test_friction_that_only_just_stops_a_slip_stops_it():
    """The slip dies away a thousand times as slowly as in other impacts: the corner sticks, and rises at e u_n."""
    cases = [
        ((1.0015, 1.0679, 1.12997, -0.00882, 0.005795, 0.009), (-0.00017534, -0.0030886, -1.39981), 0.9, 0.018417),
        ((1.00514, 1.02541, 1.01052, -0.0014206, -0.00695, -0.0033767), (0.00054, 0.0022549, -1.71843), 0.5, 0.014177),
        ((1.13571, 5.74333, 5.70187, 0.646812, 0.602853, 1.040045), (0.0017277, 0.0018143, -1.290017), 0.5, 0.47915),
    ]

    for K, u, restitution, friction in cases:
        held = np.linalg.solve([[K[0], K[3]], [K[3], K[1]]], K[4:6])
        assert np.linalg.norm(held) < friction, "it can be held"
        assert after(K, u, restitution, friction) == (0.0, 0.0, -restitution * u[2])
