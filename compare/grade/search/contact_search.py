"""Which contact law a file follows: the scene's, or one with mistakes, to what its steps and digits leave open.

A law is compared with each impact from the file's own state just before it, and with each motion along the plane from
its start.  Errors are in units of what a step of the program, as far as the file shows it, and its digits may change.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

import numpy as np

from tumble.compare.grade.hypotheses.contact_mistakes import (
    EARLY,
    GRAVITY_FIRST,
    HANGS,
    TUNNELS,
    ContactHypothesis,
    contact_hypotheses,
)
from tumble.compare.grade.measure.contact_motion import ContactMotion, Impact, Lasting
from tumble.compare.grade.model.contact_law import (
    INSTANT,
    Approach,
    ContactLaw,
    after_impact,
    after_impacts,
    free_rotation,
    lowest_of,
    right_law,
    slide,
)
from tumble.scenarios.frames import Array, rotation_matrix, turned_by
from tumble.solver.contact.flight import axes_of
from tumble.solver.quaternion import from_matrix

# Velocities after an impact may be off by so many steps of gravity, and by this share.
STEPS_OFF, SHARE_OFF = 1.5, 3e-4
# The same of an impact that lasts several steps, as on a stiff spring; at least this many that are late by one time,
# within this share, show it.
SOFT, FEW, ALIKE = 0.02, 3, 0.1
# Places on a slide may be off by so many steps squared of friction, and by this share of the way.
SLIDE_OFF, WAY_OFF = 1.5, 1e-3
# The same in a program whose contacts are less steady: so many units of an impact, this share of the way, at most.
NEARLY, OF_WAY = 2.0, 0.005
# Where a motion is known this well, in the units that no law changes, it is late by half a step, of which a row has a
# whole number within this share, or more than so many; otherwise it misses so many units.
PRECISE, UNEVEN, MANY, BY_NO_STEP = 10.0, 0.05, 4.0, 2.0
# Viscous friction hides its step: it is at most this many times as long as seen.
HIDDEN = 3.0
# Uncertainties by digits count so many times.
DIGITS = 4.0
# Odds against the contacts of a file being all as punctual as they are by chance.
IMPROBABLE = 100.0
# The longest step that a program is believed to have [s].
LONGEST_STEP = 1 / 30
# Share of a row interval below which a shown step may be none, and is rounding.
SHORTEST, LEAST_STEP = 0.02, 1e-6
# A contact later than this many times the usual one is not one impact.
FAR_LATER = 20.0
# Speeds below this, over that of a fall by the body's reach, and lengths over the reach, are rounding.
LEAST, ROUNDING = 1e-6, 1e-12
# A chain of impacts is compared if a step's delay changes its outcome by this share of what it changes at most.
STEADY = 0.2
# Share of the body's reach below which a gap is none.
TOUCHES = 1e-3
# Programs stop a rebound of fewer steps of gravity than this; rows show at least one part in so many of a hop's height.
STOPPED, SEEN = 4.0, 8.0
# Errors above this many units count as so many.
MOST = 1e9
# An explanation in part leaves at most this share of the largest miss; one that leaves this share is far better.
PARTLY, FAR_LESS = 0.1, 0.1
# Explanations whose misses differ by so many units at most are the same motion.
SAME = 0.05
# Mistakes that are tried in pairs with all, and pairs whose values are refined; what fits as well as this is not.
PAIRED, REFINED, WELL = 4, 6, 0.2
# The excess of a rebound in steps of gravity that names gravity before the bounce, and how well it must be known.
EXCESS, KNOWN = 0.25, 0.2


@dataclass(frozen=True)
class ContactMistake:
    """One mistake of an explanation, with its values."""

    hypothesis: ContactHypothesis
    values: tuple[float, ...] = ()

    @property
    def text(self) -> str:
        """The mistake in words."""
        return self.hypothesis.text_with(self.values)


@dataclass(frozen=True)
class ContactExplanation:
    """A law with mistakes, and how badly it fits.

    Parameters
    ----------
    mistakes : one, or a pair
    misses : of each impact and motion, in units of what a right program may be off
    law : with the mistakes' fitted values
    apart : as misses, in units that no law changes
    """

    mistakes: tuple[ContactMistake, ...]
    misses: tuple[float, ...]
    law: ContactLaw
    apart: tuple[float, ...] = ()

    @cached_property
    def cost(self) -> float:
        """How badly it fits: a large miss counts by its order of magnitude."""
        return float(np.log1p(np.square(np.minimum(self.apart, MOST))).sum())

    @property
    def fits(self) -> bool:
        """Whether nothing is missed by more than a unit."""
        return bool(self.misses) and max(self.misses) <= 1.0

    @property
    def parts(self) -> set[str]:
        """The parts of the law that it changes."""
        return {mistake.hypothesis.part for mistake in self.mistakes}

    @property
    def rank(self) -> tuple[int, int]:
        """How much it assumes: number of mistakes, and of fitted values."""
        return len(self.mistakes), sum(len(mistake.values) for mistake in self.mistakes)


def simplest_first(found: list[ContactExplanation]) -> list[ContactExplanation]:
    """Return explanations, the best first, with friction on the whole impulse before a pyramid that is the same motion.

    A pyramid bounds the impulse as a whole too; where the slip stays along one of its axes, nothing shows the pyramid.
    """
    best, *others = found
    if best.fits and "cone" in best.parts:
        simpler = best.parts - {"cone"} | {"instant"}
        for one in others:
            if one.fits and one.parts == simpler and np.allclose(one.misses, best.misses, rtol=0, atol=SAME):
                return [one, *(other for other in found if other is not one)]
    return found


@dataclass(frozen=True, eq=False)
class SlideRows:
    """A motion along the plane in the file, and by a law.

    times [s], (n,); places: in the file [m], (n, 2); spins: between its rows [rad/s], (n - 1, 3); x, turning: the same
    by the law; late: by which x is moved [s]; x_on_time: x before that; v, w: at the first time.
    """

    times: Array
    places: Array
    spins: Array
    x: Array
    turning: Array
    late: float
    x_on_time: Array
    v: Array
    w: Array


@dataclass(eq=False)
class ContactSearch:
    """The search for the law of one throw."""

    motion: ContactMotion
    trials: int = 0
    _known: dict[ContactLaw, tuple[tuple[float, float], ...]] = field(default_factory=dict)
    _parts: dict[tuple, tuple[float, float]] = field(default_factory=dict)
    _spreads: dict[Impact, tuple[float, float]] = field(default_factory=dict)

    @cached_property
    def right(self) -> ContactLaw:
        """The scene's law."""
        assert self.motion.scene.plane is not None
        return right_law(self.motion.scene.plane)

    @cached_property
    def strength(self) -> float:
        """Gravity [m/s2]."""
        return float(np.linalg.norm(self.motion.pull))

    @cached_property
    def shown_step(self) -> float | None:
        """The step of a first-order program [s], by the velocity of its first flight; None if the file shows none.

        With the velocity changed before or after the position, the parabola of the first flight begins with half a
        step of gravity too much or too little.
        """
        motion, rows = self.motion, self.motion.rows
        if not motion.flights or motion.flights[0].first > 0 or rows.times[0] != 0:
            return None
        flight = motion.flights[0]
        off = flight.at(0.0, motion.pull)[1] - self.start_velocity
        step = 2 * abs(float(off @ motion.pull)) / self.strength**2
        sure = 2 * DIGITS * flight.sigma / self.strength
        if sure > 0.1 * step or not LEAST_STEP < step / rows.spacing_s < 1.02:
            return None
        whole = rows.spacing_s / max(1, round(rows.spacing_s / step))
        return whole if abs(whole - step) < 0.02 * step else step

    @cached_property
    def ahead(self) -> float:
        """Time that a program may look ahead without a margin [s]: its step, or a row where its order hides that.

        The digits of a program of first order may hide its step; then a contact above the plane is taken for a margin.
        """
        motion = self.motion
        if self.shown_step is not None:
            return self.shown_step
        exact = motion.flights and 20 * DIGITS * motion.flights[0].sigma / self.strength < 0.01 * motion.rows.spacing_s
        return min(motion.rows.spacing_s, LONGEST_STEP) if exact else 0.0

    @cached_property
    def start_velocity(self) -> Array:
        """The scene's velocity at the start, plane's frame [m/s], (3,)."""
        assert self.motion.scene.plane is not None
        return axes_of(self.motion.scene.plane.normal) @ self.motion.scene.start[0, 7:10]

    @cached_property
    def step(self) -> float:
        """The step that errors of impacts are compared with [s]: as seen at the start, or as contacts are late."""
        spacing = min(self.motion.rows.spacing_s, LONGEST_STEP)
        late = [one.late for one in self.alone if np.isfinite(one.late) and not one.stays]
        if self.shown_step is not None:
            return float(min(max([self.shown_step, *late]), 2 * spacing))
        # A contact is late by a random part of a step: that all are this early in a longer one is improbable.
        return float(min(max(late) * IMPROBABLE ** (1 / len(late)), spacing)) if late else spacing

    @cached_property
    def alone(self) -> tuple[Impact, ...]:
        """The impacts of one corner alone, after which no other meets the plane before the next row.

        Where a contact seems far later than the others, two corners have met the plane between two rows.
        """
        found = tuple(one for one in self.motion.impacts if one.single and not one.chain)
        if self.motion.scene.body.radius or not found:
            return found
        late = [one.late for one in found if np.isfinite(one.late)]
        usual = float(np.median(late)) if late else 0.0
        return tuple(one for one in found if not late or not one.late > FAR_LATER * usual)

    @cached_property
    def judged(self) -> tuple[Impact, ...]:
        """The impacts that a law can be held to, in order of time: also chains of them that a step changes little."""
        chains = [one for one in self.motion.impacts if one.single and one.chain]
        steady = [one for one in chains if self.spread(one)[0] <= STEADY * np.linalg.norm(one.v - one.before.v)]
        return tuple(sorted((*self.alone, *steady), key=lambda one: one.time))

    def after(self, one: Impact, law: ContactLaw) -> tuple[Array, Array]:
        """Return v [m/s] and w [rad/s], (3,) each, after an impact or a chain of them by a law; infinite if unknown."""
        body = self.motion.scene.body
        if not one.chain:
            return after_impact(body, one.before, law)
        found = after_impacts(body, one.before, law, self.motion.pull, one.chain)
        return found[:2] if found is not None else (np.full(3, np.inf), np.full(3, np.inf))

    def spread(self, one: Impact) -> tuple[float, float]:
        """Return what a step of delay changes in v [m/s] and w [rad/s] after a chain of impacts."""
        if one not in self._spreads:
            body, pull, at = self.motion.scene.body, self.motion.pull, one.before
            q = from_matrix(at.axes[None])[0]
            turned, w = (each[0] for each in free_rotation(body.moments, q, at.w, np.array([self.step])))
            axes = rotation_matrix(turned[None])[0]
            late = Approach(at.v + self.step * pull, w, axes, lowest_of(body, axes), 0.0)
            found = after_impacts(body, late, self.right, pull, max(0.0, one.chain - self.step))
            v, w = self.after(one, self.right)
            self._spreads[one] = (
                (float(np.linalg.norm(found[0] - self.step * pull - v)), float(np.linalg.norm(found[1] - w)))
                if found is not None
                else (np.inf, np.inf)
            )
        return self._spreads[one]

    @cached_property
    def slid(self) -> tuple[Lasting, ...]:
        """The motions along the plane."""
        return self.motion.lasting

    @property
    def is_empty(self) -> bool:
        """Whether the file shows nothing that a law can be held to: also a motion after unclear impacts."""
        motion = self.motion
        falls = motion.flights and motion.lasting and motion.flights[0].first < motion.lasting[0].first
        return not self.judged and (not self.slid or bool(falls))

    # --- how far a law is off ---------------------------------------------------------------------------------------

    def explained(self, mistakes: tuple[ContactMistake, ...], law: ContactLaw) -> ContactExplanation:
        """Return the explanation by a law: by how many units it misses each impact, and each motion along the plane."""
        if law not in self._known:
            self.trials += 1
            # What has no effect on an impact, or on a slide, makes no other law for it.
            at_once = replace(law, asleep=0.0, viscous=0.0)
            lasting = replace(law, restitution=0.0, threshold=0.0, push=0.0, laid=False, in_impact=INSTANT)
            if not self.right.friction:
                lasting = replace(lasting, viscous=0.0)
            parts = [(self.missed_impact, one, at_once) for one in self.judged]
            parts += [(self.missed_slide, one, lasting) for one in self.slid]
            self._known[law] = tuple(self._missed(*part) for part in parts)
        misses = tuple(missed for missed, _ in self._known[law])
        return ContactExplanation(mistakes, misses, law, tuple(apart for _, apart in self._known[law]))

    def _missed(self, how: Callable, one: Impact | Lasting, law: ContactLaw) -> tuple[float, float]:
        """Return by how many units a law misses one impact or motion, computed once; and in units that stay."""
        if (one, law) not in self._parts:
            missed, apart = how(one, law)
            self._parts[one, law] = (missed if np.isfinite(missed) else np.inf, apart if np.isfinite(apart) else np.inf)
        return self._parts[one, law]

    def missed_impact(self, one: Impact, law: ContactLaw) -> tuple[float, float]:
        """Return by how many units a law misses the velocities after an impact, twice."""
        body, spacing = self.motion.scene.body, self.motion.rows.spacing_s
        v, w = self.after(one, law)
        speed, spin = float(np.linalg.norm(one.before.v)), float(np.linalg.norm(one.before.w))
        gained = float(np.linalg.norm(one.v - one.before.v))
        share = SOFT if self.is_soft(one) else SHARE_OFF
        step = self.step + (max(spacing, one.lasts) if one.stays else 0.0)
        turned = 0.0 if body.radius else STEPS_OFF * spin * gained * self.step
        room_v = (
            (STEPS_OFF + self.right.friction) * self.strength * step + DIGITS * one.sigma_v + share * speed + turned
        )
        lever = float(np.linalg.norm(one.before.lever))
        room_w = (
            room_v * body.mass * lever / float(np.min(body.moments))
            + DIGITS * one.sigma_w
            + SHARE_OFF * 3 * (spin + float(np.linalg.norm(one.w)))
        )
        if one.chain:
            late_v, late_w = self.spread(one)
            room_v, room_w = room_v + late_v, room_w + late_w
        off = v - one.v
        hop = max(self.strength * spacing / 2, float(np.sqrt(2 * self.strength * SEEN * one.rises)))
        if one.stays and 0 < v[2] < max(hop, STOPPED * self.strength * self.step):
            off[2] = 0.0
        # A body that stays has no velocity along the normal, whatever the digits: only a step may change the rebound.
        room_n = (STEPS_OFF + self.right.friction) * self.strength * self.step + share * speed if one.stays else room_v
        # The depth that a push-out is by is known to the digits.
        deep = law.push * DIGITS * float(np.median(self.motion.rows.half))
        beside = max(float(np.abs(off[:2]).max()) / room_v, float(np.abs(w - one.w).max()) / room_w)
        return max(beside, float(abs(off[2])) / (room_n + deep)), max(beside, float(abs(off[2])) / room_n)

    def is_soft(self, one: Impact) -> bool:
        """Whether an impact lasts several steps: by the step of the first flight, or as all are late by one time.

        A contact that is found at the end of a step is late by a random part of it.
        """
        if self.shown_step is not None:
            return one.late > 2 * self.shown_step
        late = [each.late for each in self.alone if not each.stays]
        return len(late) >= FEW and bool(np.ptp(late) < ALIKE * np.mean(late))

    def slide_by(self, one: Lasting, law: ContactLaw) -> SlideRows:
        """Return the rows of a motion along the plane, and the motion by a law from the same start."""
        rows, scene = self.motion.rows, self.motion.scene
        some = slice(one.first, one.last + 1)
        times, places = rows.times[some], rows.x[some, :2] - rows.x[one.first, :2]
        spins = turned_by(rows.q[some][:-1], rows.q[some][1:]) / np.diff(times)[:, None]

        def run(v: Array, w: Array) -> tuple[Array, Array, Array]:
            found = slide(scene, self.motion.pull, v, w, law, times)
            return found.x, found.v, np.diff(found.turned, axis=0) / np.diff(times)[:, None]

        v, w = one.v, one.w
        if not one.from_start:
            v, w = self._fitted_start(run, v, w, places, spins, bool(scene.body.radius))
        x, along, turning = run(v, w)
        # A first-order program is ahead or late by half a step of what it has gained.
        gained = along - v[:2]
        square = float((gained * gained).sum())
        late = float(((places - x) * gained).sum()) / square if square > 0 and one.from_start else 0.0
        late = float(np.clip(late, -0.51 * rows.spacing_s, 0.51 * rows.spacing_s))
        return SlideRows(times, places, spins, x + late * gained, turning, late, x, v, w)

    def missed_slide(self, one: Lasting, law: ContactLaw) -> tuple[float, float]:
        """Return by how many units a law misses a motion along the plane; and the same if its step were the shortest.

        The step is seen in the motion by the law, so that units alone would draw a search to long steps.
        """
        rows, body = self.motion.rows, self.motion.scene.body
        found = self.slide_by(one, law)
        half = float(np.median(rows.half[one.first : one.last + 1]))
        step, shown = min(rows.spacing_s, LONGEST_STEP), 2 * abs(found.late) * (HIDDEN if law.viscous else 1.0)
        step = shown if SHORTEST * step < shown < step else step
        pull = self.right.friction * self.strength + float(np.linalg.norm(self.motion.pull[:2]))
        way = np.concatenate(((0.0,), np.cumsum(np.linalg.norm(np.diff(found.x, axis=0), axis=1))))
        often = SLIDE_OFF if one.from_start else 2 + SLIDE_OFF
        # A program of first order has another path too, where friction turns.
        coarse = slide(
            self.motion.scene,
            self.motion.pull,
            found.v,
            found.w,
            law,
            found.times,
            max(1, round(float(found.times[-1] - found.times[0]) / step)),
        )
        turned = np.linalg.norm(coarse.x - found.x_on_time, axis=1)
        least = DIGITS * half + ROUNDING * body.reach
        room = least + often * pull * step**2 + WAY_OFF * way + turned
        off = np.linalg.norm(found.places - found.x, axis=1)
        missed = float((off / room).max())
        apart = float((off / (least + often * pull * (SHORTEST * rows.spacing_s) ** 2)).max())
        if body.radius:
            spun = self.missed_spin(one, found, step)
            missed, apart = max(missed, spun), max(apart, spun)
        if apart <= PRECISE and self.is_late_by_no_step(one, found):
            missed, apart = max(missed, BY_NO_STEP), max(apart, PRECISE)
        crept = self.missed_rest(found.times, found.places, found.x, half)
        return max(missed, crept), max(apart, crept)

    def is_late_by_no_step(self, one: Lasting, found: SlideRows) -> bool:
        """Whether a motion is late by more than the half of a step that rows are a multiple of may make it."""
        half_steps = self.motion.rows.spacing_s / max(2 * abs(found.late), np.finfo(float).tiny)
        return one.from_start and half_steps < MANY and abs(half_steps - round(half_steps)) > UNEVEN * half_steps

    def missed_spin(self, one: Lasting, found: SlideRows, step: float) -> float:
        """Return by how many units a law misses the spin of a sphere that moves along the plane."""
        rows, body = self.motion.rows, self.motion.scene.body
        assert body.radius
        lever = body.mass * body.radius / float(body.moments[0])
        often = SLIDE_OFF if one.from_start else 2 + SLIDE_OFF
        room = (
            LEAST * np.sqrt(self.strength / body.reach)
            + often * lever * self.right.friction * self.strength * step
            + DIGITS * 2 * rows.half_turn / float(np.median(np.diff(found.times)))
            # A body that has sunk in has a shorter lever.
            + (SHARE_OFF * 3 + min(abs(one.height) / body.radius, SOFT))
            * float(np.linalg.norm(found.turning, axis=1).max())
            # The rotation of a row is not the integral of a spin whose axis turns.
            + float(np.linalg.norm(np.cross(found.turning[1:], found.turning[:-1]), axis=1).max()) * rows.spacing_s / 6
        )
        return float(np.linalg.norm(found.spins - found.turning, axis=1).max()) / room

    @cached_property
    def nearly_fits(self) -> bool:
        """Whether the scene's law misses little.

        That is what a step may change, of a ball's impact twice that; on the plane, the motion in a row.  A contact
        that lifts or tilts the body, or takes hold a step late, changes the path by that much in a program of first
        order.
        """
        # A corner's contact, which one turn of a step moves, is allowed for already.
        most = NEARLY if self.motion.scene.body.radius else 1.0
        if any(self._missed(self.missed_impact, one, self.right)[0] > most for one in self.judged):
            return False
        for one in self.slid:
            found = self.slide_by(one, self.right)
            half = float(np.median(self.motion.rows.half[one.first : one.last + 1]))
            steps = np.linalg.norm(np.diff(found.x, axis=0), axis=1)
            room = min(float(steps.max()), OF_WAY * float(steps.sum())) + DIGITS * half
            off = float(np.linalg.norm(found.places - found.x, axis=1).max())
            if self._missed(self.missed_slide, one, self.right)[0] == BY_NO_STEP:
                return False
            if off > room or self.missed_rest(found.times, found.places, found.x, half) > 1:
                return False
            spacing = min(self.motion.rows.spacing_s, LONGEST_STEP)
            if self.motion.scene.body.radius and self.missed_spin(one, found, spacing) > 1:
                return False
        return True

    def is_supported(self, one: ContactExplanation) -> bool:
        """Whether an explanation has fewer fitted values than there are contacts, or explains them all the better.

        A motion along the plane counts twice: it shows a place and an instant.
        """
        beyond = one.rank[1] - len(self.judged) - 2 * len(self.slid) + 1
        return max(one.misses) <= FAR_LESS ** max(0, beyond) * max(self.null.misses)

    def missed_rest(self, times: Array, places: Array, x: Array, half: float) -> float:
        """Return by how many units a law misses the speed of a body that rests at the end by the law."""
        moved = np.linalg.norm(x - x[-1], axis=1) > 1e-9 * (1 + float(np.abs(x).max()))
        first = int(np.flatnonzero(moved)[-1]) + 1 if moved.any() else 0
        first += (len(times) - first) // 2
        if len(times) - first < 3:
            return 0.0
        took = float(times[-1] - times[first])
        own, model = ((one[-1] - one[first]) / took for one in (places, x))
        room = 2 * DIGITS * half / took + LEAST * np.sqrt(self.strength * self.motion.scene.body.reach)
        return float(np.linalg.norm(own - model)) / room

    def _fitted_start(
        self, run: Callable, v: Array, w: Array, places: Array, spins: Array, turns: bool
    ) -> tuple[Array, Array]:
        """Return the velocity and spin at the start of a motion along the plane that fit its rows best."""
        reach = self.motion.scene.body.reach

        def misfit(at: Array) -> Array:
            x, _, turning = run(np.array((at[0], at[1], 0.0)), at[2:5])
            return np.concatenate(((places - x).ravel(), (turning - spins).ravel() * reach * 0.01))

        at, free = np.concatenate((v[:2], w)), 5 if turns else 2
        for _ in range(3):
            off = misfit(at)
            slopes = np.stack([(misfit(at + 1e-4 * np.eye(5)[n]) - off) / 1e-4 for n in range(free)], axis=1)
            at[:free] += np.linalg.lstsq(slopes, -off, rcond=None)[0]
        return np.array((at[0], at[1], 0.0)), at[2:5]

    # --- what is said -----------------------------------------------------------------------------------------------

    @cached_property
    def null(self) -> ContactExplanation:
        """The scene's law."""
        return self.explained((), self.right)

    @cached_property
    def hypotheses(self) -> tuple[ContactHypothesis, ...]:
        """The mistakes that are tried."""
        return contact_hypotheses(self.right, self.motion.pull, tuple(one.approach for one in self.judged))

    @cached_property
    def explanations(self) -> list[ContactExplanation]:
        """The laws with mistakes, the best first: those that fit, the ones that assume least first, then the others."""
        found = [self.fitted(one, self.right) for one in self.hypotheses]
        least = min((max(one.misses) for one in found if one.fits), default=np.inf)
        if least > WELL:
            # A pair without a value is preferred to a mistake that leaves far more, if a step would still allow both.
            others = list(self.pairs(found))
            if any(not one.rank[1] and max(one.misses) < FAR_LESS * least for one in others):
                found = [one for one in found if not one.fits]
            found += others

        def key(one: ContactExplanation) -> tuple:
            fits = one.fits and self.is_supported(one)
            return not fits, one.rank if fits else (0, 0), one.cost

        return simplest_first(sorted(found, key=key))

    def pairs(self, alone: list[ContactExplanation]) -> Iterator[ContactExplanation]:
        """Yield pairs of mistakes of different parts, of those that help most with all; the best are fitted."""
        found = []
        for first, second in product(sorted(alone, key=lambda one: one.cost)[:PAIRED], alone):
            parts = {each.mistakes[0].hypothesis.part for each in (first, second)}
            if len(parts) == 1 or parts == {"material", "friction"}:
                continue
            if first.mistakes[0].values and not second.mistakes[0].values:
                first, second = second, first
            found.append(self.tried(second.mistakes[0].hypothesis, first.law, first.mistakes))
        found.sort(key=lambda one: one.cost)
        yield from map(self.refined, found[:REFINED])
        yield from found[REFINED:]

    def fitted(self, hypothesis: ContactHypothesis, law: ContactLaw) -> ContactExplanation:
        """Return the explanation by a mistake added to a law, with the values that fit best."""
        best = self.tried(hypothesis, law)
        return best if best.cost >= self.null.cost else self.refined(best)

    def tried(
        self, hypothesis: ContactHypothesis, law: ContactLaw, before: tuple[ContactMistake, ...] = ()
    ) -> ContactExplanation:
        """Return the explanation by a mistake added to a law, with the best of the values that are tried first."""
        return min(
            (
                self.explained((*before, ContactMistake(hypothesis, values)), hypothesis.change(law, values))
                for values in hypothesis.values or ((),)
            ),
            key=lambda one: one.cost,
        )

    def refined(self, best: ContactExplanation) -> ContactExplanation:
        """Return the explanation with values of its last mistake near the best ones that fit better."""
        *before, last = best.mistakes
        hypothesis, start = last.hypothesis, last.values
        if not start or hypothesis.name == "contact-bounce-threshold" or (best.fits and max(best.misses) < WELL):
            return best
        from scipy.optimize import minimize  # slow to load

        def explained(values: Array) -> ContactExplanation:
            at = tuple((values if hypothesis.is_signed else np.abs(values)).tolist())
            return self.explained((*before, ContactMistake(hypothesis, at)), hypothesis.change(best.law, at))

        def squares(values: Array) -> float:
            return float(np.square(np.minimum(explained(values).apart, MOST)).sum())

        def cost(values: Array) -> float:
            return explained(values).cost

        # Far from the best values a sum of squares leads there; near them, what other mistakes miss must not count.
        at = np.array(start)
        for least in (squares, cost) if len(start) > 1 else (cost,):
            simplex = np.array([at, *(at + np.eye(len(at)) * (0.3 * max(at, key=abs)))])
            how = {"initial_simplex": simplex, "maxfev": 40 * len(at), "xatol": 1e-5, "fatol": 1e-4}
            found = minimize(least, at, method="Nelder-Mead", options=how)
            at = found.x
        other = explained(at)
        return other if other.cost < best.cost else best

    def shown(self) -> ContactMistake | None:
        """Return a mistake that the motion shows by itself, whatever the law; None if there is none."""
        motion, rows = self.motion, self.motion.rows
        if motion.through is not None:
            return ContactMistake(TUNNELS)
        if motion.frozen is not None:
            return ContactMistake(HANGS)
        half = DIGITS * float(np.median(rows.half))
        resting = [one.height for one in motion.lasting if one.height > half + TOUCHES * motion.scene.body.reach]
        early = [
            one.gap
            for one in self.judged
            if not one.stays and one.gap > 2 * half + TOUCHES * motion.scene.body.reach + one.approach * self.ahead
        ]
        # Between two rows another corner may have met the plane too, which lifts the point where the flights meet.
        if not motion.scene.body.radius and 2 * len(early) <= len(self.judged):
            early = []
        if resting or early:
            return ContactMistake(EARLY, (max(resting or early),))
        return None

    def gravity_first(self) -> ContactMistake | None:
        """Return the mistake of gravity added before the bounce, if every rebound is too fast by it; None otherwise.

        At the step k where a semi-implicit program turns the velocity back, the parabolas before and after have the
        velocities (k + 1/2) g dt and, with gravity added first, e (k + 1) g dt + g dt / 2: the rebound has
        (1 + e) / 2 steps of gravity too much, otherwise (1 - e) / 2 too much or (1 + e) / 2 too little.
        """
        step, e = self.shown_step, self.right.restitution
        least = 2 * self.strength * self.motion.rows.spacing_s
        flying = [one for one in self.judged if not one.stays and one.approach > least]
        if step is None or not flying or e == 0 or not self.motion.scene.body.radius:
            return None
        excess = []
        for one in flying:
            if one.sigma_v * DIGITS > KNOWN * self.strength * step:
                return None
            flights = list(self.motion.flights)
            before = max((each for each in flights if each.time < one.time), key=lambda each: each.time)
            after = min((each for each in flights if each.time > one.time), key=lambda each: each.time)
            turned = np.ceil(one.time / step - 0.02) * step
            fall, rise = (float(each.at(turned, self.motion.pull)[1][2]) for each in (before, after))
            excess.append((rise + e * fall) / (-float(self.motion.pull[2]) * step) - (1 + e) / 2)
        return ContactMistake(GRAVITY_FIRST, (step,)) if max(map(abs, excess)) <= EXCESS else None
