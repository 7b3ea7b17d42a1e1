"""The columns of a file: where each quantity is, and how the body's pose is described."""

from collections.abc import Mapping, Sequence

from tumble.compare.grade.read.columns import (
    ACCELEROMETER,
    CENTRE,
    GYRO,
    IGNORED,
    MATRIX,
    QUATERNION,
    READINGS,
    SPIN,
    TIME,
    UNITS,
    VELOCITY,
    VERTEX,
    AmbiguousAngles,
    AmbiguousFile,
    BadTrajectory,
    Column,
    Description,
    Suggestion,
    dimension,
    parsed,
)
from tumble.compare.grade.read.suggestions import (
    COUNTED_SCALAR,
    angles_of,
    counted_quaternion,
    is_angle,
    likely_names,
    map_option,
    map_options,
)
from tumble.scenarios.format import nearest, printable, short

COUNTED_FROM_0 = tuple(f"r{row}{column}" for row in "012" for column in "012")
# Column names, and characters of a list of them, that fit into one line.
MOST_LISTED = 8
MOST_NEAR = 200


def layout(
    file: str, header: Sequence[str], mapping: Mapping[str, str], with_readings: bool = False
) -> dict[str, Column]:
    """Return the column of each quantity.

    mapping: column -> name, or `ignore`; with_readings: sensor readings are read, too.  Raises BadTrajectory for an
    unknown name and for an ambiguous file.
    """
    for column, name in mapping.items():
        if column not in header:
            near = nearest(column, [printable(name) for name in header])
            near = near if len(near) <= MOST_NEAR else f"{near[:MOST_NEAR]}..."
            raise BadTrajectory(f"{file}: no column {short(column)} to map: {near}")
        if name != IGNORED and parsed(name) is None:
            raise BadTrajectory(f"{file}: {short(column)} = {short(name)}: {_allowed(name)}")
    found: dict[str, Column] = {}
    for index, column in enumerate(header):
        meaning = parsed(mapping.get(column, column))
        if meaning is None:
            continue
        quantity, factor = meaning
        if quantity in READINGS and not with_readings:
            continue
        if quantity in found:
            first = header[found[quantity].place]
            raise BadTrajectory(
                f"{file}: columns {short(first)} and {short(column)} are both {quantity}; "
                f"leave one out, e.g. {map_option(column, IGNORED)}"
            )
        found[quantity] = Column(index, factor)
    _ask(file, header, mapping, found, with_readings)
    return found


def _ask(
    file: str, header: Sequence[str], mapping: Mapping[str, str], found: Mapping[str, Column], with_readings: bool
) -> None:
    """Raise AmbiguousFile if a column seems to be a quantity, but its name leaves the unit or the order open."""
    unnamed = [column for column in header if column not in mapping and parsed(column) is None]
    counted = [column for column in unnamed if COUNTED_SCALAR.fullmatch(column)]
    if counted and QUATERNION[0] not in found:
        ways = [counted_quaternion(counted, last) for last in (False, True)]
        suggestions = [map_options(way) or "name all four" for way in ways]
        raise AmbiguousFile(
            f"{file}: {_listed(counted)}: which is the scalar?  If the first: {suggestions[0]}; "
            f"if the last: {suggestions[1]}",
            f"whether the scalar is the first of {_listed(counted)}, or the last",
            Suggestion(ways[0]),
        )
    if set(COUNTED_FROM_0) <= set(unnamed) | set(found) and COUNTED_FROM_0[0] in unnamed:
        likely = dict(zip(COUNTED_FROM_0, MATRIX, strict=True))
        raise AmbiguousFile(
            f"{file}: the matrix is counted from 0; rows and columns must be counted from 1: {map_options(likely)}",
            "whether the matrix is counted from 0",
            Suggestion(likely),
        )
    # The name of a quantity without a unit.
    without_unit = [
        column
        for column in unnamed
        if dimension(column.lower()) not in (None, "none", "angle")
        and (with_readings or column.lower() not in READINGS)
    ]
    if without_unit:
        units = {measured: UNITS[measured] for column in without_unit if (measured := dimension(column.lower()))}
        available = "; ".join(f"{measured} in {', '.join(names)}" for measured, names in units.items())
        likely = likely_names(header, mapping, found)
        raise AmbiguousFile(
            f"{file}: {_listed(without_unit)}: in which unit?  If SI: {map_options(likely)}; units are {available}; "
            f"NAME={IGNORED} leaves a column out",
            f"the unit of {_listed(without_unit)}",
            Suggestion(likely),
        )


def _allowed(name: str) -> str:
    quantity = name.partition("_")[0]
    measured = dimension(quantity)
    if measured is None:
        return (
            "unknown name; names are t_s, x_m .., qw .., r11 .., vx_m_s .., wx_rad_s .., v0x_m .., ax_m_s2 .., "
            f"gx_rad_s .., and {IGNORED}"
        )
    units = [f"{quantity}_{unit}" if unit else quantity for unit in UNITS[measured]]
    return f"must be one of {', '.join(units)}"


def descriptions(
    file: str,
    header: Sequence[str],
    mapping: Mapping[str, str],
    columns: Mapping[str, Column],
    points: int,
    by: str | None,
    with_readings: bool = False,
) -> list[Description]:
    """Return how a file describes the body's pose, the description to grade first.

    points: number of the body's vertices; by: the kind that the user chose, or None; with_readings: a file of a
    sensor's readings alone has none.  Raises BadTrajectory if a description is incomplete, a vertex does not exist, or
    there is no description.
    """
    if TIME not in columns:
        raise _column_question(file, "the time, t_s, is missing", "which column is the time", header, mapping, columns)
    for group in (CENTRE, QUATERNION, MATRIX, VELOCITY, SPIN, ACCELEROMETER, GYRO):
        _check_whole(file, columns, group)
    numbers = sorted({int(match[1]) for name in columns if (match := VERTEX.fullmatch(name))})
    for number in numbers:
        if number >= points:
            raise BadTrajectory(f"{file}: v{number}: the body has vertices 0 to {points - 1}")
        _check_whole(file, columns, tuple(f"v{number}{axis}" for axis in "xyz"))
    velocities = all(name in columns for name in (*VELOCITY, *SPIN))
    has_centre = CENTRE[0] in columns
    has = {
        "vertices": bool(numbers),
        "pose": (has_centre or not numbers) and QUATERNION[0] in columns,
        "matrix": (has_centre or not numbers) and MATRIX[0] in columns,
    }
    # With a centre or angles beside it, an angular velocity is the body's, and the pose is what is missing.
    readings = any(name in columns for name in (READINGS if has_centre else (*READINGS, *SPIN)))
    if with_readings and not any(has.values()) and not by and readings and not angles_of(header):
        return []
    if not any(has.values()):
        what = "the attitude is missing" if has_centre else "the pose is missing"
        needed = "qw, qx, qy, qz or r11 ... r33" if has_centre else "x_m, y_m, z_m with qw, qx, qy, qz or r11 ... r33"
        message = f"{what}: needed are {needed}, or v0x_m, v0y_m, v0z_m, ..."
        if has_centre and not any(_is_attitude(name) for name in likely_names(header, mapping, columns).values()):
            _ask_angles(f"{file}: {message}", header)
        topic = f"which columns are the {'attitude' if has_centre else 'pose'}"
        raise _column_question(file, message, topic, header, mapping, columns)
    if by and not has[by]:
        raise BadTrajectory(f"{file}: --by {by}: the file has only {' and '.join(kind for kind in has if has[kind])}")
    order = [by] if by else [kind for kind in has if has[kind]]
    everything = tuple(range(points))
    return [
        Description(
            kind,
            tuple(numbers) if kind == "vertices" else everything,
            velocities,
            SPIN[0] in columns,
            has_centre or kind == "vertices",
        )
        for kind in order
    ]


def _column_question(
    file: str, message: str, topic: str, header: Sequence[str], mapping: Mapping[str, str], found: Mapping[str, Column]
) -> AmbiguousFile:
    """Return the question which column is a quantity, with the likely ones."""
    likely = likely_names(header, mapping, found)
    perhaps = f"perhaps {map_options(likely)}" if likely else f"line 1 names {_listed(header)}"
    more = "" if likely else "; name a column with --map COLUMN=NAME"
    return AmbiguousFile(f"{file}: {message}: {perhaps}{more}", topic, Suggestion(likely))


def _is_attitude(name: str) -> bool:
    quantity = name.partition("_")[0]
    return quantity in (*QUATERNION, *MATRIX) or VERTEX.fullmatch(quantity) is not None


def _ask_angles(message: str, header: Sequence[str]) -> None:
    """Raise an error if columns are angles: AmbiguousAngles if they are the three of an attitude."""
    if named := angles_of(header):
        raise AmbiguousAngles(f"{message}; {_listed(list(named))} are Euler angles, which are ambiguous", named)
    if angles := [column for column in header if is_angle(column)]:
        raise BadTrajectory(f"{message}; {_listed(angles)} are angles, but not one for each of three axes")


def _check_whole(file: str, columns: Mapping[str, Column], group: Sequence[str]) -> None:
    missing = [name for name in group if name not in columns]
    if missing and len(missing) < len(group):
        raise BadTrajectory(f"{file}: {', '.join(missing)} missing, though there is {_present(columns, group)}")


def _present(columns: Mapping[str, Column], group: Sequence[str]) -> str:
    return ", ".join(name for name in group if name in columns)


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - MOST_LISTED} more" if len(names) > MOST_LISTED else ""
    return ", ".join(map(short, names[:MOST_LISTED])) + more
