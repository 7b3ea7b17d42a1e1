"""Errors of a trajectory against the reference: over all rows, a block at a time, and a subsample for the diagnosis."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tumble.compare.grade.measure.conserved import Conserved
from tumble.compare.grade.measure.significance import FEWEST_ROWS, LARGE_FLOOR
from tumble.compare.grade.model.reference import Reference, ReferenceEnds
from tumble.compare.grade.read.block import Block, vertices_of
from tumble.compare.grade.read.columns import ANGLES, CENTRE, MATRIX, QUATERNION, SPIN, BadTrajectory, Description
from tumble.compare.grade.read.digits import Digits
from tumble.compare.grade.read.even_clock import EXACT, EvenClock
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.compare.run.progress import Progress, ProgressCallback, no_progress
from tumble.scenarios.frames import Array, vertices
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import NoTruth

# Sampled rows of the throw that is diagnosed: at least this many if the file has them, at most twice as many.
SAMPLE_SIZE = 256
ALL_OF_FIRST = 16
GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0
BINS = 60
# Largest difference of two descriptions of a pose, relative to the largest coordinate; in single precision, four last
# bits.  For each of a quaternion's four components, the same of the body's reach: engines let its length drift.
ALIKE, SINGLES_ALIKE, TURNED = 1e-9, 4 * 2.0**-23, 4
# First rows that decide the clock, and how much smoother errors must be with the printed clock.
FIRST_ROWS, SMOOTHER = 200, 0.1
# An error that exceeds the rounding of the digits by less than this factor is their rounding.
SLIGHTLY = 1.1
# Row intervals that determine the row spacing.
SPACED = 10_000


@dataclass(frozen=True, eq=False)
class SampledRows:
    """A subsample of the rows of one throw, evenly spread, with the first row.

    times [s], (S,); vertices: in the file [m], (S, K, 3), scaled by a quaternion that is not of unit length; true:
    reference; half: shift of a vertex along each axis if every printed number is off by half a unit in its last digit
    [m], (S, 3); spins: w in the file [rad/s], (S, 3), or None; resolution: of the reference [m], (S,), or None.
    """

    times: Array
    vertices: Array
    true: Array
    half: Array
    spins: Array | None
    resolution: Array | None = None

    def __len__(self) -> int:
        return len(self.times)

    def some(self, rows: np.ndarray | slice) -> "SampledRows":
        """Return some of the rows."""
        return SampledRows(*(None if each is None else each[rows] for each in self._arrays()))  # type: ignore[arg-type]

    def joined(self, other: "SampledRows") -> "SampledRows":
        """Return these rows followed by others."""
        pairs = zip(self._arrays(), other._arrays(), strict=True)
        return SampledRows(*(None if a is None or b is None else np.concatenate((a, b)) for a, b in pairs))  # type: ignore[arg-type]

    def _arrays(self) -> tuple[Array | None, ...]:
        return self.times, self.vertices, self.true, self.half, self.spins, self.resolution


class Subsampler:
    """Samples a stream of rows: all until there are too many, then half of them, a quarter, ...

    The golden ratio decides which: evenly spread, and out of phase with anything periodic in a program.  The first rows
    are all sampled.
    """

    def __init__(self) -> None:
        self._share, self._seen, self._turns, self.sample = 1.0, 0, np.empty(0), None

    def add(self, rows: SampledRows) -> None:
        """Add the next rows."""
        numbers = np.arange(self._seen, self._seen + len(rows))
        turns = np.where(numbers < ALL_OF_FIRST, 0.0, numbers * GOLDEN % 1.0)
        self._seen += len(rows)
        self._take(rows, turns)
        while len(self._turns) > 2 * SAMPLE_SIZE:
            self._share /= 2
            sample, self.sample, turns, self._turns = self.sample, None, self._turns, np.empty(0)
            assert sample is not None
            self._take(sample, turns)

    def _take(self, rows: SampledRows, turns: Array) -> None:
        chosen = np.flatnonzero(turns < self._share)
        self._turns = np.append(self._turns, turns[chosen])
        self.sample = rows.some(chosen) if self.sample is None else self.sample.joined(rows.some(chosen))


def golden_subsample(count: int, most: int) -> np.ndarray:
    """Return the indices of about `most` of `count` rows, with the first, evenly spread but out of phase with all."""
    return np.flatnonzero(np.arange(count) * GOLDEN % 1.0 < most / count) if count > most else np.arange(count)


@dataclass(eq=False)
class Measured:
    """The errors of a whole trajectory.

    Parameters
    ----------
    description : columns that the pose is read from
    rows : number of rows
    throws : number of throws
    spacing_s : interval between most neighbouring rows [s]
    intervals : intervals between the first rows [s], (n,)
    rounding_s : rounding of the printed times [s]
    worst_m : largest error of a vertex [m]
    worst_t_s : time of the largest error [s]
    worst_throw : throw of the largest error
    worst_vertex : vertex of the largest error
    rms_m : root mean square error over vertices and rows [m]
    final_m : largest error in the last row of a throw [m]
    half_m : largest error that the printed digits allow [m]
    excess_m : largest error beyond the printed digits and the resolution [m]
    resolution_m : resolution of the reference solution [m]
    over_time_m : largest error in each of equal parts of the duration [m], (BINS,); nan in a part without rows
    autocorrelation : correlation of the errors of neighbouring rows; 0 for noise, 1 for a drift
    pairs : number of pairs of neighbouring rows
    lengths : length of the shortest and of the longest quaternion; None: there are no quaternions
    single : whether the pose is of single precision
    may_be_single : whether the pose is, or may be, of single precision: no number in it refutes that
    drifts : of energy, momentum and angular momentum, as in `tumble.compare.judge.errors`; None: unknown
    by_differences : whether the drifts come from differences of poses
    throw : throw that the sample is of, the one with the largest error
    sample : sampled rows of this throw
    ends : why later rows are not graded, a sentence; empty: all are
    """

    description: Description
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
    autocorrelation: float
    pairs: int
    lengths: tuple[float, float] | None
    single: bool
    may_be_single: bool
    drifts: tuple[float, float, float] | None
    by_differences: bool
    throw: int
    sample: SampledRows
    ends: str = ""


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
    """Measure the error of every row, up to where the reference is known.

    Parameters
    ----------
    trajectory, scene : the file and the scene that it is graded against
    on_progress : called with the shares of the rows, and of the truth

    Returns
    -------
    the errors

    Raises
    ------
    BadTrajectory : a row cannot be read
    NoTruth : the scene has no reference solution at more than the first row
    """
    reference, ends = Reference(scene), ""
    _choose_clock(trajectory, reference, scene)
    reading, working = Progress("rows", on_progress), Progress(f"{scene.name} truth", on_progress)
    while True:
        try:
            return replace(_measured(trajectory, scene, reference, reading, working), ends=ends)
        except ReferenceEnds as end:
            if not 0.0 < end.until < reference.horizon(end.throw):
                raise
            reference.end(end.throw, end.until)
            ends = f"Rows after t = {end.until:.6g} s are not graded, for there the reference ends: {end.why}."


def _measured(
    trajectory: Trajectory, scene: Scene, reference: Reference, reading: Progress, working: Progress
) -> Measured:
    """Return the errors of rows up to where the reference is known.  Raises BadTrajectory, ReferenceEnds, NoTruth.

    reading, working: progress of the rows and of the truth, which may have been told before.
    """
    description = trajectory.descriptions[0]
    sums, conserved, single = _Sums(), Conserved(scene, description), _is_single(trajectory)
    slack = SINGLES_ALIKE if single else ALIKE
    subsamplers: dict[int, Subsampler] = {}
    for block in trajectory.blocks():
        _add_lengths(sums, block)
        for throw in np.unique(block.throws).tolist():
            rows = _known(block.throw(throw), reference, throw)
            if not len(rows.times):
                continue
            states = reference.states(throw, rows.times)
            true = _true_vertices(states, description, scene)
            half = half_digits(trajectory, rows, description, scene, states)
            _add(sums, rows, vertices_of(rows, description, scene, stretched=False), true, half, throw, scene.duration)
            _check_agreement(trajectory, rows, scene, np.linalg.norm(half, axis=1), slack)
            conserved.add(rows, states)
            if not subsamplers or throw in subsamplers:
                subsamplers.setdefault(throw, Subsampler()).add(_sampled(rows, description, scene, true, half))
        reading(trajectory.share)
    reading.end()
    if not sums.rows:
        raise NoTruth(f"{trajectory.name}: the reference solution of {scene.name} ends before the first row")
    worst_m, worst_t_s, worst_throw, worst_vertex = sums.worst
    if worst_throw not in subsamplers:
        subsamplers = {worst_throw: _resampled(trajectory, scene, reference, worst_throw)}
    diagnosed, sample = worst_throw, subsamplers[worst_throw].sample
    assert sample is not None
    resolution = reference.resolution(diagnosed, sample.times, working)
    sample, resolution_m = replace(sample, resolution=resolution), float(resolution[-1])
    if sums.excess <= resolution_m:
        _check_resolution(sample, diagnosed, scene)
    working.end()
    return Measured(
        description=description,
        rows=sums.rows,
        throws=len(sums.last),
        spacing_s=float(np.median(sums.intervals)) if sums.intervals else scene.duration,
        intervals=np.array(sums.intervals),
        rounding_s=sums.rounding,
        worst_m=worst_m,
        worst_t_s=worst_t_s,
        worst_throw=worst_throw,
        worst_vertex=description.vertices[worst_vertex],
        rms_m=float(np.sqrt(sums.squares / (sums.rows * len(description.vertices)))),
        final_m=max(sums.last.values()),
        half_m=sums.half,
        excess_m=sums.excess - resolution_m,
        resolution_m=resolution_m,
        over_time_m=sums.over_time,
        autocorrelation=sums.products / float(np.sqrt(sums.neighbours.prod())) if sums.neighbours.all() else 0.0,
        pairs=sums.pairs,
        lengths=sums.lengths,
        single=single,
        may_be_single=single or _may_be_single(trajectory),
        drifts=conserved.drifts(),
        by_differences=conserved.by_differences,
        throw=diagnosed,
        sample=sample,
    )


def size_of(scene: Scene) -> float:
    """Return the largest edge of a box around the body [m]."""
    return float(np.ptp(scene.body.points, axis=0).max())


def _check_resolution(sample: SampledRows, throw: int, scene: Scene) -> None:
    """Raise ReferenceEnds where the resolution becomes so large that it hides any error, if enough rows are before.

    sample: rows whose errors are all within the resolution at the last one.
    """
    assert sample.resolution is not None
    small = sample.resolution <= LARGE_FLOOR * size_of(scene)
    if not small.all() and small.sum() >= FEWEST_ROWS:
        until, last = float(sample.times[small][-1]), float(sample.times[-1])
        why = f"at t = {last:.6g} s it is accurate only to {sample.resolution[-1]:.2g} m"
        raise ReferenceEnds(throw, until, why)


def _choose_clock(trajectory: Trajectory, reference: Reference, scene: Scene) -> None:
    """Take times as exact if the errors of rows are far smoother with them than with an even clock.

    A program that rounds its times first moves the body to the rounded times; most round only what they print.
    """
    if not isinstance(trajectory.clock, EvenClock):
        return
    clock, even = trajectory.clock, _unevenness(trajectory, reference, scene)
    trajectory.clock = EXACT
    if not _unevenness(trajectory, reference, scene) < SMOOTHER * even:
        trajectory.clock = clock


def _unevenness(trajectory: Trajectory, reference: Reference, scene: Scene) -> float:
    """Return the median second difference of the errors of the first rows [m]; 0 for too few rows."""
    block = next(trajectory.blocks())
    throw = int(block.throws[0])
    rows = _known(block.throw(throw).some(slice(FIRST_ROWS)), reference, throw)
    errors = vertices_of(rows, trajectory.descriptions[0], scene) - _true_vertices(
        reference.states(throw, rows.times), trajectory.descriptions[0], scene
    )
    bends = np.linalg.norm(np.diff(errors, 2, axis=0), axis=-1)
    return float(np.median(bends)) if bends.size else 0.0


def _known(rows: Block, reference: Reference, throw: int) -> Block:
    """Return the rows up to where the reference ends."""
    known = rows.times <= reference.horizon(throw)
    return rows if known.all() else rows.some(known)


def _true_vertices(states: Array, description: Description, scene: Scene) -> Array:
    """Return the true vertices [m], (n, K, 3), as `vertices_of` returns those in the file."""
    places = vertices(states, scene.body.points)[:, description.vertices]
    return places if description.has_centre else places - states[:, None, 0:3]


def _sampled(rows: Block, description: Description, scene: Scene, true: Array, half: Array) -> SampledRows:
    spins = rows.of(SPIN) if description.spin else None
    return SampledRows(rows.times, vertices_of(rows, description, scene), true, half, spins)


def _resampled(trajectory: Trajectory, scene: Scene, reference: Reference, throw: int) -> Subsampler:
    """Return a subsample of one throw's rows, reading the file a second time."""
    subsamplers, description = Subsampler(), trajectory.descriptions[0]
    for block in trajectory.blocks():
        rows = _known(block.throw(throw), reference, throw)
        if len(rows.times):
            states = reference.states(throw, rows.times)
            true = _true_vertices(states, description, scene)
            subsamplers.add(
                _sampled(rows, description, scene, true, half_digits(trajectory, rows, description, scene, states))
            )
    return subsamplers


def _add(
    sums: _Sums, rows: Block, vertices_in_file: Array, true: Array, half: Array, throw: int, duration: float
) -> None:
    """Add one throw's rows of a block; vertices_in_file, true: [m], (n, K, 3)."""
    errors = vertices_in_file - true
    with np.errstate(over="ignore"):
        distances = np.linalg.norm(errors, axis=-1)
        largest = distances.max(axis=1)
        beyond = np.linalg.norm(np.maximum(np.abs(errors) - SLIGHTLY * half[:, None], 0.0), axis=-1)
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


def _add_lengths(sums: _Sums, block: Block) -> None:
    if QUATERNION[0] in block.values:
        lengths = np.linalg.norm(block.of(QUATERNION), axis=1)
        least, most = sums.lengths or (np.inf, 0.0)
        sums.lengths = min(least, float(lengths.min())), max(most, float(lengths.max()))


def half_digits(trajectory: Trajectory, rows: Block, description: Description, scene: Scene, states: Array) -> Array:
    """Return the shift of a vertex along each axis if every number is off by half a last digit [m], (n, 3)."""

    def half(names: Sequence[str]) -> Array:
        return np.stack([trajectory.half_digits(name, rows.values[name]) for name in names], axis=1)

    reach, late = scene.body.reach, moved_by(rows.rounding, states, scene)[:, None]
    if description.kind == "vertices":
        places = [[f"v{number}{axis}" for axis in "xyz"] for number in description.vertices]
        return late + np.max([half(place) for place in places], axis=0)
    late = late + half(CENTRE) if description.has_centre else np.broadcast_to(late, (len(late), 3))
    if description.kind == "matrix":
        return late + reach * np.linalg.norm(half(MATRIX), axis=1)[:, None]
    # A change dq of a unit quaternion is a rotation by 2 |dq|.
    return late + 2 * reach * np.linalg.norm(half(QUATERNION), axis=1)[:, None]


def moved_by(late: Array, states: Array, scene: Scene) -> Array:
    """Return an upper bound of the distance that a vertex moves in a short time [s], (n,), from states, (n, 13), in m.

    The speed, and half of the acceleration: for an angular velocity w that is |w|^2 about the axis, and as much again
    for the change of w.
    """
    spin = np.linalg.norm(states[:, 10:13], axis=1)
    speed = np.linalg.norm(states[:, 7:10], axis=1) + scene.body.reach * spin
    gravity = 0.0 if scene.gravity is None else float(np.linalg.norm(scene.gravity))
    return speed * late + (gravity + 2 * scene.body.reach * spin**2) * late**2 / 2


def _check_agreement(trajectory: Trajectory, rows: Block, scene: Scene, half: Array, slack: float) -> None:
    """Raise BadTrajectory if two descriptions of the pose differ.

    half: uncertainty from the printed digits [m], (R,); slack: allowed difference relative to the distances.
    """
    first, *others = trajectory.descriptions
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
                f"{apart[row]:.2g} m apart: choose one: --by {first.kind} or --by {other.kind}"
            )


def _is_single(trajectory: Trajectory) -> bool:
    """Whether the position, the attitude or the vertices are of single precision, as far as the digits show it.

    One group is enough: a program may convert the others in double precision when it writes them.
    """
    return any(one.is_decisive for one in _unrefuted(trajectory).values())


def _may_be_single(trajectory: Trajectory) -> bool:
    """Whether no number of the position, the attitude or the vertices refutes that they are of single precision.

    Vertices, matrices, angles and lengths in another unit are computed when they are written, perhaps in double
    precision; beside angles the centre counts.  If the quaternion refutes it, the centre counts only if it could do so
    too: the round numbers of a free flight from round values could not.  So does one coordinate, if others refute it:
    they may be in other axes, into which a program turns them when it writes.
    """
    columns, unrefuted = trajectory.columns, _unrefuted(trajectory)
    centre = [name for name in CENTRE if name in columns]
    is_computed = trajectory.descriptions[0].kind in ("vertices", "matrix")
    if is_computed or any(columns[name].factor != 1.0 for name in centre):
        return True
    if any(each.single and each.is_telling and each.place for each in (trajectory.digits[name] for name in centre)):
        return True
    if ANGLES[0] in columns:
        return all(name in unrefuted for name in centre)
    if QUATERNION[0] in columns and unrefuted.keys() <= set(CENTRE):
        return any(one.is_telling for one in unrefuted.values())
    return any(one.place or one.is_telling for one in unrefuted.values())


def _unrefuted(trajectory: Trajectory) -> dict[str, Digits]:
    """Return the print formats of the groups of columns in which every number may be of single precision."""
    digits = trajectory.digits
    groups = [group for group in trajectory.places() if all(digits[name].single for name in group)]
    return {name: digits[name] for group in groups for name in group}
