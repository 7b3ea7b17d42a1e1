"""What the columns of a file are: where each quantity is, what that shows of the body; asks where it is not said."""

from collections.abc import Mapping, Sequence

from tumble.compare.grade.read.columns import (
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
    Answer,
    BadTrajectory,
    Column,
    Shown,
    Unsaid,
    dimension,
    parsed,
)
from tumble.compare.grade.read.suggestions import (
    UNORDERED,
    angles_of,
    are_angles,
    likely_meant,
    map_option,
    map_options,
    unordered,
)
from tumble.scenarios.format import nearest, printable, short

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
    counted = [column for column in unnamed if UNORDERED.fullmatch(column)]
    if counted and QUATERNION[0] not in found:
        ways = [unordered(counted, last) for last in (False, True)]
        offers = [map_options(way) or "name all four" for way in ways]
        raise Unsaid(
            f"{file}: {_listed(counted)}: which is the scalar?  The first: {offers[0]}; the last: {offers[1]}",
            f"whether the scalar is the first of {_listed(counted)}, or the last",
            Answer(ways[0]),
        )
    if set(COUNTED_FROM_0) <= set(unnamed) | set(found) and COUNTED_FROM_0[0] in unnamed:
        meant = dict(zip(COUNTED_FROM_0, MATRIX, strict=True))
        raise Unsaid(
            f"{file}: a matrix counted from 0: rows and columns are counted from 1 here: {map_options(meant)}",
            "a matrix counted from 0",
            Answer(meant),
        )
    # A quantity by its bare name: meant, but in which unit?
    bare = [column for column in unnamed if dimension(column.lower()) not in (None, "none", "angle")]
    if bare:
        units = {measured: UNITS[measured] for column in bare if (measured := dimension(column.lower()))}
        others = "; ".join(f"{measured} in {', '.join(names)}" for measured, names in units.items())
        meant = likely_meant(header, mapping, found)
        raise Unsaid(
            f"{file}: {_listed(bare)}: in which unit?  If SI: {map_options(meant)}; there is {others}; "
            f"NAME={IGNORED} leaves a column out",
            f"in which unit {_listed(bare)} {'is' if len(bare) == 1 else 'are'}",
            Answer(meant),
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
    if TIME not in columns:
        raise _unnamed(file, "no column says the time, t_s", "which column is the time", header, mapping, columns)
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
        what = "nothing says how the body is turned" if turned else "nothing says where the body is"
        needed = "qw, qx, qy, qz or r11 ... r33" if turned else "x_m, y_m, z_m with qw, qx, qy, qz or r11 ... r33"
        message = f"{what}: it takes {needed}, or v0x_m, v0y_m, v0z_m, ..."
        if turned and not any(_says_attitude(name) for name in likely_meant(header, mapping, columns).values()):
            _ask_for_angles(f"{file}: {message}", header)
        asks = f"which columns say {'how the body is turned' if turned else 'where the body is'}"
        raise _unnamed(file, message, asks, header, mapping, columns)
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


def _unnamed(
    file: str, message: str, asks: str, header: Sequence[str], mapping: Mapping[str, str], found: Mapping[str, Column]
) -> Unsaid:
    """Return the question which columns are meant, with those that are likely."""
    meant = likely_meant(header, mapping, found)
    perhaps = f"perhaps {map_options(meant)}" if meant else f"line 1 names {_listed(header)}"
    more = "" if meant else ": --map COLUMN=NAME says what one is"
    return Unsaid(f"{file}: {message}: {perhaps}{more}", asks, Answer(meant))


def _says_attitude(name: str) -> bool:
    quantity = name.partition("_")[0]
    return quantity in (*QUATERNION, *MATRIX) or VERTEX.fullmatch(quantity) is not None


def _ask_for_angles(message: str, header: Sequence[str]) -> None:
    """Raise where columns are angles; AnglesUnread where they are the three of an attitude."""
    if named := angles_of(header):
        raise AnglesUnread(f"{message}; {_listed(list(named))} are angles, which are read in many ways", named)
    if angles := [column for column in header if are_angles(column)]:
        raise BadTrajectory(f"{message}; {_listed(angles)} are angles, but not about each of three axes")


def _whole(file: str, columns: Mapping[str, Column], group: Sequence[str]) -> None:
    missing = [name for name in group if name not in columns]
    if missing and len(missing) < len(group):
        raise BadTrajectory(f"{file}: {', '.join(missing)} missing beside {_rest(columns, group)}")


def _rest(columns: Mapping[str, Column], group: Sequence[str]) -> str:
    return ", ".join(name for name in group if name in columns)


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - MOST_LISTED} more" if len(names) > MOST_LISTED else ""
    return ", ".join(map(short, names[:MOST_LISTED])) + more
