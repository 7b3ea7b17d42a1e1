"""Messages between Tumble and the process of an engine: plain values and arrays, which are data and never code.

A frame is MAGIC, the lengths of a head (4 bytes) and of a body (8 bytes), the head, which is JSON, and the body, the
bytes of all arrays one after another.  An array stands in the head as its type, its shape and its place in the body.
Both ends need nothing but numpy.  Who reads says what type it expects, down to the last field; anything else is
Malformed.
"""

import json
import re
import struct
import types
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from enum import StrEnum
from functools import cache
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np

MAGIC = b"TMBL"
PREFIX = struct.Struct("<4sIQ")
MOST_HEAD = 1 << 24
ARRAY = "array"
# Booleans, integers and floats: what an array of ours can hold; how such a type is written.  numpy's own reader of
# types takes much more than that, and parses some of it as Python.
KINDS = "biuf"
TYPE = re.compile(rf"[<>|][{KINDS}]\d\d?", re.ASCII)


class Malformed(ValueError):
    """What arrived is no message, or not the message that was waited for; depth: how many fields down that was seen."""

    depth = 0

    def within(self, name: str) -> "Malformed":
        """Return the same of a value that has it as a field of that name."""
        outer = Malformed(f"{self} ({name})" if self.depth == 0 else f"{str(self)[:-1]} of {name})")
        outer.depth = self.depth + 1
        return outer


def frame(value: object) -> list[bytes | memoryview]:
    """Return the parts of a frame: prefix and head, then each array.

    value: None, booleans, numbers, texts, members of a StrEnum, arrays, and lists, sets, dicts and dataclasses of
    those.
    Raises TypeError.
    """
    arrays: list[np.ndarray] = []
    head = json.dumps(_plain(value, arrays)).encode()
    if len(head) > MOST_HEAD:
        raise TypeError(f"a message of {len(head)} bytes besides its arrays; {MOST_HEAD} are allowed")
    prefix = PREFIX.pack(MAGIC, len(head), sum(array.nbytes for array in arrays))
    return [prefix + head, *(array.reshape(-1).view(np.uint8).data for array in arrays)]


def lengths(prefix: bytes) -> tuple[int, int]:
    """Return the length of head and body.  Raises Malformed."""
    magic, head, body = PREFIX.unpack(prefix)
    if magic != MAGIC or head > MOST_HEAD:
        raise Malformed("what it sent is no message")
    return head, body


def split(frames: bytes) -> tuple[bytes, bytes]:
    """Return the head of the first frame, and what comes after it: its body and further frames.  Raises Malformed."""
    if len(frames) < PREFIX.size:
        raise Malformed("what it sent is no message")
    head, _ = lengths(frames[: PREFIX.size])
    return frames[PREFIX.size : PREFIX.size + head], frames[PREFIX.size + head :]


def unframed(hint: Any, data: bytes) -> Any:
    """Return the value of one whole frame as the type of that hint.  Raises Malformed."""
    return unpacked(hint, *split(data))


def unpacked(hint: Any, head: bytes, body: bytes | bytearray) -> Any:
    """Return the value of a frame as the type of that hint; its arrays lie in body.  Raises Malformed."""
    try:
        return _build(hint)(json.loads(head), memoryview(body))
    except Malformed:
        raise
    except (ValueError, TypeError, KeyError, OverflowError, RecursionError) as error:
        raise Malformed(f"what it sent cannot be read: {type(error).__name__}") from error


def _plain(value: object, arrays: list[np.ndarray]) -> object:
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.ndarray):
        if value.dtype.kind not in KINDS:
            raise TypeError(f"an array of {value.dtype}, not of numbers")
        offset = sum(array.nbytes for array in arrays)
        arrays.append(np.asarray(value, value.dtype.newbyteorder("<"), order="C"))
        return {ARRAY: [arrays[-1].dtype.str, list(value.shape), offset]}
    if is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name), arrays) for field in fields(value)}
    if isinstance(value, list | tuple):
        return [_plain(item, arrays) for item in value]
    if isinstance(value, dict) and all(isinstance(key, str) for key in value):
        return {key: _plain(item, arrays) for key, item in value.items()}
    if isinstance(value, dict):
        return [[_plain(key, arrays), _plain(item, arrays)] for key, item in value.items()]
    if isinstance(value, set | frozenset):
        return sorted((_plain(item, arrays) for item in value), key=lambda item: (item is not None, item))
    raise TypeError(f"a {type(value).__name__} is no plain value")


Build = Callable[[Any, memoryview], Any]


def _build(hint: Any) -> Build:
    """Return what makes a value of that type of what stands in a head, and of a body."""
    hint = unaliased(hint)
    # Unions are equal in any order of their types, which are tried in theirs.
    return _as_one_of(get_args(hint)) if get_origin(hint) in (Union, types.UnionType) else _as(hint)


@cache
def _as(hint: Any) -> Build:
    origin, arguments = get_origin(hint), get_args(hint)
    if hint is np.ndarray or origin is np.ndarray:
        return _array
    if is_dataclass(hint):
        return _as_dataclass(hint)
    if origin is dict:
        return _as_dict(*arguments)
    if origin in (tuple, list, set, frozenset):
        return _as_several(origin, arguments)
    if isinstance(hint, type) and issubclass(hint, StrEnum):
        return _as_member(hint)
    return _as_plain(hint)


def _as_plain(hint: Any) -> Build:
    kind, takes_whole = type(None) if hint is None else hint, hint is float

    def build(plain: Any, body: memoryview) -> Any:
        if type(plain) is kind:
            return plain
        if takes_whole and type(plain) is int:
            return float(plain)
        raise Malformed(f"what it sent has a {type(plain).__name__} where a {name_of(hint)} belongs")

    return build


def _as_member(kind: type[StrEnum]) -> Build:
    def build(plain: Any, body: memoryview) -> Any:
        if type(plain) is not str or plain not in {*kind}:
            raise Malformed(f"what it sent has no {name_of(kind)} where one belongs")
        return kind(plain)

    return build


def _as_dataclass(kind: Any) -> Build:
    hints = get_type_hints(kind)
    builds = {field.name: _build(hints[field.name]) for field in fields(kind)}

    def build(plain: Any, body: memoryview) -> Any:
        if not isinstance(plain, dict) or plain.keys() != builds.keys():
            raise Malformed(f"what it sent is no {name_of(kind)}")
        values = {}
        for name, of_field in builds.items():
            try:
                values[name] = of_field(plain[name], body)
            except Malformed as error:
                raise error.within(name) from None
        return kind(**values)

    return build


def _as_dict(of_key: Any, of_value: Any) -> Build:
    if of_key is not str:
        pairs = _build(list[tuple[of_key, of_value]])
        return lambda plain, body: dict(pairs(plain or [], body))  # without a key, {} is a dict by text too
    value = _build(of_value)

    def build(plain: Any, body: memoryview) -> Any:
        if not isinstance(plain, dict):
            raise Malformed(f"what it sent has a {type(plain).__name__} where names and values belong")
        return {name: value(one, body) for name, one in plain.items()}

    return build


def _as_several(kind: Any, arguments: tuple[Any, ...]) -> Build:
    """Of tuple[A, B], or of tuple[A, ...], list[A] or a set of A."""
    repeated = kind is not tuple or arguments[-1:] == (...,)
    of_each = [_build(item) for item in (arguments[:1] if repeated else arguments)]

    def build(plain: Any, body: memoryview) -> Any:
        if not isinstance(plain, list):
            raise Malformed(f"what it sent has a {type(plain).__name__} where a list belongs")
        builds = of_each * len(plain) if repeated else of_each
        return kind(one(item, body) for one, item in zip(builds, plain, strict=True))

    return build


@cache
def _as_one_of(hints: tuple[Any, ...]) -> Build:
    """Of the first of these types that it can be.

    Raises Malformed with the reason of the type that it comes nearest to: whose fields it has.
    """
    builds = [_build(hint) for hint in hints]

    def build(plain: Any, body: memoryview) -> Any:
        reasons = []
        for one in builds:
            try:
                return one(plain, body)
            except Malformed as error:
                # A traceback would hold this frame, which holds the reasons: the arrays would stay until the next
                # collection of cycles.
                reasons.append(error.with_traceback(None))
        nearest = max(reasons, key=lambda error: error.depth)
        raise nearest if nearest.depth else Malformed(f"what it sent is no {' or '.join(map(name_of, hints))}")

    return build


def unaliased(hint: Any) -> Any:
    """Return what a type's alias stands for, the type itself where it is none.

    `type A[T] = ...` of Python 3.12, as which numpy 2.5 has NDArray, is neither what it stands for nor an origin of it.
    """
    while hasattr(alias := get_origin(hint) or hint, "__value__"):
        arguments = get_args(hint)
        hint = alias.__value__[arguments] if arguments else alias.__value__
    return hint


def _array(plain: Any, body: memoryview) -> np.ndarray:
    if not isinstance(plain, dict) or set(plain) != {ARRAY}:
        raise Malformed("what it sent has no array where one belongs")
    kind, shape, offset = plain[ARRAY]
    if not (isinstance(kind, str) and TYPE.fullmatch(kind)):
        raise Malformed("what it sent has an array of no numbers")
    dtype = np.dtype(kind)
    if any(type(length) is not int or length < 0 for length in (*shape, offset)):
        raise Malformed("what it sent has an array of no numbers")
    return np.ndarray(shape, dtype, body, offset)


def name_of(hint: Any) -> str:
    """Return what a type is called."""
    return getattr(hint, "__name__", str(hint))
