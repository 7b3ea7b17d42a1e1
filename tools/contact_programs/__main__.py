"""Draws random programs of contact, runs `tumble grade` on their files, and counts how often it is right.

    .venv/bin/python -m tools.contact_programs [--count 60] [--seed N] [-o FOLDER]

The seed is new in every run and printed. FOLDER keeps each program's file and scene. `--only 17` grades that program
alone and prints its answer.
"""

import argparse
import json
import math
import os
import secrets
import subprocess
import sys
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from tools.contact_programs.programs import Program, Scene, rows_of, toml, written

# The mistakes that each kind of motion shows, and what `tumble grade` may call each.
OF_KIND = {
    "drop": ("e squared", "bounce threshold", "gravity first", "push-out", "tunnelling", "margin"),
    "throw": (
        "e squared",
        "product rule",
        "friction at centre",
        "pyramid",
        "bounce threshold",
        "gravity first",
        "push-out",
        "tunnelling",
        "margin",
        "wrong normal",
    ),
    "slide": ("product rule", "pyramid", "sleep", "creep"),
    "hold": ("creep", "wrong normal"),
    "roll": ("product rule", "friction at centre", "pyramid", "sleep"),
    "corner": ("e squared", "product rule", "friction at centre", "wrong normal"),
}
NAMES = {
    "e squared": ("contact-restitution-squared",),
    "product rule": ("contact-product-rule", "contact-friction-squared"),
    "friction at centre": ("contact-friction-at-centre",),
    "pyramid": ("contact-pyramid",),
    "bounce threshold": ("contact-bounce-threshold",),
    "gravity first": ("contact-gravity-before-bounce",),
    "push-out": ("contact-push-out",),
    "tunnelling": ("contact-tunnelling",),
    "margin": ("contact-without-touching",),
    "wrong normal": ("contact-wrong-normal", "contact-normal-vertical"),
    "sleep": ("contact-sleep",),
    "creep": ("contact-creep",),
}
# Mistakes that only a program by steps can have.
OF_STEPS = ("gravity first", "push-out", "tunnelling", "margin", "sleep")
# Ways to apply friction to the impact of a corner, which may be named beside a mistake.
BESIDE = {"contact-friction-after-normal", "contact-whole-impulse"}
RIGHT, ALIKE, PARTLY, HONEST, WRONG = "right", "fits alike", "partly", "honest", "wrong name"
FALSE_CORRECT, FALSE_ALARM, FAILED = "false correct", "false alarm", "failed"
# Kinds of motion whose contacts are late by a step, which moves the body more than a mistake may.
FLYING = ("drop", "throw", "corner")
# A mistake is in a file if it moves the body by this many last digits, and by this share of its size.
SEEN, SEEN_SHARE = 20.0, 1e-3


def scene_of(kind: str, rng: np.random.Generator) -> Scene:
    """Draw a scene of a kind."""

    def u(low: float, high: float) -> float:
        return round(float(rng.uniform(low, high)), 4)

    e, mu, radius = u(0.3, 0.9), u(0.1, 0.8), u(0.05, 0.4)
    angle = rng.uniform(0, 2 * math.pi)
    across = np.array((math.cos(angle), 0.0, math.sin(angle)))
    if kind == "drop":
        height = u(0.4, 1.5)
        return Scene(kind, e, 0.0, radius=radius, mass=u(0.2, 5), x=(0.0, radius + height, 0.0), duration=u(1.2, 2.0))
    if kind == "throw":
        v = u(0.5, 3) * across + (0.0, u(-2, 2), 0.0)
        w = rng.normal(size=3) * u(1, 15)
        incline = u(0.1, 0.4) if rng.random() < 0.3 else 0.0
        start = (0.0, radius + u(0.4, 1.5), 0.0)
        return Scene(
            kind, e, mu, incline, radius, mass=u(0.2, 5), x=start, v=tuple(v), w=tuple(w), duration=u(1.2, 2.0)
        )
    if kind == "slide":
        half = (u(0.1, 0.4), u(0.02, 0.06), u(0.1, 0.4))
        v, mu = u(1, 4) * across, u(0.15, 0.8)
        incline = u(0.05, 0.3) if rng.random() < 0.4 else 0.0
        return Scene(
            kind, 0.0, mu, incline, half=half, mass=u(0.5, 5), x=(0.0, half[1], 0.0), v=tuple(v), duration=u(0.8, 1.6)
        )
    if kind == "hold":
        half, mu = (u(0.1, 0.4), u(0.02, 0.06), u(0.1, 0.4)), u(0.2, 0.8)
        incline = round(math.atan(mu) * float(rng.choice((0.5, 0.8, 1.3))), 4)
        return Scene(kind, 0.0, mu, incline, half=half, mass=u(0.5, 5), x=(0.0, half[1], 0.0), duration=u(0.6, 1.2))
    if kind == "roll":
        v, w = u(0.5, 3) * across, rng.normal(size=3) * u(2, 20)
        w[1] = 0.0
        mu = u(0.15, 0.6)
        return Scene(
            kind, 0.0, mu, radius=radius, mass=u(0.2, 5), x=(0.0, radius, 0.0), v=tuple(v), w=tuple(w), duration=u(1, 2)
        )
    half = (u(0.1, 0.3), u(0.1, 0.3), u(0.1, 0.3))
    q = rng.normal(size=4)
    q /= np.linalg.norm(q)
    v, w = u(0.2, 2) * across + (0.0, -u(0.5, 2), 0.0), rng.normal(size=3) * u(1, 3)
    up = float(np.linalg.norm(half)) + u(0.05, 0.4)
    return Scene(
        kind, e, mu, half=half, mass=u(0.5, 5), x=(0.0, up, 0.0), v=tuple(v), w=tuple(w), q=tuple(q), duration=0.6
    )


def drawn(number: int, seed: int) -> tuple[Scene, Program]:
    """Draw a scene and a program."""
    rng = np.random.default_rng((seed, number))
    kind = str(rng.choice(("drop", "throw", "throw", "throw", "slide", "slide", "hold", "roll", "roll", "corner")))
    scene = scene_of(kind, rng)
    rate = int(rng.choice((60, 100, 120, 240, 500) if kind != "corner" else (500, 1000)))
    methods = ("steps", "steps", "events", "spring") if kind in ("drop", "throw") else ("steps", "steps", "events")
    method = str(rng.choice(methods))
    every = int(rng.choice((1, 1, 2, 4, 10)))
    mistake = "" if rng.random() < 0.3 else str(rng.choice(OF_KIND[kind]))
    if mistake in OF_STEPS:
        method = "steps"
    if kind == "hold" and mistake == "":
        method = "steps"
    values: dict = {}
    if mistake == "pyramid":
        values["cone"] = str(rng.choice(("box", "diamond")))
    if mistake == "bounce threshold":
        values["speed"] = round(float(rng.uniform(0.8, 2.5)), 3)
    if mistake == "push-out":
        values["share"] = round(float(rng.uniform(0.2, 0.8)), 3)
    if mistake == "margin":
        # A margin that is shorter than what the body falls in a step shows nothing.
        values["margin"] = round(float(rng.uniform(1.3, 3.0) * (5.5 + abs(scene.v[1])) / rate / every), 4)
    if mistake == "tunnelling":
        values["thickness"] = 0.002
    if mistake == "creep":
        values["speed"] = round(float(rng.choice((0.01, 0.05, 0.2))), 3)
    if mistake == "sleep":
        values["speed"] = round(float(rng.uniform(0.2, 0.8)), 3)
    if mistake == "wrong normal":
        tilt = rng.uniform(0.05, 0.3) * np.array((math.cos(number), 0.0, math.sin(number)))
        normal = tilt + np.array((0.0, 1.0, 0.0))
        if scene.incline:
            normal = np.array((-math.sin(scene.incline), math.cos(scene.incline), 0.0))
        values["normal"] = tuple((normal / np.linalg.norm(normal)).tolist())
    program = Program(
        method,
        1 / rate / every,
        every,
        int(rng.integers(5, 10)),
        clamp=bool(rng.random() < 0.5),
        bounce_first=bool(rng.random() < 0.5),
        mistake=mistake,
        values=values,
    )
    rows = max(12, round(scene.duration * rate))
    return replace(scene, duration=rows / rate), program


def moved(scene: Scene, rows: np.ndarray, others: np.ndarray) -> float:
    """Return how far rows of two programs are apart at most, over the size of the body."""
    count, size = min(len(rows), len(others)), scene.radius or max(scene.half)
    apart = np.linalg.norm(rows[:count, :3] - others[:count, :3], axis=1).max() / size
    return float(max(apart, np.linalg.norm(rows[:count, 3:] - others[:count, 3:], axis=1).max()))


def is_seen(scene: Scene, program: Program, rows: np.ndarray) -> bool:
    """Whether the mistake is in the file: it moves the body by more than its digits, and on the plane than its step."""
    right = replace(program, mistake="", values={})
    plain = rows_of(scene, right)
    size = scene.radius or max(scene.half)
    digit = 10.0 ** (math.floor(math.log10(max(1e-3, np.abs(rows[:, :3]).max()))) + 1 - program.digits)
    found, least = moved(scene, rows, plain), max(SEEN_SHARE, SEEN * digit / size)
    if found <= least or scene.kind in FLYING:
        return found > least
    finer = rows_of(scene, replace(right, step=program.step / 2, every=program.every * 2))
    return found > 2 * moved(scene, finer, plain)


def graded(number: int, seed: int, folder: Path) -> tuple[str, str, str, float]:
    """Draw, write and grade a program; return its visible mistake, the class of the answer, details and time [s]."""
    scene, program = drawn(number, seed)
    rows = rows_of(scene, program)
    mistake = program.mistake if program.mistake and is_seen(scene, program, rows) else ""
    file, about = folder / f"{number:03d}.csv", folder / f"{number:03d}.toml"
    file.write_text(written(scene, program, rows), encoding="utf-8")
    about.write_text(toml(scene), encoding="utf-8")
    command = (sys.executable, "-m", "tumble", "grade", str(file), "--scene", str(about), "--json")
    answer, errors = folder / f"{number:03d}.json", folder / f"{number:03d}.err"
    with answer.open("w", encoding="utf-8") as out, errors.open("w", encoding="utf-8") as err:
        process = subprocess.Popen(command, stdout=out, stderr=err)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    seconds = used.ru_utime + used.ru_stime
    shown = f"{scene.kind}, {program.method} of {program.step:.3g} s, {program.every} a row, {program.digits} digits"
    planted = program.mistake + ("" if mistake or not program.mistake else " (not visible)")
    if process.returncode:
        return mistake, FAILED, f"{shown}; {planted}: {errors.read_text(encoding='utf-8').strip()[-300:]}", seconds
    said = json.loads(answer.read_text(encoding="utf-8"))
    named = [{row["mistake"] for row in said["contact"]["diagnosis"] if row["rank"] == rank} for rank in (1, 2, 3, 4)]
    # A mistake that is named, though the rule calls it not visible, is in the file all the same.
    meant = mistake or (program.mistake if named[0] & set(NAMES.get(program.mistake, ())) else "")
    kind = assessed(meant, said["verdict"], named, scene.kind)
    return mistake, kind, f"{shown}; {planted} {program.values or ''} -> {said['verdict']}: {sorted(named[0])}", seconds


def assessed(mistake: str, verdict: str, named: Sequence[set], kind: str) -> str:
    """Return the class of an answer."""
    beside = BESIDE if kind == "corner" else set()
    is_correct = verdict.startswith("correct")
    if not mistake:
        if is_correct or (verdict == "explained" and named[0] <= beside):
            return RIGHT
        return FALSE_ALARM if verdict == "explained" else HONEST
    if is_correct:
        return FALSE_CORRECT
    if verdict not in ("explained", "explained in part"):
        return HONEST
    hits = [bool(each & set(NAMES[mistake])) and not each - set(NAMES[mistake]) - beside for each in named]
    if hits[0]:
        return RIGHT if verdict == "explained" else PARTLY
    if any(hits):
        return ALIKE
    if named[0] & set(NAMES[mistake]):
        return PARTLY
    return WRONG if verdict == "explained" else HONEST


def main(words: Sequence[str] | None = None) -> int:
    """Draw, grade and count; return 1 if a file was not graded or a wrong one was called correct."""
    parser = argparse.ArgumentParser(
        prog="python -m tools.contact_programs", description=(__doc__ or "").split("\n")[0]
    )
    parser.add_argument("--count", type=int, default=60, help="number of programs (default: 60)")
    parser.add_argument("--seed", type=int, help="seed (default: random)")
    parser.add_argument("--only", type=int, action="append", help="grade only this program")
    parser.add_argument("--processes", type=int, default=2, help="programs graded in parallel (default: 2)")
    parser.add_argument("-o", "--output", type=Path, help="folder that keeps files and scenes")
    options = parser.parse_args(words)
    seed = secrets.randbelow(2**31) if options.seed is None else options.seed
    sys.stdout.write(f"seed {seed}\n")
    counts: Counter = Counter()
    by_mistake: dict[str, Counter] = {}
    times: list[float] = []
    with TemporaryDirectory() as scratch, ThreadPoolExecutor(options.processes) as pool:
        folder = options.output or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        numbers = options.only or range(options.count)
        for number, (mistake, kind, details, seconds) in zip(
            numbers, pool.map(lambda number: graded(number, seed, folder), numbers), strict=True
        ):
            counts[kind] += 1
            times.append(seconds)
            by_mistake.setdefault(mistake or "none", Counter())[kind] += 1
            sys.stdout.write(f"{number}: {kind}; {details}\n")
            sys.stdout.flush()
    sys.stdout.write("\n| mistake | " + " | ".join(counts) + " |\n|---" * 1 + "|---" * len(counts) + "|\n")
    for mistake, own in sorted(by_mistake.items()):
        sys.stdout.write(f"| {mistake} | " + " | ".join(str(own[kind] or "") for kind in counts) + " |\n")
    total = sum(counts.values())
    right = counts[RIGHT] + counts[ALIKE]
    seen = sum((each for mistake, each in by_mistake.items() if mistake != "none"), Counter())
    sys.stdout.write(
        f"\n{right} of {total} right, {counts[FALSE_CORRECT]} false correct; {seen[RIGHT] + seen[ALIKE]} of "
        f"{seen.total()} visible mistakes named\n"
        f"processor time: median {np.median(times):.1f} s, longest {max(times):.1f} s\n"
    )
    return 1 if counts[FAILED] or counts[FALSE_CORRECT] else 0


if __name__ == "__main__":
    sys.exit(main())
