"""Assesses an answer of `tumble grade` by the true facts of the file."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from tools.random_programs.contact import Answer, Claim
from tools.random_programs.names import (
    DECAYS,
    GYROSCOPIC,
    PLACES,
    STEPS,
    TURNING,
    VELOCITY,
    back,
    fits,
    names,
    step_fits,
)
from tools.random_programs.program import SEEN, SIGNIFICANT, Case, Fact, Planted, Program, Truth, apart_from
from tools.random_programs.scheme import SPLIT, Damping, Reading, Scheme

# Kinds of files: without a visible mistake; with a faint one; all significant mistakes have names; some have none.
NOTHING, FAINT, NAMED, UNNAMED = "nothing to see", "faint", "named", "unnamed"
# Classes of answers.  Right: every mistake and nothing else.  Extras: every mistake and something else.  Alike: one of
# the explanations called equally good is right.  Same motion: it names something that makes the same motion.  Partly:
# some mistakes, or all of them called a partial explanation.  Honest: not explained, or called partial.  Firmly wrong.
# False correct.  False alarm: a correct file is called wrong.  Failed: no answer.
RIGHT, EXTRAS, ALIKE, SAME = "right", "right, with extras", "fits alike", "same motion"
PARTLY, HONEST, WRONG = "partly", "honest", "firmly wrong"
FALSE_CORRECT, FALSE_ALARM, FAILED = "false correct", "false alarm", "failed"
CLASSES = (RIGHT, EXTRAS, ALIKE, SAME, PARTLY, HONEST, WRONG, FALSE_CORRECT, FALSE_ALARM, FAILED)
# Answers that a reader can act on; `confidence` is their probability.
HITS = (RIGHT, ALIKE, SAME)
# Relative tolerance of a value: of three printed figures, and for an effect of this many times the noise.
EXACT, BY_NOISE = 0.01, 5.0
# Step of the program that simulates an answer without a step [s].
FINE = 0.0005
# How rows between ticks are read, by the name of a claim.
BETWEEN = {"interpolated-rows": "arcs", "fixed-physics-step": "held", "extrapolated-rows": "ahead"}


@dataclass(frozen=True)
class Matched:
    """Facts that no claim fits, claims that fit no fact, whether a claim names something that makes the same motion."""

    missing: tuple[Fact, ...]
    hits: int
    extras: tuple[Claim, ...]
    is_same: bool


def kind_of(case: Case, truth: Truth) -> str:
    """Return the kind of a file."""
    if truth.error < SEEN:
        return NOTHING
    if truth.error < SIGNIFICANT or not truth.significant:
        return FAINT
    return NAMED if all(names(fact.label, fact.params) for fact in truth.significant) else UNNAMED


def _is_file_of(case: Case, truth: Truth, program: Program) -> bool:
    """Whether another program would write the same file apart from its noise."""
    return apart_from(case, program, truth.rows, truth.noise_m) < SIGNIFICANT


# --- claims and facts -----------------------------------------------------------------------------------------------


def matched(case: Case, truth: Truth, claims: Sequence[Claim]) -> Matched:
    """Match claims with facts."""
    missing, used, is_same, hits = [], set[int](), False, 0
    for fact in truth.facts:
        due = fact.effect >= SIGNIFICANT
        tolerance = max(EXACT, BY_NOISE / fact.effect) if due else float("inf")
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
    due = fact.effect >= SIGNIFICANT
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
        return WRONG if answer.is_firm and matched(case, truth, answer.best).extras else RIGHT
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
    if not best.missing:
        return EXTRAS
    for other in answer.explanations[1:]:
        found = matched(case, truth, other)
        if not found.missing and not found.extras:
            return ALIKE
    if any(_is_file_of(case, truth, program) for program in translated(case, answer.best)):
        return SAME
    return PARTLY if best.hits and not best.extras and kind == NAMED else WRONG


# --- an answer as a program -----------------------------------------------------------------------------------------


def translated(case: Case, claims: Sequence[Claim]) -> list[Program]:
    """Return programs that implement the claims; empty if a claim cannot be translated."""
    own = case.program.scheme
    by_name = {claim.name: claim for claim in claims}
    scheme = _claimed_scheme(own, by_name)
    if scheme is None:
        return []
    damping = Damping()
    planted: list[Planted] = []
    late = 0.0
    for claim in claims:
        if claim.name in (*STEPS.values(), *BETWEEN, "velocity-in-body-axes"):
            continue
        if claim.name in ("linear-damping", "angular-damping") and scheme.method == SPLIT:
            damping = _claimed_damping(damping, claim)
        elif claim.name in ("log-lag", "clock-offset"):
            late = abs(claim.number("time") or 0.0)
        elif claim.name == "gyroscopic-term-missing" and scheme.method == SPLIT:
            scheme = replace(scheme, gyroscopic="none")
        elif (label := back(claim)) is None:
            return []
        else:
            planted.append(Planted(*label))
    found = [Program(replace(scheme, damping=damping), tuple(planted))]
    if late:
        found = [
            replace(program, planted=(*program.planted, Planted("clock offset", {"time": sign * late})))
            for program in found
            for sign in (-1, 1)
        ]
    return found


def _claimed_scheme(own: Scheme, claims: dict[str, Claim]) -> Scheme | None:
    """Return the scheme of an answer; None if rows are not multiples of its step."""
    method = next((method for method, name in STEPS.items() if name in claims), None)
    between = next((name for name in BETWEEN if name in claims), None)
    reading = Reading(0, BETWEEN[between]) if between else Reading()
    tick = claims[between].number("step") if between else None
    if method is None:
        whole = tick or own.spacing
        parts = max(1, round(whole / FINE))
        if tick:
            return Scheme(tick, own.spacing, "order 4", reading=reading, substeps=parts)
        return Scheme(own.spacing / parts, own.spacing, "order 4")
    claim = claims[STEPS[method]]
    step = claim.number("step")
    if not step:
        return None
    tick = tick or step
    every = round(own.spacing / tick)
    if not reading.between:
        if every < 1 or abs(every * tick - own.spacing) > 1e-3 * own.spacing:
            return None
        tick = own.spacing / every
    spins = {name: kind for kind, name in GYROSCOPIC.items() if name}
    spin = spins.get(claim.parameters.get("gyroscopic", ""), "explicit")
    turns = {name: kind for kind, name in TURNING.items()}
    moves = "new"
    if method == "explicit Euler" and "rotation" in claim.parameters:
        method, moves = SPLIT, "old, all"
    return Scheme(
        tick,
        own.spacing,
        method,
        "explicit" if spin == "momentum" else spin,
        turns.get(claim.parameters.get("rotation", ""), "exponential"),
        reading=reading,
        keeps="momentum" if spin == "momentum" else claim.parameters.get("stored", "") or "world",
        moves=moves,
        substeps=max(1, round(tick / step)),
        centre=int(claim.number("substeps") or 1),
        velocity=next((how for how, moves in VELOCITY.items() if moves == _moves(claims)), "world"),
    )


def _moves(claims: dict[str, Claim]) -> str:
    """Return how the centre moves in an answer with its velocity in body axes; empty in another."""
    return claims["velocity-in-body-axes"].parameters["moves"] if "velocity-in-body-axes" in claims else ""


def _claimed_damping(damping: Damping, claim: Claim) -> Damping:
    rate = claim.number("rate") or 0.0
    where = PLACES.get(claim.parameters.get("damping-place", ""), "before")
    how = DECAYS.get(claim.parameters.get("damping-form", ""), "1 - c dt")
    linear = rate if claim.name == "linear-damping" else damping.linear
    angular = rate if claim.name == "angular-damping" else damping.angular
    return Damping(linear, angular, where, how)
