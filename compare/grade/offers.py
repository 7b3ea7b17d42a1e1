"""What a foreign column is likely meant for: offered to the user as the option to give, never assumed.

Programs say `Time (s)`, `pos_x [cm]`, `quat.w`, `omega_z_deg_s`; a name is a unit at its end, if any, and words.
"""

import re
import shlex
from collections.abc import Container, Iterator, Mapping, Sequence

from compare.grade.columns import ANGLES as ROTATIONS
from compare.grade.columns import PILOTS, TIME, UNITS, dimension, parsed
from scenarios.format import printable

# Words of a name without its unit, in small letters and digits only -> what we call it.
_POSITION = "p|pos|position|c|com|centre|center|loc|location|translation"
_TURN = "q|quat|quaternion|o|orientation|rot|rotation|att|attitude"
_SPEED = "v|vel|velocity|lin|linvel|linearvelocity|speed"
_SPIN = "w|omega|angvel|angularvelocity|spin|gyro|rate"
WORDS = tuple(
    (re.compile(words, re.ASCII), name)
    for words, name in (
        (r"(?:sim|simulation|elapsed)?(?:t|time|timestamp|zeit)|elapsed", TIME),
        (rf"(?:pose)?(?:{_POSITION})?([xyz])|([xyz])(?:pos|position|coordinate)", "{}"),
        (rf"(?:pose)?(?:{_TURN})([wxyz])", "q{}"),
        (rf"(?:twist)?(?:{_SPEED})([xyz])|([xyz])(?:vel|velocity)", "v{}"),
        (rf"(?:twist)?(?:{_SPIN})([xyz])", "w{}"),
        (r"(?:r|m|mat|matrix|rot|rotation)([1-3][1-3])", "r{}"),
        (r"(?:v|vertex|corner)0*(\d{1,6}[xyz])", "v{}"),
    )
)
ANGLES = re.compile(
    r"roll|pitch|yaw|heading|phi|theta|psi|(?:euler|rot|rotation|angle|r)(?:[xyz]|angle[xyz]|[123])", re.ASCII
)
PILOTED = {**PILOTS, "heading": "rz", "phi": "rx", "theta": "ry", "psi": "rz"}
UNIT_WORDS = {
    "sec": "s", "secs": "s", "second": "s", "seconds": "s", "msec": "ms", "milliseconds": "ms", "usec": "us",
    "µs": "us", "meter": "m", "meters": "m", "metre": "m", "metres": "m", "m_sec": "m_s", "deg_sec": "deg_s",
    "rad_sec": "rad_s",
}  # fmt: skip
# How a name ends in a unit, the longest unit first.
ENDINGS = tuple(
    (ending, unit)
    for unit in sorted({*UNIT_WORDS, *(unit for units in UNITS.values() for unit in units if unit)}, key=len)[::-1]
    for ending in (f"_{unit}", f" {unit}", f".{unit}", f" {unit.replace('_', '/')}")
)
# More options than this are no line to copy.
MOST_OFFERED = 32


def map_option(column: str, name: str) -> str:
    """Return the option that says what a column is, as a shell takes it."""
    pair = f"{printable(column)}={name}"
    return shlex.quote(f"--map={pair}") if column.startswith("-") else f"--map {shlex.quote(pair)}"


def offered(header: Sequence[str], mapping: Mapping[str, str], found: Container[str]) -> str:
    """Return the options that would name the columns whose quantities are not found yet, SI where no unit is said."""
    names: dict[str, tuple[str, str]] = {}
    for column in header:
        if column not in mapping and parsed(column) is None:
            for quantity, unit in _likely(column):
                if quantity not in found:
                    names.setdefault(quantity, (column, f"{quantity}_{unit}".removesuffix("_")))
    options = [map_option(*each) for each in names.values()]
    more = f" and so on for {len(options) - MOST_OFFERED} more" if len(options) > MOST_OFFERED else ""
    return " ".join(options[:MOST_OFFERED]) + more


def are_angles(column: str) -> bool:
    """Whether a column is likely one of three angles of an attitude."""
    return ANGLES.fullmatch(_words(_parts(column)[0])) is not None


def angles_of(header: Sequence[str]) -> dict[str, tuple[str, str]]:
    """Return which columns are likely rx, ry and rz, in that order, and in which unit; nothing where one is not."""
    found: dict[str, tuple[str, str]] = {}
    for column in filter(are_angles, header):
        name, said = _parts(column)
        words = _words(name)
        angle = PILOTED.get(words, f"r{words[-1]}")
        unit = {"degrees": "deg", "degree": "deg", "radians": "rad", "radian": "rad"}.get(said, said)
        found[column] = angle, unit
    return (
        dict(sorted(found.items(), key=lambda item: item[1]))
        if sorted(a for a, _ in found.values()) == list(ROTATIONS)
        else {}
    )


def _likely(column: str) -> Iterator[tuple[str, str]]:
    """Yield the quantity that a column is likely meant for and its unit, that of SI where none is said."""
    name, said = _parts(column)
    for words, quantity in WORDS:
        match = words.fullmatch(_words(name))
        if match is None:
            continue
        part = next((group for group in match.groups() if group), "")
        meant = quantity.format(part)
        units = UNITS[dimension(meant) or "none"]
        unit = UNIT_WORDS.get(said, said)
        if not said or unit in units:
            yield meant, unit if said else next(iter(units))


def _parts(column: str) -> tuple[str, str]:
    """Return a name and its unit, in small letters: what stands in brackets at its end, or the unit that it ends in."""
    name = column.strip("# ").lower()
    bracket = max(name.rfind("("), name.rfind("["))
    said = name[bracket + 1 : -1]
    if bracket >= 0 and name.endswith((")", "]")) and not said.isdigit() and not set(said) & set(")]") and said:
        return name[:bracket].rstrip(), re.sub(r"[\s/.]+", "_", said.strip().replace("°", "deg"))
    for ending, unit in ENDINGS:
        if name.endswith(ending):
            return name.removesuffix(ending), unit
    return name, ""


def _words(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "", name)
