"""A scene as this package reads, draws and writes it: SI units, world axes unless a name says body."""

import itertools
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Impulse:
    """J [N s] at a time [s], at a vertex, at a point in body axes, or at a point in world axes [m]: one of them."""

    time: float
    value: np.ndarray
    vertex: int | None = None
    point_body: np.ndarray | None = None
    point: np.ndarray | None = None


@dataclass(frozen=True)
class Tether:
    """A spring and damper from a vertex to an anchor [m]; stiffness [N/m], damping [N s/m], rest length [m]."""

    vertex: int
    anchor: np.ndarray
    stiffness: float
    damping: float = 0.0
    rest_length: float = 0.0


@dataclass(frozen=True)
class Scene:
    """One body and what acts on it; size [m]: of a box, else None; inertia [kg m2], (3, 3); points [m], (n, 3), body.

    drag: of the velocity [N s/m] and of the spin [N m s/rad]; q: w x y z.
    """

    name: str
    duration: float
    mass: float
    inertia: np.ndarray
    points: np.ndarray
    x: np.ndarray
    q: np.ndarray
    v: np.ndarray
    w: np.ndarray
    gravity: np.ndarray
    size: np.ndarray | None = None
    impulses: tuple[Impulse, ...] = ()
    tethers: tuple[Tether, ...] = ()
    drag: tuple[float, float] = (0.0, 0.0)

    @property
    def size_m(self) -> float:
        """The largest edge of the box about the points [m]."""
        return float(np.ptp(self.points, axis=0).max())

    @property
    def reach(self) -> float:
        """How far the furthest vertex is from the centre of mass [m]."""
        return float(np.linalg.norm(self.points, axis=1).max())

    @property
    def moments(self) -> np.ndarray:
        """Principal moments [kg m2], (3,), increasing."""
        return np.linalg.eigvalsh(self.inertia)

    @property
    def is_triaxial(self) -> bool:
        """Whether any two principal moments differ by a hundredth."""
        return bool(self.moments[2] > 1.01 * self.moments[0])

    def body_point(self, impulse: Impulse) -> np.ndarray | None:
        """Return where an impulse acts in body axes [m]; None where a point of the world says it."""
        return self.points[impulse.vertex] if impulse.vertex is not None else impulse.point_body


def box_inertia(mass: float, size: np.ndarray) -> np.ndarray:
    """Return the tensor of a solid box [kg m2], (3, 3)."""
    squares = np.square(size)
    return np.diag(mass / 12 * (squares.sum() - squares))


def corners(size: np.ndarray) -> np.ndarray:
    """Return the corners of a box [m], (8, 3): vertex 4 a + 2 b + c is at signs a, b, c of x, y, z."""
    return 0.5 * np.array(list(itertools.product((-1, 1), repeat=3))) * size


def read(text: str, name: str) -> Scene:
    """Return the scene of a TOML text."""
    said = tomllib.loads(text)
    body = said["body"]
    mass, size = float(body["mass"]), None
    if body["shape"] == "box":
        size = np.array(body["size"], float)
        inertia, points = box_inertia(mass, size), corners(size)
    else:
        inertia, points = np.array(body["inertia"], float), np.array(body["points"], float)
    q = np.array(body.get("orientation", (1.0, 0.0, 0.0, 0.0)), float)
    drag = said.get("drag", {})

    def vector(table: dict, key: str) -> np.ndarray:
        return np.array(table.get(key, (0.0, 0.0, 0.0)), float)

    return Scene(
        name,
        float(said["duration"]),
        mass,
        inertia,
        points,
        vector(body, "position"),
        q / np.linalg.norm(q),
        vector(body, "velocity"),
        vector(body, "angular_velocity"),
        vector(said, "gravity"),
        size,
        tuple(_impulse(each) for each in said.get("impulse", ())),
        tuple(
            Tether(
                each["vertex"],
                np.array(each["anchor"], float),
                each["stiffness"],
                each.get("damping", 0.0),
                each.get("rest_length", 0.0),
            )
            for each in said.get("tether", ())
        ),
        (drag.get("linear", 0.0), drag.get("angular", 0.0)),
    )


def _impulse(said: dict) -> Impulse:
    if "value" in said:
        value = np.array(said["value"], float)
    else:
        direction = np.array(said["direction"], float)
        value = said["magnitude"] * direction / np.linalg.norm(direction)
    body = np.array(said["point_body"], float) if "point_body" in said else None
    point = np.array(said["point"], float) if "point" in said else None
    return Impulse(float(said.get("time", 0.0)), value, said.get("vertex"), body, point)


def _numbers(values: np.ndarray) -> str:
    return "[" + ", ".join(repr(float(value)) for value in values) + "]"


def toml(scene: Scene) -> str:
    """Return the scene file of a scene."""
    lines = [f'title = "{scene.name}"', f"duration = {scene.duration!r}", "samples = 20"]
    if scene.gravity.any():
        lines.append(f"gravity = {_numbers(scene.gravity)}")
    lines += ["", "[body]"]
    if scene.size is not None:
        lines += ['shape = "box"', f"size = {_numbers(scene.size)}"]
    else:
        lines += ['shape = "rigid"', f"inertia = [{', '.join(map(_numbers, scene.inertia))}]"]
        lines.append(f"points = [{', '.join(map(_numbers, scene.points))}]")
    lines += [f"mass = {scene.mass!r}", f"position = {_numbers(scene.x)}", f"orientation = {_numbers(scene.q)}"]
    lines += [f"velocity = {_numbers(scene.v)}", f"angular_velocity = {_numbers(scene.w)}"]
    for impulse in scene.impulses:
        lines += ["", "[[impulse]]", f"time = {impulse.time!r}", f"value = {_numbers(impulse.value)}"]
        if impulse.vertex is not None:
            lines.append(f"vertex = {impulse.vertex}")
        elif impulse.point_body is not None:
            lines.append(f"point_body = {_numbers(impulse.point_body)}")
        else:
            assert impulse.point is not None
            lines.append(f"point = {_numbers(impulse.point)}")
    for tether in scene.tethers:
        lines += ["", "[[tether]]", f"vertex = {tether.vertex}", f"anchor = {_numbers(tether.anchor)}"]
        lines += [f"stiffness = {tether.stiffness!r}", f"damping = {tether.damping!r}"]
        lines.append(f"rest_length = {tether.rest_length!r}")
    if any(scene.drag):
        lines += ["", "[drag]", f"linear = {scene.drag[0]!r}", f"angular = {scene.drag[1]!r}"]
    return "\n".join(lines) + "\n"


def save(scene: Scene, path: Path) -> None:
    """Write a scene file."""
    path.write_text(toml(scene), encoding="utf-8")
