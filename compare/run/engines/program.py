"""A program as an engine of compare.engines: a TOML file says how it is started, lines of JSON are all that is said.

docs/programs.md is the page for who writes one.  It runs in the process group of the engine's process, and ends with
it.  Every question has one answer, a line; anything else ends the program, and costs the flight that it was in.
"""

import json
import os
import shutil
import subprocess
import tomllib
import weakref
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from tumble.compare.run.process.process import signal_name
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Body, Scene

# Where what is installed for it lies, told to engines of ours that no Python brings.
ENVIRONMENT = "TUMBLE_ENVIRONMENT"
# What it says of itself, as the names in capitals of an engine file; the first four it must say.
NEEDED = ("command", "methods", "features", "precision")
ABOUT = ("version", "precision", "switched_off", "defaults")
STATED = (
    "step_ns",
    "adaptive",
    "whole",
    "forced",
    "contact",
    "on_request",
    "default",
    "shown",
    "schemes",
    "gyroscopic",
    "orders",
    "largest_turn",
    "exempt",
    "known_failures",
)
# What brings one of ours: tumble.compare.run.engines.registry.Package.
BROUGHT = ("packages", "pins", "installer", "apart", "megabytes")
PRECISIONS = ("single", "double")
# A number takes so many bytes at most, and words about a flight so many [B].
NUMBER, WORDS = 32, 1 << 16
SHOWN = 60
TO_END_S = 1.0


class ProgramFailed(Exception):
    """The program died, or did not answer what it was asked; the message says how."""


@dataclass(eq=False)
class World:
    """One world of a program: its process, the shape of its states, and how long it says that it took [ns]."""

    talk: "Talk"
    throws: int
    reported_ns: float = 0.0


class Talk:
    """A started program.  Raises ProgramFailed where it cannot be started."""

    def __init__(self, command: list[str], folder: Path) -> None:
        try:
            pipe = subprocess.PIPE
            self._process = subprocess.Popen(command, cwd=folder, stdin=pipe, stdout=pipe, bufsize=0)
        except OSError as error:
            raise ProgramFailed(f"its program cannot be started: {error.strerror or error}") from error
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self.pid = self._process.pid
        self._to, self._from = self._process.stdin.fileno(), self._process.stdout.fileno()

    def ask(self, question: Mapping[str, Any], numbers: int = 0) -> dict[str, Any]:
        """Return the answer, which has so many numbers at most.

        Raises ProgramFailed, and NotImplementedError where it says that it cannot do this.
        """
        try:
            return self._answer(question, numbers)
        except ProgramFailed:
            self._process.kill()
            self._process.wait()
            raise

    def _answer(self, question: Mapping[str, Any], numbers: int) -> dict[str, Any]:
        self._say(json.dumps(question, allow_nan=True).encode() + b"\n")
        line = self._line(WORDS + NUMBER * numbers)
        try:
            answer = json.loads(line)
        except (ValueError, RecursionError):
            raise ProgramFailed(f"its program answered {question['do']} with no JSON: {shown(line)}") from None
        if not isinstance(answer, dict):
            raise ProgramFailed(f"its program answered {question['do']} with no object: {shown(line)}")
        if "skipped" in answer:
            raise NotImplementedError(in_one_line(answer["skipped"]))
        if "error" in answer:
            raise ProgramFailed(f"its program says: {in_one_line(answer['error'])}")
        return answer

    def _say(self, line: bytes) -> None:
        rest = memoryview(line)
        while rest:
            try:
                rest = rest[os.write(self._to, rest) :]
            except OSError:
                raise ProgramFailed(self._how_it_ended()) from None

    def _line(self, most: int) -> bytes:
        """Return one line of so many bytes at most, without its end."""
        parts, length = [], 0
        while not (parts and b"\n" in parts[-1]):
            part = os.read(self._from, 1 << 16)
            if not part:
                raise ProgramFailed(self._how_it_ended(b"".join(parts)))
            parts.append(part)
            length += len(part)
            if length > most:
                raise ProgramFailed(f"its program said more than {most} bytes: {shown(b''.join(parts[:1]))}")
        line, _, more = b"".join(parts).partition(b"\n")
        if more:
            raise ProgramFailed(f"its program said more than it was asked: {shown(more)}")
        return line

    def _how_it_ended(self, unfinished: bytes = b"") -> str:
        amid = f" in the middle of a line: {shown(unfinished)}" if unfinished else ""
        try:
            code = self._process.wait(TO_END_S)
        except subprocess.TimeoutExpired:
            return f"its program closed its line{amid}"
        if code < 0:
            return f"its program was killed by {signal_name(-code)}{amid}"
        return f"its program ended with code {code}{amid}"


class ProgramEngine(ModuleType):
    """An engine whose verbs are lines to a program.  path: its TOML file.  Raises ValueError, OSError.

    Where a world is not needed any more its process makes the next one.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path.stem)
        stated = stated_in(path)
        self._command, self._folder = stated["command"], path.resolve().parent
        if not shutil.which(self._command[0]) and not shutil.which(str(self._folder / self._command[0])):
            raise FileNotFoundError(f"there is no {self._command[0]!r} here")
        self._idle: list[Talk] = []
        self.METHODS, self.FEATURES = stated["methods"], stated["features"]
        self.ABOUT = {name: stated[name] for name in ABOUT if name in stated}
        if (version := installed_version(stated.get("packages", ()))) is not None:
            self.ABOUT["version"] = version
        for name in STATED:
            if name in stated:
                setattr(self, name.upper(), stated[name])

    def build(self, scene: Scene, method: str) -> World:
        """Return a world of the scene."""
        talk = self._idle.pop() if self._idle else Talk(self._command, self._folder)
        try:
            talk.ask({"do": "build", "method": method, **numbers_of(scene)})
        except NotImplementedError:
            self._idle.append(talk)
            raise
        world = World(talk, len(scene.start))
        weakref.finalize(world, self._end, talk).atexit = False
        return world

    def _end(self, talk: Talk) -> None:
        with suppress(ProgramFailed, NotImplementedError):
            talk.ask({"do": "end"})
            self._idle.append(talk)

    def write(self, world: World, states: Array) -> None:
        """Put the throws into these states."""
        world.talk.ask({"do": "write", "states": states.tolist()})

    def advance(self, world: World, n: int, dt: float) -> None:
        """Have it make n steps of dt [s]."""
        ns = world.talk.ask({"do": "advance", "n": n, "dt": dt}).get("ns")
        world.reported_ns += ns if isinstance(ns, int | float) else np.nan

    def reported_ns(self, world: World) -> float:
        """Return the time that the program reported since the last call [ns], NaN if it reports none."""
        ns, world.reported_ns = world.reported_ns, 0.0
        return float(ns)

    def process(self, world: World) -> int:
        """Return the number of its process."""
        return world.talk.pid

    def read(self, world: World) -> Array:
        """Return the states."""
        answer = world.talk.ask({"do": "read"}, 13 * world.throws)
        try:
            states = np.array(answer["states"])
            if states.dtype.kind not in "iufO" or states.shape != (world.throws, 13):
                raise ValueError
            return states.astype(float)  # null, which stands for what is not finite, is NaN
        except (KeyError, ValueError, TypeError, OverflowError):
            raise ProgramFailed(
                f"its program answered read with no {world.throws} rows of 13 numbers: {shown(repr(answer).encode())}"
            ) from None

    def audit(self, world: World) -> Iterable[tuple[str, str]]:
        """Return what it says went wrong silently."""
        found = world.talk.ask({"do": "audit"}).get("findings", ())
        pairs = isinstance(found, list | tuple) and all(isinstance(one, list) and len(one) == 2 for one in found)
        if not pairs:
            raise ProgramFailed(f"its program found {shown(repr(found).encode())}, and not pairs of kind and text")
        return [(str(kind), in_one_line(text)) for kind, text in found]


def stated_in(path: Path) -> dict[str, Any]:
    """Return what the file says.  Raises ValueError with what is wrong, OSError."""
    try:
        stated = tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"is no TOML: {error}") from error
    known = (*NEEDED, *ABOUT, *STATED, *BROUGHT)
    for key in stated:
        if key not in known:
            raise ValueError(f"{key}: no such key of a program's file; there are {', '.join(dict.fromkeys(known))}")
    for key in NEEDED:
        if key not in stated:
            raise ValueError(f"has no {key}; a program's file needs {', '.join(NEEDED)}")
    command = stated["command"]
    if not (isinstance(command, list) and command and all(isinstance(word, str) and word for word in command)):
        raise ValueError(f'command = {command!r}: must be a list of words, such as ["node", "engine.mjs"]')
    if stated["precision"] not in PRECISIONS:
        raise ValueError(f"precision = {stated['precision']!r}: must be {' or '.join(PRECISIONS)}")
    return stated


def numbers_of(scene: Scene) -> dict[str, Any]:
    """Return a scene as plain numbers for a program, SI, without the parts that the scene lacks."""
    body = scene.body
    numbers = {
        "throws": len(scene.start),
        "mass": body.mass,
        "moments": body.moments.tolist(),
        "points": body.points.tolist(),
    }
    if scene.gravity is not None:
        numbers["gravity"] = scene.gravity.tolist()
    if scene.tethers:
        numbers["tethers"] = [
            {
                "point": tether.point_body.tolist(),
                "anchor": tether.anchor.tolist(),
                "stiffness": tether.stiffness,
                "damping": tether.damping,
                "rest_length": tether.rest_length,
            }
            for tether in scene.tethers
        ]
    if scene.drag:
        numbers["drag"] = {"linear": scene.drag.linear, "angular": scene.drag.angular}
    if floor := scene.floor:
        numbers["floor"] = {
            "height": floor.height,
            "normal": floor.normal.tolist(),
            "stiffness": floor.stiffness,
            "damping": floor.damping,
        }
    if plane := scene.plane:
        numbers["plane"] = {
            "point": plane.point.tolist(),
            "normal": plane.normal.tolist(),
            "restitution": plane.restitution,
            "friction": plane.friction,
        }
        numbers["shape"] = shape_of(body)
    return numbers


def shape_of(body: Body) -> dict[str, Any]:
    """Return what touches a plane, in body axes [m]: a box, a sphere, a disc, or the convex hull of the points."""
    if body.size is not None:
        return {"kind": "box", "size": body.size.tolist()}
    if body.disc is not None:
        return {"kind": "disc", "radius": body.disc.radius, "thickness": body.disc.thickness}
    return {"kind": "hull"} if body.radius is None else {"kind": "sphere", "radius": body.radius}


def installed_version(packages: Iterable[str]) -> str | None:
    """Return the release of the first of npm's packages in the environment that was given, None without one."""
    place = os.environ.get(ENVIRONMENT)
    for package in packages if place else ():
        return json.loads(Path(place or "", "node_modules", package, "package.json").read_bytes())["version"]
    return None


def shown(sent: bytes) -> str:
    """Return the beginning of what a program sent, so that it can be printed."""
    text = sent.decode("utf-8", "replace")
    return repr(text[:SHOWN]) + (" ..." if len(text) > SHOWN else "")


def in_one_line(text: object) -> str:
    """Return a text as one line of bearable length."""
    return " ".join(str(text).split())[:200]
