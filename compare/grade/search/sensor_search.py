"""Finds the mistakes of a sensor that explain its readings: one device at a time, by a beam search.

A prediction is linear in a bias, a point, a scale and the size of gravity, which least squares give at once; a delay
and a filter are fitted around the first values that help.  Explanations are compared by the information criterion of
`measure.significance`, so that each further assumption must pay for itself against the noise, which is estimated.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import figures
from tumble.compare.grade.hypotheses.sensor_mistakes import SensorHypothesis, sensor_hypotheses
from tumble.compare.grade.measure.readings import MOST_ROWS, MeasuredReadings, Readings
from tumble.compare.grade.measure.significance import ALIKE, EXPLAINED, FITTED_VALUES, choice_cost
from tumble.compare.grade.measure.whiteness import is_white
from tumble.compare.grade.model.kinematics import Kinematics, Motion
from tumble.compare.grade.model.sensor_model import MOVING_AVERAGE, NO_FILTER, ROW_FILTER, SensorModel
from tumble.scenarios.frames import Array

# Mistakes in an explanation at most, explanations that each round continues, and those whose values are refined.
MOST_MISTAKES, BEAM, REFINED = 4, 6, 10
# Iterations of a fit, and the range of a fitted value as a multiple of the first one.
MOST_STEPS, MOST_TIMES = 40, 8.0
# Rows on which candidates are compared, before all rows decide.
QUICK_ROWS, QUICK_RUNS = 400, 4
# A choice among this many names of mistakes costs.
NAMES = 32
# A mistake that leaves a residual which is neither noise nor rounding must reduce it to this share.
HELPS = 0.5
# A mistake is found in noise if it changes the readings by this many standard deviations of their noise, in all rows.
SEEN = 10.0
# Share of a row that is no part of a filter's sum.
NEGLIGIBLE = 1e-18
# If the body turns by more between two rows [rad], errors of any kind look like noise, and only this share of a reading
# can be noise.
SLOW, LITTLE_NOISE = 0.7, 0.02
# Equally good explanations that are reported.
SHOWN = 5


class SensorMistake(NamedTuple):
    """A hypothesis with its value.

    Parameters
    ----------
    hypothesis : the mistake
    value : its value; 0 if it has none
    fitted : the values of a bias, a point or a factor, which least squares gave
    """

    hypothesis: SensorHypothesis
    value: float = 0.0
    fitted: tuple[float, ...] = ()

    @property
    def text(self) -> str:
        """Its text, with the values."""
        hypothesis = self.hypothesis
        if hypothesis.words:
            return hypothesis.text.format(hypothesis.words[int(self.value)])
        named = dict(hypothesis.named).get(self.value)
        text = hypothesis.text.format(*map(figures, self.fitted or (self.value,)))
        return f"{text} ({named})" if named else text

    @property
    def parameters(self) -> tuple[tuple[str, str, str], ...]:
        """Name, value and unit of each parameter."""
        hypothesis = self.hypothesis
        if hypothesis.free_names:
            pairs = zip(hypothesis.free_names, self.fitted, strict=True)
            return tuple((name, f"{value:.9g}", hypothesis.unit) for name, value in pairs)
        if hypothesis.words:
            return ((hypothesis.parameter, hypothesis.words[int(self.value)], ""),)
        return ((hypothesis.parameter, f"{self.value:.9g}", hypothesis.unit),) if hypothesis.parameter else ()


@dataclass(frozen=True, eq=False)
class SensorExplanation:
    """Mistakes that together reproduce a device's readings, and the residual.

    Parameters
    ----------
    mistakes : the mistakes; empty: the readings without a mistake
    rms : root mean square of the residual's length [m/s2 or rad/s]
    worst : largest length of the residual [m/s2 or rad/s]
    within_floor : whether the residual is within the floor
    is_noise : whether the residual is noise
    weight : information criterion; smaller is better
    """

    mistakes: tuple[SensorMistake, ...]
    rms: float
    worst: float
    within_floor: bool
    is_noise: bool
    weight: float

    @property
    def is_whole(self) -> bool:
        """Whether it leaves only rounding or noise."""
        return self.within_floor or self.is_noise

    @property
    def names(self) -> frozenset[str]:
        """The names of its mistakes."""
        return frozenset(mistake.hypothesis.name for mistake in self.mistakes)


@dataclass(frozen=True, eq=False)
class SensorDiagnosis:
    """null: without a mistake; best: the best explanation; alike: others that fit as well; trials: models tried."""

    null: SensorExplanation
    best: SensorExplanation
    alike: tuple[SensorExplanation, ...]
    trials: int


class _Rows:
    """Evaluates models of one device on some rows, with the motion at each delay computed once."""

    def __init__(self, readings: Readings, floor: float, motion: Motion, most_noise: float = np.inf) -> None:
        """Prepare the rows; floor: of a residual; most_noise: largest noise that can be told from a mistake."""
        self.readings, self.floor, self._most_noise = readings, floor, most_noise
        self._motion = _Cached(motion)
        self.numbers = readings.values.size
        starts = np.flatnonzero(np.append(True, np.diff(readings.run) != 0))
        self.runs = [slice(*pair) for pair in zip(starts, [*starts[1:], len(readings)], strict=True)]

    def residual(self, model: SensorModel) -> tuple[Array, tuple[float, ...]]:
        """Return the residual, (N, 3), and the free values that make it least."""
        known, columns = model.columns_at(self._motion, self.readings.times)
        known, columns = self._filtered(model, known, columns)
        left = self.readings.values - known
        unknown = self._unknown(model)
        left[unknown] = 0.0
        scale = np.sqrt(len(left) / max(len(left) - len(unknown), 1))
        if not columns.shape[2]:
            return scale * left, ()
        columns = np.array(columns)
        columns[unknown] = 0.0
        flat = columns.reshape(-1, columns.shape[2])
        values = np.linalg.lstsq(flat, left.ravel(), rcond=1e-9)[0]
        return scale * (left - columns @ values), tuple(values.tolist())

    def _unknown(self, model: SensorModel) -> np.ndarray:
        """Return the rows for which a filter would need rows before their run."""
        before = {NO_FILTER: 0, MOVING_AVERAGE: int(model.cutoff_value) - 1}.get(model.cutoff, 1)
        places = [np.arange(run.start, min(run.start + before, run.stop)) for run in self.runs if before]
        return np.concatenate(places) if places else np.empty(0, dtype=int)

    def _filtered(self, model: SensorModel, known: Array, columns: Array) -> tuple[Array, Array]:
        """Return what a filter makes of the readings; each run starts from its first row in the file."""
        if model.cutoff == NO_FILTER:
            return known, columns
        together = np.concatenate((known[:, :, None], columns), axis=2)
        first = np.zeros(together.shape[2])
        first[0] = 1.0
        out = np.empty_like(together)
        for run in self.runs:
            start = self.readings.values[run.start][:, None] * first
            out[run] = _low_pass(together[run], start, model.cutoff, model.cutoff_value, self.readings.spacing_s)
        return out[:, :, 0], out[:, :, 1:]

    def weight(self, left: Array) -> float:
        """Return the information criterion of a residual without the cost of assumptions."""
        return float(self.numbers * np.log((left**2).mean() + self.floor**2))

    def explanation(self, mistakes: tuple[SensorMistake, ...], model: SensorModel) -> SensorExplanation:
        """Return the explanation by mistakes that make this model."""
        left, values = self.residual(model)
        rms = float(np.sqrt((left**2).mean()))
        return SensorExplanation(
            mistakes=_with_fitted(mistakes, values),
            rms=rms * np.sqrt(3.0),
            worst=float(np.linalg.norm(left, axis=1).max()),
            within_floor=rms <= EXPLAINED * self.floor,
            is_noise=rms <= self._most_noise and is_white(left, self.runs),
            weight=self.weight(left) + sum(cost(mistake, self.numbers) for mistake in mistakes),
        )


class _Cached:
    """A motion that remembers its states at the times of each delay."""

    def __init__(self, motion: Motion) -> None:
        self._motion, self.gravity = motion, motion.gravity
        self._found: dict[tuple[float, int], Kinematics] = {}

    def at(self, times: Array) -> Kinematics:
        """Return the motion at increasing times [s]."""
        key = float(times[0]), len(times)
        if key not in self._found:
            if len(self._found) > 64:
                self._found.clear()
            self._found[key] = self._motion.at(times)
        return self._found[key]


def _low_pass(signal: Array, start: Array, kind: int, value: float, spacing_s: float) -> Array:
    """Return a filtered run of rows, (n, 3, m), that starts from the given row, (3, m)."""
    if kind == MOVING_AVERAGE:
        count = int(value)
        sums = np.cumsum(np.concatenate((np.repeat(signal[:1], count, axis=0), signal)), axis=0)
        return (sums[count:] - sums[:-count]) / count
    if kind == ROW_FILTER:
        now, before, kept = value, 0.0, 1.0 - value
    else:  # exact for a signal that is linear between rows
        kept = float(np.exp(-spacing_s / value))
        mean = value / spacing_s * (1.0 - kept)
        now, before = 1.0 - mean, mean - kept
    forced = now * signal[1:] + before * signal[:-1]
    return _decaying(np.concatenate((start[None], forced)), kept)


def _decaying(terms: Array, kept: float) -> Array:
    """Return y, y_k = kept y_{k-1} + terms_k along the first axis, by sums over twice as many rows in each pass."""
    found, step = terms, 1
    while step < len(found) and kept**step > NEGLIGIBLE:
        found = np.concatenate((found[:step], found[step:] + kept**step * found[:-step]))
        step *= 2
    return found


def cost(mistake: SensorMistake, numbers: int) -> float:
    """Return the cost of a mistake's name, choice and values; numbers: of observations."""
    hypothesis = mistake.hypothesis
    one = float(np.log(numbers)) + choice_cost(FITTED_VALUES)
    has_number = bool(hypothesis.values) and not hypothesis.words and mistake.value not in dict(hypothesis.named)
    choices = max(len(hypothesis.words), 1)
    return choice_cost(NAMES) + choice_cost(choices) + (len(hypothesis.free_names) + has_number) * one


def _with_fitted(mistakes: tuple[SensorMistake, ...], values: Sequence[float]) -> tuple[SensorMistake, ...]:
    """Return mistakes with the free values, which come in the order of `SensorModel.columns`."""
    order = ("sensor-at-wrong-point", "sensor-gravity-wrong-magnitude", "sensor-biased", "sensor-wrong-scale")
    free = sorted((m for m in mistakes if m.hypothesis.free_names), key=lambda m: order.index(m.hypothesis.name))
    rest, found = list(values), {}
    for mistake in free:
        count = len(mistake.hypothesis.free_names)
        found[mistake.hypothesis], rest = tuple(rest[:count]), rest[count:]
    return tuple(mistake._replace(fitted=found.get(mistake.hypothesis, ())) for mistake in mistakes)


class SensorSearch:
    """Searches the mistakes of one device.

    measured: its readings; model: of the right device; motion: that it measures.
    """

    def __init__(self, measured: MeasuredReadings, model: SensorModel, motion: Motion) -> None:
        self._model = model
        spins = motion.at(measured.readings.times).w_body
        turned = measured.readings.spacing_s * float(np.sqrt((spins**2).sum(axis=1).mean()))
        most_noise = np.inf if turned <= SLOW else LITTLE_NOISE * measured.size
        self.rows = _Rows(measured.readings.sampled(MOST_ROWS), measured.floor, motion, most_noise)
        self._quick = _Rows(self.rows.readings.sampled(QUICK_ROWS, QUICK_RUNS), measured.floor, motion)
        self._hypotheses = sensor_hypotheses(model, measured.readings.spacing_s)
        self._order = {hypothesis: number for number, hypothesis in enumerate(self._hypotheses)}
        self.trials = 0

    def model(self, mistakes: Sequence[SensorMistake]) -> SensorModel:
        """Return the model with mistakes."""
        made = self._model
        for mistake in mistakes:
            made = mistake.hypothesis.change(made, mistake.value)
        return made

    def explanation(self, mistakes: tuple[SensorMistake, ...]) -> SensorExplanation:
        """Return the explanation by mistakes, with the values that least squares give."""
        ordered = tuple(sorted(mistakes, key=lambda mistake: self._order[mistake.hypothesis]))
        return self.rows.explanation(ordered, self.model(ordered))

    def _weight(self, rows: _Rows, mistakes: tuple[SensorMistake, ...]) -> float:
        self.trials += 1
        left, _ = rows.residual(self.model(mistakes))
        return rows.weight(left) + sum(cost(mistake, rows.numbers) for mistake in mistakes)

    def diagnosis(self) -> SensorDiagnosis:
        """Return what explains the readings."""
        null = self.explanation(())
        pool, beam = [null], [null]
        for _ in range(MOST_MISTAKES):
            candidates = {_key(each): (weight, each) for one in beam for weight, each in self.more(one.mistakes)}
            ranked = [mistakes for _, mistakes in sorted(candidates.values(), key=lambda pair: pair[0])]
            fresh = [self.refined(mistakes) for mistakes in ranked[:REFINED]]
            if not any(each.is_whole for each in fresh):
                # The first values of a delay and a filter may both be far from the pair that fits.
                smooth = [each for each in ranked[REFINED:] if all(one.hypothesis.fitted for one in each)]
                fresh += [self.refined(mistakes) for mistakes in smooth[:REFINED]]
            fresh.sort(key=lambda each: each.weight)
            least = min(each.weight for each in pool)
            pool += fresh
            if not fresh or fresh[0].weight > least - ALIKE:
                break
            beam = fresh[:BEAM]
            if fresh[0].within_floor:
                break
        return _chosen(null, pool, self.trials)

    def hidden(self, null: SensorExplanation) -> tuple[SensorMistake, ...]:
        """Return the mistakes that change the readings by so little that the noise of the file would hide them."""
        right, found = self.rows.residual(self._model)[0], []
        for hypothesis in self._hypotheses:
            if hypothesis.free_names or hypothesis.words or hypothesis.part == "filter":
                continue
            mistake = SensorMistake(hypothesis, hypothesis.named[0][0] if hypothesis.named else 0.0)
            effect = self.rows.residual(self.model((mistake,)))[0] - right
            ratio = float(np.linalg.norm(effect)) / (null.rms / np.sqrt(3.0))
            if np.sqrt((effect**2).mean()) > self.rows.floor and ratio < SEEN:
                found.append(mistake)
        return tuple(found)

    def more(self, mistakes: tuple[SensorMistake, ...]) -> list[tuple[float, tuple[SensorMistake, ...]]]:
        """Return the mistakes with each further one, at its best first value, with their quick weights."""
        taken = {mistake.hypothesis.part for mistake in mistakes}
        found = []
        for hypothesis in self._hypotheses:
            if hypothesis.part not in taken:
                several = [(*mistakes, SensorMistake(hypothesis, value)) for value in hypothesis.values or (0.0,)]
                weights = [self._weight(self._quick, each) for each in several]
                best = int(np.argmin(weights))
                found.append((weights[best], several[best]))
        return found

    def refined(self, mistakes: tuple[SensorMistake, ...]) -> SensorExplanation:
        """Return the explanation by mistakes with the best of their values, or with values that have a name."""
        places = [k for k, mistake in enumerate(mistakes) if mistake.hypothesis.fitted]
        if not places:
            return self.explanation(mistakes)
        fitted = self._fitted(mistakes, places)
        found = [self.explanation(mistakes), self.explanation(fitted)]
        rounded = tuple(_with_named(mistake) for mistake in fitted)
        free = [k for k in places if not mistakes[k].hypothesis.named]
        if rounded != fitted:
            found.append(self.explanation(self._fitted(rounded, free) if free else rounded))
        return min(found, key=lambda each: each.weight)

    def _fitted(self, mistakes: tuple[SensorMistake, ...], places: Sequence[int]) -> tuple[SensorMistake, ...]:
        """Return mistakes with the values at these places by least squares, from the given ones on."""
        from scipy.optimize import least_squares  # slow to load: only a search pays for it

        start = np.array([mistakes[k].value for k in places])

        def with_values(shares: Array) -> tuple[SensorMistake, ...]:
            changed = dict(zip(places, (shares * start).tolist(), strict=True))
            return tuple(m._replace(value=changed[k]) if k in changed else m for k, m in enumerate(mistakes))

        def left(shares: Array) -> Array:
            self.trials += 1
            return self.rows.residual(self.model(with_values(shares)))[0].ravel()

        is_share = [mistakes[k].hypothesis.parameter == "share" for k in places]
        most = [0.999 / value if share else MOST_TIMES for value, share in zip(start, is_share, strict=True)]
        ones, least = np.ones(len(places)), np.full(len(places), 1 / MOST_TIMES)
        return with_values(least_squares(left, ones, bounds=(least, most), max_nfev=MOST_STEPS, x_scale=0.1).x)


def _with_named(mistake: SensorMistake) -> SensorMistake:
    """Return a mistake with the nearest value that has a name, if there is one."""
    named = [value for value, _ in mistake.hypothesis.named]
    if not named:
        return mistake
    return mistake._replace(value=min(named, key=lambda value: abs(value - mistake.value)))


def _key(mistakes: Sequence[SensorMistake]) -> frozenset[tuple[SensorHypothesis, float]]:
    return frozenset((mistake.hypothesis, mistake.value) for mistake in mistakes)


def _chosen(null: SensorExplanation, pool: list[SensorExplanation], trials: int) -> SensorDiagnosis:
    """Return the best explanation of a pool; one that leaves neither noise nor rounding must halve the residual."""
    best = min(pool, key=lambda each: each.weight)
    if not best.is_whole:
        by_count = [
            min((e for e in pool if len(e.mistakes) == n), key=lambda e: e.weight, default=None)
            for n in range(MOST_MISTAKES + 1)
        ]
        best = null
        for each in by_count[1:]:
            if each is not None and each.rms <= HELPS ** (len(each.mistakes) - len(best.mistakes)) * best.rms:
                best = each
    if best.weight > null.weight - ALIKE:
        best = null
    alike = []
    seen = {best.names}
    for each in sorted(pool, key=lambda each: each.weight):
        fits = each.weight <= best.weight + ALIKE and each.is_whole >= best.is_whole and each.mistakes
        if fits and best.mistakes and each.names not in seen and not best.names < each.names:
            alike.append(each)
            seen.add(each.names)
    return SensorDiagnosis(null, best, tuple(alike[:SHOWN]), trials)
