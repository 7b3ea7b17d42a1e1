"""The digest of a value, by which a finished task is found again: of plain values, arrays, dataclasses, functions."""

import hashlib
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache, partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np


class NoValue(TypeError):
    """Something that is no value: it is another one in another process, or holds what cannot be compared."""


def digest(value: object) -> str:
    """Return 32 hexadecimal digits that differ for another value, and are the same in every process.

    value: None, numbers, texts, bytes, paths, arrays, functions of a module, and lists, sets, dicts, dataclasses and
    partial calls of those.  What has an `identity` stands for that: it follows from it, maybe with another last bit on
    another processor.
    Raises NoValue.
    """
    found = hashlib.sha256()
    _feed(found.update, value)
    return found.hexdigest()[:32]


def _feed(update: Callable[[bytes], object], value: Any) -> None:
    """Hash a value, its type first: no two values have the same bytes."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, Enum):
        value = value.value
    update(type(value).__name__.encode() + b"(")
    if (identity := getattr(value, "identity", None)) is not None:
        value = identity
    if value is None or isinstance(value, bool | int | float | str | Path):
        update(repr(value).encode("utf-8", "backslashreplace"))
    elif isinstance(value, bytes):
        update(b"%d:" % len(value) + value)
    elif isinstance(value, np.ndarray):
        update(f"{value.dtype.str}{value.shape}:".encode() + np.ascontiguousarray(value).tobytes())
    elif isinstance(value, partial):
        _feed(update, [value.func, list(value.args), value.keywords])
    elif is_dataclass(value):
        for field in fields(value):
            update(field.name.encode() + b"=")
            _feed(update, getattr(value, field.name))
    elif isinstance(value, list | tuple):
        for item in value:
            _feed(update, item)
    elif isinstance(value, set | frozenset | dict):
        pairs = value.items() if isinstance(value, dict) else ((item, None) for item in value)
        for one in sorted(digest(pair) for pair in pairs):
            update(one.encode())
    elif callable(value) and "<" not in getattr(value, "__qualname__", "<"):
        update(f"{value.__module__}:{value.__qualname__}".encode())
    else:
        raise NoValue(f"a {type(value).__name__} is no value: {value!r}")
    update(b")")


@cache
def code_digest() -> str:
    """Return the digest of Tumble's own code that results depend on: in a checkout it changes between versions."""
    # Found, not imported: the solver would bring the compiler.
    specs = map(find_spec, ("tumble.compare", "tumble.scenarios", "tumble.solver"))
    folders = [Path(path) for spec in specs if spec for path in spec.submodule_search_locations or ()]
    found = {
        f"{folder.name}/{file.relative_to(folder).as_posix()}": file.read_bytes()
        for folder in folders
        for file in folder.rglob("*.py")
    }
    return digest(found)
