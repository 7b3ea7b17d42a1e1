"""Runs the stages of a search against the rows of a trajectory, and ranks the explanations that they find."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from time import thread_time

import numpy as np

from tumble.compare.grade.hypotheses.engine_schemes import ENGINES, EngineScheme
from tumble.compare.grade.hypotheses.explanation import Explanation
from tumble.compare.grade.measure.significance import ALIKE
from tumble.compare.grade.model.program_model import ProgramModel
from tumble.compare.grade.search.combining import Combiner
from tumble.compare.grade.search.engine_search import EngineSearch
from tumble.compare.grade.search.evaluator import Evaluator, SearchStopped
from tumble.compare.grade.search.fitting import Fitter
from tumble.compare.grade.search.stages import (
    CLOSING,
    STAGES,
    Search,
    by_weight,
    defaults_of_engines_with_short_steps,
    plain_values,
    replace_each_mistake,
)

# An explanation with fewer mistakes must leave this many times as much to be worse; more, if what is left with more
# mistakes is not noise, since any fitted value explains a part of a systematic residual.
LEAST_HELP, MUCH_HELP = 1.1, 1.5
# Stages that no limit of time cuts off: a body at rest, and the defaults of engines.
NEVER_STOPPED = 2


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
    engines : engines that do the same at their defaults
    stopped_s : processor time after which the search was stopped [s]; 0: it ended by itself
    """

    null: Explanation
    best: Explanation
    alike: tuple[Explanation, ...]
    steps: tuple[Explanation, ...]
    trials: int
    program: ProgramModel
    engines: tuple[str, ...] = ()
    stopped_s: float = 0.0


def diagnosed(
    evaluator: Evaluator,
    engines: Sequence[EngineScheme] = ENGINES,
    on_nearest: Callable[[Explanation], None] = lambda _: None,
    search_s: float = np.inf,
) -> Diagnosis:
    """Search for the mistakes that explain the rows.

    Parameters
    ----------
    evaluator : evaluates mistakes against the rows
    engines : the schemes that are tried
    on_nearest : called with the nearest scheme if none fits and a search begins
    search_s : processor time after which the search stops with the best explanation so far [s]

    Returns
    -------
    the diagnosis
    """
    fitter = Fitter(evaluator)
    engine_search = EngineSearch(evaluator, fitter, engines)
    search = Search(
        evaluator=evaluator,
        fitter=fitter,
        combiner=Combiner(evaluator, fitter),
        engine_search=engine_search,
        on_nearest=on_nearest,
        null=evaluator.explain(()),
    )
    stopped = not search.null.within_floor and _is_stopped(search, search_s)
    replace_each_mistake(search)
    plain_values(search)
    return replace(_ranked(search), stopped_s=search_s if stopped else 0.0)


def _is_stopped(search: Search, search_s: float) -> bool:
    """Run the stages; return whether processor time ended them before they had ended by themselves.

    It does not cut off the first ones: what an engine does is said on a slow machine, too.
    """
    stops_at = thread_time() + search_s
    is_done = any(stage(search) for stage in STAGES[:NEVER_STOPPED])
    search.evaluator.stops_at = stops_at
    try:
        is_done = is_done or any(stage(search) for stage in STAGES[NEVER_STOPPED:])
        if not is_done or search.engines or not search.best.is_whole:
            return False
        defaults_of_engines_with_short_steps(search)  # a known scheme may be what was found in parts
    except SearchStopped:
        search.evaluator.stops_at = np.inf
        for stage in CLOSING:
            stage(search)
        return True
    else:
        return False
    finally:
        search.evaluator.stops_at = np.inf


def _ranked(search: Search) -> Diagnosis:
    """Return the best of the explanations that a search has found, and those that fit equally well."""
    null, found = search.null, search.explanations
    # Where single precision decides nothing, a run that is right may be off by more than one that is not.
    helpful = [null, *(each for each in found if each.max_m < null.max_m or each.within_floor)]
    ranked = [each for each in sorted(helpful, key=by_weight) if not _is_padded(each, helpful)]
    best = ranked[0]
    alike = [
        each
        for each in ranked[1:]
        if each.weight < best.weight + ALIKE and not each.names > best.names and each.names != best.names
    ]
    # Late rows alone do not identify an engine.
    has_more = any(mistake.hypothesis.part != "clock offset" for mistake in best.mistakes)
    engines = search.engines if has_more and best in search.by_engines else ()
    return Diagnosis(
        null=null,
        best=best,
        alike=tuple(_distinct(alike)),
        steps=tuple(_steps(search.evaluator, null, best)),
        trials=search.evaluator.trials,
        program=search.evaluator.program_with(best.mistakes),
        engines=engines,
    )


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


def _is_padded(explanation: Explanation, others: Iterable[Explanation]) -> bool:
    """Whether some of an explanation's mistakes fit nearly as well without the rest."""
    enough = explanation.weighted_rms_m * (LEAST_HELP if explanation.is_whole else MUCH_HELP)
    return any(
        other.names < explanation.names
        and (other.weighted_rms_m <= enough or (other.within_floor and explanation.within_floor))
        for other in others
    )


def _distinct(explanations: Iterable[Explanation]) -> Iterator[Explanation]:
    """Yield the first explanation of each set of names."""
    seen: set[frozenset[str]] = set()
    for each in explanations:
        if each.names not in seen:
            seen.add(each.names)
            yield each
