"""One impact: closed forms, invariants and limits of the map, each by formulas of its own."""

import numpy as np
import pytest
from mpmath import MPContext

from tumble.scenarios.read import read_scene, scene_of
from tumble.scenarios.truth.contact.impact import FRICTIONLESS, REVERSES, SLIPS, STICKS, impact, response, velocity_at
from tumble.scenarios.truth.contact.setting import read_setting

DIE = """
title = "a"
duration = 1.0
samples = 1
step = 0.1
[body]
shape = "box"
size = [{size}]
mass = 2.0
position = [0.0, 5.0, 0.0]
orientation = [{q}]
velocity = [{v}]
angular_velocity = [{w}]
[plane]
restitution = {e}
friction = {mu}
"""
BRICK = {"size": "0.4, 0.15, 0.1", "q": "0.8, 0.3, -0.4, 0.35", "v": "0.9, -2.0, -0.4", "w": "3.0, 5.0, -4.0"}


def struck(tmp_path, e, mu, **numbers):
    """The setting, the pose before, the lever of the lowest corner and the impact there."""
    path = tmp_path / "a.toml"
    text = DIE.format(e=e, mu=mu, **{**BRICK, **numbers})
    mp = MPContext()
    mp.prec = 140
    setting = read_setting(mp, scene_of(text, path, "a"), 0)
    pose = setting.start
    levers = setting.levers(pose)
    lever = levers[min(range(8), key=lambda corner: levers[corner][1])]
    return setting, pose, lever, impact(setting, pose, lever)


def doubles(*arrays):
    return [np.asarray(array, dtype=float) for array in arrays]


def energy(setting, pose):
    w_body = pose.axes.T @ pose.w_world
    return float(setting.mass * (pose.v @ pose.v) + w_body @ setting.tensor @ w_body) / 2


def brute_force(K, u, mu, target, step):
    """Euler's steps in the impulse along y, of the velocity that K times the impulse adds: first order, no thought."""
    u, J = u.copy(), np.zeros(3)
    while u[1] < target:
        slip = np.array((u[0], 0.0, u[2]))
        speed = np.linalg.norm(slip)
        push = np.array((0.0, 1.0, 0.0))
        hold = -np.linalg.solve(K[np.ix_((0, 2), (0, 2))], K[np.ix_((0, 2), (1,))])[:, 0]
        if speed <= 3 * step * np.abs(K).max() and np.hypot(*hold) <= mu:
            push[[0, 2]] = hold
        elif speed:
            push -= mu * slip / speed
        J += step * push
        u += step * K @ push
    return J


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_without_friction_the_impulse_is_the_closed_form(tmp_path, e):
    setting, pose, lever, done = struck(tmp_path, e, 0.0)
    m, I_inv = float(setting.mass), np.array(setting.inverse_world(pose), dtype=float)
    r, n, u = *doubles(lever, setting.normal), doubles(velocity_at(pose, lever))[0]
    rn = np.cross(r, n)
    J = -(1 + e) * (u @ n) / (1 / m + rn @ I_inv @ rn)
    np.testing.assert_allclose(doubles(done.impulse)[0], J * n, rtol=0, atol=1e-14 * J)
    assert done.modes == (FRICTIONLESS,)
    assert float(done.after @ setting.normal) == pytest.approx(-e * u @ n, rel=1e-14, abs=1e-25)


def test_elastic_and_frictionless_keeps_the_energy(tmp_path):
    setting, pose, _, done = struck(tmp_path, 1.0, 0.0)
    assert energy(setting, done.pose) == pytest.approx(energy(setting, pose), rel=1e-14)
    assert abs(float(done.energy_lost)) < 1e-30


@pytest.mark.parametrize("mu", [0.0, 0.05, 0.3, 0.8, 5.0])
def test_momentum_moment_and_energy_add_up(tmp_path, mu):
    setting, pose, lever, done = struck(tmp_path, 0.4, mu)
    v, w = done.pose.v - pose.v, done.pose.w_world - pose.w_world
    np.testing.assert_allclose(doubles(v * setting.mass)[0], doubles(done.impulse)[0], rtol=1e-14, atol=1e-20)
    spun = doubles(pose.axes @ setting.tensor @ pose.axes.T @ w)[0]
    np.testing.assert_allclose(spun, np.cross(*doubles(lever, done.impulse)), rtol=0, atol=1e-15)  # pyright: ignore[reportCallIssue]
    assert float(done.energy_lost) == pytest.approx(energy(setting, pose) - energy(setting, done.pose), rel=1e-12)
    np.testing.assert_allclose(doubles(velocity_at(done.pose, lever))[0], doubles(done.after)[0], rtol=0, atol=1e-15)
    along = done.impulse - setting.normal * (done.impulse @ setting.normal)
    assert float(setting.mp.sqrt(along @ along)) <= mu * float(done.impulse @ setting.normal) * (1 + 1e-14) + 1e-25


@pytest.mark.parametrize(("mu", "modes"), [(0.05, (SLIPS,)), (0.3, None), (0.8, None), (5.0, (SLIPS, STICKS))])
def test_the_impulse_is_what_small_steps_in_it_come_to(tmp_path, mu, modes):
    setting, pose, lever, done = struck(tmp_path, 0.4, mu)
    K, u = doubles(response(setting, pose, lever), velocity_at(pose, lever))
    apart = []
    for step in (4e-5, 2e-5):
        J = brute_force(K, u, mu, -0.4 * u[1], step)
        apart.append(np.linalg.norm(J - doubles(done.impulse)[0]))
    # Euler's steps: the error is of the size of the step.
    assert apart[0] < 2e-4 * (1 + mu)
    assert apart[1] < 1e-4 * (1 + mu)
    assert modes is None or done.modes == modes


def test_with_much_friction_it_is_the_sticking_impulse_where_there_was_no_slip(tmp_path):
    """J = K^-1 (0, -e u_n, 0) - K^-1 u, of a corner that meets the plane without slip."""
    setting, pose, lever, _ = struck(tmp_path, 0.5, 50.0)
    v = pose.v - setting.along(velocity_at(pose, lever))
    done = impact(setting, pose._replace(v=v), lever)
    K, u = doubles(response(setting, pose, lever), velocity_at(pose._replace(v=v), lever))
    np.testing.assert_allclose(doubles(done.impulse)[0], np.linalg.solve(K, -1.5 * u), rtol=1e-12)
    assert done.modes == (STICKS,)


def routh(K, u, mu, e):
    """Routh's closed form in the plane: velocity of the point, x and y, after the impact; K, (2, 2); slip or stick."""
    x, y = u
    target, sign = -e * y, np.sign(x)
    a, b, c = K[0, 0], K[0, 1], K[1, 1]
    rate = b - mu * sign * a
    P = np.inf if sign * rate >= 0 else -x / rate
    climb = c - mu * sign * b
    if y + P * climb >= target:
        P = (target - y) / climb
        return np.array((x + P * rate, target)), "slips"
    y += P * climb
    if abs(b / a) <= mu:
        return np.array((0.0, target)), "sticks"
    sign = np.sign(b)
    P = (target - y) / (c - mu * sign * b)
    return np.array((P * (b - mu * sign * a), target)), "slips back"


@pytest.mark.parametrize("mu", [0.1, 0.25, 0.4, 0.7, 2.0])
@pytest.mark.parametrize(("angle", "vx"), [(0.5, 0.3), (0.5, -0.3), (1.2, 0.6), (1.9, -0.2), (0.5, 3.0)])
def test_in_the_plane_it_is_rouths_closed_form(tmp_path, mu, angle, vx):
    """A cube, corner and velocities in the plane z = 0, with its edges askew: the modes of arts. 191 to 197."""
    # The corner (1, 1, 1) laid into the plane by a turn of 45 degrees about x, then turned about z.
    about_x, about_z = (np.cos(np.pi / 8), np.sin(np.pi / 8)), (np.cos(angle), np.sin(angle))
    q = (about_z[0] * about_x[0], about_z[0] * about_x[1], about_z[1] * about_x[1], about_z[1] * about_x[0])
    setting, pose, lever, done = struck(
        tmp_path,
        0.4,
        mu,
        size="0.2, 0.2, 0.2",
        q=", ".join(str(float(c)) for c in q),
        v=f"{vx}, -1.0, 0.0",
        w="0.0, 0.0, 2.0",
    )
    K, u = doubles(response(setting, pose, lever), velocity_at(pose, lever))
    assert abs(u[2]) < 1e-15
    expected, mode = routh(K[:2, :2], u[:2], mu, 0.4)
    np.testing.assert_allclose(doubles(done.after)[0][:2], expected, rtol=0, atol=1e-13)
    assert abs(doubles(done.after)[0][2]) < 1e-13
    assert done.modes[-1] == mode


def test_every_mode_of_an_impact_in_the_plane_is_met():
    """The negative control of the test above: its cases are not all one."""
    K = np.array(((3.0, 1.2), (1.2, 1.0)))
    found = {
        routh(K, np.array(u), mu, 0.4)[1] for mu in (0.1, 0.3, 2.0) for u in ((0.3, -1.0), (-0.1, -1.0), (3.0, -1.0))
    }
    assert found == {"slips", "sticks", "slips back"}


def test_a_slip_that_friction_cannot_hold_comes_back(tmp_path):
    """A slender rod at 60 degrees with little friction reverses its slip, also where Newton's law adds energy."""
    modes = set()
    for mu in (0.02, 0.1):
        for vx in (-0.1, 0.1):
            q = f"{float(np.cos(0.5))}, 0.03, 0.02, {float(np.sin(0.5))}"
            _, _, _, done = struck(tmp_path, 0.5, mu, size="1.0, 0.02, 0.02", q=q, v=f"{vx}, -1.0, 0", w="0, 0, 0")
            modes.add(done.modes)
    assert any(REVERSES in mode for mode in modes)


def test_the_slip_turns_in_space_and_not_in_the_plane(tmp_path):
    _, _, _, done = struck(tmp_path, 0.4, 0.3)
    before, after = doubles(done.before, done.after)
    turned = abs(before[0] * after[2] - before[2] * after[0]) / np.hypot(before[0], before[2])
    assert turned > 1e-3


def test_the_catalogue_has_an_impact_of_every_kind():
    from tumble.scenarios.truth import truth

    impacts = {}
    for name in ("die-corner-smooth", "die-corner-sticks", "die-corner-planar", "die-corner-space"):
        (record,) = truth(read_scene(name), False).contacts
        impacts[name] = next(event for event in record.events if event.kind == "impact")
    modes = {event.modes for event in impacts.values()}
    assert {(FRICTIONLESS,), (SLIPS, STICKS), (SLIPS, REVERSES), (SLIPS,)} <= modes
    # In plane motion the corner leaves in the plane it came in, in space it does not.
    assert abs(impacts["die-corner-planar"].velocity_after[2]) < 1e-12
    assert abs(impacts["die-corner-space"].velocity_after[2]) > 1e-3
