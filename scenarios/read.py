"""From a scene file (TOML) to a Scene, or to the one line that says what is wrong with it.

The tables below are the format: msgspec holds a file against their keys, types and signs, and the rest of this room
checks what a type cannot say.  Reading runs no code and opens no file but the scene and its mesh.
"""

import difflib
import io
import os
import re
import reprlib
import stat
import sys
import tomllib
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
from msgspec import Meta, inspect

from scenarios import mass
from scenarios.frames import Array, quaternion_product, rotation_matrix, vertices
from scenarios.impulse import RayMissed, jump
from scenarios.scene import Body, Drag, Floor, Impulse, Ray, Scene, Tether, frozen_array

CATALOGUE = Path(__file__).parent / "catalogue"
MESH_FORMATS = ("stl", "ply", "off")
LARGEST_FILE = 100_000_000  # bytes
MOST_SAMPLES = 1_000_000
MOST_STEPS = 1e9
ROUNDING = 1e-12  # relative: how far a tensor may be from symmetric, or from A + B >= C
SMALLEST, LARGEST = sys.float_info.min, sys.float_info.max  # between which a float has all its digits
DEEPEST = 4  # impulse[0].ray.origin
LANDINGS = ("point", "vertex", "point_body", "ray")

# --- the format: what is allowed, and the words that say so -----------------------------------------------------------

Text = Annotated[str, Meta(description="a string")]
Number = Annotated[float, Meta(description="a number")]
Positive = Annotated[float, Meta(gt=0, description="a number > 0")]
NotNegative = Annotated[float, Meta(ge=0, description="a number >= 0")]
Index = Annotated[int, Meta(ge=0, description="a whole number >= 0")]
Count = Annotated[int, Meta(ge=1, le=MOST_SAMPLES, description=f"a whole number from 1 to {MOST_SAMPLES}")]
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


class _Body(_Table, tag_field="shape"):
    mass: Positive
    position: Vector = ORIGIN
    orientation: Quaternion = (1.0, 0.0, 0.0, 0.0)
    velocity: Vector = ORIGIN
    angular_velocity: Vector = ORIGIN


class _Box(_Body, tag="box", kw_only=True):
    size: Size


class _Mesh(_Body, tag="mesh", kw_only=True):
    file: Text


class _Rigid(_Body, tag="rigid", kw_only=True):
    inertia: Tensor
    points: Points


class _Ray(_Table):
    origin: Vector
    direction: Vector


class _Impulse(_Table):
    time: NotNegative = 0.0
    value: Vector | None = None
    magnitude: NotNegative | None = None
    direction: Vector | None = None
    point: Vector | None = None
    vertex: Index | None = None
    point_body: Vector | None = None
    ray: _Ray | None = None


class _Tether(_Table):
    vertex: Index
    anchor: Vector
    stiffness: NotNegative
    damping: NotNegative = 0.0
    rest_length: NotNegative = 0.0


class _Drag(_Table):
    linear: NotNegative = 0.0
    angular: NotNegative = 0.0


class _Floor(_Table):
    stiffness: NotNegative
    height: Number = 0.0
    normal: Vector = (0.0, 1.0, 0.0)
    damping: NotNegative = 0.0


class _File(_Table):
    title: Text
    duration: Positive
    step: Positive
    body: _Box | _Mesh | _Rigid
    source: Text = ""
    times: Times | None = None
    samples: Count | None = None
    gravity: Vector = ORIGIN
    impulse: Annotated[list[_Impulse], Meta(description="tables headed [[impulse]]")] = []
    tether: Annotated[list[_Tether], Meta(description="tables headed [[tether]]")] = []
    drag: _Drag | None = None
    floor: _Floor | None = None


# --- reading ----------------------------------------------------------------------------------------------------------

type_of = inspect.type_info
Keys = tuple[str | int, ...]


class BadScene(ValueError):
    """A scene that cannot be read; its text is the one line to show."""


class _Refused(Exception):
    """Why the value at a path of keys and list indices is refused."""

    def __init__(self, keys: Keys, why: str, show_value: bool = True) -> None:
        self.keys, self.why, self.show_value = keys, why, show_value


def catalogue() -> list[str]:
    """Return the names of the scenes that come with Tumble."""
    return sorted(path.stem for path in CATALOGUE.glob("*.toml"))


def read_scene(name_or_path: str) -> Scene:
    """Return the scene of that name in the catalogue, or in that file (anything with .toml or a path separator).

    Raises BadScene.
    """
    path, shown = _locate(name_or_path), _printable(name_or_path)
    document = _document(path, shown)
    try:
        # What overflows is refused by its result, not by a warning on the way.
        with np.errstate(all="ignore"):
            return _scene(_tables(document), path)
    except _Refused as refused:
        value = f" = {_short(_at(document, refused.keys))}" if refused.show_value else ""
        raise BadScene(f"{shown}: {_dotted(refused.keys)}{value}: {refused.why}") from None


def _locate(name_or_path: str) -> Path:
    if name_or_path.endswith(".toml") or any(sep in name_or_path for sep in (os.sep, os.altsep) if sep):
        return Path(name_or_path)
    names = catalogue()
    if name_or_path not in names:
        raise BadScene(f"unknown scene {_short(name_or_path)}: {_hint(name_or_path, names)}")
    return CATALOGUE / f"{name_or_path}.toml"


def _document(path: Path, shown: str) -> dict:
    try:
        return tomllib.loads(_bytes(path).decode("utf-8-sig"))
    except OSError as error:
        raise BadScene(f"{shown}: {_why_unread(error)}") from None
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise BadScene(f"{shown}: not UTF-8 text (at line {line})") from None
    except RecursionError:
        raise BadScene(f"{shown}: not TOML: nested too deeply") from None
    except ValueError as error:  # besides TOMLDecodeError: an integer of thousands of digits
        raise BadScene(f"{shown}: not TOML: {_printable(str(error))}") from None


def _bytes(path: Path) -> bytes:
    """Return what is in a plain file of sensible length; raises OSError."""
    try:
        status = path.stat()
    except ValueError as error:  # a null character in the path
        raise OSError(0, str(error)) from None
    if not stat.S_ISREG(status.st_mode):
        raise OSError(0, "not a plain file")
    if status.st_size > LARGEST_FILE:
        raise OSError(0, f"larger than {LARGEST_FILE // 10**6} MB")
    return path.read_bytes()


def _why_unread(error: OSError) -> str:
    return "no such file" if isinstance(error, FileNotFoundError) else f"cannot be read: {error.strerror}"


# --- keys, types and signs --------------------------------------------------------------------------------------------


def _tables(document: dict) -> _File:
    """Return the document as tables; raises _Refused for a key, type, sign or non-finite number."""
    if "ensemble" in document:
        raise _Refused(("ensemble",), "many throws of one scene are not in this version: leave the table out", False)
    _refuse_odd(document, ())
    try:
        return msgspec.convert(document, _File)
    except msgspec.ValidationError as error:
        raise _explained(str(error), document) from None


def _refuse_odd(value: object, keys: Keys) -> None:
    """Raise _Refused for a number that is not finite, and for keys and depths that no scene has."""
    if isinstance(value, dict | list):
        if len(keys) > DEEPEST:
            raise _Refused(keys[:1], "nested too deeply", False)
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            if isinstance(key, str) and not re.fullmatch(r"[\w-]+", key):
                raise _Refused((*keys, key), "unknown key; keys are letters, digits, _ and -", False)
            _refuse_odd(item, (*keys, key))
    elif isinstance(value, int | float) and not -LARGEST <= value <= LARGEST:
        raise _Refused(keys, "must be finite")


def _explained(message: str, document: dict) -> _Refused:
    """Return what msgspec complains of in our own words: the key it points at, and what the tables allow there."""
    complaint, _, where = message.partition(" - at `$")
    keys: Keys = tuple(int(index) if index else key for key, index in re.findall(r"(\w+)|\[(\d+)]", where))
    kind: Any = type_of(_File)
    for depth, key in enumerate(keys, start=1):
        kind = _member(kind, key, _at(document, keys[:depth]))
    if unknown := re.fullmatch(r"Object contains unknown field `(.*)`", complaint):
        hint = _hint(unknown[1], [field.name for field in kind.fields])
        return _Refused((*keys, unknown[1]), f"unknown key; {hint}", False)
    if missing := re.fullmatch(r"Object missing required field `(.*)`", complaint):
        return _Refused((*keys, missing[1]), f"missing; must be {_words(_member(kind, missing[1], None))}", False)
    value = _at(document, keys)
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return _Refused(keys, f"must be {_words(kind).removeprefix('a number ' if is_number else '')}")


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


# --- from tables to a scene -------------------------------------------------------------------------------------------


def _scene(file: _File, path: Path) -> Scene:
    """Return the scene; raises _Refused for what the types alone could not see."""
    if not file.title.isprintable():
        raise _Refused(("title",), "must be one line of printable text")
    if file.duration / file.step > MOST_STEPS:
        raise _Refused(("step",), f"must be at least the duration / {MOST_STEPS:.0e}")
    body = _body(file.body, path.parent)
    start = _start(file.body, body)
    impulses = [_impulse(table, ("impulse", i), file.duration, body, start) for i, table in enumerate(file.impulse)]
    tethers = [_tether(table, ("tether", i), body) for i, table in enumerate(file.tether)]
    return Scene(
        name=path.stem,
        title=file.title,
        source=file.source,
        duration=file.duration,
        times=_times(file),
        step=file.step,
        body=body,
        start=start,
        gravity=frozen_array(file.gravity) if any(file.gravity) else None,
        impulses=tuple(sorted((impulse for impulse in impulses if impulse.value.any()), key=lambda it: it.time)),
        tethers=tuple(tether for tether in tethers if tether.stiffness or tether.damping),
        drag=_drag(file.drag) if file.drag else None,
        floor=_floor(file.floor) if file.floor else None,
    )


def _times(file: _File) -> Array:
    """Return the sample instants [s], (S,)."""
    if file.times is not None and file.samples is not None:
        raise _Refused(("samples",), "must be left out where times are given")
    if file.times is not None:
        times, keys = np.array(file.times), ("times",)
    elif file.samples is not None:
        times, keys = np.linspace(0, file.duration, file.samples + 1)[1:], ("samples",)
    else:
        raise _Refused(("times",), "missing; must be a list of instants, or samples a number of them", False)
    if not (np.diff(times) > 0).all():
        raise _Refused(keys, "must be strictly increasing instants")
    if times[0] < 0 or times[-1] > file.duration:
        raise _Refused(keys, f"must be within the duration, 0 to {file.duration!r}")
    return frozen_array(times)


def _body(table: _Box | _Mesh | _Rigid, folder: Path) -> Body:
    """Return the body in its principal axes."""
    size, where = None, ("body",)
    if isinstance(table, _Box):
        size = frozen_array(table.size)
        points, faces, tensor = mass.box_corners(size), mass.BOX_FACES, mass.box(table.mass, size).tensor
    elif isinstance(table, _Mesh):
        points, faces, tensor = _solid(table, folder)
    else:
        points, faces, tensor = np.array(table.points), np.empty((0, 3), dtype=int), np.array(table.inertia)
        where = ("body", "inertia")
    moments, file_axes = _principal(tensor, where)
    points = frozen_array(points @ rotation_matrix(file_axes).T)
    shape = str(table.__struct_config__.tag)
    return Body(shape, table.mass, moments, points, frozen_array(faces, int), size, file_axes)


def _principal(tensor: Array, where: Keys) -> tuple[Array, Array]:
    """Return moments and axes, as mass.principal_axes does, of a tensor that some body could have."""
    if not np.isfinite(tensor).all():
        raise _Refused(where, "must have finite moments of inertia")
    if (np.abs(tensor - tensor.T) > ROUNDING * np.abs(tensor).max()).any():
        raise _Refused(where, "must be symmetric")
    moments, file_axes = mass.principal_axes(tensor / 2 + tensor.T / 2)
    a, b, c = sorted(moments)
    if a < SMALLEST:
        raise _Refused(where, f"must have principal moments of inertia > 0, but one is {a:.3g}")
    if a + b < c * (1 - ROUNDING):
        raise _Refused(where, f"inertia that no body has: A + B >= C must hold, but {a:.6g} + {b:.6g} < {c:.6g}")
    return moments, file_axes


def _solid(table: _Mesh, folder: Path) -> tuple[Array, np.ndarray, Array]:
    """Return a mesh's points from its centre of mass [m], (n, 3), outward faces, (m, 3), and tensor [kg m2], (3, 3)."""
    points, faces = _surface(table.file, folder)
    try:
        solid = mass.mesh(table.mass, points, faces)
    except ValueError as error:
        raise _Refused(("body", "file"), f"must be the surface of a solid: {error}") from None
    return points - solid.centre, faces if solid.volume > 0 else faces[:, ::-1], solid.tensor


def _surface(file: str, folder: Path) -> tuple[Array, np.ndarray]:
    """Return the closed surface in a mesh file: its points [m], (n, 3), as they first appear, and faces, (m, 3)."""
    where, kind = ("body", "file"), file.rpartition(".")[2].lower()
    if kind not in MESH_FORMATS:
        raise _Refused(where, f"must end in one of .{', .'.join(MESH_FORMATS)}")
    try:
        data = _bytes(folder / file)
    except OSError as error:
        raise _Refused(where, _why_unread(error)) from None
    import trimesh  # slow to import, and needed here only

    try:
        # From bytes, so that a mesh cannot make its reader open further files.
        read = trimesh.load_mesh(io.BytesIO(data), file_type=kind, process=False)
        corners = np.asarray(read.vertices, dtype=float)[read.faces]
    except Exception:  # whatever the parser trips over in a file of anyone's
        raise _Refused(where, "must be a mesh that can be read") from None
    # A triangle with two corners in one is an edge: it bounds nothing.
    corners = corners[(corners != np.roll(corners, 1, axis=1)).any(axis=2).all(axis=1)]
    if not len(corners):
        raise _Refused(where, "must have triangles, and none were found")
    if not np.isfinite(corners).all():
        raise _Refused(where, "must have finite coordinates")
    points, first, index = np.unique(corners.reshape(-1, 3), axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    points, faces = points[order], np.argsort(order)[index].reshape(-1, 3)
    closed = trimesh.Trimesh(points, faces, process=False)
    if not closed.is_watertight:
        raise _Refused(where, "must be closed: every edge in exactly two triangles")
    if not closed.is_winding_consistent:
        raise _Refused(where, "must have all its triangles turn the same way")
    return points, faces


def _start(table: _Body, body: Body) -> Array:
    """Return the state before any impulse, (1, 13)."""
    # The file says how its own axes stand; the state, how the principal axes do.
    to_file_axes = body.file_axes * (1, -1, -1, -1)
    q = quaternion_product(_unit(table.orientation, ("body", "orientation")), to_file_axes)
    start = frozen_array([[*table.position, *q, *table.velocity, *table.angular_velocity]])
    if not np.isfinite(vertices(start, body.points)).all():
        raise _Refused(("body",), "must have vertices at finite coordinates")
    return start


def _unit(vector: tuple[float, ...], keys: Keys) -> Array:
    largest = max(map(abs, vector))
    scaled = np.array(vector) / (largest or 1.0)  # whose squares neither overflow nor all underflow
    if not scaled.any():
        raise _Refused(keys, "must not be zero")
    return frozen_array(scaled / np.linalg.norm(scaled))


def _vertex(vertex: int, keys: Keys, body: Body) -> Array:
    if vertex >= len(body.points):
        raise _Refused(keys, f"must be a vertex of the body, 0 to {len(body.points) - 1}")
    return body.points[vertex]


def _impulse(table: _Impulse, keys: Keys, duration: float, body: Body, start: Array) -> Impulse:
    if table.time > duration:
        raise _Refused((*keys, "time"), f"must be within the duration, 0 to {duration!r}")
    impulse = Impulse(table.time, _blow(table, keys), **_landing(table, keys, body))
    if impulse.ray and table.time > 0:
        return impulse  # whether it meets the body, only the flight can tell
    try:
        # Blows of one instant do not move the body, so each meets it as it starts; a later one is tried for size.
        struck = jump(impulse, start, body)
    except RayMissed as error:
        raise _Refused((*keys, "ray"), f"must meet the body's surface from outside: {error}") from None
    if not np.isfinite(struck).all():
        raise _Refused(keys, "must leave the body with a finite velocity")
    return impulse


def _blow(table: _Impulse, keys: Keys) -> Array:
    """Return the impulse itself [N s], (3,)."""
    if table.value is not None and table.magnitude is None:
        if table.direction is not None:
            raise _Refused((*keys, "direction"), "must be left out where value is given")
        return frozen_array(table.value)
    if table.magnitude is None or table.value is not None:
        raise _Refused(keys, "must have either value, or magnitude with a direction")
    if table.direction is not None:
        return frozen_array(table.magnitude * _unit(table.direction, (*keys, "direction")))
    if table.ray is not None:
        return frozen_array(table.magnitude * _unit(table.ray.direction, (*keys, "ray", "direction")))
    raise _Refused((*keys, "magnitude"), "must come with a direction, or with a ray that gives it")


def _landing(table: _Impulse, keys: Keys, body: Body) -> dict[str, Any]:
    """Return the one field of an Impulse that says where it lands."""
    given = [key for key in LANDINGS if getattr(table, key) is not None]
    if len(given) != 1:
        has = " and ".join(given) or "none"
        raise _Refused(keys, f"must have exactly one of {', '.join(LANDINGS)}; it has {has}")
    where = getattr(table, given[0])
    keys = (*keys, given[0])
    match given[0]:
        case "point":
            return {"point_world": frozen_array(where)}
        case "vertex":
            return {"point_body": _vertex(where, keys, body)}
        case "point_body":
            return {"point_body": frozen_array(rotation_matrix(body.file_axes) @ where)}
        case _:
            return {"ray": _ray(where, keys, body)}


def _ray(table: _Ray, keys: Keys, body: Body) -> Ray:
    if not len(body.faces):
        raise _Refused(keys, "must meet a surface, and a rigid body has none: give a point or a vertex")
    return Ray(frozen_array(table.origin), _unit(table.direction, (*keys, "direction")))


def _tether(table: _Tether, keys: Keys, body: Body) -> Tether:
    point_body = _vertex(table.vertex, (*keys, "vertex"), body)
    return Tether(point_body, frozen_array(table.anchor), table.stiffness, table.damping, table.rest_length)


def _drag(table: _Drag) -> Drag | None:
    return Drag(table.linear, table.angular) if table.linear or table.angular else None


def _floor(table: _Floor) -> Floor | None:
    normal = _unit(table.normal, ("floor", "normal"))
    return Floor(table.height, normal, table.stiffness, table.damping) if table.stiffness or table.damping else None


# --- the one line -----------------------------------------------------------------------------------------------------


_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 60
_SHORT.maxlist = 9


def _at(document: Any, keys: Keys) -> Any:
    """Return the value at a path of keys and list indices."""
    for key in keys:
        document = document[key]
    return document


def _dotted(keys: Keys) -> str:
    """Return the path as a person writes it: impulse[0].value."""
    parts = (f"[{key}]" if isinstance(key, int) else f".{_key(key)}" for key in keys)
    return "".join(parts).removeprefix(".")


def _key(key: str) -> str:
    return key if re.fullmatch(r"[\w-]{1,60}", key) else _short(key)


def _short(value: object) -> str:
    """Return a value on one line of at most 60 characters."""
    try:
        text = _SHORT.repr(value)
    except ValueError:  # Python does not write out an integer of thousands of digits
        text = "a number of thousands of digits"
    return text if len(text) <= 60 else f"{text[:57]}..."


def _printable(text: str) -> str:
    return text if text.isprintable() else repr(text)


def _hint(name: str, known: list[str]) -> str:
    near = difflib.get_close_matches(name, known, n=1)
    return f"did you mean {near[0]!r}?" if near else f"there are {', '.join(known)}"
