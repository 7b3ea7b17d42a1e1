"""Schemes of engines as mistakes: hypotheses that the search knows, with the engine's values."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from tumble.compare.grade.hypotheses.engine_schemes import (
    DAMPING_FORMS,
    DAMPING_PLACES,
    GYROSCOPIC,
    ROTATION,
    Damping,
    SteppedScheme,
)
from tumble.compare.grade.hypotheses.explanation import Mistake, Mistakes
from tumble.compare.grade.hypotheses.hypothesis import NEAR, Context, Hypothesis
from tumble.compare.grade.hypotheses.mistakes.forces import BULLET_KINDS, RATES, damped, damping_rates
from tumble.compare.grade.hypotheses.mistakes.rotation import gyroscopic_term_missing
from tumble.compare.grade.hypotheses.mistakes.steps import velocity_in_body_axes
from tumble.compare.grade.hypotheses.names import (
    CLOCK_RATE,
    GRAVITY_DELAYED,
    IMPULSE_OVER_ONE_STEP,
    LOG_LAG,
    PYBULLET_DAMPING,
    SPIN_CAP,
    SYMPLECTIC_EULER,
)
from tumble.compare.grade.model.kernel.dynamics import AS_FORCE, IN_BODY, IN_WORLD_AXES, MOMENTUM, Scheme
from tumble.compare.grade.model.program_model import SLERP, Clock, ImpulseApplication, ProgramModel

# Powers of e by which a body slows down at the largest rate that is fitted: the first eighth of the run shows it.
MOST_DAMPED = 40.0


class SchemeHypotheses:
    """Converts schemes to mistakes; equal parts of schemes give identical hypotheses."""

    def __init__(self, context: Context) -> None:
        self._context, self._made = context, dict[tuple, Hypothesis]()
        self._equal = float(np.ptp(context.program.moments)) == 0.0

    def mistakes(self, stepped: SteppedScheme, fitted: bool = False) -> Mistakes:
        """Return the differences of a scheme from a correct program; fitted: its damping rates are to be fitted."""
        scheme, found = stepped.scheme, []
        if stepped.impulse_as_force:
            found.append(Mistake(self._of(_impulse_as_force, ()), stepped.step))
        if scheme.idle_steps:
            found.append(Mistake(self._of(_gravity_delayed, (scheme.idle_steps,)), stepped.step))
        if (cap := scheme.cap(stepped.step)) and cap * self._context.turn_s < 1:
            found.append(Mistake(self._of(_spin_cap, ()), cap))
        duration = self._context.duration if fitted else 0.0
        found += [Mistake(self._of(_damping, (*key, duration)), rate) for key, rate in _dampings(scheme.damping)]
        if scheme.gyroscopic == "none" and not self._equal:
            found.append(Mistake(self._of(gyroscopic_term_missing, ())))
        normalise_every = 0 if scheme.unnormalised else 1
        step = self.step(scheme.gyroscopic, scheme.rotation, scheme.position_substeps, normalise_every)
        found.append(Mistake(step, stepped.step))
        if scheme.velocity_axes != IN_WORLD_AXES:
            found.append(Mistake(self._of(velocity_in_body_axes, (scheme.velocity_axes,))))
        spacing = self._context.spacing_s
        if scheme.step and not scheme.interpolated and abs(scheme.step - spacing) > NEAR * spacing:
            found.append(Mistake(self._of(_own_step, ()), scheme.step / spacing))
        ticks = scheme.late + stepped.late
        if scheme.interpolated:
            found.append(Mistake(self._of(_interpolated, (ticks,)), stepped.step))
        elif ticks:
            late = abs(ticks * (stepped.step if scheme.step else spacing))
            found.append(Mistake(self._of(_late, (1 if ticks > 0 else -1,)), late))
        return tuple(found)

    def late(self, ticks: int) -> Mistake:
        """Return rows that are late by so many row intervals; early, if the number is negative."""
        return Mistake(self._of(_late, (1 if ticks > 0 else -1,)), abs(ticks * self._context.spacing_s))

    def step(self, gyroscopic: str, rotation: str, position_substeps: int = 1, normalise_every: int = 1) -> Hypothesis:
        """Return the hypothesis of a step; "" stands for a detail that has no effect."""
        gyroscopic = "" if self._equal or gyroscopic == "none" else gyroscopic
        steps = tuple(self._context.steps.items())
        return self._of(_step, (gyroscopic, rotation, position_substeps, normalise_every, steps))

    def _of(self, make: Callable[..., Hypothesis], key: tuple) -> Hypothesis:
        return self._made.setdefault((make, key), make(*key))


def _step(
    gyroscopic: str, rotation: str, position_substeps: int, normalise_every: int, steps: tuple[tuple[float, str], ...]
) -> Hypothesis:
    spin, term = GYROSCOPIC[gyroscopic or "explicit"]
    attitude, update = ROTATION[rotation or "exponential"]
    more = [term if gyroscopic else "", update if rotation else "", "" if normalise_every else "never normalised"]
    more.append(f"position moved in {position_substeps} substeps" if position_substeps > 1 else "")
    # v changes by a dt / n in each of n substeps, after which x moves.
    position_weight = (position_substeps + 1) / (2 * position_substeps)
    return Hypothesis(
        SYMPLECTIC_EULER,
        "steps",
        ", ".join(("symplectic Euler with a step of {} s", *filter(None, more))),
        lambda program, step: replace(
            program,
            scheme=Scheme(
                step,
                attitude,
                spin,
                True,
                position_weight,
                normalise_every,
                program.scheme.idle_steps,
                stored=MOMENTUM if gyroscopic == "momentum" else IN_BODY,
            ),
        ),
        named_values=dict(steps),
        unit="s",
        details=(
            ("gyroscopic", gyroscopic),
            ("rotation", rotation),
            ("substeps", str(position_substeps) if position_substeps > 1 else ""),
            ("normalised", "" if normalise_every else "never"),
        ),
    )


def _dampings(damping: Damping) -> Iterator[tuple[tuple, float]]:
    """Yield the key and the rate [1/s] of each damping of a scheme."""
    how = damping.place, damping.form
    if damping.quadratic:
        yield ("PyBullet", *how), damping.linear
        return
    if damping.linear:
        yield ("linear", *how), damping.linear
    if damping.angular:
        yield ("angular", *how), damping.angular


def _damping(kind: str, place: int, form: int, duration: float = 0.0) -> Hypothesis:
    """Return damping as in engines; duration: of the run to which its rate is fitted [s], 0 if it is not."""
    where = "" if place == AS_FORCE else f", {DAMPING_FORMS[form]} {DAMPING_PLACES[place]}"
    details = (("damping-form", DAMPING_FORMS[form]), ("damping-place", DAMPING_PLACES[place]))
    kinds = {"linear": (0,), "angular": (2,), "PyBullet": BULLET_KINDS}[kind]

    def change(program: ProgramModel, rate: float) -> ProgramModel:
        return replace(damped(program, dict.fromkeys(kinds, rate), place), damping_form=form)

    if kind == "PyBullet":
        text = "PyBullet's default damping: a = -{} (1 + |v|) v, and the same for w"
        return Hypothesis(PYBULLET_DAMPING, "linear damping", text, change, unit="1/s", details=details)
    what = "velocity" if kind == "linear" else "angular velocity"
    text = f"{kind} damping: {what} decays at {{}} /s{where}"
    found = Hypothesis(f"{kind}-damping", f"{kind} damping", text, change, unit="1/s", details=details)
    return replace(found, values=damping_rates(duration, MOST_DAMPED), named_values=RATES) if duration else found


def _impulse_as_force() -> Hypothesis:
    return Hypothesis(
        IMPULSE_OVER_ONE_STEP,
        "impulse",
        "impulse applied as a force over a first step of {} s",
        lambda program, step: replace(program, application=ImpulseApplication(lasts=step)),
        unit="s",
    )


def _spin_cap() -> Hypothesis:
    return Hypothesis(
        SPIN_CAP,
        "spin cap",
        "angular velocity limited to {} rad/s",
        lambda program, cap: replace(program, caps=(program.caps[0], cap), caps_when_set=True),
        unit="rad/s",
    )


def _gravity_delayed(steps: int) -> Hypothesis:
    return Hypothesis(
        GRAVITY_DELAYED,
        "gravity start",
        "gravity acts from the second step on, after {} s",
        lambda program, _: replace(program, scheme=program.scheme._replace(idle_steps=steps)),
        unit="s",
    )


def _late(sign: int) -> Hypothesis:
    return Hypothesis(
        LOG_LAG,
        "clock offset",
        f"rows logged {{}} s {'late' if sign > 0 else 'early'}",
        lambda program, late: replace(program, clock=program.clock._replace(offset=-sign * late)),
        unit="s",
    )


def _own_step() -> Hypothesis:
    return Hypothesis(
        CLOCK_RATE,
        "clock rate",
        "each row is one step of the engine, which is {} times as long as the row interval",
        lambda program, rate: replace(program, clock=program.clock._replace(rate=rate)),
    )


def _interpolated(ticks: int) -> Hypothesis:
    return Hypothesis(
        LOG_LAG,
        "clock offset",
        "rows logged {} s late, and interpolated between two steps",
        lambda program, tick: replace(program, clock=Clock(tick=tick, lag=float(ticks), interpolation=SLERP)),
        unit="s",
    )
