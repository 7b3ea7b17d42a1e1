"""What the columns of a file are: where each quantity is, what that shows of the body; asks where it is not said."""

import re
from collections.abc import Mapping, Sequence

from compare.grade.columns import (
    CENTRE,
    IGNORED,
    MATRIX,
    QUATERNION,
    SPIN,
    TIME,
    UNITS,
    VELOCITY,
    VERTEX,
    AnglesUnread,
    BadTrajectory,
    Column,
    Shown,
    dimension,
    parsed,
)
from compare.grade.offers import angles_of, are_angles, map_option, offered
from scenarios.format import nearest, printable, short

# Names that say that something is there but not what: which of four numbers is the scalar.
UNORDERED = re.compile(r"(q|quat|quaternion|orientation)[_.]?[0-4]", re.ASCII | re.IGNORECASE)
COUNTED_FROM_0 = tuple(f"r{row}{column}" for row in "012" for column in "012")
# Names of columns, and characters of a list of them, that fit into one line.
MOST_LISTED = 8
MOST_NEAR = 200


def layout(file: str, header: Sequence[str], mapping: Mapping[str, str]) -> dict[str, Column]:
    """Return where each quantity is.

    mapping: column -> name, or `ignore`.  Raises BadTrajectory for names nobody knows and for what is ambiguous.
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
        if quantity in found:
            first = header[found[quantity].place]
            raise BadTrajectory(
                f"{file}: columns {short(first)} and {short(column)} both say {quantity}: which one? "
                f"e.g. {map_option(column, IGNORED)}"
            )
        found[quantity] = Column(index, factor)
    _ask(file, header, mapping, found)
    return found


def _ask(file: str, header: Sequence[str], mapping: Mapping[str, str], found: Mapping[str, Column]) -> None:
    """Raise BadTrajectory where columns are likely meant for something that their names do not say."""
    unnamed = [column for column in header if column not in mapping and parsed(column) is None]
    unordered = [column for column in unnamed if UNORDERED.fullmatch(column)]
    if unordered and QUATERNION[0] not in found:
        ways = [
            " ".join(map_option(*pair) for pair in zip(unordered, order, strict=False))
            for order in (QUATERNION, (*QUATERNION[1:], QUATERNION[0]))
        ]
        raise BadTrajectory(
            f"{file}: {_listed(unordered)}: which is the scalar?  The first: {ways[0]}; the last: {ways[1]}"
        )
    if set(COUNTED_FROM_0) <= set(unnamed) | set(found) and COUNTED_FROM_0[0] in unnamed:
        options = " ".join(map(map_option, COUNTED_FROM_0, MATRIX))
        raise BadTrajectory(f"{file}: a matrix counted from 0: rows and columns are counted from 1 here: {options}")
    # A quantity by its bare name: meant, but in which unit?
    bare = [column for column in unnamed if dimension(column.lower()) not in (None, "none", "angle")]
    if bare:
        units = {measured: UNITS[measured] for column in bare if (measured := dimension(column.lower()))}
        others = "; ".join(f"{measured} in {', '.join(names)}" for measured, names in units.items())
        raise BadTrajectory(
            f"{file}: {_listed(bare)}: in which unit?  If SI: {offered(header, mapping, found)}; there is {others}; "
            f"NAME={IGNORED} leaves a column out"
        )


def _allowed(name: str) -> str:
    quantity = name.partition("_")[0]
    measured = dimension(quantity)
    if measured is None:
        return f"no such name; there are t_s, x_m .., qw .., r11 .., vx_m_s .., wx_rad_s .., v0x_m .., and {IGNORED}"
    units = [f"{quantity}_{unit}" if unit else quantity for unit in UNITS[measured]]
    return f"must be one of {', '.join(units)}"


def shown(
    file: str,
    header: Sequence[str],
    mapping: Mapping[str, str],
    columns: Mapping[str, Column],
    points: int,
    by: str | None,
) -> list[Shown]:
    """Return the descriptions of the body's place in a file, the one to grade first.

    points: how many the body has; by: the one that the user wants, or None.  Raises BadTrajectory where a description
    has a part missing, a vertex does not exist, or nothing says where the body is.
    """
    offer = offered(header, mapping, columns)
    perhaps = f"perhaps {offer}" if offer else f"line 1 names {_listed(header)}: --map COLUMN=NAME says what one is"
    if TIME not in columns:
        raise BadTrajectory(f"{file}: no column says the time, t_s: {perhaps}")
    for group in (CENTRE, QUATERNION, MATRIX, VELOCITY, SPIN):
        _whole(file, columns, group)
    numbers = sorted({int(match[1]) for name in columns if (match := VERTEX.fullmatch(name))})
    for number in numbers:
        if number >= points:
            raise BadTrajectory(f"{file}: v{number}: the body has vertices 0 to {points - 1}")
        _whole(file, columns, tuple(f"v{number}{axis}" for axis in "xyz"))
    velocities = all(name in columns for name in (*VELOCITY, *SPIN))
    turned = CENTRE[0] in columns
    has = {
        "vertices": bool(numbers),
        "pose": (turned or not numbers) and QUATERNION[0] in columns,
        "matrix": (turned or not numbers) and MATRIX[0] in columns,
    }
    if not any(has.values()):
        angles = [column for column in header if are_angles(column)]
        if angles:
            perhaps = f"{_listed(angles)} are not read, for angles come in dozens of conventions"
        what = "nothing says how the body is turned" if turned else "nothing says where the body is"
        needed = "qw, qx, qy, qz or r11 ... r33" if turned else "x_m, y_m, z_m with qw, qx, qy, qz or r11 ... r33"
        message = f"{file}: {what}: it takes {needed}, or v0x_m, v0y_m, v0z_m, ...; {perhaps}"
        raise AnglesUnread(message, named) if (named := angles_of(header)) and turned else BadTrajectory(message)
    if by and not has[by]:
        raise BadTrajectory(f"{file}: --by {by}: the file has {' and '.join(kind for kind in has if has[kind])} only")
    order = [by] if by else [kind for kind in has if has[kind]]
    everything = tuple(range(points))
    return [
        Shown(
            kind,
            tuple(numbers) if kind == "vertices" else everything,
            velocities,
            SPIN[0] in columns,
            turned or kind == "vertices",
        )
        for kind in order
    ]


def _whole(file: str, columns: Mapping[str, Column], group: Sequence[str]) -> None:
    missing = [name for name in group if name not in columns]
    if missing and len(missing) < len(group):
        raise BadTrajectory(f"{file}: {', '.join(missing)} missing beside {_rest(columns, group)}")


def _rest(columns: Mapping[str, Column], group: Sequence[str]) -> str:
    return ", ".join(name for name in group if name in columns)


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - MOST_LISTED} more" if len(names) > MOST_LISTED else ""
    return ", ".join(map(short, names[:MOST_LISTED])) + more
