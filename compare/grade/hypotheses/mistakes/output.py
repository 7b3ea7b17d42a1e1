"""Mistakes in what is written down: numbers in another order, an inverse, another centre, other axes."""

from collections.abc import Iterator, Sequence

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import Hypothesis, Question, choice, grid
from tumble.compare.grade.hypotheses.mistakes.axes import axis_names, signed_permutations
from tumble.compare.grade.model.program_model import Pose, Writing, with_writing
from tumble.scenarios.frames import Array, rotation_matrix

EARTH_RAD_S = 7.292115e-5
UNITS = {
    "cm for m": 100.0, "mm for m": 1000.0, "km for m": 1e-3, "feet for m": 1 / 0.3048, "inches for m": 1 / 0.0254,
    "m for cm": 0.01, "m for feet": 0.3048,
}  # fmt: skip
BOX_CORNERS = 8
# Whose mistakes need no other flight: the same poses are written otherwise.
WRITTEN = frozenset(
    {
        "quaternion order",
        "conjugate",
        "half angle",
        "pivot",
        "logged point",
        "unit",
        "turning axes",
        "axes",
        "body axes",
    }
)


def writings(question: Question) -> Iterator[Hypothesis]:
    """Yield what is wrong with poses or vertices that were right; first what asks for the quaternion itself."""
    if question.kind == "pose":
        yield from _orders()
    yield Hypothesis(
        "conjugate",
        "conjugate",
        "attitude inverted: the quaternion conjugate, or the matrix transposed (world to body)",
        lambda account, _: with_writing(account, _inverted),
    )
    yield Hypothesis(
        "turned about the origin",
        "pivot",
        "vertex not taken from the centre of mass: the body turns about the world's origin",
        lambda account, _: with_writing(account, _about_origin(account.start)),
    )
    yield from _logged_points(question)
    yield from _units(question)
    yield Hypothesis(
        "half angle missing",
        "half angle",
        "quaternion made of the whole angle, not of half of it: turned twice as far",
        lambda account, _: with_writing(account, lambda pose: pose._replace(axes=pose.axes @ pose.axes)),
        rare=True,
    )
    yield from _turning_axes(question)
    yield from _renamed_axes(question)
    yield from _half_converted(question)
    yield from _mirrored(question)


def _orders() -> Iterator[Hypothesis]:
    for name, says, order in (
        ("quaternion order", "quaternion written x y z w and read w x y z", (1, 2, 3, 0)),
        ("quaternion order reversed", "quaternion written w x y z and read x y z w", (3, 0, 1, 2)),
    ):
        writing = _shuffled(order)
        yield Hypothesis(
            name, "quaternion order", says, lambda account, _, writing=writing: with_writing(account, writing)
        )
    # Without a mirror they are other axes of the attitude; all three reversed are the conjugate.
    mirrors = [names for names in signed_permutations(-1) if (names != -np.eye(3)).any()]
    yield Hypothesis(
        "quaternion's vector mirrored",
        "quaternion order",
        "signs or order of the quaternion's x y z: for them stand {}",
        lambda account, number: with_writing(account, _vector_renamed(mirrors[int(number)])),
        choice(len(mirrors)),
        tuple(map(axis_names, mirrors)),
        rare=True,
    )


def _logged_points(question: Question) -> Iterator[Hypothesis]:
    """Yield that another point of the body was logged for its centre of mass, where the centre is written."""
    points = question.scene.body.points
    if question.offset is not None:
        offset = question.offset
        yield Hypothesis(
            "constant offset in body axes",
            "logged point",
            f"the point ({', '.join(f'{value:.4g}' for value in offset)}) m in body axes logged for the centre of mass",
            lambda account, _: with_writing(account, _shifted(offset)),
            rare=True,
            taken=3,
        )
    if question.kind == "vertices" or len(points) != BOX_CORNERS:
        return
    corners = [(f"vertex {number}", point) for number, point in enumerate(points)]
    faces = [
        (f"the middle of the face at {sign}{axis}", 0.5 * sum(points[points[:, number] * (2 * up - 1) > 0]) / 2)
        for number, axis in enumerate("xyz")
        for up, sign in ((1, "+"), (0, "-"))
    ]
    places = corners + faces
    yield Hypothesis(
        "another point logged",
        "logged point",
        "{} logged for the centre of mass: a constant offset in body axes",
        lambda account, number: with_writing(account, _shifted(places[int(number)][1])),
        choice(len(places)),
        tuple(name for name, _ in places),
        rare=True,
    )


def _shifted(point: Array) -> Writing:
    return lambda pose: pose._replace(x=pose.x + pose.axes @ point)


def _units(question: Question) -> Iterator[Hypothesis]:
    """Yield that lengths are written in another unit than the column says."""
    names, sizes = tuple(UNITS), tuple(UNITS.values())
    whole = question.kind == "vertices"

    def written(number: float) -> Writing:
        size = sizes[int(number)]
        return lambda pose: pose._replace(x=size * pose.x, axes=size * pose.axes if whole else pose.axes)

    if question.centred:
        yield Hypothesis(
            "another unit of length",
            "unit",
            "places written in another unit: {}",
            lambda account, number: with_writing(account, written(number)),
            choice(len(names)),
            names,
            rare=True,
        )


def _half_converted(question: Question) -> Iterator[Hypothesis]:
    """Yield that axes were renamed of the centre only, or of the attitude only."""
    if question.kind == "vertices":
        return
    for name, says, centre in (
        ("only the centre in other axes", "only the centre is written in other axes: for x y z stand {}", True),
        ("only the attitude in other axes", "only the attitude is written in other axes: for x y z stand {}", False),
    ):
        # Of the attitude a mirror is no other than other axes: it turns round the axis of the turn as well.
        matrices = [*(signed_permutations(-1) if centre else ()), *signed_permutations(1)]
        writings = [_partly_renamed(names, centre) for names in matrices]
        yield Hypothesis(
            name,
            "axes",
            says,
            lambda account, number, writings=writings: with_writing(account, writings[int(number)]),
            choice(len(matrices)),
            tuple(map(axis_names, matrices)),
            rare=True,
        )


def _partly_renamed(names: Array, centre: bool) -> Writing:
    if centre:
        return lambda pose: pose._replace(x=pose.x @ names.T)
    return lambda pose: pose._replace(axes=names @ pose.axes @ names.T)


def _mirrored(question: Question) -> Iterator[Hypothesis]:
    """Yield that the body itself has other axes: vertices of its mirror image, or another order of its edges."""
    determinants = (-1, 1) if question.kind == "vertices" else (1,)
    points = question.scene.body.points
    matrices = [names for determinant in determinants for names in signed_permutations(determinant)]
    # A box is its own mirror image but for the numbers of its vertices.
    matrices = [names for names in matrices if not np.allclose(points @ names.T, points)]
    yield Hypothesis(
        "other body axes",
        "body axes",
        "the body's own axes are others (or mirrored): for its x y z stand {}",
        lambda account, number: with_writing(account, _of_body(matrices[int(number)])),
        choice(len(matrices)),
        tuple(map(axis_names, matrices)),
        rare=True,
    )


def _of_body(names: Array) -> Writing:
    return lambda pose: pose._replace(axes=pose.axes @ names)


def _turning_axes(question: Question) -> Iterator[Hypothesis]:
    rates = grid(1e-4 / question.duration, 3 / question.duration, 7)
    for number, axis in enumerate("xyz"):
        yield Hypothesis(
            "turning axes",
            "turning axes",
            f"written in axes that turn about {axis} at {{}} rad/s",
            lambda account, rate, number=number: with_writing(account, _turning(number, rate)),
            (*(-rate for rate in reversed(rates)), *rates),
            known={EARTH_RAD_S: "the Earth", -EARTH_RAD_S: "the Earth, the other way round"},
            unit="rad/s",
        )


def _renamed_axes(question: Question) -> Iterator[Hypothesis]:
    for name, says, determinant in (
        ("left-handed axes", "left-handed axes: for x y z stand {}", -1),
        ("other axes", "other axes: for x y z stand {}", 1),
    ):
        renamings = [_renamed(axes, question.kind == "vertices") for axes in signed_permutations(determinant)]
        yield Hypothesis(
            name,
            "axes",
            says,
            lambda account, number, renamings=renamings: with_writing(account, renamings[int(number)]),
            choice(len(renamings)),
            tuple(map(axis_names, signed_permutations(determinant))),
        )


def _shuffled(order: Sequence[int]) -> Writing:
    """Return how a pose is written whose quaternion's numbers come in another order."""

    def write(pose: Pose) -> Pose:
        q = pose.q[:, list(order)]
        square = (q * q).sum(axis=1)
        axes = square[:, None, None] * rotation_matrix(q / np.sqrt(square)[:, None])
        return pose._replace(axes=axes)

    return write


def _vector_renamed(names: Array) -> Writing:
    """Return how a pose is written whose quaternion has other numbers for its vector."""

    def write(pose: Pose) -> Pose:
        q = np.hstack((pose.q[:, :1], pose.q[:, 1:] @ names.T))
        square = (q * q).sum(axis=1)
        return pose._replace(q=q, axes=square[:, None, None] * rotation_matrix(q / np.sqrt(square)[:, None]))

    return write


def _inverted(pose: Pose) -> Pose:
    return pose._replace(axes=np.swapaxes(pose.axes, 1, 2))


def _about_origin(start: Array) -> Writing:
    """Return how a body is written that turns about the origin: x(t) = R(t) R(0)^T x(0) + what it has moved."""
    at_first = rotation_matrix(start[3:7]).T @ start[0:3]
    return lambda pose: pose._replace(x=pose.axes @ at_first + pose.x - start[0:3])


def _turning(axis: int, rate: float) -> Writing:
    """Return how a world is written whose axes turn about one of them [rad/s]."""
    first, second = (axis + 1) % 3, (axis + 2) % 3

    def write(pose: Pose) -> Pose:
        cos, sin = np.cos(rate * pose.times), np.sin(rate * pose.times)
        x, axes = pose.x.copy(), pose.axes.copy()
        x[:, first] = cos * pose.x[:, first] + sin * pose.x[:, second]
        x[:, second] = cos * pose.x[:, second] - sin * pose.x[:, first]
        cos, sin = cos[:, None], sin[:, None]
        axes[:, first] = cos * pose.axes[:, first] + sin * pose.axes[:, second]
        axes[:, second] = cos * pose.axes[:, second] - sin * pose.axes[:, first]
        return pose._replace(x=x, axes=axes)

    return write


def _renamed(names: Array, vertices: bool) -> Writing:
    """Return how a world with other axes is written, as x -> A x.

    Vertices are written as they are, A R p; of a pose the body's axes are renamed as well, A R A^T.
    """

    def write(pose: Pose) -> Pose:
        axes = names @ pose.axes
        return pose._replace(x=pose.x @ names.T, axes=axes if vertices else axes @ names.T)

    return write
