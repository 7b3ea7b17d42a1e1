"""Assesses an answer of `tumble grade` by the true facts of the file."""

from collections.abc import Sequence
from dataclasses import dataclass

from tools.random_programs.answers import candidates
from tools.random_programs.contact import Answer, Claim
from tools.random_programs.names import fits, names, step_fits
from tools.random_programs.program import Case, Fact, Truth, Writes, apart_from

# Kinds of files: without a visible mistake; with a faint one; all significant mistakes have names; some have none.
NOTHING, FAINT, NAMED, UNNAMED = "nothing to see", "faint", "named", "unnamed"
# Classes of answers.  Right: every mistake and nothing else.  Extras: every mistake and something else.  Alike: one of
# the explanations called equally good is right.  Same motion: it names something that makes the same motion.  Partly:
# some mistakes, or all of them called a partial explanation.  Honest: not explained, or called partial.  Firmly wrong:
# none of the explanations called equally good is right.
# False correct.  False alarm: a correct file is called wrong.  Failed: no answer.
RIGHT, EXTRAS, ALIKE, SAME = "right", "right, with extras", "fits alike", "same motion"
PARTLY, HONEST, WRONG = "partly", "honest", "firmly wrong"
FALSE_CORRECT, FALSE_ALARM, FAILED = "false correct", "false alarm", "failed"
CLASSES = (RIGHT, EXTRAS, ALIKE, SAME, PARTLY, HONEST, WRONG, FALSE_CORRECT, FALSE_ALARM, FAILED)
# Answers that a reader can act on; `confidence` is their probability.
HITS = (RIGHT, ALIKE, SAME)
# Relative tolerance of a value, of three printed figures.
EXACT = 0.01


@dataclass(frozen=True)
class Matched:
    """Facts that no claim fits, claims that fit no fact, whether a claim names something that makes the same motion."""

    missing: tuple[Fact, ...]
    hits: int
    extras: tuple[Claim, ...]
    is_same: bool


def kind_of(case: Case, truth: Truth) -> str:
    """Return the kind of a file."""
    if truth.error < case.limits.seen:
        return NOTHING
    if truth.error < case.limits.significant or not truth.significant:
        return FAINT
    return NAMED if all(names(fact.label, fact.params) for fact in truth.significant) else UNNAMED


def _is_file_of(case: Case, truth: Truth, program: Writes) -> bool:
    """Whether another program would write the same file apart from its noise."""
    return apart_from(case, program, truth.rows, truth.noise_m) < case.limits.same


# --- claims and facts -----------------------------------------------------------------------------------------------


def matched(case: Case, truth: Truth, claims: Sequence[Claim]) -> Matched:
    """Match claims with facts."""
    missing, used, is_same, hits = [], set[int](), False, 0
    for fact in truth.facts:
        due = fact.effect >= case.limits.significant
        tolerance = max(EXACT, case.limits.value / fact.effect) if due else float("inf")
        found = _fitting(case, fact, claims, tolerance)
        used |= set(found)
        if due and not found:
            missing.append(fact)
        elif due:
            hits += 1
            is_same = is_same or all(found.values())
    extras = tuple(claim for number, claim in enumerate(claims) if number not in used)
    return Matched(tuple(missing), hits, extras, is_same)


def _fitting(case: Case, fact: Fact, claims: Sequence[Claim], tolerance: float) -> dict[int, bool]:
    """Return the numbers of the claims that fit a fact, and whether each only names something with the same motion."""
    found: dict[int, bool] = {}
    due = fact.effect >= case.limits.significant
    for name in names(fact.label, fact.params):
        for number, claim in enumerate(claims):
            if not fits(name, claim, fact.params, case.scene, tolerance):
                continue
            if fact.label == "step" and due and not step_fits(claim, fact.params):
                continue
            found[number] = name.same and found.get(number, True)
    return found


# --- the answer -----------------------------------------------------------------------------------------------------


def assessed(case: Case, truth: Truth, answer: Answer, kind: str) -> str:
    """Return the class of an answer; kind: of the file."""
    if answer.failure:
        return FAILED
    if kind == NOTHING:
        if answer.is_correct:
            return RIGHT
        if answer.is_firm:  # a method of higher order shows in the digits of some files below their noise
            return WRONG if matched(case, truth, answer.best).extras else RIGHT
        return FALSE_ALARM
    if kind == FAINT:
        is_wrong = answer.is_firm and all(matched(case, truth, one).extras for one in answer.explanations)
        return WRONG if is_wrong else RIGHT
    if answer.is_correct:
        return FALSE_CORRECT
    best = matched(case, truth, answer.best)
    if not answer.is_firm:
        return PARTLY if best.hits and kind == NAMED else HONEST
    return _firmly(case, truth, answer, best, kind)


def _firmly(case: Case, truth: Truth, answer: Answer, best: Matched, kind: str) -> str:
    """Return the class of an answer that explains the file completely."""
    if not best.missing and not best.extras:
        return SAME if best.is_same else RIGHT
    if any(_is_file_of(case, truth, program) for program in candidates(case, answer.best)):
        return SAME
    if not best.missing:
        return EXTRAS
    for other in answer.explanations[1:]:
        found = matched(case, truth, other)
        if not found.missing and not found.extras:
            return ALIKE
    return PARTLY if best.hits and not best.extras and kind == NAMED else WRONG
