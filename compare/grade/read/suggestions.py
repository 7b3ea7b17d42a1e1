"""What a foreign column is likely to be: suggested to the user as an option, or taken from a known program's defaults.

Programs write `Time (s)`, `pos_x [cm]`, `quat.w`, `Rotation X`, `omega_z_deg_s`: words, and perhaps a unit at the end.
"""

import re
import shlex
from collections.abc import Container, Iterator, Mapping, Sequence
from typing import NamedTuple

from tumble.compare.grade.read.columns import ANGLES as ROTATIONS
from tumble.compare.grade.read.columns import PILOTS, QUATERNION, TIME, UNITS, dimension, parsed
from tumble.scenarios.format import printable

# A column name without its unit, as lower-case letters and digits only -> our name.
_OWNER = (
    "(?:field|header|transform|rigidbody|rb|body|actor|object|obj|node|cube|die|brick|global|local|world|data|pose)*"
)
_POSITION = "p|pos|position|c|com|centre|center|loc|location|translation|origin"
_TURN = "q|quat|quaternion|o|orientation|rot|rotation|rotationquaternion|att|attitude"
_SPEED = "v|vel|velocity|lin|linear|linvel|linearvelocity|speed"
_SPIN = "w|omega|angvel|angular|angularvelocity|spin|rate"
_FORCE = "a|acc|accel|acceleration|accelerometer|linacc|linearacceleration|specificforce"
_GYRO = "g|gyr|gyro|gyroscope"
WORDS = tuple(
    (re.compile(words, re.ASCII), name)
    for words, name in (
        (
            rf"{_OWNER}(?:sim|simulation|elapsed|fixed|game|physics|real|time)*(?:t|time|timestamp|zeit|stamp)|elapsed",
            TIME,
        ),
        (rf"{_OWNER}(?:{_POSITION})?([xyz])|([xyz])(?:pos|position|coordinate)", "{}"),
        (rf"{_OWNER}(?:{_TURN})([wxyz])", "q{}"),
        (rf"{_OWNER}(?:twist)?(?:{_SPEED})([xyz])|([xyz])(?:vel|velocity)", "v{}"),
        (rf"{_OWNER}(?:twist)?(?:{_SPIN})([xyz])", "w{}"),
        (rf"{_OWNER}(?:imu|sensor)?(?:{_FORCE})([xyz])", "a{}"),
        (rf"{_OWNER}(?:imu|sensor)?(?:{_GYRO})([xyz])", "g{}"),
        (r"(?:r|m|mat|matrix|rot|rotation)([1-3][1-3])", "r{}"),
        (r"(?:v|vertex|corner)0*(\d{1,6}[xyz])", "v{}"),
    )
)
ANGLES = re.compile(
    rf"{_OWNER}(?:rot|rotation|orientation)?(?:roll|pitch|yaw|heading|phi|theta|psi)"
    rf"|{_OWNER}(?:euler|eulerangles?|rot|rotation|rotationeuler|rotationdegrees|angles?|r)"
    r"(?:[xyz]|angle[xyz]|[0-3])",
    re.ASCII,
)
PILOTED = {**PILOTS, "heading": "rz", "phi": "rx", "theta": "ry", "psi": "rz"}
COUNTED = ("123", "012")
# Numbered components of a quaternion, whose names do not tell which is the scalar.
COUNTED_SCALAR = re.compile(
    r"(?:.*[ ._])?(?:q|quat|quaternion|orientation|rotation_quaternion)[ ._\[(]*([0-4])[\])]?", re.I | re.A
)
# A free joint's coordinates as MuJoCo has them.
JOINT = re.compile(r"(?:data)?(qpos|qvel)([0-6])", re.ASCII)
JOINTS = {
    "qpos": ("x", "y", "z", *QUATERNION),
    "qvel": ("vx", "vy", "vz", "wx", "wy", "wz"),
}
UNIT_WORDS = {
    "sec": "s", "secs": "s", "second": "s", "seconds": "s", "msec": "ms", "milliseconds": "ms", "usec": "us",
    "µs": "us", "nsec": "ns", "nanoseconds": "ns", "meter": "m", "meters": "m", "metre": "m", "metres": "m",
    "m_sec": "m_s", "deg_sec": "deg_s", "rad_sec": "rad_s", "°": "deg", "degree": "deg", "degrees": "deg",
    "radian": "rad", "radians": "rad",
}  # fmt: skip
_UNITS = sorted({*UNIT_WORDS, *(unit for units in UNITS.values() for unit in units if unit)}, key=len, reverse=True)
# A name that ends in a unit, the longest match first.
ENDING = re.compile(rf"(.+?)[_ .]({'|'.join(re.escape(u) for unit in _UNITS for u in {unit, unit.replace('_', '/')})})")
# More options than this are too many for a line to copy.
MOST_OFFERED = 32
# No name of a quantity has more characters.
LONGEST_NAME = 80


class ColumnDefaults(NamedTuple):
    """The meaning of a program's columns where their names leave it open.

    units: dimension -> unit; last: whether the scalar of a quaternion comes last, None if unknown.
    """

    units: Mapping[str, str]
    last: bool | None = None


SI = ColumnDefaults({measured: next(iter(units)) for measured, units in UNITS.items()})


def map_option(column: str, name: str) -> str:
    """Return the option that names a column, quoted for a shell."""
    pair = f"{printable(column)}={name}"
    return shlex.quote(f"--map={pair}") if column.startswith("-") else f"--map {shlex.quote(pair)}"


def map_options(likely: Mapping[str, str]) -> str:
    """Return the options that name columns; of many, the first ones."""
    options = [map_option(*each) for each in likely.items()]
    more = f" and so on for {len(options) - MOST_OFFERED} more" if len(options) > MOST_OFFERED else ""
    return " ".join(options[:MOST_OFFERED]) + more


def likely_names(
    header: Sequence[str], mapping: Mapping[str, str], found: Container[str], defaults: ColumnDefaults = SI
) -> dict[str, str]:
    """Return likely names, column -> name, of columns whose quantities are not in `found`."""
    names: dict[str, tuple[str, str]] = {}
    for column in header:
        if column not in mapping and parsed(column) is None:
            for quantity, unit in _likely(column, defaults):
                if quantity not in found:
                    names.setdefault(quantity, (column, f"{quantity}_{unit}".removesuffix("_")))
    # Three numbers of a rotation without a scalar are angles.
    if QUATERNION[0] not in names and QUATERNION[0] not in found:
        for name in QUATERNION[1:]:
            names.pop(name, None)
    return dict(names.values())


def angles_of(header: Sequence[str]) -> dict[str, tuple[str, str]]:
    """Return the columns that are likely rx, ry, rz, in that order, with the unit; empty unless there are three."""
    found: dict[str, tuple[str, str]] = {}
    for column in filter(is_angle, header):
        name, unit_text = _parts(column)
        words = _words(name)
        pilots = next((angle for word, angle in PILOTED.items() if words.endswith(word)), "")
        found[column] = pilots or f"r{words[-1]}", UNIT_WORDS.get(unit_text, unit_text)
    for counted in COUNTED:
        if sorted(angle for angle, _ in found.values()) == [f"r{number}" for number in counted]:
            found = {name: (ROTATIONS[counted.index(angle[-1])], unit) for name, (angle, unit) in found.items()}
    is_whole = sorted(angle for angle, _ in found.values()) == list(ROTATIONS)
    return dict(sorted(found.items(), key=lambda item: item[1])) if is_whole else {}


def is_angle(column: str) -> bool:
    """Whether a column is likely one of three Euler angles."""
    return len(column) <= LONGEST_NAME and ANGLES.fullmatch(_words(_parts(column)[0])) is not None


def counted_quaternion(header: Sequence[str], last: bool) -> dict[str, str]:
    """Return names for a quaternion's four numbered columns, the scalar first or last; empty unless there are four."""
    counted = [column for column in header if len(column) <= LONGEST_NAME and COUNTED_SCALAR.fullmatch(column)]
    order = (*QUATERNION[1:], QUATERNION[0]) if last else QUATERNION
    return dict(zip(counted, order, strict=True)) if len(counted) == len(order) else {}


def _likely(column: str, defaults: ColumnDefaults) -> Iterator[tuple[str, str]]:
    """Yield the quantities that a column may be, each with its unit, by default that of `defaults`."""
    if len(column) > LONGEST_NAME:
        return
    name, unit_text = _parts(column)
    words_only = _words(name)
    if joint := JOINT.fullmatch(words_only):
        quantities = JOINTS[joint[1]]
        if int(joint[2]) < len(quantities):
            quantity = quantities[int(joint[2])]
            yield quantity, defaults.units[dimension(quantity) or "none"]
        return
    for words, quantity in WORDS:
        match = words.fullmatch(words_only)
        if match is None:
            continue
        part = next((group for group in match.groups() if group), "")
        likely = quantity.format(part)
        measured = dimension(likely) or "none"
        unit = UNIT_WORDS.get(unit_text, unit_text)
        if not unit_text or unit in UNITS[measured]:
            yield likely, unit if unit_text else defaults.units[measured]


def _parts(column: str) -> tuple[str, str]:
    """Return a name and its unit in lower case: the unit in brackets at its end, or the unit that it ends in."""
    name = column.strip("#% ").lower()
    bracket = max(name.rfind("("), name.rfind("["))
    unit_text = name[bracket + 1 : -1]
    if (
        bracket >= 0
        and name.endswith((")", "]"))
        and not unit_text.isdigit()
        and not set(unit_text) & set(")]")
        and unit_text
    ):
        return name[:bracket].rstrip(), re.sub(r"[\s/.]+", "_", unit_text.strip().replace("°", "deg"))
    if ending := ENDING.fullmatch(name):
        return ending[1], ending[2].replace("/", "_")
    return name, ""


def _words(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "", name)
