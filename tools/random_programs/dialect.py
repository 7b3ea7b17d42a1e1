"""How a program writes its file: which columns, in which order, units and digits; and what the digits leave open."""

import json
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from tools.random_programs.scene import Scene
from tools.random_programs.simulation import Rows

# Axes of other programs: what our x, y, z are theirs, and the matrix from ours to theirs.
AXES = {
    "x,z,-y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "x,y,-z": np.diag([1.0, 1.0, -1.0]),
    "x,z,y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]),
}
POSE, MATRIX, EULER, VERTICES = "pose", "matrix", "euler", "vertices"
OWN_NAMES = {
    "t": "Time", "x": "pos.x", "y": "pos.y", "z": "pos.z", "qw": "rot.w", "qx": "rot.x", "qy": "rot.y", "qz": "rot.z",
}  # fmt: skip


@dataclass(frozen=True)
class Dialect:
    """A way to write rows.

    digits: significant, or where `fixed` one decimal fewer; clock: "" as the others, or its decimals; kind:
    what says where the body is; scalar_last: of the quaternion; shuffled: the order of groups of columns; unit, t_unit:
    of lengths and times; names: canonical, own (given by --map), none (by --columns); start: what the clock shows at
    the scene's start [s]; axes: "" or a key of AXES; vertices: numbers of those written; json: lines of JSON.
    """

    digits: int = 9
    fixed: bool = False
    clock: str = ""
    kind: str = POSE
    scalar_last: bool = False
    shuffled: int = 0
    unit: str = "m"
    t_unit: str = "s"
    names: str = "canonical"
    separator: str = ","
    decimal: str = "."
    start: float = 0.0
    velocities: bool = False
    axes: str = ""
    vertices: tuple[int, ...] = ()
    json: bool = False

    # --- numbers ----------------------------------------------------------------------------------------------------

    def printed(self, value: float, name: str) -> str:
        """Return a number as it stands in the file."""
        if name == "t" and self.clock:
            return f"{value:.{self.clock}f}"
        return f"{value:.{self.digits - 1}f}" if self.fixed else f"{value:.{self.digits}g}"

    def half(self, values: np.ndarray, name: str) -> np.ndarray:
        """Return half a unit of the last place of numbers."""
        if name == "t" and self.clock:
            return np.full(values.shape, 0.5 * 10.0 ** -int(self.clock))
        if self.fixed:
            return np.full(values.shape, 0.5 * 10.0 ** (1 - self.digits))
        sizes = np.abs(values)
        leading = np.floor(np.log10(np.where(sizes > 0, sizes, 1.0)))
        return np.where(sizes > 0, 0.5 * 10.0 ** (leading + 1 - self.digits), 0.0)

    # --- columns ----------------------------------------------------------------------------------------------------

    def columns(self, rows: Rows) -> dict[str, np.ndarray]:
        """Return the columns by quantity, each in its unit, in the scene's order."""
        length = 100.0 if self.unit == "cm" else 1.0
        m = AXES.get(self.axes, np.eye(3))
        x, axes = rows.x @ m.T, m @ rows.axes @ m.T
        found = {"t": (rows.t + self.start) * (1000.0 if self.t_unit == "ms" else 1.0)}
        if self.kind == VERTICES:
            there = rows.vertices @ m.T
            for vertex in self.vertices:
                found |= {f"v{vertex}{axis}": length * there[:, vertex, place] for place, axis in enumerate("xyz")}
            return found
        found |= {axis: length * x[:, place] for place, axis in enumerate("xyz")}
        if self.kind == MATRIX:
            found |= {f"r{i + 1}{j + 1}": axes[:, i, j] for i in range(3) for j in range(3)}
        elif self.kind == EULER:
            angles = Rotation.from_matrix(axes).as_euler("xyz", degrees=True)
            found |= {f"r{axis}": angles[:, place] for place, axis in enumerate("xyz")}
        else:
            vector = np.linalg.det(m) * rows.q[:, 1:] @ m.T
            q = {"qw": rows.q[:, 0]} | {f"q{axis}": vector[:, place] for place, axis in enumerate("xyz")}
            found |= dict(sorted(q.items(), key=lambda pair: pair[0] == "qw")) if self.scalar_last else q
        if self.velocities:
            turned = np.linalg.det(m) * rows.w @ m.T
            found |= {f"v{axis}": (rows.v @ m.T)[:, place] for place, axis in enumerate("xyz")}
            found |= {f"w{axis}": turned[:, place] for place, axis in enumerate("xyz")}
        return found

    def column(self, quantity: str) -> str:
        """Return the canonical name of a quantity's column, with its unit."""
        if quantity == "t":
            return f"t_{self.t_unit}"
        if quantity in ("x", "y", "z") or (quantity[0] == "v" and quantity[1].isdigit()):
            return f"{quantity}_{self.unit}"
        units = {"v": "_m_s", "w": "_rad_s", "r": "_deg" if self.kind == EULER else ""}
        return quantity + units.get(quantity[0], "")

    def text(self, rows: Rows) -> str:
        """Return the file."""
        columns = self._in_order(self.columns(rows))
        cells = [[self.printed(value, name) for value in values] for name, values in columns.items()]
        names = [
            OWN_NAMES.get(name, self.column(name)) if self.names == "own" else self.column(name) for name in columns
        ]
        if self.json:
            lines = ["{" + ", ".join(f"{json.dumps(n)}: {c}" for n, c in zip(names, row, strict=True)) + "}"
                     for row in zip(*cells, strict=True)]  # fmt: skip
            return "\n".join(lines) + "\n"
        head = [] if self.names == "none" else [self.separator.join(names)]
        lines = [self.separator.join(row).replace(".", self.decimal) for row in zip(*cells, strict=True)]
        return "\n".join([*head, *lines]) + "\n"

    def options(self, rows: Rows) -> list[str]:
        """Return the options that describe the file to `tumble grade`."""
        columns = self._in_order(self.columns(rows))
        found = ["--decimal", ","] if self.decimal == "," else []
        if self.names == "own":
            for name in columns:
                if name in OWN_NAMES:
                    found += ["--map", f"{OWN_NAMES[name]}={self.column(name)}"]
        elif self.names == "none":
            found += ["--columns", ",".join(self.column(name) for name in columns)]
        found += [f"--axes={self.axes}"] if self.axes else []
        found += ["--start", repr(self.start)] if self.start else []
        return found + (["--euler", "xyz"] if self.kind == EULER else [])

    def _in_order(self, columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Return the columns in the file's order: groups of them are shuffled, the time among them."""
        if not self.shuffled:
            return columns
        groups: dict[str, list[str]] = {}
        for name in columns:
            key = "x" if name in ("x", "y", "z") else name[:2] if name[0] == "v" and name[1].isdigit() else name[0]
            groups.setdefault(key + ("v" if name in ("vx", "vy", "vz") else ""), []).append(name)
        order = list(groups)
        np.random.default_rng(self.shuffled).shuffle(order)
        return {name: columns[name] for group in order for name in groups[group]}

    # --- what is left open ------------------------------------------------------------------------------------------

    def seen(self, rows: Rows, scene: Scene) -> np.ndarray:
        """Return the vertices that a reader of the file takes the body to have [m], (n, k, 3)."""
        if self.kind == VERTICES:
            return rows.vertices[:, list(self.vertices)]
        rows = replace(rows, points=scene.points)
        if self.kind != MATRIX:  # a quaternion and angles show a rotation, and nothing else
            rows = replace(rows, own_axes=None, q=rows.q / np.linalg.norm(rows.q, axis=1)[:, None])
        return rows.vertices

    def noise(self, rows: Rows, scene: Scene) -> np.ndarray:
        """Return how far vertices may be off by the rounding of digits [m], (n,)."""
        columns = self.columns(rows)
        half = {name: self.half(values, name) for name, values in columns.items()}
        length = 0.01 if self.unit == "cm" else 1.0
        clock = half["t"] * (1e-3 if self.t_unit == "ms" else 1.0)
        speed = np.linalg.norm(rows.v, axis=1) + scene.reach * np.linalg.norm(rows.w, axis=1)

        def together(names: list[str]) -> np.ndarray:
            return np.sqrt(sum(np.square(half[name]) for name in names))

        if self.kind == VERTICES:
            places = [together([f"v{vertex}{axis}" for axis in "xyz"]) for vertex in self.vertices]
            return length * np.max(places, axis=0) + clock * speed
        if self.kind == MATRIX:
            turn = together([name for name in columns if name[0] == "r"])
        elif self.kind == EULER:
            turn = np.pi / 180 * together(["rx", "ry", "rz"])
        else:
            turn = 2 * together(["qw", "qx", "qy", "qz"]) / np.linalg.norm(rows.q, axis=1)
        return length * together(["x", "y", "z"]) + scene.reach * turn + clock * speed


def drawn(random: np.random.Generator, scene: Scene) -> Dialect:
    """Return a dialect."""
    kind = str(random.choice((POSE, MATRIX, EULER, VERTICES), p=(0.62, 0.1, 0.08, 0.2)))
    vertices = tuple(range(len(scene.points)))
    if kind == VERTICES and random.random() < 0.3:
        vertices = vertices[: max(4, len(vertices) // 2)]
    names = str(random.choice(("canonical", "own", "none"), p=(0.75, 0.15, 0.1)))
    form = random.random()
    separator = str(random.choice((",", ";", "\t", " "), p=(0.7, 0.1, 0.1, 0.1)))
    decimal_comma = separator in (";", "\t") and random.random() < 0.4
    is_json = bool(form < 0.06 and names == "canonical")
    return Dialect(
        int(random.integers(5, 10)),
        bool(random.random() < 0.25),
        str(random.choice(("", "5", "6", "9"), p=(0.55, 0.15, 0.15, 0.15))),
        kind,
        bool(random.random() < 0.5),
        int(random.integers(1, 1000)) if random.random() < 0.3 else 0,
        "cm" if random.random() < 0.1 else "m",
        "ms" if random.random() < 0.08 else "s",
        names,
        separator,
        "," if decimal_comma and not is_json else ".",
        float(random.choice((0.0, 10.0), p=(0.93, 0.07))),
        bool(kind in (POSE, MATRIX) and random.random() < 0.25),
        str(random.choice(list(AXES))) if kind == POSE and random.random() < 0.06 else "",
        vertices,
        is_json,
    )
