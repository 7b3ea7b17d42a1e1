"""Laws of engines as mistakes: the same hypotheses that a search knows, with the numbers that the engine has."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from tumble.compare.grade.hypotheses.engine_schemes import DECAYS, GYROSCOPIC, PLACES, ROTATION, Damping, Flown
from tumble.compare.grade.hypotheses.explanation import Mistake, Mistakes
from tumble.compare.grade.hypotheses.hypothesis import NEAR, Hypothesis, Question
from tumble.compare.grade.hypotheses.mistakes.forces import RATES, damping_rates
from tumble.compare.grade.model.kernel.dynamics import AS_FORCE, Scheme
from tumble.compare.grade.model.program_model import ALONG_ARCS, Account, Clock, Stroke

# Powers of e that a body loses in a flight at the greatest rate that is fitted: its first eighth shows that.
MOST_DAMPED = 40.0
STEP, LAG = "symplectic Euler", "log lag"


class Laws:
    """Turns laws into mistakes of one question: the same law gives the same hypotheses."""

    def __init__(self, question: Question) -> None:
        self._question, self._known = question, dict[tuple, Hypothesis]()
        self._equal = float(np.ptp(question.account.moments)) == 0.0

    def mistakes(self, flown: Flown, fitted: bool = False) -> Mistakes:
        """Return what is said of a program that does this, instead of what is right.

        fitted: the rates of its damping are no engine's, but to be fitted.
        """
        law, found = flown.law, []
        if flown.forced:
            found.append(Mistake(self._of(_forced, ()), flown.step))
        if law.idle:
            found.append(Mistake(self._of(_idle, (law.idle,)), flown.step))
        if (cap := law.cap(flown.step)) and cap * self._question.turn_s < 1:
            found.append(Mistake(self._of(_spin_cap, ()), cap))
        longest = self._question.duration if fitted else 0.0
        found += [Mistake(self._of(_damping, (*key, longest)), rate) for key, rate in _dampings(law.damping)]
        if law.gyroscopic == "none" and not self._equal:
            found.append(Mistake(self._of(_no_gyroscopic, ())))
        found.append(Mistake(self.step(law.gyroscopic, law.rotation, law.falls, 0 if law.lengthens else 1), flown.step))
        spacing = self._question.spacing_s
        late = flown.step if law.step else spacing
        if law.step and not law.between and abs(law.step - spacing) > NEAR * spacing:
            found.append(Mistake(self._of(_own_step, ()), law.step / spacing))
        ticks = law.late + flown.late
        if law.between:
            found.append(Mistake(self._of(_between, (ticks,)), flown.step))
        elif ticks:
            found.append(Mistake(self._of(_late, (1 if ticks > 0 else -1,)), abs(ticks * late)))
        return tuple(found)

    def step(self, gyroscopic: str, rotation: str, falls: int = 1, normalises: int = 1) -> Hypothesis:
        """Return the hypothesis of a step, where "" stands for what cannot be seen."""
        gyroscopic = "" if self._equal or gyroscopic == "none" else gyroscopic
        return self._of(_step, (gyroscopic, rotation, falls, normalises, tuple(self._question.steps.items())))

    def _of(self, make: Callable[..., Hypothesis], key: tuple) -> Hypothesis:
        return self._known.setdefault((make, key), make(*key))


def _step(
    gyroscopic: str, rotation: str, falls: int, normalises: int, steps: tuple[tuple[float, str], ...]
) -> Hypothesis:
    spin, term = GYROSCOPIC[gyroscopic or "explicit"]
    attitude, turned = ROTATION[rotation or "exponential"]
    more = [term if gyroscopic else "", turned if rotation else "", "" if normalises else "never normalised"]
    more.append(f"in which the centre takes {falls} substeps" if falls > 1 else "")
    # v changes by a dt / falls in each of the substeps, after which x moves.
    fall = (falls + 1) / (2 * falls)
    return Hypothesis(
        STEP,
        "steps",
        ", ".join(("symplectic Euler with a step of {} s", *filter(None, more))),
        lambda account, step: replace(
            account, scheme=Scheme(step, attitude, spin, True, fall, normalises, account.scheme.idle)
        ),
        known=dict(steps),
        unit="s",
        details=(
            ("gyroscopic", gyroscopic),
            ("rotation", rotation),
            ("substeps", str(falls) if falls > 1 else ""),
            ("normalised", "" if normalises else "never"),
        ),
    )


def _no_gyroscopic() -> Hypothesis:
    return Hypothesis(
        "gyroscopic term missing",
        "gyroscopic",
        "gyroscopic term missing: the angular velocity keeps still",
        lambda account, _: replace(account, gyroscopic=0.0),
    )


def _dampings(damping: Damping) -> Iterator[tuple[tuple, float]]:
    """Yield what identifies each damping of a law, and its rate [1/s]."""
    how = damping.damps, damping.decays
    if damping.quadratic:
        yield ("PyBullet", *how), damping.linear
        return
    if damping.linear:
        yield ("linear", *how), damping.linear
    if damping.angular:
        yield ("angular", *how), damping.angular


def _damping(kind: str, damps: int, decays: int, duration: float = 0.0) -> Hypothesis:
    """Return damping as engines have it; duration: of the flight that its rate is to be fitted to [s], 0 for none."""
    where = "" if damps == AS_FORCE else f", {DECAYS[decays]} {PLACES[damps]}"
    details = (("damping law", DECAYS[decays]), ("damps", PLACES[damps]))

    def damped(account: Account, rate: float) -> Account:
        kinds = {"linear": (0,), "angular": (2,), "PyBullet": (0, 1, 2, 3)}[kind]
        rates = tuple(rate if place in kinds else old for place, old in enumerate(account.damping))
        return replace(account, damping=rates, damps=damps, decays=decays)

    if kind == "PyBullet":
        says = "PyBullet's default damping: a = -{} (1 + |v|) v, and the same for w"
        return Hypothesis("damping as PyBullet's default", "linear damping", says, damped, unit="1/s", details=details)
    what = "velocity" if kind == "linear" else "angular velocity"
    name = f"{kind} damping"
    says = f"{name}: {what} decays at {{}} /s{where}"
    found = Hypothesis(name, name, says, damped, unit="1/s", details=details)
    return replace(found, values=damping_rates(duration, MOST_DAMPED), known=RATES) if duration else found


def _forced() -> Hypothesis:
    return Hypothesis(
        "impulse as force over a step",
        "impulse",
        "impulse used as a force over a first step of {} s",
        lambda account, step: replace(account, stroke=Stroke(lasts=step)),
        unit="s",
    )


def _spin_cap() -> Hypothesis:
    return Hypothesis(
        "spin cap",
        "spin cap",
        "angular velocity not let past {} rad/s",
        lambda account, cap: replace(account, caps=(account.caps[0], cap)),
        unit="rad/s",
    )


def _idle(steps: int) -> Hypothesis:
    return Hypothesis(
        "gravity late",
        "gravity start",
        "gravity acts from the second step on, after {} s",
        lambda account, _: replace(account, scheme=account.scheme._replace(idle=steps)),
        unit="s",
    )


def _late(sign: int) -> Hypothesis:
    return Hypothesis(
        LAG,
        "clock offset",
        f"rows written {{}} s {'late' if sign > 0 else 'early'}",
        lambda account, late: replace(account, clock=account.clock._replace(offset=-sign * late)),
        unit="s",
    )


def _own_step() -> Hypothesis:
    return Hypothesis(
        "clock rate",
        "clock rate",
        "each row is one step of the engine's own, {} times as long as from row to row",
        lambda account, rate: replace(account, clock=account.clock._replace(rate=rate)),
    )


def _between(ticks: int) -> Hypothesis:
    return Hypothesis(
        LAG,
        "clock offset",
        "rows written {} s late, and interpolated between two steps",
        lambda account, tick: replace(account, clock=Clock(tick=tick, lag=float(ticks), between=ALONG_ARCS)),
        unit="s",
    )
