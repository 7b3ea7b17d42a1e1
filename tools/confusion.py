"""Makes docs/confusion.md, .csv and .png: which mistake was planted, and which one `tumble grade` named.

Random boxes with random impulses are simulated with one or two mistakes, and written with noise of 1e-4 of the body's
size.  `.venv/bin/python -m tools.confusion` takes four minutes on two cores; a number after it says how
many of the 200 scenes, evenly spread, so that all mistakes have their turn.
"""

from argparse import ArgumentParser
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import altair
import numpy as np
import vl_convert

from tools.palette import reduced
from tumble.compare.grade.grade import SEARCH_S, diagnose, scale_of
from tumble.compare.grade.hypotheses.hypothesis import Context, Hypothesis
from tumble.compare.grade.hypotheses.mistakes import hypotheses
from tumble.compare.grade.hypotheses.names import CLOCK_OFFSET, LOG_LAG, RENAMED_MISTAKES
from tumble.compare.grade.measure.errors import SampledRows
from tumble.compare.grade.measure.significance import root_mean_square
from tumble.compare.grade.model.program_model import FINE, ProgramModel, correct_program
from tumble.compare.grade.read.columns import Description
from tumble.compare.tables.files import write_whole
from tumble.compare.tables.frames import csv_text, frame
from tumble.compare.tables.schema import Table
from tumble.notes import progress
from tumble.scenarios.frames import Array
from tumble.scenarios.mass import BOX_FACES, box, box_corners
from tumble.scenarios.scene import Body, Impulse, Scene, frozen_array

DOCS = Path(__file__).parents[1] / "docs"
SCENES = 200
NOISE = 1e-4
ROWS = 60
SEED = 7
# A mistake is visible if its effect is at least this many times the noise.
SEEN = 3.0
PROCESSES = 2
# One mistake with two names: rows late by whole steps, and by any time.
SAME = {LOG_LAG: CLOCK_OFFSET}
# Name in format 3 -> name in format 2, whose order decides which mistake is planted in a scene.
FORMAT_2 = {new: old for old, new in RENAMED_MISTAKES.items()}
# By how much a vector is off, over its scale.
OFF = 0.3
# Larger positions, over the body's size, are of runs that diverged.
BLOWN_UP = 1e4


@dataclass(frozen=True)
class ConfusionRow:
    """One planted trajectory: what was planted, whether it is visible, what was named, and what fits as well."""

    mistakes: int
    scene: int
    planted: str
    values: str
    effect_m: float
    noise_m: float
    seen: bool
    named: str
    answer: str
    alike: str
    residual_m: float
    right: bool
    right_or_alike: bool


def random_scene(random: np.random.Generator) -> Scene:
    """Return a box thrown at random, with one or two impulses."""
    size = frozen_array(0.1 + 0.9 * random.random(3))
    mass = float(np.exp(random.uniform(-0.7, 1.6)))
    moments = frozen_array(np.diag(box(mass, size).tensor))
    body = Body("box", mass, moments, frozen_array(box_corners(size)), frozen_array(BOX_FACES, int), size)
    q = random.normal(size=4)
    start = np.concatenate((random.normal(size=3), q / np.linalg.norm(q), random.normal(size=3), _spin(random)))
    duration = float(random.uniform(1.0, 3.0))
    impulses = [_impulse(random, body, float(time)) for time in (0.0, random.uniform(0.2, 0.6) * duration)]
    return Scene(
        name="random",
        title="Random",
        source="",
        duration=duration,
        times=frozen_array(np.linspace(0, duration, ROWS + 1)[1:]),
        step=0.001,
        body=body,
        start=frozen_array(start[None]),
        gravity=frozen_array((0.0, -9.81, 0.0)) if random.random() < 0.75 else None,
        impulses=tuple(impulses[random.integers(0, 2) :]),
    )


def _spin(random: np.random.Generator) -> Array:
    return random.normal(size=3) * random.uniform(0.5, 3.0)


def _impulse(random: np.random.Generator, body: Body, time: float) -> Impulse:
    """Return an impulse at a point of the body that changes its velocity by some m/s."""
    point = frozen_array((2 * random.random(3) - 1) * body.points[7])
    value = frozen_array(random.normal(size=3) * body.mass * random.uniform(0.3, 1.0))
    return Impulse(time, value, point_body=point)


def shown_kind(random: np.random.Generator, body: Body) -> Description:
    """Return a random description of the pose."""
    kind = ("pose", "matrix", "vertices")[random.integers(3)]
    return Description(kind, tuple(range(len(body.points))), False, False)


def planted_value(random: np.random.Generator, hypothesis: Hypothesis) -> Any:
    """Return a value between the first values of a hypothesis, or every other time one with a name."""
    values = hypothesis.values
    if not values:
        return 0.0
    if hypothesis.choices:
        return float(values[random.integers(len(values))])
    if hypothesis.scale:
        return tuple((np.array(values[0]) + OFF * hypothesis.scale * random.normal(size=hypothesis.dimension)).tolist())
    known = [value for value in hypothesis.named_values if min(values) < value < max(values)]
    if known and random.random() < 0.5:
        return float(known[random.integers(len(known))])
    low, high = sorted(values)[1], sorted(values)[-2]
    if low > 0:
        return float(np.exp(random.uniform(np.log(low), np.log(high))))
    return float(random.uniform(low, high))


def written(program: ProgramModel, times: Array, points: Array) -> Array:
    """Return the vertices in the output of a program [m], (T, K, 3)."""
    pose = program.output(times, FINE)
    return pose.x[:, None] + np.einsum("tij,kj->tki", pose.axes, points)


def noisy(random: np.random.Generator, seen: Array, kind: str, points: Array, sigma: float) -> Array:
    """Return vertices with noise [m]: of each vertex independently, or of the pose."""
    if kind == "vertices":
        return seen + random.normal(size=seen.shape) * sigma
    shift = random.normal(size=(len(seen), 1, 3)) * sigma
    turn = random.normal(size=(len(seen), 1, 3)) * sigma / np.linalg.norm(points, axis=1).max()
    return seen + shift + np.cross(turn, seen - seen.mean(axis=1, keepdims=True))


def confused(job: tuple[int, int]) -> ConfusionRow:
    """Plant mistakes in one random scene and see what is named.  job: number of mistakes, number of the scene."""
    count, number = job
    random = np.random.default_rng((SEED, count, number))
    scene = random_scene(random)
    description = shown_kind(random, scene.body)
    program = correct_program(scene, 0)
    times = np.array(scene.rows)
    true = written(program, times, scene.body.points)
    rates = np.linalg.norm(program.simulate(times)[:, 15:18], axis=1)
    spacing = scene.duration / ROWS
    context = Context(scene, program, description.kind, len(times), scene.duration, float(1 / rates.max()), spacing)
    # A file without a quaternion has none in the wrong order; the axes of v have an effect upon a scheme alone.
    unseen = {"velocity axes"} | (set() if description.kind == "pose" else {"quaternion order"})
    known = [h for h in hypotheses(context) if h.part not in unseen]
    names = _names(known)
    size = float(np.ptp(scene.body.points, axis=0).max())

    def with_mistakes(some: Sequence[int], values: Sequence[Any]) -> Array:
        changed = program
        for place in some:
            changed = picked[place].change(changed, values[place])
        return written(changed, times, scene.body.points)

    picked: list[Hypothesis] = []
    values: list[Any] = []
    planted = np.full(1, np.inf)
    while not np.abs(planted).max() < BLOWN_UP * size:  # a diverged run would have been noticed
        picked = picks(random, known, names[number % len(names)], count)
        values = [planted_value(random, hypothesis) for hypothesis in picked]
        planted = with_mistakes(range(count), values)
    without = [with_mistakes([place for place in range(count) if place != left], values) for left in range(count)]
    effect_m = min(root_mean_square(planted - other) for other in without)
    sigma = NOISE * size
    seen = noisy(random, planted, description.kind, scene.body.points, sigma)
    noise_m = root_mean_square(seen - planted)
    sample = SampledRows(times, seen, true, np.zeros((len(times), 3)), None)
    diagnosis = diagnose(context, description, sample, scale_of(sample, scene), search_s=SEARCH_S)
    named = [frozenset(SAME.get(name, name) for name in each.names) for each in (diagnosis.best, *diagnosis.alike)]
    right = frozenset(hypothesis.name for hypothesis in picked)
    return ConfusionRow(
        count,
        number,
        " + ".join(sorted(right)),
        " ".join(f"{number:.6g}" for value in values for number in np.atleast_1d(value)),
        effect_m,
        noise_m,
        effect_m > SEEN * noise_m,
        " + ".join(sorted(named[0])) or "nothing",
        "; ".join(mistake.text for mistake in diagnosis.best.mistakes),
        " | ".join(" + ".join(sorted(each)) for each in named[1:]),
        diagnosis.best.rms_m,
        named[0] == right,
        right in named,
    )


def picks(random: np.random.Generator, known: Sequence[Hypothesis], first: str, count: int) -> list[Hypothesis]:
    """Return as many mistakes of different parts, one of them by name, in the order in which a program makes them."""
    names = _names(known)
    picked = [_one_of(random, known, first)]
    while len(picked) < count:
        other = _one_of(random, known, names[int(random.integers(len(names)))])
        if other.part != picked[0].part:
            picked.append(other)
    return sorted(picked, key=known.index)


def _names(hypotheses: Sequence[Hypothesis]) -> list[str]:
    return sorted({hypothesis.name for hypothesis in hypotheses}, key=lambda name: FORMAT_2.get(name, name))


def _one_of(random: np.random.Generator, known: Sequence[Hypothesis], name: str) -> Hypothesis:
    same = [hypothesis for hypothesis in known if hypothesis.name == name]
    return same[int(random.integers(len(same)))]


def all_rows(scenes: int) -> Iterator[ConfusionRow]:
    """Yield all planted trajectories."""
    jobs = [(count, number) for count in (1, 2) for number in range(0, SCENES, SCENES // scenes)]
    with ProcessPoolExecutor(PROCESSES) as pool, progress(len(jobs)) as on_progress:
        for row in pool.map(confused, jobs):
            on_progress(row.planted)
            yield row


def share(rows: Sequence[ConfusionRow], right: str) -> str:
    """Return how many rows are right, and as a share."""
    good = sum(getattr(row, right) for row in rows)
    return f"{good} of {len(rows)} ({100 * good / max(len(rows), 1):.1f} %)"


def page(rows: Sequence[ConfusionRow]) -> str:
    """Return docs/confusion.md."""
    lines = [
        "# Which mistake was planted, and which was named",
        "",
        "Made by `tools/confusion.py`: random boxes with one or two impulses, simulated by a program with one or two",
        "mistakes, and written as poses, matrices or vertices with noise of 1e-4 of the body's size.",
        f"`confusion.csv` has every row: {len(rows) // 2} of the {SCENES} scenes, evenly spread. Each search ends",
        f"after the {SEARCH_S:g} s of processor time of `tumble grade`; with more (`--search`) more pairs are named.",
        "",
        "The models that recognise mistakes also simulate the planted trajectories. So the table shows how well",
        "mistakes can be distinguished from one another and from noise, not that a program's mistake is one of these;",
        "a mistake that is none of these is reported as not explained.",
        "",
        "| mistakes | planted | not visible | named | named, or reported as equally good |",
        "|---|---|---|---|---|",
    ]
    for count in (1, 2):
        own = [row for row in rows if row.mistakes == count]
        seen = [row for row in own if row.seen]
        shares = share(seen, "right"), share(seen, "right_or_alike")
        lines.append(f"| {count} | {len(own)} | {len(own) - len(seen)} | {' | '.join(shares)} |")
    hidden = [row for row in rows if not row.seen]
    silent = sum(
        row.named == "nothing" or set(row.named.split(" + ")) < set(row.planted.split(" + ")) for row in hidden
    )
    lines += [
        "",
        f"A file's mistakes are not visible if one of them moves the vertices by less than {SEEN:g} times the noise",
        f"(rms). Of these {len(hidden)} files, {silent} were reported as correct to their noise, or only the other",
        "mistake was named.",
        "",
        "![Planted and named mistakes, for single mistakes](confusion.png)",
        "",
        "## Mistakes that were not named first",
        "",
        "| planted | named | equally good |",
        "|---|---|---|",
    ]
    lines += [
        f"| {row.planted} ({row.values}) | {row.named} | {row.alike.replace(' | ', ', or ')} |"
        for row in rows
        if row.seen and not row.right
    ]
    return "\n".join(lines) + "\n"


def picture(rows: Sequence[ConfusionRow]) -> bytes:
    """Return docs/confusion.png: single mistakes, planted and named."""
    cells = Counter((row.planted, row.named) for row in rows if row.seen and row.mistakes == 1)
    planted = sorted({pair[0] for pair in cells})
    named = planted + sorted({pair[1] for pair in cells} - set(planted))
    data = [{"planted": pair[0], "named": pair[1], "trajectories": count} for pair, count in cells.items()]
    base = altair.Chart(altair.Data(values=data)).encode(
        x=altair.X("named:N", sort=named, scale=altair.Scale(domain=named), axis=altair.Axis(labelAngle=-60)),
        y=altair.Y("planted:N", sort=planted, scale=altair.Scale(domain=planted)),
    )
    squares = base.mark_rect().encode(color=altair.Color("trajectories:Q", scale=altair.Scale(scheme="blues")))
    numbers = base.mark_text(fontSize=9).encode(text="trajectories:Q")
    chart = (squares + numbers).properties(width=altair.Step(18), height=altair.Step(16))
    return vl_convert.vegalite_to_png(chart.to_json(), scale=1.25)


def main() -> None:
    """Write the three files."""
    parser = ArgumentParser(prog="tools.confusion", description="Make docs/confusion.md, .csv and .png.")
    parser.add_argument("scenes", type=int, nargs="?", default=SCENES, help=f"how many of the {SCENES} scenes")
    rows = list(all_rows(parser.parse_args().scenes))
    write_whole(DOCS / "confusion.csv", csv_text(frame(Table("", ConfusionRow), rows)))
    _, heading, second = (DOCS / "confusion.md").read_text(encoding="utf-8").partition("## Random programs")
    write_whole(DOCS / "confusion.md", page(rows) + f"\n{heading}{second}")  # made by others
    (DOCS / "confusion.png").write_bytes(reduced(picture(rows)))


if __name__ == "__main__":
    main()
