"""Throw one die in every physics engine: which one is wrong, by how much, and why.

One function per command, with the same words, defaults and results; `tumble.Scene` makes scenes, `@tumble.engine` makes
a contestant of a function.  Heavy parts load when they are used.
"""

import sys
from importlib import import_module
from types import ModuleType

TYPE_CHECKING = False  # what typing has; importing typing takes most of the 20 ms
if TYPE_CHECKING:
    from typing import Any

    from tumble.api.ablate import ablate as ablate
    from tumble.api.advise import advise as advise
    from tumble.api.check import check as check
    from tumble.api.compare import compare as compare
    from tumble.api.engines import check_engine as check_engine
    from tumble.api.engines import engine as engine
    from tumble.api.engines import engines as engines
    from tumble.api.grade import grade as grade
    from tumble.api.merge import merge as merge
    from tumble.api.reference import reference as reference
    from tumble.api.releases import releases as releases
    from tumble.api.report import report as report
    from tumble.api.result import Result as Result
    from tumble.api.result import read as read
    from tumble.api.run import run as run
    from tumble.api.scene import Scene as Scene
    from tumble.api.scene import scenes as scenes
    from tumble.api.session import session as session
    from tumble.api.stability import stability as stability
    from tumble.api.sweep import sweep as sweep
    from tumble.scenarios.refusal import UserError as UserError

# Every public name, and the module that has it: the one import path of each is `tumble.NAME`.
_HOMES = {
    "Result": "tumble.api.result",
    "Scene": "tumble.api.scene",
    "UserError": "tumble.scenarios.refusal",
    "ablate": "tumble.api.ablate",
    "advise": "tumble.api.advise",
    "check": "tumble.api.check",
    "check_engine": "tumble.api.engines",
    "compare": "tumble.api.compare",
    "engine": "tumble.api.engines",
    "engines": "tumble.api.engines",
    "grade": "tumble.api.grade",
    "merge": "tumble.api.merge",
    "read": "tumble.api.result",
    "reference": "tumble.api.reference",
    "releases": "tumble.api.releases",
    "report": "tumble.api.report",
    "run": "tumble.api.run",
    "scenes": "tumble.api.scene",
    "session": "tumble.api.session",
    "stability": "tumble.api.stability",
    "sweep": "tumble.api.sweep",
}
__all__ = [
    "Result",
    "Scene",
    "UserError",
    "ablate",
    "advise",
    "check",
    "check_engine",
    "compare",
    "engine",
    "engines",
    "grade",
    "merge",
    "read",
    "reference",
    "releases",
    "report",
    "run",
    "scenes",
    "session",
    "stability",
    "sweep",
]


class _CallablePackage(ModuleType):
    """The package `tumble.compare`, which can also be called: it has the name of a command's function."""

    def __call__(self, *arguments: "Any", **options: "Any") -> "Any":
        return import_module(_HOMES["compare"]).compare(*arguments, **options)

    @property
    def __doc__(self) -> str | None:  # type: ignore[override]
        return import_module(_HOMES["compare"]).compare.__doc__

    @property
    def __signature__(self) -> "Any":
        return import_module("inspect").signature(import_module(_HOMES["compare"]).compare)


class _Package(ModuleType):
    """This package: what the import system sets as its attribute `compare` becomes callable."""

    def __setattr__(self, name: str, value: object) -> None:
        if name == "compare" and isinstance(value, ModuleType):
            value.__class__ = _CallablePackage
        super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *__all__})


def __getattr__(name: str) -> "Any":
    if name == "compare":
        return import_module("tumble.compare")
    if name in _HOMES:
        found = getattr(import_module(_HOMES[name]), name)
        globals()[name] = found
        return found
    raise AttributeError(f"module 'tumble' has no attribute {name!r}; there are {', '.join(__all__)}")


sys.modules[__name__].__class__ = _Package
