"""The stages of a search, in order.  Each adds explanations; the search ends at the first stage that explains all.

`STAGES`, at the end of this file, is the list.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from itertools import combinations

from tumble.compare.grade.hypotheses.explanation import Explanation, Mistake, Mistakes, with_value
from tumble.compare.grade.hypotheses.names import BODY_NEVER_MOVES
from tumble.compare.grade.measure.significance import ALIKE
from tumble.compare.grade.model.program_model import FINE
from tumble.compare.grade.search.combining import FINALISTS, Combiner
from tumble.compare.grade.search.engine_search import EngineSearch
from tumble.compare.grade.search.evaluator import Evaluator
from tumble.compare.grade.search.fitting import Fitter

# Parts of a program whose mistakes may cause one motion: gravity from the second step on, x moved by the old velocity.
TWINS = {"gravity start": "position step", "position step": "gravity start"}
# Mistakes without which no body in space moves.
START_MISSING = ("start-velocity-missing", "start-spin-missing")
# Single mistakes that are fitted finely: the right one may rank below others in a quick look.
SINGLES = 12
# Mistakes without a value that are explained first.
PLAIN = 2
# So few numbers fit many schemes.
FEW_NUMBERS = 100
# Explanations to which further mistakes are added.
STARTS = 3
# Single mistakes that are put upon schemes: at most so many, which leave at most this share of the error.
BELOW, MOSTLY = 3, 0.3
MOST_MISTAKES = 5
# A single mistake that leaves at most this share of the error is taken for one of the mistakes.
SURELY = 0.05
# Share of ENOUGH steps that may be spent on replacing mistakes by others, and those that are fitted finely.
OF_REPLACING, REPLACED = 0.1, 4
# Significant digits of a value that a person wrote, and weights that differ by less than rounding may cause.
FEW_DIGITS, SAME_WEIGHT = (1, 2, 3), 1.0
# An error below this share of the body's size is explained by at most one mistake.
SMALL = 1e-6


@dataclass(eq=False)
class Search:
    """What the stages work with and what they have found.

    null: the explanation without a mistake; immobile, by_engines, by_damping, found: explanations, by the stages that
    found them; engines: names of those whose defaults fit; singles: every mistake alone, best first; pairs: the best
    mistakes with one more; extended: mistakes to which one has been added; has_short_steps: engines with many steps in
    a row interval have been tried; on_nearest: called with the nearest scheme if none fits.
    """

    evaluator: Evaluator
    fitter: Fitter
    combiner: Combiner
    engine_search: EngineSearch
    on_nearest: Callable[[Explanation], None]
    null: Explanation
    immobile: list[Explanation] = field(default_factory=list)
    by_engines: list[Explanation] = field(default_factory=list)
    engines: tuple[str, ...] = ()
    by_damping: list[Explanation] = field(default_factory=list)
    found: list[Explanation] = field(default_factory=list)
    singles: list[Mistakes] = field(default_factory=list)
    pairs: list[Mistakes] = field(default_factory=list)
    extended: set[Mistakes] = field(default_factory=set)
    has_short_steps: bool = False

    @property
    def explanations(self) -> list[Explanation]:
        """All explanations."""
        return [self.null, *self.immobile, *self.by_engines, *self.by_damping, *self.found]

    @property
    def combinable(self) -> list[Explanation]:
        """The explanations that more mistakes are added to; damped schemes are not, since damping is a mistake too."""
        return [*self.by_engines, *self.found]

    @property
    def best(self) -> Explanation:
        """The best of the explanations that more mistakes are added to."""
        return min(self.combinable or [self.null], key=by_weight)

    def explained(self, candidates: Iterable[Mistakes]) -> list[Explanation]:
        """Add and return the explanations by candidates fitted finely, and by the same with named values."""
        begun = len(self.found)
        for candidate in candidates:
            fitted = self.fitter.fit(candidate)
            self.found += map(self.evaluator.explain, dict.fromkeys((fitted, self.fitter.snapped(fitted))))
        return self.found[begun:]

    def add_upon_scheme(self, mistakes: Mistakes) -> None:
        """Add the explanations by mistakes upon a scheme, with fitted and with named values, simplified if whole."""
        free = [m.hypothesis for m in mistakes if m.hypothesis.part not in ("steps", "clock offset")]
        fitted = self.fitter.fit(mistakes, free)
        explained = [self.evaluator.explain(each) for each in dict.fromkeys((fitted, self.fitter.snapped(fitted)))]
        self.found += self.engine_search.simplified_if_whole(sorted(explained, key=by_weight))


def by_weight(explanation: Explanation) -> float:
    """Return the weight of an explanation, to sort by."""
    return explanation.weight


# --- the stages; each returns whether everything is explained ---------------------------------------------------------


def body_that_never_moves(search: Search) -> bool:
    """Explain a body at rest first: many schemes would fit as well."""
    never = [search.evaluator.explain((Mistake(h),)) for h in search.evaluator.hypotheses if h.name == BODY_NEVER_MOVES]
    search.immobile = [each for each in never if each.within_floor]
    if search.immobile:  # a body that only rotates does not move without its spin, either
        starts = (h for h in search.evaluator.hypotheses if h.name in START_MISSING)
        search.found = [search.evaluator.explain((Mistake(hypothesis),)) for hypothesis in starts]
    return bool(search.immobile)


def defaults_of_engines(search: Search) -> bool:
    """Simulate the scheme of every engine with steps as long as the row interval, or a little shorter."""
    search.by_engines, search.engines = search.engine_search.defaults(short=False)
    return any(each.within_floor for each in search.by_engines)


def defaults_of_engines_with_short_steps(search: Search) -> bool:
    """Simulate the scheme of every engine with steps of which many are in a row interval, once."""
    if search.has_short_steps:
        return False
    search.has_short_steps = True
    found, engines = search.engine_search.defaults(short=True)
    search.by_engines += found
    is_whole = any(each.within_floor for each in found)
    if is_whole:  # a known scheme has priority over mistakes
        search.engines, search.found = engines, []
    return is_whole


def single_mistakes(search: Search) -> bool:
    """Try each mistake alone; those without a value first, which take one run each."""
    plain = [(Mistake(hypothesis),) for hypothesis in search.evaluator.hypotheses if not hypothesis.values]
    for mistakes in sorted(plain, key=search.evaluator.quick_weight)[:PLAIN]:
        search.found.append(search.evaluator.explain(mistakes))
    tuned = (search.fitter.tuned((hypothesis,)) for hypothesis in search.evaluator.hypotheses)
    search.singles = sorted(tuned, key=search.evaluator.quick_weight)
    search.explained(search.singles[:SINGLES])
    return False


def schemes_below_the_best_mistakes(search: Search) -> bool:
    """Put the best single mistakes upon schemes."""
    if search.best.is_whole:
        return False
    best = [each for each in search.found if each.weighted_rms_m <= MOSTLY * search.null.weighted_rms_m]
    seen: set[frozenset[str]] = set()
    for each in sorted(best, key=by_weight)[:SINGLES]:
        if each.names not in seen and len(seen) < BELOW:
            seen.add(each.names)
            search.add_upon_scheme(search.engine_search.schemes.below(each.mistakes))
    return any(each.within_floor for each in search.found)


def schemes_between_ticks(search: Search) -> bool:
    """Put rows between the ticks of a scheme."""
    if not search.best.is_whole:
        for mistakes in search.engine_search.schemes.between_ticks():
            search.add_upon_scheme(mistakes)
    return any(each.within_floor for each in search.found)


def one_mistake_upon_any_scheme(search: Search) -> bool:
    """Try each mistake upon rough schemes, and improve the schemes below the best."""
    if not search.best.is_whole:
        for mistakes in search.engine_search.schemes.upon_schemes():
            search.add_upon_scheme(mistakes)
    return any(each.within_floor for each in search.found)


def schemes_with_fitted_damping(search: Search) -> bool:
    """Fit damping in every scheme, unless a single mistake explains all; its steps do not count for the limit."""
    if not any(each.within_floor for each in search.found):
        steps = search.evaluator.simulated_steps
        search.by_damping = search.engine_search.damped(search.best.weight)
        search.evaluator.simulated_steps = steps
    if search.by_damping and search.by_damping[0].within_floor:
        return True
    if schemes := (*search.by_engines, *search.by_damping):
        search.on_nearest(min(schemes, key=by_weight))
    return False


def best_fitted_finely(search: Search) -> bool:
    """Fit the best explanation to fine runs: coarse ones may be what it leaves."""
    best = search.best
    continuous = [m.hypothesis for m in best.mistakes if m.hypothesis.fitted and not m.has_named_value]
    if continuous and not best.is_whole:
        search.found.append(search.evaluator.explain(search.fitter.descended(best.mistakes, continuous, FINE)))
    return False


def combinations_of_schemes(search: Search) -> bool:
    """Combine parts of the schemes of several engines."""
    if not search.best.within_floor:
        search.found += search.engine_search.combined()
    return False


def run_and_output_in_few_rows(search: Search) -> bool:
    """Try pairs of a mistake in the run with one in the output before schemes, if there are few rows."""
    if search.evaluator.scale.numbers <= FEW_NUMBERS and not search.best.is_whole:
        search.explained(search.combiner.of_run_and_output())
    return any(each.within_floor for each in search.found)


def second_mistake_if_one_explains_most(search: Search) -> bool:
    """Add a second mistake at once if the best single one explains most of the error."""
    alone = [each for each in search.found if len(each.mistakes) == 1]
    for best in (min(alone, key=by_weight), search.best) if alone else ():
        if best.weighted_rms_m <= MOSTLY * search.null.weighted_rms_m and not search.best.within_floor:
            _add_second_mistake(search, best)
    return any(each.within_floor for each in search.found)


def second_mistake_with_the_best(search: Search) -> bool:
    """Add a second mistake, and then more, to the best explanation if it surely has one of the mistakes."""
    _add_second_mistake(search, search.best)
    if search.pairs and search.best.weighted_rms_m <= SURELY * search.null.weighted_rms_m:
        _add_more_mistakes(search)
    return False


def _add_second_mistake(search: Search, best: Explanation) -> None:
    """Add a second mistake to an explanation, unless that has been done."""
    search.evaluator.aim_at(best.rms_m)
    is_small = search.null.rms_m < SMALL * search.evaluator.scale.size_m
    if best.within_floor or is_small or best.mistakes in search.extended:
        return
    search.extended.add(best.mistakes)
    pairs = search.combiner.with_one_more(best.mistakes)
    quick_weight = search.evaluator.quick_weight
    if pairs and (not best.is_noise or quick_weight(pairs[0]) < quick_weight(best.mistakes) - ALIKE):
        search.pairs = pairs
        search.explained(pairs)


def all_pairs(search: Search) -> bool:
    """Try pairs of all mistakes, and then more."""
    if search.pairs and not search.best.is_whole:
        search.explained(search.combiner.pairs(search.singles, search.pairs))
        _add_more_mistakes(search)
    return False


def one_mistake_fewer(search: Search) -> bool:
    """Leave out each mistake of the best explanations, with the others as they were fitted together."""
    best = sorted(search.combinable, key=by_weight)[:FINALISTS]
    several = (each.mistakes for each in best if len(each.mistakes) > 1)
    fewer = (some for mistakes in several for some in combinations(mistakes, len(mistakes) - 1))
    search.found += [search.evaluator.explain(some) for some in dict.fromkeys(fewer)]
    return False


def equivalent_mistakes(search: Search) -> bool:
    """Replace each mistake of the best explanation by others of its part without a value, and by its twins.

    A twin with a value gets the step.
    """
    best = search.best
    step = next((mistake.value for mistake in best.mistakes if mistake.hypothesis.part == "steps"), 0.0)
    several = best.mistakes if len(best.mistakes) > 1 else ()
    swapped = [
        (*best.mistakes[:place], Mistake(h, step if h.values else 0.0), *best.mistakes[place + 1 :])
        for place, mistake in enumerate(several)
        for h in search.evaluator.hypotheses
        if h is not mistake.hypothesis
        and ((h.part == mistake.hypothesis.part and not h.values) or h.part == TWINS.get(mistake.hypothesis.part))
    ]
    search.found += [search.evaluator.explain(search.evaluator.ordered(some)) for some in swapped]
    return False


def replace_each_mistake(search: Search) -> None:
    """Replace each mistake of an explanation of everything by each other one: a file may not distinguish them.

    A scheme with a step is taken as it is, and only its other mistakes are replaced.
    """
    best, evaluator = min(search.explanations, key=by_weight), search.evaluator
    if not best.is_whole:
        return
    evaluator.aim_at(best.rms_m)
    before, found = evaluator.simulated_steps, []
    for place, mistake in enumerate(best.mistakes):
        others = (*best.mistakes[:place], *best.mistakes[place + 1 :])
        taken = {"steps", *(other.hypothesis.part for other in others)}
        if mistake.hypothesis.part == "steps":
            continue
        for hypothesis in evaluator.hypotheses:
            if evaluator.is_spent(OF_REPLACING, before):
                break
            if hypothesis.part not in taken and hypothesis.name != mistake.hypothesis.name:
                several = (evaluator.ordered((*others, Mistake(hypothesis, v))) for v in hypothesis.values or (0.0,))
                found.append((min(several, key=evaluator.quick_weight), hypothesis))
    likely = sorted(found, key=lambda one: evaluator.quick_weight(one[0]))[:SINGLES]
    refined = sorted((search.fitter.refined_one(*one) for one in likely), key=evaluator.quick_weight)
    begun = len(search.found)
    search.explained(refined[:REPLACED])
    # What only fits as well comes after it.
    search.found[begun:] = [
        replace(each, weight=best.weight + SAME_WEIGHT) if best.weight - ALIKE < each.weight < best.weight else each
        for each in search.found[begun:]
    ]


def plain_values(search: Search) -> None:
    """Give the best explanation of everything the values that a person would have written, if they fit as well."""
    best, evaluator = min(search.explanations, key=by_weight), search.evaluator
    if not best.within_floor or not best.mistakes:
        return
    in_rows = search.engine_search.schemes.in_rows(best.mistakes)
    mistakes = in_rows if evaluator.explain(in_rows).within_floor else best.mistakes
    for mistake in mistakes:
        if not mistake.hypothesis.fitted or mistake.has_named_value:
            continue
        for digits in FEW_DIGITS:
            value = float(f"{mistake.value:.{digits - 1}e}")
            plain = evaluator.explain(with_value(mistakes, mistake.hypothesis, value))
            if plain.within_floor and plain.weight <= best.weight + SAME_WEIGHT:
                mistakes = plain.mistakes
                break
    if mistakes != best.mistakes:
        plain = evaluator.explain(mistakes)
        search.found.append(replace(plain, weight=min(plain.weight, best.weight - SAME_WEIGHT)))


Stage = Callable[[Search], bool]
STAGES: tuple[Stage, ...] = (
    body_that_never_moves,
    defaults_of_engines,
    single_mistakes,
    run_and_output_in_few_rows,
    schemes_with_fitted_damping,
    schemes_below_the_best_mistakes,
    second_mistake_if_one_explains_most,
    schemes_between_ticks,
    defaults_of_engines_with_short_steps,
    combinations_of_schemes,
    one_mistake_upon_any_scheme,
    best_fitted_finely,
    second_mistake_with_the_best,
    all_pairs,
    best_fitted_finely,
    one_mistake_fewer,
    equivalent_mistakes,
)
# What a search that was stopped still does with its best explanation: a share of a second.
CLOSING: tuple[Stage, ...] = (best_fitted_finely, one_mistake_fewer, equivalent_mistakes)


def _add_more_mistakes(search: Search) -> None:
    """Add explanations with more and more mistakes, as long as another one helps much."""
    starts = sorted(search.combinable, key=by_weight)[:STARTS]
    while not _is_enough(search.evaluator, starts[0]):
        search.evaluator.aim_at(starts[0].rms_m)
        several = [more for start in starts if start.mistakes for more in search.combiner.with_one_more(start.mistakes)]
        more = search.explained(sorted(several, key=search.evaluator.quick_weight)[:FINALISTS])
        if not more or min(map(by_weight, more)) > starts[0].weight - ALIKE:
            break
        starts = sorted(more, key=by_weight)[:STARTS]


def _is_enough(evaluator: Evaluator, best: Explanation) -> bool:
    """Whether nothing is left to explain, or too much has been assumed or simulated already."""
    return best.is_whole or not best.mistakes or len(best.mistakes) >= MOST_MISTAKES or evaluator.is_spent()
