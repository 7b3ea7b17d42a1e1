"""Which engines there are, and what a name on the command line means."""

import ast
import importlib
import importlib.util
import math
import pkgutil
import sys
import threading
import traceback
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

from tumble.compare import engines
from tumble.compare.engines import CHECKS, CONTACT_CHECKS, FINDINGS, GYROSCOPIC_NAMES, OWN, SCHEME_NAMES, SHIPPED
from tumble.compare.run.contestant import FILES, BadEngine, MethodName
from tumble.compare.run.engines import program
from tumble.compare.run.engines.program import ProgramEngine
from tumble.compare.run.engines.step_function import StepEngine
from tumble.scenarios.needs import FORCES
from tumble.scenarios.refusal import nearest
from tumble.scenarios.scene import Scene

VERBS = ("build", "write", "advance", "read")
# What a step takes where an engine does not say it [ns]: it is a plain loop in Python, as far as anybody knows.
STEP_NS = 50_000.0
OWN_SENSOR, DIFFERENCES = "sensor", "differences"
OWN_SCHEME = "its own"  # in place of a name, for a scheme that an engine states as a function


class Missing(ImportError):
    """An engine of ours whose package is not installed here."""


@dataclass(frozen=True)
class Finding:
    """What an audit found: a kind of tumble.compare.engines.FINDINGS, and words."""

    kind: str
    text: str


@dataclass(frozen=True)
class Package:
    """What brings an engine, read from its file without running it: all that is known of one that is not installed.

    packages: the one to install first; pins: what an environment of its own gets, that package first; python: the only
    release of Python that it has wheels for, empty where it has them for all; installer: what installs them, "pip",
    "npm" or "apt"; debian: of the last the packages that bring the first pin, that of Python first; apart: whether it
    has an environment of its own everywhere, and takes part only when asked for; megabytes: what such an environment
    takes; imports: packages that it shares with other engines and are slow to import, for a fork server.
    """

    packages: tuple[str, ...] = ()
    pins: tuple[str, ...] = ()
    python: str = ""
    installer: str = "pip"
    debian: tuple[str, ...] = ()
    apart: bool = False
    megabytes: int = 0
    imports: tuple[str, ...] = ()


@dataclass(frozen=True)
class EngineInfo:
    """What an engine's file states: its methods, force laws, settings and numerical properties.

    Parameters
    ----------
    methods : names of the methods; the first is used where one is enough
    adaptive : tolerance that each adaptive method takes by default, by method; nan where it is not stated
    whole : methods that simulate a run of any length in one step
    forced : methods that take part only in scenes with a tether, drag or a floor
    contact : methods that take part only in scenes with a plane
    on_request : methods that take part only when asked for
    default : methods that do what the engine does with no settings by its user
    shown : methods that a page shows
    landing : methods that a page of the whole catalogue shows above a plane
    optional : features that build leaves out where a scene does not need them, unless asked to keep them
    features : force laws that the engine can express exactly
    version : release of the engine
    precision : "single" or "double"
    switched_off : settings switched off for a fair comparison, in words
    defaults : settings that a user gets who sets none, in words
    schemes : integration scheme by method, a name of tumble.compare.engines; OWN_SCHEME for a function
    gyroscopic : how the gyroscopic torque is integrated, by method, a name of tumble.compare.engines
    largest_turn : largest rotation in one step [rad]; None: not limited
    whole_turn : by method, the largest rotation [rad] that it takes in one step; a longer step is taken in parts
    exempt : reason for each check that the engine is meant to fail, by check
    step_ns : approximate time of one step of one throw [ns], by method, or under * for all
    orders : by method, the power of the step by which the error of a free body falls
    instants : the only sample instants at which the engine has an answer [s]; empty: any instant
    known_failures : reason for each check that methods fail by the engine's own law, by check and method, * for all
    senses : whether any of its methods reads sensors itself; otherwise the readings are differences of its velocities
    """

    methods: tuple[str, ...]
    adaptive: dict[str, float]
    whole: frozenset[str]
    forced: tuple[str, ...]
    contact: tuple[str, ...]
    on_request: tuple[str, ...]
    default: tuple[str, ...]
    shown: tuple[str, ...]
    landing: tuple[str, ...]
    optional: tuple[str, ...]
    features: frozenset[str]
    version: str
    precision: str
    switched_off: tuple[str, ...]
    defaults: tuple[str, ...]
    schemes: dict[str, str]
    gyroscopic: dict[str, str]
    largest_turn: float | None
    whole_turn: dict[str, float]
    exempt: dict[str, str]
    step_ns: dict[str, float]
    orders: dict[str, float]
    instants: tuple[float, ...]
    senses: bool
    known_failures: dict[str, dict[str, str]]

    @property
    def every_method(self) -> tuple[str, ...]:
        """Every method that can be asked for by name."""
        return (*self.methods, *self.forced, *self.contact, *self.on_request)

    def without_use(self, scene: Scene) -> frozenset[str]:
        """Return the methods that are another method in this scene: of forces or a plane that it does not have."""
        forced = self.forced if scene.is_unforced else ()
        return frozenset((*forced, *(() if scene.plane else self.contact)))

    def step_of(self, method: str) -> float:
        """Return about what a step of one throw takes by a method [ns]."""
        return self.step_ns.get(str(MethodName.parse(method).without_tolerance), self.step_ns.get("*", STEP_NS))

    def tolerance(self, method: str) -> float | None:
        """Return the tolerance under which a method chooses its steps, nan where it is not told; None of others."""
        parsed = MethodName.parse(method)
        alone = self.adaptive.get(str(parsed.without_tolerance))
        return float(parsed.tolerance) if alone is not None and parsed.tolerance else alone


def names() -> list[str]:
    """Return the names of our own engine files and programs; a folder beside them is none.

    Returns
    -------
    the names, Tumble's own solver first, the others sorted
    """
    found = {module.name for module in pkgutil.iter_modules(engines.__path__) if not module.ispkg}
    found |= {path.stem for folder in engines.__path__ for path in Path(folder).glob("*.toml")}
    return sorted(found, key=lambda name: (name != OWN, name))


def own_program(engine: str) -> Path | None:
    """Return the file of one of our own engines that is a program, None of the others."""
    path = Path(engines.__path__[0]) / f"{engine}.toml"
    return path if path.is_file() else None


# Before Python 3.12.1 two threads that parse at once disturb each other: a SystemError of "recursion depth mismatch".
PARSING = threading.Lock()


@cache
def package(engine: str) -> Package:
    """Return what brings one of our own engines.

    Parameters
    ----------
    engine : name of the engine

    Returns
    -------
    the packages and how they are installed, as the engine's file states them
    """
    if path := own_program(engine):
        stated = {key: value for key, value in program.stated_in(path).items() if key in program.BROUGHT}
        return Package(**{**stated, **{key: tuple(stated[key]) for key in ("packages", "pins")}})
    source = (Path(engines.__path__[0]) / f"{engine}.py").read_bytes()
    with PARSING:
        tree = ast.parse(source)
    stated = {
        target.id: ast.literal_eval(line.value)
        for line in tree.body
        if isinstance(line, ast.Assign) and isinstance(target := line.targets[0], ast.Name) and target.id.isupper()
        if target.id.lower() in Package.__dataclass_fields__
    }
    return Package(**{name.lower(): value for name, value in stated.items()})


def usual() -> list[str]:
    """Return the names of the engines that take part where none is named."""
    return [name for name in names() if not package(name).apart]


def is_file(engine: str) -> bool:
    """Whether the name is that of a user's own file: an engine, or how a program is started.

    Parameters
    ----------
    engine : name of an engine, or path of a file

    Returns
    -------
    True for a path of a file
    """
    return engine.endswith(FILES)


def title(engine: str) -> str:
    """Return the name an engine goes by in tables: a user's file without its folder and ending, unless that is ours."""
    if not is_file(engine):
        return engine
    path = Path(engine)
    return path.name if path.stem in names() else path.stem


def load(engine: str) -> ModuleType:
    """Return the engine's module.  Raises BadEngine for a user's file, Missing for an engine that is not installed."""
    if is_file(engine):
        return load_program(engine) if engine.endswith(".toml") else load_file(engine)
    if path := own_program(engine):
        try:
            return ProgramEngine(path)
        except OSError as error:
            raise Missing(str(error)) from error
    try:
        return importlib.import_module(f"{engines.__name__}.{engine}")
    except ImportError as error:
        raise Missing(missing_reason(engine, error)) from error


def missing_reason(engine: str, error: ImportError) -> str:
    """Return why an engine of ours is not here."""
    reason = f"no module named {error.name}" if error.name else str(error)
    here, needed = f"{sys.version_info.major}.{sys.version_info.minor}", package(engine).python
    return f"{reason} (it has wheels for Python {needed}, this is {here})" if needed not in ("", here) else reason


def load_program(path: str) -> ModuleType:
    """Return a user's own program as a module.  Raises BadEngine."""
    try:
        return ProgramEngine(Path(path))
    except OSError as error:
        raise BadEngine(f"{path}: {error.strerror or error}") from error
    except ValueError as error:
        raise BadEngine(f"{path}: {' '.join(str(error).split())}") from error


class FromSource(SourceFileLoader):
    """Loads a file from its source: bytecode cannot tell edits within a second apart that leave its size."""

    def get_code(self, fullname: str) -> CodeType:
        """Return the compiled source."""
        return self.source_to_code(self.get_data(self.path), self.path)


def load_file(path: str) -> ModuleType:
    """Return a user's own engine file as a module; its folder is importable to it, as for a script."""
    spec = importlib.util.spec_from_file_location(title(path), path, loader=FromSource(title(path), path))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, str(Path(path).resolve().parent))
    try:
        spec.loader.exec_module(module)
    except SyntaxError as error:
        raise BadEngine(f"{error.filename or path}:{error.lineno or 1}: {error.msg}") from error
    except FileNotFoundError as error:
        raise BadEngine(f"{path}: no such engine file") from error
    except Exception as error:
        raise BadEngine(f"{path}: cannot be loaded: {in_one_line(error)}") from error
    if callable(getattr(module, "step", None)) and not any(hasattr(module, name) for name in (*VERBS, "METHODS")):
        return StepEngine(module)
    for name in (*VERBS, "METHODS", "FEATURES", "ABOUT"):
        if not hasattr(module, name):
            needed = f"METHODS, FEATURES, ABOUT, {', '.join(VERBS)}, or step(state, dt, body) alone"
            raise BadEngine(f"{path}: has no {name}; an engine file needs {needed}")
    for verb in VERBS:
        if not callable(getattr(module, verb)):
            raise BadEngine(f"{path}: {verb} is not a function")
    return module


def engine_info(engine: str, module: ModuleType) -> EngineInfo:
    """Return what the engine says of itself.

    Parameters
    ----------
    engine : ENGINE[@RELEASE], or path of a user's file
    module : the loaded engine file

    Returns
    -------
    what its METHODS, FEATURES, ABOUT and optional names state

    Raises
    ------
    BadEngine : one of these has the wrong shape
    """
    try:
        methods = words(module.METHODS)
        features = frozenset(words(module.FEATURES))
        about = dict(module.ABOUT)
        switched_off = words(about.get("switched_off", ()))
    except (TypeError, ValueError) as error:
        raise BadEngine(
            f"{engine}: METHODS and FEATURES must be names, ABOUT a dict (version, precision, switched_off): {error}"
        ) from error
    for feature in sorted(features - {*FORCES}):
        raise BadEngine(f"{engine}: unknown feature {feature!r}: {nearest(feature, FORCES)}")
    if not methods:
        raise BadEngine(f"{engine}: METHODS is empty; at least one name is needed")
    schemes = names_by_method(engine, module, "SCHEMES", SCHEME_NAMES)
    gyroscopic = names_by_method(engine, module, "GYROSCOPIC", GYROSCOPIC_NAMES)
    step_ns = getattr(module, "STEP_NS", STEP_NS)
    of_each = step_ns if isinstance(step_ns, dict) else {"*": step_ns}
    if not all(isinstance(ns, int | float) and 0 < ns < math.inf for ns in of_each.values()):
        raise BadEngine(f"{engine}: STEP_NS must be a number above 0, or one by method, is {step_ns!r}")
    try:
        largest_turn = getattr(module, "LARGEST_TURN", None)
        exempt = dict(getattr(module, "EXEMPT", {}))
        info = EngineInfo(
            methods=methods,
            adaptive=tolerances(module),
            whole=frozenset(words(getattr(module, "WHOLE", ()))),
            forced=words(getattr(module, "FORCED", ())),
            contact=words(getattr(module, "CONTACT", ())),
            on_request=words(getattr(module, "ON_REQUEST", ())),
            default=words(getattr(module, "DEFAULT", as_shipped(methods, words(getattr(module, "ON_REQUEST", ()))))),
            shown=words(getattr(module, "SHOWN", methods)),
            landing=words(getattr(module, "LANDING", getattr(module, "SHOWN", methods))),
            optional=words(getattr(module, "OPTIONAL", ())),
            features=features,
            version=str(about.get("version", "")),
            precision=str(about.get("precision", "")),
            switched_off=switched_off,
            defaults=words(about.get("defaults", ())),
            schemes=schemes,
            gyroscopic=gyroscopic,
            largest_turn=None if largest_turn is None else float(largest_turn),
            whole_turn={str(method): float(turn) for method, turn in dict(getattr(module, "WHOLE_TURN", {})).items()},
            exempt={str(law): str(why) for law, why in exempt.items()},
            step_ns={str(method): float(ns) for method, ns in of_each.items()},
            orders={str(method): float(order) for method, order in dict(getattr(module, "ORDERS", {})).items()},
            instants=tuple(float(instant) for instant in getattr(module, "INSTANTS", ())),
            known_failures={
                str(check): {str(method): str(why) for method, why in dict(reasons).items()}
                for check, reasons in dict(getattr(module, "KNOWN_FAILURES", {})).items()
            },
            senses=callable(getattr(module, "sense", None)),
        )
    except (TypeError, ValueError, OverflowError) as error:
        raise BadEngine(f"{engine}: what it says of itself cannot be read: {error}") from error
    for method, order in info.orders.items():
        if not 0 < order < math.inf:
            raise BadEngine(f"{engine}: ORDERS: {method}: must be a number above 0, is {order:g}")
    for table, checks in (("EXEMPT", info.exempt), ("KNOWN_FAILURES", info.known_failures)):
        for check in checks:
            if check not in (*CHECKS, *CONTACT_CHECKS):
                every = ", ".join((*CHECKS, *CONTACT_CHECKS))
                raise BadEngine(f"{engine}: {table}: no check {check!r}: there are {every}")
    return info


def as_shipped(methods: tuple[str, ...], on_request: tuple[str, ...]) -> tuple[str, ...]:
    """Return the DEFAULT of an engine that states none: METHOD+defaults where there is one, else METHODS[0]."""
    shipped = [method for method in on_request if method.endswith(SHIPPED)]
    first = f"{methods[0]}{SHIPPED}"
    return (first if first in shipped else [*shipped, methods[0]][0],)


def names_by_method(engine: str, module: ModuleType, table: str, known: Collection[str]) -> dict[str, str]:
    """Return one of the engine's tables by method, a function in it as OWN_SCHEME.  Raises BadEngine."""
    stated = getattr(module, table, {})
    if not isinstance(stated, Mapping):
        raise BadEngine(f"{engine}: {table} must be a dict by method, is {stated!r}")
    for method, name in stated.items():
        own = callable(name) and table == "SCHEMES"
        if not own and not (isinstance(name, str) and name in known):
            raise BadEngine(f"{engine}: {table}: {method}: no {name!r}: there are {', '.join(known)}")
    return {str(method): OWN_SCHEME if callable(name) else str(name) for method, name in stated.items()}


def tolerances(module: ModuleType) -> dict[str, float]:
    """Return the tolerance that each adaptive method takes alone, nan where it is not told.  Raises TypeError."""
    stated = getattr(module, "ADAPTIVE", ())
    if not isinstance(stated, Mapping):
        return dict.fromkeys(words(stated), math.nan)
    try:
        return {str(method): float(tolerance) for method, tolerance in stated.items()}
    except (TypeError, ValueError, OverflowError) as error:
        raise TypeError(f"ADAPTIVE must be tolerances by method, is {stated!r}") from error


def findings(raw: Iterable[str | tuple[str, str]]) -> list[Finding]:
    """Return what an audit returned; a plain string is of the kind `other`.  Raises ValueError for an unknown kind."""
    found = []
    for one in (raw,) if isinstance(raw, str) else raw:
        kind, text = ("other", one) if isinstance(one, str) else one
        if kind not in FINDINGS:
            raise ValueError(f"audit() found {kind!r}; there are {', '.join(FINDINGS)}")
        found.append(Finding(kind, str(text)))
    return found


def built(engine: ModuleType, scene: Scene, method: str, keep: frozenset[str]) -> Any:
    """Return the engine's world of a scene; keep, of its OPTIONAL, is for an engine that has any."""
    return engine.build(scene, method, keep) if keep else engine.build(scene, method)


def how_sensed(engine: ModuleType, method: str) -> str:
    """Return how a method's readings of sensors are made, a word of the column `reading`."""
    if not hasattr(engine, "sense"):
        return DIFFERENCES
    stated = getattr(engine, "SENSE", OWN_SENSOR)
    if isinstance(stated, Mapping):
        return str(stated.get(str(MethodName.parse(method).without_tolerance), DIFFERENCES))
    return str(stated)


def words(names: object) -> tuple[str, ...]:
    """Return one name or several as a tuple.

    Parameters
    ----------
    names : a name, or names in any iterable

    Returns
    -------
    the names, in their order

    Raises
    ------
    TypeError : it is neither
    """
    if isinstance(names, str):
        return (names,)
    if not isinstance(names, Iterable):
        raise TypeError(f"{names!r} is not a list of names")
    return tuple(str(name) for name in names)


def in_one_line(error: BaseException) -> str:
    """Return an exception as one line, with the place in the engine's file where it was raised."""
    message = " ".join(str(error).split())
    frames = traceback.extract_tb(error.__traceback__)
    place = f" ({Path(frames[-1].filename).name}:{frames[-1].lineno})" if frames else ""
    return f"{type(error).__name__}: {message}{place}" if message else f"{type(error).__name__}{place}"
