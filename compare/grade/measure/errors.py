"""What is off from the right motion: over all rows, a block at a time, and a few rows kept for the diagnosis."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from tumble.compare.grade.measure.conserved import Conserved
from tumble.compare.grade.model.reference import Reference
from tumble.compare.grade.read.block import Block, vertices_of
from tumble.compare.grade.read.columns import CENTRE, MATRIX, QUATERNION, SPIN, BadTrajectory, Shown
from tumble.compare.grade.read.even_clock import EXACT, EvenClock
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.compare.run.progress import Progress, ProgressCallback, no_progress
from tumble.scenarios.frames import Array, vertices
from tumble.scenarios.scene import Scene

# Rows kept of the throw that is diagnosed: at least so many where there are as many, at most twice that.
KEPT = 256
GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0
BINS = 60
# How far two descriptions of one place may differ, of the largest coordinate; of single precision, four last bits.
# And as much for each of a quaternion's four numbers, of how far the body reaches: engines let its length slip.
ALIKE, SINGLES_ALIKE, TURNED = 1e-9, 4 * 2.0**-23, 4
# First rows that say by which clock a body moves, and how much more smoothly it must by the printed one.
FIRST_ROWS, SMOOTHER = 200, 0.1
# Intervals between rows that are looked at for how far rows are apart.
SPACED = 10_000


@dataclass(frozen=True, eq=False)
class Kept:
    """Rows of one throw, evenly spread, the first among them.

    times [s], (S,); vertices as the file has them [m], (S, K, 3), which a quaternion longer than 1 stretches;
    true: the right ones; half: how far a vertex moves along each axis when every printed number is half a unit of its
    last digit off [m], (S, 3); spins: w as written [rad/s], (S, 3), or None where it is not.
    """

    times: Array
    vertices: Array
    true: Array
    half: Array
    spins: Array | None

    def __len__(self) -> int:
        return len(self.times)

    def some(self, rows: np.ndarray | slice) -> "Kept":
        """Return some of the rows."""
        spins = None if self.spins is None else self.spins[rows]
        return Kept(self.times[rows], self.vertices[rows], self.true[rows], self.half[rows], spins)

    def joined(self, other: "Kept") -> "Kept":
        """Return these rows and then the other's."""
        pairs = zip(self._arrays(), other._arrays(), strict=True)
        return Kept(*(None if a is None or b is None else np.concatenate((a, b)) for a, b in pairs))  # type: ignore[arg-type]

    def _arrays(self) -> tuple[Array | None, ...]:
        return self.times, self.vertices, self.true, self.half, self.spins


class Thinned:
    """Keeps every row of a stream until there are too many, then half of them, a quarter, ...

    Which ones, the golden ratio says: evenly spread, and in step with nothing that a program does every so many rows.
    """

    def __init__(self) -> None:
        self._share, self._seen, self._turns, self.kept = 1.0, 0, np.empty(0), None

    def add(self, rows: Kept) -> None:
        """Take in the next rows."""
        turns = np.arange(self._seen, self._seen + len(rows)) * GOLDEN % 1.0
        self._seen += len(rows)
        self._take(rows, turns)
        while len(self._turns) > 2 * KEPT:
            self._share /= 2
            kept, self.kept, turns, self._turns = self.kept, None, self._turns, np.empty(0)
            assert kept is not None
            self._take(kept, turns)

    def _take(self, rows: Kept, turns: Array) -> None:
        chosen = np.flatnonzero(turns < self._share)
        self._turns = np.append(self._turns, turns[chosen])
        self.kept = rows.some(chosen) if self.kept is None else self.kept.joined(rows.some(chosen))


def golden(count: int, most: int) -> np.ndarray:
    """Return which of so many rows to take, about `most` of them and the first, evenly but in step with nothing."""
    return np.flatnonzero(np.arange(count) * GOLDEN % 1.0 < most / count) if count > most else np.arange(count)


@dataclass(eq=False)
class Measured:
    """A whole trajectory against the right motion.

    spacing_s: of most rows; intervals: of the first rows [s]; rounding_s: of their instants; worst_m: the largest
    error, with where it is; final_m: the largest at any throw's last row; half_m: the largest that printed digits leave
    open; excess_m: the largest that they do not; over_time_m: the largest in each of equal parts of the duration, nan
    where there are no rows; relation: of neighbouring rows' errors, 0 for noise, 1 for a drift, over so many pairs;
    lengths: of the shortest and the longest quaternion; single: its places are of single precision; drifts: of
    energy, momentum, angular momentum as `tumble.compare.judge.errors` has them, None where they cannot be known,
    by_differences where they come from poses; resolution_m: of the reference; throw: the one furthest off.
    """

    shown: Shown
    rows: int
    throws: int
    spacing_s: float
    intervals: Array
    rounding_s: float
    worst_m: float
    worst_t_s: float
    worst_throw: int
    worst_vertex: int
    rms_m: float
    final_m: float
    half_m: float
    excess_m: float
    resolution_m: float
    over_time_m: Array
    relation: float
    pairs: int
    lengths: tuple[float, float] | None
    single: bool
    drifts: tuple[float, float, float] | None
    by_differences: bool
    throw: int
    kept: Kept


@dataclass(eq=False)
class _Sums:
    rows: int = 0
    rounding: float = 0.0
    squares: float = 0.0
    products: float = 0.0
    neighbours: Array = field(default_factory=lambda: np.zeros(2))
    pairs: int = 0
    worst: tuple[float, float, int, int] = (-1.0, 0.0, 0, 0)
    half: float = 0.0
    excess: float = -np.inf
    lengths: tuple[float, float] | None = None
    last: dict[int, float] = field(default_factory=dict)
    over_time: Array = field(default_factory=lambda: np.full(BINS, np.nan))
    intervals: list[float] = field(default_factory=list)


def measure(trajectory: Trajectory, scene: Scene, on_progress: ProgressCallback = no_progress) -> Measured:
    """Hold every row against the right motion; on_progress is called with shares of the rows, and of the truth.

    Raises BadTrajectory for a bad row, NoTruth where there is no truth.
    """
    shown, reference = trajectory.shown[0], Reference(scene)
    _settle_clock(trajectory, reference, scene)
    reading, working = Progress("rows", on_progress), Progress(f"{scene.name} truth", on_progress)
    sums, conserved, single = _Sums(), Conserved(scene, shown), _single(trajectory)
    slack = SINGLES_ALIKE if single else ALIKE
    thinned: dict[int, Thinned] = {}
    for block in trajectory.blocks():
        _see_lengths(sums, block)
        for throw in np.unique(block.throws).tolist():
            rows = block.throw(throw)
            states = reference.states(throw, rows.times)
            true = _right(states, shown, scene)
            half = half_digits(trajectory, rows, shown, scene, states)
            _add(sums, rows, vertices_of(rows, shown, scene, stretched=False), true, half, throw, scene.duration)
            _check_agreement(trajectory, rows, scene, np.linalg.norm(half, axis=1), slack)
            conserved.add(rows, states)
            if not thinned or throw in thinned:
                thinned.setdefault(throw, Thinned()).add(_kept(rows, shown, scene, true, half))
        reading(trajectory.share)
    reading.end()
    worst_m, worst_t_s, worst_throw, worst_vertex = sums.worst
    if worst_throw not in thinned:
        thinned = {worst_throw: _thinned(trajectory, scene, worst_throw)}
    diagnosed, kept = worst_throw, thinned[worst_throw].kept
    assert kept is not None
    limit = reference.limit(diagnosed, kept.times, working)
    working.end()
    return Measured(
        shown=shown,
        rows=sums.rows,
        throws=len(sums.last),
        spacing_s=float(np.median(sums.intervals)) if sums.intervals else scene.duration,
        intervals=np.array(sums.intervals),
        rounding_s=sums.rounding,
        worst_m=worst_m,
        worst_t_s=worst_t_s,
        worst_throw=worst_throw,
        worst_vertex=shown.vertices[worst_vertex],
        rms_m=float(np.sqrt(sums.squares / (sums.rows * len(shown.vertices)))),
        final_m=max(sums.last.values()),
        half_m=sums.half,
        excess_m=sums.excess - limit,
        resolution_m=limit,
        over_time_m=sums.over_time,
        relation=sums.products / float(np.sqrt(sums.neighbours.prod())) if sums.neighbours.all() else 0.0,
        pairs=sums.pairs,
        lengths=sums.lengths,
        single=single,
        drifts=conserved.drifts(),
        by_differences=conserved.by_differences,
        throw=diagnosed,
        kept=kept,
    )


def _settle_clock(trajectory: Trajectory, reference: Reference, scene: Scene) -> None:
    """Take instants as exact where the errors of rows change far more smoothly by them than by an even clock.

    A program that rounded its instants first has moved the body to those; most round what they print.
    """
    if not isinstance(trajectory.clock, EvenClock):
        return
    clock, even = trajectory.clock, _unevenness(trajectory, reference, scene)
    trajectory.clock = EXACT
    if not _unevenness(trajectory, reference, scene) < SMOOTHER * even:
        trajectory.clock = clock


def _unevenness(trajectory: Trajectory, reference: Reference, scene: Scene) -> float:
    """Return by how much the errors of the first rows change unevenly, in the middle [m]; 0 of too few."""
    block = next(trajectory.blocks())
    throw = int(block.throws[0])
    rows = block.throw(throw).some(slice(FIRST_ROWS))
    errors = vertices_of(rows, trajectory.shown[0], scene) - _right(
        reference.states(throw, rows.times), trajectory.shown[0], scene
    )
    bends = np.linalg.norm(np.diff(errors, 2, axis=0), axis=-1)
    return float(np.median(bends)) if bends.size else 0.0


def _right(states: Array, shown: Shown, scene: Scene) -> Array:
    """Return where the vertices that a file shows should be [m], (n, K, 3), as `vertices_of` has them."""
    places = vertices(states, scene.body.points)[:, shown.vertices]
    return places if shown.centred else places - states[:, None, 0:3]


def _kept(rows: Block, shown: Shown, scene: Scene, true: Array, half: Array) -> Kept:
    spins = rows.of(SPIN) if shown.spin else None
    return Kept(rows.times, vertices_of(rows, shown, scene), true, half, spins)


def _thinned(trajectory: Trajectory, scene: Scene, throw: int) -> Thinned:
    """Return the rows kept of one throw, on a second way through the file."""
    thinned, reference, shown = Thinned(), Reference(scene), trajectory.shown[0]
    for block in trajectory.blocks():
        rows = block.throw(throw)
        if len(rows.times):
            states = reference.states(throw, rows.times)
            true = _right(states, shown, scene)
            thinned.add(_kept(rows, shown, scene, true, half_digits(trajectory, rows, shown, scene, states)))
    return thinned


def _add(sums: _Sums, rows: Block, seen: Array, true: Array, half: Array, throw: int, duration: float) -> None:
    """Add one throw's rows of a block; seen, true: vertices [m], (n, K, 3)."""
    errors = seen - true
    with np.errstate(over="ignore"):
        distances = np.linalg.norm(errors, axis=-1)
        largest = distances.max(axis=1)
        beyond = np.linalg.norm(np.maximum(np.abs(errors) - half[:, None], 0.0), axis=-1)
        sums.squares += float((distances**2).sum())
        sums.products += float((errors[1:] * errors[:-1]).sum())
        sums.neighbours += np.array([(errors[:-1] ** 2).sum(), (errors[1:] ** 2).sum()])
    sums.rows += len(errors)
    sums.rounding = max(sums.rounding, float(rows.rounding.max()))
    sums.pairs += len(errors) - 1
    sums.last[throw] = float(largest[-1])
    row, vertex = np.unravel_index(int(np.argmax(distances)), distances.shape)
    if distances[row, vertex] > sums.worst[0]:
        sums.worst = float(distances[row, vertex]), float(rows.times[row]), throw, int(vertex)
    sums.half = max(sums.half, float(np.linalg.norm(half, axis=1).max()))
    sums.excess = max(sums.excess, float(beyond.max()))
    if len(sums.last) == 1:
        sums.intervals += np.diff(rows.times[: max(SPACED - len(sums.intervals), 0)]).tolist()
    bins = np.minimum((rows.times / duration * BINS).astype(int), BINS - 1)
    np.fmax.at(sums.over_time, bins, largest)


def _see_lengths(sums: _Sums, block: Block) -> None:
    if QUATERNION[0] in block.values:
        lengths = np.linalg.norm(block.of(QUATERNION), axis=1)
        least, most = sums.lengths or (np.inf, 0.0)
        sums.lengths = min(least, float(lengths.min())), max(most, float(lengths.max()))


def half_digits(trajectory: Trajectory, rows: Block, shown: Shown, scene: Scene, states: Array) -> Array:
    """Return how far a vertex moves along each axis when every number is half a last digit off [m], (n, 3)."""

    def half(names: Sequence[str]) -> Array:
        return np.stack([trajectory.half_digits(name, rows.values[name]) for name in names], axis=1)

    reach, late = scene.body.reach, moved_by(rows.rounding, states, scene)[:, None]
    if shown.kind == "vertices":
        places = [[f"v{number}{axis}" for axis in "xyz"] for number in shown.vertices]
        return late + np.max([half(place) for place in places], axis=0)
    late = late + half(CENTRE) if shown.centred else np.broadcast_to(late, (len(late), 3))
    if shown.kind == "matrix":
        return late + reach * np.linalg.norm(half(MATRIX), axis=1)[:, None]
    # A change dq of a unit quaternion turns by 2 |dq|.
    return late + 2 * reach * np.linalg.norm(half(QUATERNION), axis=1)[:, None]


def moved_by(late: Array, states: Array, scene: Scene) -> Array:
    """Return how far a vertex moves at most in a short time [s], (n,), from states, (n, 13), before it or after [m].

    Its speed, and half of its acceleration: of a spin w that is |w|^2 about the axis, and as much again as w changes.
    """
    spin = np.linalg.norm(states[:, 10:13], axis=1)
    speed = np.linalg.norm(states[:, 7:10], axis=1) + scene.body.reach * spin
    gravity = 0.0 if scene.gravity is None else float(np.linalg.norm(scene.gravity))
    return speed * late + (gravity + 2 * scene.body.reach * spin**2) * late**2 / 2


def _check_agreement(trajectory: Trajectory, rows: Block, scene: Scene, half: Array, slack: float) -> None:
    """Raise BadTrajectory where a file says in two ways where the body is, and the two differ.

    half: what the digits leave open [m], (R,); slack: how far the two may differ, of the distances they are made of.
    """
    first, *others = trajectory.shown
    for other in others:
        at = list(other.vertices if first.kind != "vertices" else first.vertices)
        one = vertices_of(rows, first, scene, stretched=False)
        two = vertices_of(rows, other, scene, stretched=False)[:, at]
        apart = np.linalg.norm(one - two, axis=-1).max(axis=1)
        far = float(np.abs(one).max()) + TURNED * scene.body.reach
        room = 4 * half + slack * far
        if (apart > room).any():
            row = int(np.argmax(apart - room))
            raise BadTrajectory(
                f"{trajectory.name}: line {rows.lines[row]}: its {first.kind} and its {other.kind} are "
                f"{apart[row]:.2g} m apart: which is to be graded? --by {first.kind} or --by {other.kind}"
            )


def _single(trajectory: Trajectory) -> bool:
    """Whether the centre, the attitude or the corners are numbers of single precision, as far as figures can tell.

    What an engine in single precision did not turn by itself, its program may have worked out in doubles as it wrote.
    """
    printed = [[trajectory.digits[name] for name in group] for group in trajectory.places()]
    return any(any(one.telling for one in group) and all(one.single for one in group) for group in printed)
