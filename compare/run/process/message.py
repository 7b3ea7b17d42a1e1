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
from dataclasses import fields, is_dataclass
from enum import StrEnum
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
        return _built(hint, json.loads(head), memoryview(body))
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


def _built(hint: Any, plain: Any, body: memoryview) -> Any:
    hint = unaliased(hint)
    origin, arguments = get_origin(hint), get_args(hint)
    if origin in (Union, types.UnionType):
        return _built_as_one(arguments, plain, body)
    if hint is np.ndarray or origin is np.ndarray:
        return _array(plain, body)
    if is_dataclass(hint):
        hints = get_type_hints(hint)
        names = [field.name for field in fields(hint)]
        if not isinstance(plain, dict) or set(plain) != set(names):
            raise Malformed(f"what it sent is no {name_of(hint)}")
        return hint(**{name: _built_field(name, hints[name], plain[name], body) for name in names})  # type: ignore[operator]
    if origin is dict and arguments[0] is not str:
        return dict(_built(list[tuple[arguments]], plain or [], body))  # without a key, {} is a dict by text too
    if origin is dict:
        if not isinstance(plain, dict):
            raise Malformed(f"what it sent has a {type(plain).__name__} where names and values belong")
        return {name: _built(arguments[1], value, body) for name, value in plain.items()}
    if origin in (tuple, list, set, frozenset):
        if not isinstance(plain, list):
            raise Malformed(f"what it sent has a {type(plain).__name__} where a list belongs")
        return origin(_built(item, value, body) for item, value in zip(_of_each(hint, plain), plain, strict=True))
    if isinstance(hint, type) and issubclass(hint, StrEnum):
        if type(plain) is not str or plain not in {*hint}:
            raise Malformed(f"what it sent has no {name_of(hint)} where one belongs")
        return hint(plain)
    if hint is float and type(plain) is int:
        return float(plain)
    if type(plain) is not (type(None) if hint is None else hint):
        raise Malformed(f"what it sent has a {type(plain).__name__} where a {name_of(hint)} belongs")
    return plain


def _built_field(name: str, hint: Any, plain: Any, body: memoryview) -> Any:
    try:
        return _built(hint, plain, body)
    except Malformed as error:
        raise error.within(name) from None


def _built_as_one(hints: tuple[Any, ...], plain: Any, body: memoryview) -> Any:
    """Return the value as the first of these types that it can be.

    Raises Malformed with the reason of the type that it comes nearest to: whose fields it has.
    """
    reasons = []
    for hint in hints:
        try:
            return _built(hint, plain, body)
        except Malformed as error:
            # A traceback would hold this frame, which holds the reasons: the arrays would stay until the next
            # collection of cycles.
            reasons.append(error.with_traceback(None))
    nearest = max(reasons, key=lambda error: error.depth)
    raise nearest if nearest.depth else Malformed(f"what it sent is no {' or '.join(map(name_of, hints))}")


def unaliased(hint: Any) -> Any:
    """Return what a type's alias stands for, the type itself where it is none.

    `type A[T] = ...` of Python 3.12, as which numpy 2.5 has NDArray, is neither what it stands for nor an origin of it.
    """
    while hasattr(alias := get_origin(hint) or hint, "__value__"):
        arguments = get_args(hint)
        hint = alias.__value__[arguments] if arguments else alias.__value__
    return hint


def _of_each(hint: Any, plain: list) -> list[Any]:
    """Return the type of each item of a list, by the hint tuple[A, B], tuple[A, ...], list[A] or a set of A."""
    arguments = get_args(hint)
    repeated = get_origin(hint) is not tuple or arguments[-1:] == (...,)
    return [arguments[0]] * len(plain) if repeated else list(arguments)


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
