"""What is read takes time as its length does: four times as much of it does not take ten times as long."""

import random
from pathlib import Path
from time import process_time

import pytest
from fuzz import BASE, texts

from tumble.compare.check.record import BadRecord, read_record
from tumble.compare.grade.measure.errors import measure
from tumble.compare.grade.read.columns import BadTrajectory
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.compare.tables.files import write_folder
from tumble.scenarios.read import read_scene
from tumble.scenarios.surface import read_surface

# Quadratic is sixteen; what is linear takes four times as long and, where others work, some more.
FACTOR, MOST, ROUNDS = 4, 10.0, 8
SCENE = read_scene("two-hits")
# Where there are fewer, the fixed part of the work hides what grows.
SIZES = {"a long cell": 50_000, "brackets": 20_000, "columns": 2_000, "cells of a record": 1_000, "facets": 4_000}


def long_cell(folder: Path, count: int) -> None:
    (folder / "f.csv").write_text(f"t_s,x_m,y_m,z_m,qw,qx,qy,qz\n{'1' * count}x,0,0,0,1,0,0,0\n")
    grade(folder)


def brackets(folder: Path, count: int) -> None:
    (folder / "f.csv").write_text(f"t_s,{'(' * count},{' ' * count}m),{'a' * count}[{'[' * count}\n0,1,2,3\n")
    grade(folder)


def columns(folder: Path, count: int) -> None:
    header = [f"c{number}" for number in range(count)]
    (folder / "f.csv").write_text(",".join(header) + "\n" + ",".join("1" * count) + "\n")
    grade(folder)


def grade(folder: Path) -> None:
    with pytest.raises(BadTrajectory):
        measure(Trajectory(folder / "f.csv", SCENE, {}), SCENE)


def record(folder: Path, count: int) -> None:
    whole = texts(BASE)
    header, row, *_ = whole["cells.csv"].splitlines()
    rows = [row.replace("s,e,m", f"s,e,m{number}", 1) for number in range(count)]
    write_folder(folder, whole | {"cells.csv": "\n".join((header, *rows, ""))})
    try:
        read_record(folder)
    except BadRecord:
        return


def facets(folder: Path, count: int) -> None:
    draw = random.Random(1)
    corners = [f"    vertex {draw.random():.6e} {draw.random():.6e} {draw.random():.6e}" for _ in range(3 * count)]
    lines = ["solid x"]
    for place in range(0, len(corners), 3):
        lines += ["facet normal 0 0 1", "  outer loop", *corners[place : place + 3], "  endloop", "endfacet"]
    (folder / "m.stl").write_text("\n".join([*lines, "endsolid x", ""]))
    with pytest.raises(ValueError, match="must be closed"):
        read_surface(folder / "m.stl")


READERS = {
    "a long cell": long_cell,
    "brackets": brackets,
    "columns": columns,
    "cells of a record": record,
    "facets": facets,
}


@pytest.mark.parametrize("what", READERS)
def test_four_times_as_much_does_not_take_ten_times_as_long(tmp_path, what):
    read, size = READERS[what], SIZES[what]
    read(tmp_path, 100)  # what is imported, and compiled, only once

    def took(count: int) -> float:
        begin = process_time()
        read(tmp_path, count)
        return process_time() - begin

    # One after the other, so that what disturbs the one disturbs the other; what is quadratic takes sixteen times as
    # long in every round, what is linear four times in one that nobody else disturbs.
    ratios = []
    for _ in range(ROUNDS):
        small, large = (took(count) for count in (size, FACTOR * size))
        ratios.append(large / max(small, 5e-3))
        if ratios[-1] < MOST:
            return
    raise AssertionError(f"{ratios} times as long")
