"""The name of a contestant, ENGINE[@RELEASE]:METHOD[+VARIANT...][@TOLERANCE], taken apart and put together."""

import re
from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Self

from tumble.scenarios.refusal import UserError

FILES = (".py", ".toml")  # endings of a user's own engine file or program
RELEASE = re.compile(r"[0-9A-Za-z][0-9A-Za-z.!+_-]*")


class BadEngine(UserError):
    """An engine name or file that cannot be used; the message is the one line for the user."""


@dataclass(frozen=True)
class MethodName:
    """METHOD[+VARIANT...][@TOLERANCE].

    Parameters
    ----------
    name : name of the method; empty: the usual methods of the engine
    variants : names of the variants, in order
    tolerance : the tolerance as text, as it was written; empty if there is none
    """

    name: str = ""
    variants: tuple[str, ...] = ()
    tolerance: str = ""

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the parts of any text; one with an empty part (`a+`, `@1`) is a name as a whole."""
        head, _, tolerance = text.partition("@")
        name, *variants = head.split("+")
        parsed = cls(name, tuple(variants), tolerance)
        return parsed if name and all(variants) and str(parsed) == text else cls(text)

    def __str__(self) -> str:
        """Return the method as it is named in tables and on the command line."""
        return "+".join((self.name, *self.variants)) + (f"@{self.tolerance}" if self.tolerance else "")

    @property
    def without_tolerance(self) -> Self:
        """METHOD[+VARIANT...]."""
        return replace(self, tolerance="")


@dataclass(frozen=True)
class Contestant:
    """An engine, one of its releases and one of its methods.

    Parameters
    ----------
    engine : name of the engine, or path of a user's file
    release : release of the engine; empty: the one installed beside Tumble
    method : method of the engine; one with an empty name: the usual methods
    """

    engine: str
    release: str = ""
    method: MethodName = MethodName()

    @classmethod
    def of(cls, engine: str, method: str = "") -> Self:
        """Return the contestant of ENGINE[@RELEASE] and METHOD[+VARIANT...][@TOLERANCE], the columns of tables."""
        name, _, release = engine.partition("@")
        if engine.endswith(FILES) or not (name and release):
            name, release = engine, ""
        return cls(name, release, MethodName.parse(method))

    @classmethod
    def of_name(cls, text: str) -> Self:
        """Return the contestant of a name that a table shows, ENGINE[@RELEASE][:METHOD...]; any text is one."""
        for ending in FILES:
            head, found, tail = text.rpartition(ending)
            if head and found and tail[:1] in ("", ":"):
                return cls(head + found, "", MethodName.parse(tail[1:]))
        engine, _, method = text.partition(":")
        return cls.of(engine, method)

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the contestant that a text names.

        Parameters
        ----------
        text : ENGINE[@RELEASE][:METHOD[+VARIANT...][@TOLERANCE]]; the engine may be a file FILE.py or FILE.toml

        Raises
        ------
        BadEngine
            if the text names no engine, or a release that none can have
        """
        found = cls.of_name(text)
        if found.engine.endswith(FILES):
            return found
        name, at, _ = found.engine.partition("@")
        if not name:
            raise BadEngine(f"{text!r} names no engine: ENGINE[@RELEASE][:METHOD]")
        if at or (found.release and not RELEASE.fullmatch(found.release)):
            raise BadEngine(f"{found.engine_release}: a release is written as in {name}@1.2.3")
        return found

    def __str__(self) -> str:
        """Return the name as on the command line."""
        return f"{self.engine_release}:{self.method}" if str(self.method) else self.engine_release

    @property
    def engine_release(self) -> str:
        """ENGINE[@RELEASE]."""
        return f"{self.engine}@{self.release}" if self.release else self.engine

    def is_among(self, names: Collection[str]) -> bool:
        """Return whether its name, or that without its tolerance, is one of these."""
        return str(self) in names or str(self.without_tolerance) in names

    @property
    def without_tolerance(self) -> Self:
        """The contestant with the tolerances of an adaptive method together."""
        return replace(self, method=self.method.without_tolerance)
