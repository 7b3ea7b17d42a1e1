"""Diagnoses rows: engines first, then a search; ranks what they find, and names the engines that do the same."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, takewhile

import numpy as np

from tumble.compare.grade.hypotheses.engine_schemes import ENGINES, EngineScheme
from tumble.compare.grade.hypotheses.explanation import Explanation, Mistake, step_divides
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis
from tumble.compare.grade.hypotheses.names import ANGULAR_DAMPING, CLOCK_OFFSET, LOG_LAG
from tumble.compare.grade.measure.significance import ALIKE, EXPLAINED
from tumble.compare.grade.model.program_model import ProgramModel
from tumble.compare.grade.search.causal import CausalSearch
from tumble.compare.grade.search.clock import search_clock
from tumble.compare.grade.search.closing import (
    LARGER,
    NOISIER,
    Closing,
    fitted_of,
    is_hidden,
    is_named,
    is_no_larger,
    is_rounded,
    leaves_much_less,
    needs_noise_alone,
)
from tumble.compare.grade.search.engine_search import EngineSearch
from tumble.compare.grade.search.evaluator import Evaluator
from tumble.compare.grade.search.proposals import STEPS

# Programs that are simulated finely over all rows, of the best.
FINALISTS = 6
# An explanation with fewer mistakes must leave this many times as much to be worse; more, if what is left with more
# mistakes is not noise, since any fitted value explains a part of a systematic residual.
LEAST_HELP, MUCH_HELP = 1.1, 1.5
# Single precision explains an error that no engine's scheme makes this many times smaller.
CLEARLY = 2.0
# Residuals that differ by a smaller share are of the same motion.
SAME_MOTION = 1e-6
# A rate that changes a velocity by a smaller share in the whole run is no mistake where rounding may make it: steps of
# the Runge-Kutta method of order 4 in single precision make 1.4e-3 in 5,000 of them.
DRIFT = 2e-3
DRIFTS = (ANGULAR_DAMPING, "angular-damping-reversed")
# Explanations that leave too much whose values are fitted to all rows, of the best.
REFINED = 2
# How often others as good as the best one are looked for, and how many of the better ones are simplified.
ROUNDS, SIMPLIFIED = 3, 2
# Share of the processor time after which nothing new is searched for; after which what single precision explains is no
# longer sought in double precision; and the least share in which what was found is simplified and compared with others.
SEARCHED, DOUBLED, CLOSED = 0.9, 0.7, 0.12


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """The result of a search.

    Parameters
    ----------
    null : the explanation without a mistake
    best : the best explanation
    alike : others that fit equally well
    steps : explanations from null to best, each with a smaller error; the least important mistakes are added last
    trials : number of simulated programs
    program : program model of the best explanation
    is_open : single precision would explain all in steps shorter than a row interval, but not in one step a row; or
        only if it rounds in the same direction in every step; or only in more steps than most programs take
    engines : engines that do the same at their defaults
    stopped_s : processor time after which the search was stopped [s]; 0: it ended by itself
    alone : explanations by one mistake, best first
    """

    null: Explanation
    best: Explanation
    alike: tuple[Explanation, ...]
    steps: tuple[Explanation, ...]
    trials: int
    program: ProgramModel
    is_open: bool = False
    engines: tuple[str, ...] = ()
    stopped_s: float = 0.0
    alone: tuple[Explanation, ...] = ()


def diagnosed(
    evaluator: Evaluator,
    engines: Sequence[EngineScheme] = ENGINES,
    on_nearest: Callable[[Explanation], None] = lambda _: None,
    on_progress: Callable[[float], object] = lambda share: None,
    search_s: float = np.inf,
) -> Diagnosis:
    """Search for the mistakes that explain the rows.

    Parameters
    ----------
    evaluator : evaluates mistakes against the rows
    engines : the schemes that are tried
    on_nearest : called with the nearest scheme if none fits and a search begins
    on_progress : called with the share of the search that is done
    search_s : processor time after which the search stops with the best explanation so far [s]

    Returns
    -------
    the diagnosis
    """
    begun_at, least_s = search_clock(), CLOSED * search_s
    null = evaluator.explain(())
    if null.within_floor and null.in_digits <= EXPLAINED:
        return _ranked(evaluator, null, [])
    search = CausalSearch(evaluator)
    engine_search, closing = EngineSearch(evaluator, search, engines), Closing(evaluator, search)
    explained = engine_search.defaults()
    if null.within_floor:
        explained = _clearly_better(explained, null)
        if not explained:
            return replace(_ranked(evaluator, null, []), is_open=not evaluator.is_within_single_steps())
    if not (explained and explained[0].within_floor):
        if explained and explained[0].max_m < null.max_m:
            on_nearest(explained[0])
        found = search.candidates(begun_at + SEARCHED * search_s, on_progress)
        explained += [evaluator.explain(each.mistakes) for each in found[:FINALISTS]]
        if not any(each.is_whole for each in explained):
            explained += engine_search.short_defaults(search_clock() + least_s)
            explained += map(evaluator.explain, search.alone[:FINALISTS])
    explained.sort(key=by_weight)
    explained += _of_double(evaluator, explained, begun_at + DOUBLED * search_s, least_s)
    explained.sort(key=by_weight)
    closing.stop_at(max(begun_at + search_s, search_clock() + least_s))
    if not explained[0].within_floor:
        explained += [closing.refined(each) for each in explained[:REFINED] if each.mistakes]
        explained.sort(key=by_weight)
        explained += _with_drift(evaluator, explained[0], closing, search)
        explained.sort(key=by_weight)
    explained = _with_parts(evaluator, _closed(explained, closing, least_s), closing)
    closing.stop_at(np.inf)
    evaluator.trials += search.trials
    ranked = _ranked(evaluator, null, explained)
    stopped = search_s if search.is_stopped or closing.is_stopped else 0.0
    ranked = _without_drift(evaluator, ranked)
    is_open = ranked.is_open or evaluator.is_within_short_steps()
    return replace(ranked, is_open=is_open, stopped_s=stopped, engines=engine_search.fitting(ranked.best, closing))


def _clearly_better(explained: Sequence[Explanation], null: Explanation) -> list[Explanation]:
    """Return the explanations that leave much less than no mistake, although single precision would explain that."""
    return [each for each in explained if each.within_floor and each.in_common <= null.in_common / CLEARLY]


def _of_double(
    evaluator: Evaluator, explained: Sequence[Explanation], stops_at: float, least_s: float
) -> list[Explanation]:
    """Return explanations by programs of double precision that leave only what the digits allow, or much less.

    They are sought if the digits do not show that the program is of single precision, and that would explain the rest;
    or the search took that for granted, and more is left.  stops_at: processor time [s]; least_s: of the first case.
    """
    best = next((each for each in explained if each.within_floor), None)
    if best is not None:
        stops_at = max(stops_at, search_clock() + least_s)
    elif explained[0].in_common <= EXPLAINED and not explained[0].is_noise:
        best = explained[0]
    if evaluator.is_known or best is None or best.in_digits <= EXPLAINED or search_clock() > stops_at:
        return []
    search = CausalSearch(evaluator, is_double=True)
    beyond = [] if best.is_vague else search.beyond(best.mistakes, stops_at)
    found = beyond if beyond and beyond[0].is_whole else search.candidates(stops_at)
    every = [evaluator.explain(each.mistakes) for each in found[:FINALISTS]]
    # Or of single precision, with another scheme.
    others = [each.mistakes for each in beyond if fitted_of(each.mistakes) <= fitted_of(best.mistakes)]
    better = [each for each in map(evaluator.explain, others[:FINALISTS]) if leaves_much_less(each, best)]
    return [*(each for each in every if each.in_digits <= EXPLAINED or each.is_noise), *better]


def _closed(explained: Sequence[Explanation], closing: Closing, least_s: float) -> list[Explanation]:
    """Return explanations, best first, with those of everything simplified, and others that are as good as these.

    least_s: processor time that the best one is given to be simplified, if none is left [s].
    """
    whole = [each for each in explained if each.within_floor] or [each for each in explained if each.is_noise]
    if not whole:
        return list(explained)
    rest = [each for each in explained if each not in whole]
    simple = [closing.simplified(each) for each in takewhile(lambda _: not closing.is_late(), whole)]
    whole, others = [*simple, *whole[len(simple) :]], list[Explanation]()
    for _ in range(ROUNDS):
        best = min(whole, key=by_weight)
        # Fitted values of a simplified one are plain, so another one with the same mistakes is no better.
        known = [_without_fitted(each) for each in (*whole, *others)]
        others += [each for each in closing.alternatives(best) if _without_fitted(each) not in known]
        better = sorted((each for each in others if each.weight < best.weight), key=by_weight)
        others = [each for each in others if each not in better]
        simple += (simpler := [closing.simplified(each) for each in better[:SIMPLIFIED]])
        whole += [*simpler, *better[SIMPLIFIED:]]
        if closing.is_late() or min(whole, key=by_weight).names <= best.names:
            break
    if (best := min(whole, key=by_weight)) not in simple or closing.is_stopped:
        closing.stop_at(search_clock() + least_s)
        whole.append(closing.simplified(best))
    return [*whole, *others, *rest]


def _with_parts(evaluator: Evaluator, explained: Sequence[Explanation], closing: Closing) -> list[Explanation]:
    """Return explanations and, of those of a part of the error, those with fewer and fewer of their mistakes.

    What a search has added last may explain nothing but what something unknown leaves.
    """
    found = {each.names: each for each in explained}
    for number, part in enumerate([] if any(each.is_whole for each in explained) else explained[:FINALISTS]):
        if number and closing.is_late():
            break
        while len(part.mistakes) > 1:
            fewer = [evaluator.explain(some) for some in combinations(part.mistakes, len(part.mistakes) - 1)]
            part = min(fewer, key=lambda each: each.weighted_rms_m)
            found.setdefault(part.names, part)
    return [*explained, *(each for each in found.values() if each not in explained)]


def _without_fitted(explanation: Explanation) -> set[tuple[Hypothesis, float | None]]:
    """Return mistakes with the lengths of steps, which are not fitted, and without other values."""
    return {(m.hypothesis, m.value if m.hypothesis.part == STEPS else None) for m in explanation.mistakes}


def _ranked(evaluator: Evaluator, null: Explanation, found: Sequence[Explanation]) -> Diagnosis:
    """Return the best of the explanations that a search has found, and those that fit equally well."""
    # Where single precision decides nothing, a run that is right may be off by more than one that is not.
    helpful = [each for each in found if each.max_m < null.max_m or each.within_floor]
    # What is found although single precision would explain all is clearly better than no mistake.
    if not (helpful and null.within_floor):
        helpful.insert(0, null)
    spacing_s = evaluator.context.spacing_s
    ranked = [each for each in sorted(helpful, key=by_weight) if not _is_padded(each, helpful, spacing_s)]
    as_good = _as_good(evaluator, ranked)
    best = _best(evaluator, ranked[0], as_good)
    alike = [
        each
        for each in ranked
        if each is not best and (each.weight < best.weight + ALIKE or each in as_good) and not each.names > best.names
    ]
    return Diagnosis(
        null=null,
        best=best,
        alike=tuple(_distinct([best, *alike]))[1:],
        steps=tuple(_steps(evaluator, null, best)),
        trials=evaluator.trials,
        program=evaluator.program_with(best.mistakes),
        alone=tuple(each for each in sorted(helpful, key=by_weight) if len(each.mistakes) == 1),
    )


def _with_drift(evaluator: Evaluator, best: Explanation, closing: Closing, search: CausalSearch) -> list[Explanation]:
    """Return explanations with a slow growth or decay of the spin, if a search took the rest for single precision.

    That rounds in the same direction in every step of some methods, which their floor does not have.
    """
    if best.is_whole or not best.mistakes or best.in_common > EXPLAINED or not evaluator.single:
        return []
    parts = {m.hypothesis.part for m in best.mistakes}
    drifts = [h for h in evaluator.hypotheses if h.name in DRIFTS and not h.details and h.part not in parts]
    least = DRIFT / evaluator.context.duration
    programs = (search.proposals.ordered((*best.mistakes, Mistake(drift, least))) for drift in drifts)
    found = [closing.refined(evaluator.explain(program)) for program in programs]
    return [each for each in found if each.is_whole and each.without_drift(least).drift]


def _without_drift(evaluator: Evaluator, ranked: Diagnosis) -> Diagnosis:
    """Return a diagnosis that takes a slow growth or decay of velocities for rounding, where that may be its cause.

    Single precision may round in the same direction in every step.  If that alone is found, it is open whether anything
    is wrong.
    """
    least = DRIFT / evaluator.context.duration

    def shown(each: Explanation) -> Explanation:
        may_round = each.is_whole and evaluator.may_be_single(evaluator.program_with(each.mistakes))
        return each.without_drift(least) if may_round else each

    every = list(map(shown, (ranked.best, *ranked.alike)))
    if not ranked.best.mistakes or not any(each.drift for each in every):
        return ranked
    best, *alike = list(_distinct(each for each in every if each.mistakes)) or every[:1]
    steps = tuple(_steps(evaluator, ranked.null, best))
    is_open = ranked.is_open or not best.mistakes
    return replace(ranked, best=best, alike=tuple(alike), steps=steps, is_open=is_open)


def _as_good(evaluator: Evaluator, ranked: Sequence[Explanation]) -> list[Explanation]:
    """Return explanations that single precision or noise does not distinguish from the first one.

    The effect of single precision is not white: a smaller residual within it says little.  Of those in noise, only ones
    that differ in values or details are among them.
    """
    first = ranked[0]
    if first.is_noise:
        likely = takewhile(lambda each: each.weight <= first.weight + NOISIER, ranked)
        return [each for each in likely if each.is_noise and each.names == first.names]
    if not first.within_floor or first.in_digits <= EXPLAINED:
        return []
    floor_m = evaluator.scale.floor_m
    return [
        each
        for each in ranked
        if is_no_larger(each, first, LARGER, floor_m)
        or any(test(each, first) for test in (is_hidden, is_named, is_rounded))
    ]


def _best(evaluator: Evaluator, first: Explanation, as_good: Sequence[Explanation]) -> Explanation:
    """Return the first explanation, or one as good with fewer values that nobody writes, or much fewer assumptions."""
    plainest = min((first, *as_good), key=lambda each: (each.odd_values, evaluator.cost(each.mistakes)))
    is_plainer = plainest.odd_values < first.odd_values
    is_plainer = is_plainer or evaluator.cost(plainest.mistakes) < evaluator.cost(first.mistakes) - ALIKE / 2
    return plainest if is_plainer else first


def by_weight(explanation: Explanation) -> float:
    """Return the weight of an explanation, to sort by."""
    return explanation.weight


def _steps(evaluator: Evaluator, null: Explanation, best: Explanation) -> list[Explanation]:
    """Return explanations from null to the best, with more and more of its mistakes, each with a smaller error.

    From the best on, the least important mistake is left out.  If mistakes help only together, the error with some of
    them is larger than without any; a step is then of several mistakes.
    """
    steps = [best]
    for fewer in range(len(best.mistakes) - 1, 0, -1):
        candidates = [evaluator.explain(some) for some in combinations(steps[0].mistakes, fewer)]
        smaller = [each for each in candidates if steps[0].max_m < each.max_m < null.max_m]
        if smaller:
            steps.insert(0, min(smaller, key=lambda each: each.weighted_rms_m))
    return [null, *steps] if best.mistakes else steps


def _is_padded(explanation: Explanation, others: Iterable[Explanation], spacing_s: float) -> bool:
    """Whether some of an explanation's mistakes fit nearly as well without the rest.

    spacing_s: interval of rows [s]; a step that ends between them needs what writes rows there.
    """
    is_written = step_divides(explanation.mistakes, spacing_s)
    return any(
        other.names < explanation.names
        and (step_divides(other.mistakes, spacing_s) or not is_written)
        and (not needs_noise_alone(explanation, other) or _is_fitted_to(explanation, other))
        and (_helps_little(explanation, other) or (other.within_floor and explanation.within_floor))
        and not leaves_much_less(explanation, other)
        for other in others
    )


def _helps_little(explanation: Explanation, other: Explanation) -> bool:
    """Whether an explanation leaves hardly less than another one.

    Of what neither explains, both leave the same part of a common floor: a larger one of their own explains nothing.
    """
    enough = LEAST_HELP if explanation.is_whole else MUCH_HELP
    is_common = not explanation.is_whole and other.in_common <= enough * explanation.in_common
    return is_common or other.weighted_rms_m <= enough * explanation.weighted_rms_m


def _is_fitted_to(explanation: Explanation, other: Explanation) -> bool:
    """Whether what an explanation has beyond another is nearly right, so it was fitted to what that leaves."""
    return any(m.is_nearly_right() for m in explanation.mistakes if m.hypothesis.name not in other.names)


def _distinct(explanations: Iterable[Explanation]) -> Iterator[Explanation]:
    """Yield the first explanation of each set of names and schemes; of those with the same motion, the first one."""
    found: list[Explanation] = []
    for each in explanations:
        if not any(_key(each) == _key(other) or _is_same_motion(each, other) for other in found):
            found.append(each)
            yield each


def _is_same_motion(one: Explanation, other: Explanation) -> bool:
    """Return whether explanations of the same names leave the same of every row: their details have no effect.

    A clock that is ahead is a log that is early.
    """
    sizes = (one.rms_m, other.rms_m), (one.max_m, other.max_m)
    names, others = ({LOG_LAG if name == CLOCK_OFFSET else name for name in each.names} for each in (one, other))
    return names == others and all(abs(a - b) <= SAME_MOTION * b for a, b in sizes)


def _key(explanation: Explanation) -> frozenset[tuple]:
    """Return the names of the mistakes, and the parts of the step."""
    parts = ("gyroscopic", "rotation")
    return frozenset(
        (m.hypothesis.name, *(word for part, word in m.hypothesis.details if part in parts))
        for m in explanation.mistakes
    )
