"""The format of a scene file: its tables, what is allowed in them, and the words that refuse the rest.

msgspec holds a file against these tables' keys, types and signs; its complaint is put in our own words, with the key it
points at, the value found there, and what the table allows.
"""

import math
import re
import reprlib
import sys
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta, inspect

from tumble.scenarios.refusal import nearest

MOST_SAMPLES = 1_000_000
MOST_THROWS = 10**12
LARGEST = sys.float_info.max
DEEPEST = 4  # impulse[0].ray.origin

Text = Annotated[str, Meta(description="a string")]
Number = Annotated[float, Meta(description="a number")]
Positive = Annotated[float, Meta(gt=0, description="a number > 0")]
NotNegative = Annotated[float, Meta(ge=0, description="a number >= 0")]
Index = Annotated[int, Meta(ge=0, description="a whole number >= 0")]
Count = Annotated[int, Meta(ge=1, le=MOST_SAMPLES, description=f"a whole number from 1 to {MOST_SAMPLES}")]
Throws = Annotated[int, Meta(ge=1, le=MOST_THROWS, description=f"a whole number from 1 to {MOST_THROWS}")]
Share = Annotated[float, Meta(ge=0, le=1, description="a number from 0 to 1")]
HalfTurn = Annotated[float, Meta(ge=0, le=math.pi, description="a number from 0 to pi")]
Vector = Annotated[tuple[Number, Number, Number], Meta(description="a list of 3 numbers")]
Quaternion = Annotated[tuple[Number, Number, Number, Number], Meta(description="a list of 4 numbers, w x y z")]
Size = Annotated[tuple[Positive, Positive, Positive], Meta(description="a list of 3 numbers > 0")]
Tensor = Annotated[tuple[Vector, Vector, Vector], Meta(description="3 rows of 3 numbers")]
Points = Annotated[list[Vector], Meta(min_length=1, description="a list of at least one point, each 3 numbers")]
Times = Annotated[
    list[Number],
    Meta(min_length=1, max_length=MOST_SAMPLES, description=f"a list of 1 to {MOST_SAMPLES} numbers"),
]
SensorKind = Annotated[
    Literal["imu", "accelerometer", "gyro", "magnetometer-direction"],
    Meta(description="'imu', 'accelerometer', 'gyro' or 'magnetometer-direction'"),
]
Switch = Annotated[bool, Meta(description="true or false")]
Shape = Annotated[str, Meta(description="'box', 'disc', 'mesh', 'rigid' or 'sphere'")]

ORIGIN = (0.0, 0.0, 0.0)


class _Table(msgspec.Struct, forbid_unknown_fields=True):
    pass


def _key(unit: str, meaning: str) -> Meta:
    """Return what docs/scene.md and editors say of a key; unit: empty for a number without one and for what is none."""
    return Meta(extra_json_schema={"unit": unit, "meaning": meaning})


class BodyTable(_Table, tag_field="shape"):
    """The body: what every shape has."""

    mass: Annotated[Positive, _key("kg", "mass")]
    position: Annotated[Vector, _key("m", "centre of mass at t = 0")] = ORIGIN
    orientation: Annotated[Quaternion, _key("", "w x y z, body to world (Hamilton); scaled to length 1")] = (
        1.0,
        0.0,
        0.0,
        0.0,
    )
    velocity: Annotated[Vector, _key("m/s", "of the centre of mass at t = 0")] = ORIGIN
    angular_velocity: Annotated[Vector, _key("rad/s", "at t = 0, world axes")] = ORIGIN


class BoxTable(BodyTable, tag="box", kw_only=True):
    """A box, shape = "box"."""

    size: Annotated[Size, _key("m", "full edges along x, y, z of the body")]


class MeshTable(BodyTable, tag="mesh", kw_only=True):
    """A closed mesh of even density, shape = "mesh"."""

    file: Annotated[Text, _key("", "path of an STL, OBJ, PLY or OFF file in metres, from the scene file's folder")]


class RigidTable(BodyTable, tag="rigid", kw_only=True):
    """A body given by its tensor, shape = "rigid"."""

    inertia: Annotated[Tensor, _key("kg m2", "tensor about the centre of mass, A + B >= C")]
    points: Annotated[Points, _key("m", "what is compared as vertices, from the centre of mass")]


class SphereTable(BodyTable, tag="sphere", kw_only=True):
    """A uniform sphere, shape = "sphere"; its points are the centre and the six ends of its axes."""

    radius: Annotated[Positive, _key("m", "radius")]


class DiscTable(BodyTable, tag="disc", kw_only=True):
    """A uniform disc about the body's z axis, shape = "disc"; its points are the centre and eight of each rim."""

    radius: Annotated[Positive, _key("m", "radius")]
    thickness: Annotated[NotNegative, _key("m", "along z; 0 is the limit of a thin disc, with one rim")] = 0.0


# The keys of [body] that some shape has.
BODY_KEYS = frozenset(
    name for table in (BoxTable, DiscTable, MeshTable, RigidTable, SphereTable) for name in table.__struct_fields__
)


class RayTable(_Table):
    """A click: the impulse acts where the ray first meets the body."""

    origin: Annotated[Vector, _key("m", "where the ray begins, outside the body")]
    direction: Annotated[Vector, _key("", "of any length; the impulse's too, unless it has its own")]


class ImpulseTable(_Table):
    """An impulse: v += J/m, w += I^-1 (r - x) x J.  One of value, magnitude; one of point, vertex, point_body, ray."""

    time: Annotated[NotNegative, _key("s", "when")] = 0.0
    value: Annotated[Vector, _key("N s", "J, world axes")] | None = None
    magnitude: Annotated[NotNegative, _key("N s", "|J|, with a direction")] | None = None
    direction: Annotated[Vector, _key("", "of J, world axes, of any length")] | None = None
    point: Annotated[Vector, _key("m", "where it acts, world axes, wherever the body is then")] | None = None
    vertex: Annotated[Index, _key("", "where it acts: a vertex of the body")] | None = None
    point_body: Annotated[Vector, _key("m", "where it acts, body axes from the centre of mass")] | None = None
    ray: RayTable | None = None


class TetherTable(_Table):
    """A spring and damper from a vertex p to an anchor a.

    F = -k (p - a) - c p' where rest_length is 0, otherwise along the line only: F = -(k (|d| - l0) + c d'.u) u.
    """

    vertex: Annotated[Index, _key("", "of the body")]
    anchor: Annotated[Vector, _key("m", "fixed point, world axes")]
    stiffness: Annotated[NotNegative, _key("N/m", "k")]
    damping: Annotated[NotNegative, _key("N s/m", "c")] = 0.0
    rest_length: Annotated[NotNegative, _key("m", "l0; it pulls and, when shorter than that, pushes")] = 0.0


class DragTable(_Table):
    """Resistance: F = -linear v, tau_body = -angular w."""

    linear: Annotated[NotNegative, _key("N s/m", "of the centre of mass")] = 0.0
    angular: Annotated[NotNegative, _key("N m s/rad", "of the spin, the same about every axis")] = 0.0


class FloorTable(_Table):
    """A penalty floor at every vertex below height: N = max(0, -k y - c y') where y < 0, no friction."""

    stiffness: Annotated[NotNegative, _key("N/m", "k")]
    height: Annotated[Number, _key("m", "along the normal")] = 0.0
    normal: Annotated[Vector, _key("", "of any length, world axes")] = (0.0, 1.0, 0.0)
    damping: Annotated[NotNegative, _key("N s/m", "c")] = 0.0


class PlaneTable(_Table, kw_only=True):
    """A rigid plane: Newton's restitution and Coulomb's friction, both of the pair of body and plane."""

    point: Annotated[Vector, _key("m", "any point of the plane, world axes")] = ORIGIN
    normal: Annotated[Vector, _key("", "of any length, world axes, towards the body's side")] = (0.0, 1.0, 0.0)
    restitution: Annotated[Share, _key("", "e: normal velocity after an impact over that before it, reversed")]
    friction: Annotated[NotNegative, _key("", "mu: greatest friction over normal force, at rest and sliding")]


class SensorTable(_Table, kw_only=True):
    """A sensor fixed to the body: reads specific force R^T (a - g), angular velocity, or a field's direction.

    All in its own axes.  An imu reads the first two.
    """

    name: Annotated[Text, _key("", "unique, not empty")]
    kind: Annotated[SensorKind, _key("", "what it reads")]
    rate: Annotated[Positive, _key("Hz", "readings at 0, 1/rate, 2/rate, ...")]
    point: Annotated[Vector, _key("m", "where it is mounted, body axes from the centre of mass")] = ORIGIN
    orientation: Annotated[Quaternion, _key("", "w x y z, sensor to body (Hamilton); scaled to length 1")] = (
        1.0,
        0.0,
        0.0,
        0.0,
    )
    average: Annotated[Switch, _key("", "true: each reading is the mean over the 1/rate before it")] = False
    field: Annotated[Vector, _key("", "direction of the magnetic field, world axes, of any length")] | None = None


class EnsembleTable(_Table):
    """Many throws of the one body around the one that is written, which is throw 0."""

    throws: Annotated[Throws, _key("", "number of throws; 1e9 is one too")]
    seed: Annotated[Index, _key("", "the same seed draws the same throws")] = 0
    magnitude: Annotated[Share, _key("", "share by which |J| varies, evenly")] = 0.0
    cone: Annotated[HalfTurn, _key("rad", "half angle of the cone around the direction of J")] = 0.0
    point: Annotated[NotNegative, _key("m", "radius around the point where the impulse acts")] = 0.0
    orientation: Annotated[HalfTurn, _key("rad", "largest turn of the start's attitude")] = 0.0
    member: Annotated[Index, _key("", "number of the only throw that is run, below throws")] | None = None


class File(_Table, kw_only=True):
    """The whole file."""

    title: Annotated[Text, _key("", "one line")]
    duration: Annotated[Positive, _key("s", "duration of the simulation")]
    step: Annotated[Positive, _key("s", "default time step; grading alone does not need one")] | None = None
    body: BoxTable | DiscTable | MeshTable | RigidTable | SphereTable
    source: Annotated[Text, _key("", "where the case comes from")] = ""
    times: Annotated[Times, _key("s", "sample times; or give samples")] | None = None
    samples: Annotated[Count, _key("", "number of equal intervals, instead of times")] | None = None
    gravity: Annotated[Vector, _key("m/s2", "world axes; no gravity if left out")] = ORIGIN
    impulse: Annotated[list[ImpulseTable], Meta(description="tables headed [[impulse]]")] = []
    tether: Annotated[list[TetherTable], Meta(description="tables headed [[tether]]")] = []
    drag: DragTable | None = None
    floor: FloorTable | None = None
    plane: PlaneTable | None = None
    sensor: Annotated[list[SensorTable], Meta(description="tables headed [[sensor]]")] = []
    ensemble: EnsembleTable | None = None


Keys = tuple[str | int, ...]

type_of = inspect.type_info


class Refused(Exception):
    """Why the value at a path of keys and list indices is refused."""

    def __init__(self, keys: Keys, why: str, show_value: bool = True) -> None:
        self.keys, self.why, self.show_value = keys, why, show_value


def tables(document: dict) -> File:
    """Return the document as tables; raises Refused for a key, type, sign or non-finite number."""
    _refuse_odd(document, ())
    try:
        return msgspec.convert(_with_whole_throws(document), File)
    except msgspec.ValidationError as error:
        raise _explained(str(error), document) from None


def _with_whole_throws(document: dict) -> dict:
    """Return the document with throws = 1e9, which TOML has as a floating-point number, as a whole number."""
    table = document.get("ensemble")
    throws = table.get("throws") if isinstance(table, dict) else None
    if not (isinstance(throws, float) and throws.is_integer()):
        return document
    return {**document, "ensemble": {**document["ensemble"], "throws": int(throws)}}


def _refuse_odd(value: object, keys: Keys) -> None:
    """Raise Refused for a number that is not finite, and for keys and depths that no scene has."""
    if isinstance(value, dict | list):
        if len(keys) > DEEPEST:
            raise Refused(keys[:1], "nested too deeply", False)
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            if isinstance(key, str) and not re.fullmatch(r"[\w-]+", key):
                raise Refused((*keys, key), "unknown key; keys are letters, digits, _ and -", False)
            _refuse_odd(item, (*keys, key))
    elif isinstance(value, int | float) and not -LARGEST <= value <= LARGEST:
        raise Refused(keys, "must be finite")


def _explained(message: str, document: dict) -> Refused:
    """Return what msgspec complains of in our own words: the key it points at, and what the tables allow there."""
    complaint, _, where = message.partition(" - at `$")
    keys: Keys = tuple(int(index) if index else key for key, index in re.findall(r"(\w+)|\[(\d+)]", where))
    kind: Any = type_of(File)
    for depth, key in enumerate(keys, start=1):
        kind = _member(kind, key, value_at(document, keys[:depth]))
    if unknown := re.fullmatch(r"Object contains unknown field `(.*)`", complaint):
        known = [field.name for field in kind.fields]
        return Refused((*keys, unknown[1]), f"unknown key; {nearest(unknown[1], known)}", False)
    if missing := re.fullmatch(r"Object missing required field `(.*)`", complaint):
        return Refused((*keys, missing[1]), f"missing; must be {_words(_member(kind, missing[1], None))}", False)
    value = value_at(document, keys)
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return Refused(keys, f"must be {_words(kind).removeprefix('a number ' if is_number else '')}")


def _member(kind: Any, key: Any, value: object) -> Any:
    """Return the type of what is at a key inside a type; the value there decides between the shapes of a body."""
    kind = _bare(kind)
    if isinstance(kind, inspect.ListType):
        member = kind.item_type
    elif isinstance(kind, inspect.TupleType):
        member = kind.item_types[key]
    elif key == kind.tag_field:
        member = type_of(Shape)
    else:
        member = next(field.type for field in kind.fields if field.name == key)
    if isinstance(member, inspect.UnionType):
        shape = value.get("shape") if isinstance(value, dict) else None
        return next((one for one in member.types if getattr(one, "tag", None) == shape), member.types[0])
    return member


def _bare(kind: Any) -> Any:
    return kind.type if isinstance(kind, inspect.Metadata) else kind


def _words(kind: Any) -> str:
    schema = getattr(kind, "extra_json_schema", None)
    return schema["description"] if schema else "a table"


_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 60
_SHORT.maxlist = 9


def value_at(document: Any, keys: Keys) -> Any:
    """Return the value at a path of keys and list indices."""
    for key in keys:
        document = document[key]
    return document


def dotted(keys: Keys) -> str:
    """Return the path as a person writes it: impulse[0].value."""
    parts = (f"[{key}]" if isinstance(key, int) else f".{_shown_key(key)}" for key in keys)
    return "".join(parts).removeprefix(".")


def _shown_key(key: str) -> str:
    return key if re.fullmatch(r"[\w-]{1,60}", key) else short(key)


def short(value: object) -> str:
    """Return a value on one line of at most 60 characters.

    Parameters
    ----------
    value

    Returns
    -------
    text
    """
    try:
        text = _SHORT.repr(value)
    except ValueError:  # Python does not write out an integer of thousands of digits
        text = "a number of thousands of digits"
    return text if len(text) <= 60 else f"{text[:57]}..."


def printable(text: str) -> str:
    """Return a text, with control characters escaped if it has any.

    Parameters
    ----------
    text

    Returns
    -------
    text
        a Python literal if anything was escaped
    """
    return text if text.isprintable() else repr(text)


def visible(text: str) -> str:
    """Return a text on one line, with control characters escaped, for a terminal, a page or an XML file.

    Parameters
    ----------
    text

    Returns
    -------
    text
    """
    return "".join(char if char.isprintable() else repr(char)[1:-1] for char in text)
