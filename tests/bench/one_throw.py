"""One throw of the yardstick: our methods beside engines and adaptive solvers, against what was asked.

    python tests/bench/one_throw.py [-o FILE.csv]

Every figure is a ratio of times at equal error, or of steps, from one round robin of `tumble.compare.run.timing.timer`;
low, high:
the ratios of its two passes.  `asked` is what the project set itself to reach on a machine with 512-bit vectors.
The error beside a method's own cost is the least that any of its steps reached.
"""

import sys
from collections.abc import Iterator

from figures import FigureRow, output_option, show

from tumble.compare.run.running_engines import launched
from tumble.compare.run.status import Failure
from tumble.compare.run.timing.readings import Reading, ratio
from tumble.compare.sweep.pareto_front import by_contestant, reach
from tumble.compare.sweep.work_precision import YARDSTICK, Sweep, sweep
from tumble.scenarios.read import read_scene

EXACT = ("tumble", "exact")
PEERS = ("mujoco:rk4", "mujoco:euler", "pybullet:multibody", "scipy", "heyoka")


# Our side, peer, error [m] (None: a step against a step), and how many times at least.
ASKED = (
    ("best", "mujoco:rk4", 1e-3, 600),
    ("best", "mujoco:rk4", 1e-6, 3000),
    ("best", "mujoco:rk4", 1e-9, 15000),
    ("best", "mujoco:euler", 1e-3, 1e6),
    ("best", "pybullet:multibody", 1e-3, 1e6),
    ("stepper", "mujoco:rk4", 1e-3, 400),
    ("stepper", "mujoco:rk4", 1e-6, 600),
    ("stepper", "mujoco:rk4", 1e-9, 1500),
    ("stepper", "heyoka:taylor", 1e-3, 16),
    ("stepper", "heyoka:taylor", 1e-6, 5),
    ("stepper", "heyoka:taylor", 1e-9, 4),
    ("stepper", "heyoka:taylor", 1e-12, 4),
    ("stepper", "scipy:dop853", 1e-6, 450),
    ("best", "scipy:dop853", 1e-6, 5000),
    ("rkmk4 step", "mujoco:rk4", None, 230),
    ("rkmk4 step", "mujoco:euler", None, 65),
    ("rkmk4 step", "pybullet:multibody", None, 32),
)
# What a step, or a flight of a method without steps, may take at most [ns].
ASKED_NS = {"exact": 200}


def figures(found: Sweep) -> Iterator[FigureRow]:
    """Yield every figure asked for that this machine has the peer for."""
    contestants = by_contestant(found.timed)
    ours = {name: timed for name, timed in contestants.items() if name[0] == "tumble"}
    steppers = {name: timed for name, timed in ours.items() if name != EXACT}
    for what, peer, error_m, asked in ASKED:
        engine, _, method = peer.partition(":")
        if (engine, method) not in contestants:
            continue
        theirs = contestants[engine, method]
        if error_m is None:
            mine = contestants["tumble", "rkmk4"]
            yield FigureRow(what, peer, None, "x", asked, *ratios(1.0, theirs[0].reading, mine[0].reading))
            continue
        costs = [reach(timed, error_m)[1:] for timed in (ours if what == "best" else steppers).values()]
        own_ns, own = min((cost for cost in costs if cost[0] is not None), key=lambda cost: cost[0])  # pyright: ignore[reportCallIssue]
        _, peer_ns, run = reach(theirs, error_m)
        if run is None or own is None or peer_ns is None:
            yield FigureRow(what, peer, error_m, "x", asked, None, None, None)
            continue
        scale = peer_ns / own_ns / (run.reading.ns / own.reading.ns)
        yield FigureRow(what, peer, error_m, "x", asked, *ratios(scale, run.reading, own.reading))


def ratios(scale: float, theirs: Reading, mine: Reading) -> tuple[float, float, float]:
    """Return the ratio of two readings and its interval, times scale."""
    found = ratio(theirs, mine) * scale
    return found.value, found.low, found.high


def native_cost(found: Sweep) -> Iterator[FigureRow]:
    """Yield what a step of each of our methods takes, or a flight of one that has no steps."""
    for (engine, method), timed in by_contestant(found.timed).items():
        if engine == "tumble":
            reading, unit = timed[0].reading, "step" if timed[0].per_step else "flight"
            yield FigureRow(
                f"{method}, a {unit}",
                "",
                min(each.error_m for each in timed),
                "ns",
                ASKED_NS.get(method),
                reading.ns,
                reading.ns,
                reading.spread[0],
            )


def main() -> None:
    """Sweep the yardstick, print the figures and the native cost of each of our methods, and write them."""
    output = output_option(__doc__.splitlines()[0])
    with launched(("tumble", *PEERS)) as running_engines:
        missing = [
            running_engine.title for running_engine in running_engines if isinstance(running_engine.info, Failure)
        ]
        found = sweep(running_engines, read_scene(YARDSTICK), lambda what: print(what, file=sys.stderr))
    if missing:
        print(f"not installed here, so not measured: {', '.join(missing)}")
    show([*figures(found), *native_cost(found)], output)


if __name__ == "__main__":
    main()
