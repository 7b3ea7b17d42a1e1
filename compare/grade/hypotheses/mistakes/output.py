"""Mistakes in the output: numbers in another order, an inverse, another centre, other axes."""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import Context, Hypothesis, choice, grid
from tumble.compare.grade.hypotheses.mistakes.axes import axis_names, signed_permutations
from tumble.compare.grade.hypotheses.names import FLOOR_AT_ZERO
from tumble.compare.grade.model.program_model import (
    OutputTransform,
    Pose,
    ProgramModel,
    output_points,
    with_output_transform,
)
from tumble.scenarios.frames import Array, quaternion_product, rotation_matrix

EARTH_RAD_S = 7.292115e-5
UNITS = {
    "cm for m": 100.0, "mm for m": 1000.0, "km for m": 1e-3, "feet for m": 1 / 0.3048, "inches for m": 1 / 0.0254,
    "m for cm": 0.01, "m for feet": 0.3048,
}  # fmt: skip
MOST_VERTICES = 8
# Weight by which a floor that stops a body is likelier than a height that is only written as 0.
STOPS_LIKELIER = 2.0
# Parts of a program whose mistakes change the output only, not the run.
OUTPUT_PARTS = frozenset(
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
        "written height",
    }
)


def output(context: Context) -> Iterator[Hypothesis]:
    """Yield mistakes in the output of a correct run; first those that need the quaternion itself."""
    yield from _quaternion_orders()
    yield Hypothesis(
        "attitude-inverted",
        "conjugate",
        "attitude inverted: quaternion conjugated, or matrix transposed (world to body)",
        lambda program, _: with_output_transform(program, _inverted),
    )
    yield Hypothesis(
        "rotation-about-origin",
        "pivot",
        "vertex not relative to the centre of mass: the body rotates about the world's origin",
        lambda program, _: with_output_transform(program, _about_origin(program)),
    )
    yield from _logged_points(context)
    yield from _heights(context)
    yield from _length_units(context)
    yield Hypothesis(
        "half-angle-missing",
        "half angle",
        "quaternion made from the whole angle, not half of it: rotated twice as far",
        lambda program, _: with_output_transform(program, lambda pose: pose._replace(axes=pose.axes @ pose.axes)),
    )
    yield from _rotating_axes(context)
    yield from _wrong_axes(context)
    yield from _half_converted(context)
    yield from _wrong_body_axes(context)


def _heights(context: Context) -> Iterator[Hypothesis]:
    """Yield that no negative height of the centre is written, if it would be."""
    if (up := context.up_from_below) is not None:
        yield Hypothesis(
            FLOOR_AT_ZERO,
            "written height",
            "a negative height of the centre written as 0: it moves on below",
            lambda program, _: with_output_transform(program, _above_zero(up)),
            unlikely=STOPS_LIKELIER,
        )


def _above_zero(up: Array) -> OutputTransform:
    """Return a pose whose centre is at no negative height."""

    def write(pose: Pose) -> Pose:
        return pose._replace(x=pose.x + np.maximum(-pose.x @ up, 0.0)[:, None] * up)

    return write


def _quaternion_orders() -> Iterator[Hypothesis]:
    for name, text, order in (
        ("quaternion-xyzw-read-as-wxyz", "quaternion written as x y z w and read as w x y z", (1, 2, 3, 0)),
        ("quaternion-wxyz-read-as-xyzw", "quaternion written as w x y z and read as x y z w", (3, 0, 1, 2)),
    ):
        transform = _reordered(order)
        yield Hypothesis(
            name,
            "quaternion order",
            text,
            lambda program, _, transform=transform: with_output_transform(program, transform),
        )
    # Without a mirror they are other axes of the attitude; all three reversed are the conjugate quaternion.
    mirrors = [names for names in signed_permutations(-1) if (names != -np.eye(3)).any()]
    yield Hypothesis(
        "quaternion-vector-mirrored",
        "quaternion order",
        "signs or order of the quaternion's vector: x y z replaced by {}",
        lambda program, number: with_output_transform(program, _vector_in_axes(mirrors[int(number)])),
        choice(len(mirrors)),
        tuple(map(axis_names, mirrors)),
    )


def _logged_points(context: Context) -> Iterator[Hypothesis]:
    """Yield that another point of the body was logged instead of the centre of mass."""
    points = output_points(context.scene.body)
    nothing = (0.0, 0.0, 0.0)
    # One that was measured explains the centre in every row, whatever else is wrong.
    values = (nothing,) if context.offset is None else (nothing, tuple(context.offset.tolist()))
    if context.has_centre:
        yield Hypothesis(
            "constant-offset-in-body-axes",
            "logged point",
            "the point ({}) m in body axes logged instead of the centre of mass",
            lambda program, at: with_output_transform(program, _with_offset(np.array(at))),
            values,
            unit="m",
            scale=float(np.abs(points).max()),
            vague=context.offset is None,
            measured=context.offset is not None,
        )
    if context.kind == "vertices" or not 0 < len(points) <= MOST_VERTICES:
        return
    places = [(f"vertex {number}", point) for number, point in enumerate(points)]
    if (size := context.scene.body.size) is not None:  # of a box, which has faces
        for axis, centre in zip("xyz", np.diag(size / 2), strict=True):
            places += [(f"the centre of the face at {sign}{axis}", way * centre) for sign, way in (("+", 1), ("-", -1))]
    yield Hypothesis(
        "wrong-point-logged",
        "logged point",
        "{} logged instead of the centre of mass",
        lambda program, number: with_output_transform(program, _with_offset(places[int(number)][1])),
        choice(len(places)),
        tuple(name for name, _ in places),
    )


def _with_offset(point: Array) -> OutputTransform:
    return lambda pose: pose._replace(x=pose.x + pose.axes @ point)


def _length_units(context: Context) -> Iterator[Hypothesis]:
    """Yield that lengths are in another unit than the column name says, or of vertices only how far the centre is."""
    names, sizes = tuple(UNITS), tuple(UNITS.values())

    def written(number: float, whole: bool) -> OutputTransform:
        size = sizes[int(number)]
        return lambda pose: pose._replace(x=size * pose.x, axes=size * pose.axes if whole else pose.axes)

    if not context.has_centre:
        return
    of_vertices = context.kind == "vertices"
    for whole in (True, False) if of_vertices else (False,):
        of_the_centre = " of the centre" if of_vertices and not whole else ""
        yield Hypothesis(
            "wrong-length-unit",
            "unit",
            f"positions{of_the_centre} in the wrong unit: {{}}",
            lambda program, number, whole=whole: with_output_transform(program, written(number, whole)),
            choice(len(names)),
            names,
        )


def _half_converted(context: Context) -> Iterator[Hypothesis]:
    """Yield that only the position, or only the attitude, was converted to other axes."""
    if not context.has_centre:
        return
    for name, text, centre in (
        ("position-only-in-wrong-axes", "position, but not attitude, in wrong axes: x y z replaced by {}", True),
        ("attitude-only-in-wrong-axes", "attitude, but not position, in wrong axes: x y z replaced by {}", False),
    ):
        # A mirrored attitude equals one in other axes: the rotation axis is reversed as well.
        matrices = [*(signed_permutations(-1) if centre else ()), *signed_permutations(1)]
        output_transforms = [_partly_in_axes(names, centre) for names in matrices]
        yield Hypothesis(
            name,
            "axes",
            text,
            lambda program, number, output_transforms=output_transforms: with_output_transform(
                program, output_transforms[int(number)]
            ),
            choice(len(matrices)),
            tuple(map(axis_names, matrices)),
        )


def _partly_in_axes(names: Array, centre: bool) -> OutputTransform:
    if centre:
        return lambda pose: pose._replace(x=pose.x @ names.T)
    return lambda pose: pose._replace(axes=names @ pose.axes @ names.T)


def _wrong_body_axes(context: Context) -> Iterator[Hypothesis]:
    """Yield that the body has other axes: the vertices of its mirror image, or permuted edges."""
    determinants = (-1, 1) if context.kind == "vertices" else (1,)
    points = output_points(context.scene.body)
    matrices = [names for determinant in determinants for names in signed_permutations(determinant)]
    # A box is its own mirror image except for the numbers of its vertices.
    matrices = [names for names in matrices if not np.allclose(points @ names.T, points)]
    yield Hypothesis(
        "wrong-body-axes",
        "body axes",
        "body axes permuted or mirrored: x y z replaced by {}",
        lambda program, number: with_output_transform(program, _in_body_axes(matrices[int(number)])),
        choice(len(matrices)),
        tuple(map(axis_names, matrices)),
    )


def _in_body_axes(names: Array) -> OutputTransform:
    return lambda pose: pose._replace(axes=pose.axes @ names)


def _rotating_axes(context: Context) -> Iterator[Hypothesis]:
    rates = grid(1e-4 / context.duration, 3 / context.duration, 7)
    for number, axis in enumerate("xyz"):
        yield Hypothesis(
            "rotating-axes",
            "turning axes",
            f"output in axes that rotate about {axis} at {{}} rad/s",
            lambda program, rate, number=number: with_output_transform(program, _rotating(number, rate)),
            (*(-rate for rate in reversed(rates)), *rates),
            named_values={EARTH_RAD_S: "the Earth", -EARTH_RAD_S: "the Earth, reversed"},
            unit="rad/s",
            neutral=0.0,
            vague=True,
        )


def _wrong_axes(context: Context) -> Iterator[Hypothesis]:
    # Vertices may be converted themselves, or computed from a pose that was.
    of_vertices = (("", True), (", before the vertices are computed", False))
    for (name, text, determinant), (when, is_of_vertices) in product(
        (
            ("left-handed-axes", "left-handed axes: x y z replaced by {}", -1),
            ("wrong-axes", "wrong axes: x y z replaced by {}", 1),
        ),
        of_vertices if context.kind == "vertices" else (("", False),),
    ):
        renamings = [_in_axes(axes, is_of_vertices) for axes in signed_permutations(determinant)]
        yield Hypothesis(
            name,
            "axes",
            text + when,
            lambda program, number, renamings=renamings: with_output_transform(program, renamings[int(number)]),
            choice(len(renamings)),
            tuple(map(axis_names, signed_permutations(determinant))),
        )


def _reordered(order: Sequence[int]) -> OutputTransform:
    """Return a pose with the components of its quaternion in another order."""

    def write(pose: Pose) -> Pose:
        q = pose.q[:, list(order)]
        square = (q * q).sum(axis=1)
        axes = square[:, None, None] * rotation_matrix(q / np.sqrt(square)[:, None])
        return pose._replace(axes=axes)

    return write


def _vector_in_axes(names: Array) -> OutputTransform:
    """Return a pose with the vector of its quaternion in other axes."""

    def write(pose: Pose) -> Pose:
        q = np.hstack((pose.q[:, :1], pose.q[:, 1:] @ names.T))
        square = (q * q).sum(axis=1)
        return pose._replace(q=q, axes=square[:, None, None] * rotation_matrix(q / np.sqrt(square)[:, None]))

    return write


def _inverted(pose: Pose) -> Pose:
    return pose._replace(axes=np.swapaxes(pose.axes, 1, 2))


def _about_origin(program: ProgramModel) -> OutputTransform:
    """Return a pose that rotates about the origin: x(t) = R(t) R(0)^T x(0) + displacement."""
    start = program.start
    at_first = rotation_matrix(quaternion_product(start[3:7], program.body.file_axes)).T @ start[0:3]
    return lambda pose: pose._replace(x=pose.axes @ at_first + pose.x - start[0:3])


def _rotating(axis: int, rate: float) -> OutputTransform:
    """Return a pose in axes that rotate about one of them [rad/s]."""
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


def _in_axes(names: Array, vertices: bool) -> OutputTransform:
    """Return a pose in other world axes, x -> A x, by a signed permutation A.

    Vertices become A R p.  In a pose the body's axes change as well, A R A^T.
    """
    order, signs = np.abs(names).argmax(axis=1), names.sum(axis=1)
    columns, column_signs = (np.arange(3), np.ones(3)) if vertices else (order, signs)
    turned, both_signs = order[:, None], signs[:, None] * column_signs

    def write(pose: Pose) -> Pose:
        return pose._replace(x=pose.x[:, order] * signs, axes=pose.axes[:, turned, columns] * both_signs)

    return write
