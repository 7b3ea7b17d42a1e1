"""The format of a scene file: its tables, what is allowed in them, and the words that refuse the rest.

msgspec holds a file against these tables' keys, types and signs; its complaint is put in our own words, with the key it
points at, the value found there, and what the table allows.
"""

import math
import re
import reprlib
import sys
from collections.abc import Sequence
from typing import Annotated, Any

import msgspec
from msgspec import Meta, inspect

MOST_SAMPLES = 1_000_000
MOST_THROWS = 1_000_000
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
Shape = Annotated[str, Meta(description="'box', 'mesh' or 'rigid'")]

ORIGIN = (0.0, 0.0, 0.0)


class _Table(msgspec.Struct, forbid_unknown_fields=True):
    pass


class BodyTable(_Table, tag_field="shape"):
    """[body]: what every shape has."""

    mass: Positive
    position: Vector = ORIGIN
    orientation: Quaternion = (1.0, 0.0, 0.0, 0.0)
    velocity: Vector = ORIGIN
    angular_velocity: Vector = ORIGIN


class BoxTable(BodyTable, tag="box", kw_only=True):
    """A box, by its full edges [m]."""

    size: Size


class MeshTable(BodyTable, tag="mesh", kw_only=True):
    """A closed mesh in a file beside the scene."""

    file: Text


class RigidTable(BodyTable, tag="rigid", kw_only=True):
    """A body given by its tensor [kg m2] and points [m]."""

    inertia: Tensor
    points: Points


class RayTable(_Table):
    """A click."""

    origin: Vector
    direction: Vector


class ImpulseTable(_Table):
    """[[impulse]]."""

    time: NotNegative = 0.0
    value: Vector | None = None
    magnitude: NotNegative | None = None
    direction: Vector | None = None
    point: Vector | None = None
    vertex: Index | None = None
    point_body: Vector | None = None
    ray: RayTable | None = None


class TetherTable(_Table):
    """[[tether]]."""

    vertex: Index
    anchor: Vector
    stiffness: NotNegative
    damping: NotNegative = 0.0
    rest_length: NotNegative = 0.0


class DragTable(_Table):
    """[drag]."""

    linear: NotNegative = 0.0
    angular: NotNegative = 0.0


class FloorTable(_Table):
    """[floor]."""

    stiffness: NotNegative
    height: Number = 0.0
    normal: Vector = (0.0, 1.0, 0.0)
    damping: NotNegative = 0.0


class EnsembleTable(_Table):
    """[ensemble]: many throws, and how far they are spread."""

    throws: Throws
    seed: Index = 0
    magnitude: Share = 0.0
    cone: HalfTurn = 0.0
    point: NotNegative = 0.0
    orientation: HalfTurn = 0.0


class File(_Table):
    """The whole file."""

    title: Text
    duration: Positive
    step: Positive
    body: BoxTable | MeshTable | RigidTable
    source: Text = ""
    times: Times | None = None
    samples: Count | None = None
    gravity: Vector = ORIGIN
    impulse: Annotated[list[ImpulseTable], Meta(description="tables headed [[impulse]]")] = []
    tether: Annotated[list[TetherTable], Meta(description="tables headed [[tether]]")] = []
    drag: DragTable | None = None
    floor: FloorTable | None = None
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
        return msgspec.convert(document, File)
    except msgspec.ValidationError as error:
        raise _explained(str(error), document) from None


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
    parts = (f"[{key}]" if isinstance(key, int) else f".{_key(key)}" for key in keys)
    return "".join(parts).removeprefix(".")


def _key(key: str) -> str:
    return key if re.fullmatch(r"[\w-]{1,60}", key) else short(key)


def short(value: object) -> str:
    """Return a value on one line of at most 60 characters."""
    try:
        text = _SHORT.repr(value)
    except ValueError:  # Python does not write out an integer of thousands of digits
        text = "a number of thousands of digits"
    return text if len(text) <= 60 else f"{text[:57]}..."


def printable(text: str) -> str:
    """Return a text as it is, or with its control characters written out."""
    return text if text.isprintable() else repr(text)


def visible(text: str) -> str:
    """Return a text on one line, control characters written out: what a terminal, a page or an XML file may show."""
    return "".join(char if char.isprintable() else repr(char)[1:-1] for char in text)


def nearest(name: str, known: Sequence[str]) -> str:
    """Return the words that offer the nearest of the known names, or all of them where none is near."""
    import difflib  # only a mistake pays for it

    near = difflib.get_close_matches(name, known, n=1)
    return f"did you mean {near[0]!r}?" if near else f"there are {', '.join(known)}"
