"""One free throw at many instants: its blows with as many digits as it takes, and between them the compiled loop."""

from dataclasses import replace
from typing import Any

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth.bulk.bodies import bodies, readings
from tumble.scenarios.truth.bulk.flight import BITS, SHARE_OF_FLOOR, Flights, drawn, off_by, simulate
from tumble.scenarios.truth.bulk.kernel import STATE, Inputs
from tumble.scenarios.truth.double_double import pairs
from tumble.scenarios.truth.flight import Stretch, quaternion, stretches
from tumble.scenarios.truth.inertia import inverse, principal
from tumble.scenarios.truth.resolution import SHARES, doubles, rounding
from tumble.scenarios.truth.rotation import exact
from tumble.scenarios.truth.throw import Throw


def one_flight(mp: Any, scene: Scene, row: int) -> Flights | None:
    """Return one throw of a free scene; None where a blow is beyond doubles or the sample is not what its error says.

    mp: mpmath context, whose precision is set here.  Raises RayMissed.
    """
    mp.prec = BITS
    read = readings(replace(scene, times=scene.times[-1:]), row)
    plain = read[0][0]
    legs = stretches(mp, plain, principal(mp, plain.solid.tensor))
    begun = [pairs([exact(number) for number in _start(mp, leg, plain)]) for leg in legs]
    try:
        changed = [[_starts_in_doubles(mp, throw) for throw in throws] for throws in read]
    except (ArithmeticError, ValueError):  # numbers that leave the range of doubles
        return None
    rows, vertices = scene.rows, np.empty((2, len(scene.rows), 1, len(plain.points), 3))
    states, input_error = np.empty((len(rows), 1, STATE)), np.empty((len(rows), 1))
    ends = [float(leg.arc.since) for leg in legs[1:]]
    for number, (begin, end) in enumerate(zip([0.0, *ends], [*ends, np.inf], strict=True)):
        within = slice(*np.searchsorted(rows, (begin, end)).tolist())
        if within.start < within.stop:
            body = bodies(mp, read, _since(rows[within], begin)[:, np.newaxis])
            starts = np.array([[each[number] for each in throws] for throws in changed])
            inputs = Inputs(body, np.array(SHARES), np.empty((0, STATE)), starts)
            # As many throws as instants, of one instant each.
            part = simulate(np.repeat(begun[number][np.newaxis], within.stop - within.start, axis=0), inputs)
            vertices[:, within], states[within] = part[0].swapaxes(1, 2), part[1].swapaxes(0, 1)
            input_error[within] = part[2].T
    input_error[~np.isfinite(vertices.sum(axis=(0, 3, 4)) + states.sum(axis=2))] = np.nan
    sample = np.union1d([0], drawn(input_error.T))
    brief = replace(scene, times=rows[sample])
    if not (off_by(mp, brief, row, vertices[:, sample, 0]) <= SHARE_OF_FLOOR * input_error[sample, 0]).all():
        return None
    return Flights(states, vertices[0], SHARE_OF_FLOOR * input_error + rounding(vertices[0]), input_error)


def _start(mp: Any, leg: Stretch, throw: Throw) -> list[Any]:
    """Return the state that a stretch begins with, (STATE,), as every state of the harness, exact or to mp's digits."""
    axes, L_body = leg.rotation.at(leg.arc.since - leg.turned)
    w_world = axes @ (inverse(throw.solid.tensor) @ L_body)
    return [*leg.arc.x, *quaternion(mp, axes @ throw.state_axes.T), *leg.arc.v, *w_world]


def _starts_in_doubles(mp: Any, throw: Throw) -> Array:
    """Return the states that the stretches begin with in doubles, (stretches, STATE)."""
    context, own = doubles(mp, throw)
    return np.array([_start(context, leg, throw) for leg in stretches(context, throw, own)], dtype=float)


def _since(times: Array, begin: float) -> Array:
    """Return differences of times [s], (R,), and an instant, exactly: pairs, (2, R) (Knuth's sum)."""
    total = times - begin
    part = total - times
    return np.array((total, (times - (total - part)) - (begin + part)))
