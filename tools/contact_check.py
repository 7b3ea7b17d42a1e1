"""Makes the table of docs/contact.md: the truth of random scenes above a plane against a second formulation.

.venv/bin/python -m tools.contact_check --seed 0 --write
"""

import argparse
import os
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / "tests/support")]

from random_contact import FAMILIES, drawn  # noqa: E402
from second_contact import worst  # noqa: E402

from tools.generated import between  # noqa: E402
from tumble.scenarios.read import read_scene  # noqa: E402
from tumble.scenarios.truth import NoTruth, truth  # noqa: E402

PAGE = ROOT / "docs" / "contact.md"
BEGIN, END = "<!-- contact-check begins -->\n", "<!-- contact-check ends -->\n"
MOST_BOUND = 1e-12


def compared(family: str, seed: int) -> tuple[float, float, float, int, str]:
    """Return error over bound and error [m] at the worst sample, the bound over the body's size, impacts, and

    why there is no truth.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drawn.toml"
        path.write_text(drawn(family, seed), encoding="utf-8")
        scene = read_scene(str(path))
        try:
            true = truth(scene, False)
            ratio, off = worst(path, true)
        except NoTruth as why:
            return 0.0, 0.0, 0.0, 0, f"{family} {seed}: {why}"
        except Exception as why:
            return 9e9, 0.0, 0.0, 0, f"{family} {seed}: {type(why).__name__}: {why}"
        # The rounding of coordinates to doubles is in proportion to the distance from the origin.
        size = scene.body.reach + abs(true.vertices[: true.known]).max()
        impacts = sum(event.kind == "impact" for event in true.contacts[0].events)
        note = f"{family} {seed}: {ratio:.3g}" if ratio > 1 else ""
        return ratio, off, float(true.bound[: true.known].max()) / size, impacts, note


def main() -> int:
    """Print the table; exit 1 if a bound is broken or too wide."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--scenes", type=int, default=34, help="scenes of each family (default 34)")
    parser.add_argument("--seed", type=int, default=0, help="number of the first scene of each family (default 0)")
    parser.add_argument("--family", help="run this family only (default: all)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes (default: one for each core)")
    parser.add_argument("--write", action="store_true", help="write the table into docs/contact.md")
    options = parser.parse_args()
    head = "| scenes | how many | impacts | error / bound, worst | error, worst [m] | bound / size, worst | beyond |"
    rows, total, broken = [f"{head}\n|---|---|---|---|---|---|---|"], 0, 0
    with ProcessPoolExecutor(options.jobs) as pool:
        for family in [options.family] if options.family else FAMILIES:
            seeds = range(options.seed, options.seed + options.scenes)
            found = list(pool.map(compared, [family] * len(seeds), seeds))
            known = [one for one in found if one[2] or one[0] > 1]
            over = sum(one[0] > 1 or one[2] > MOST_BOUND for one in known)
            ratio, off, share = (max((one[column] for one in known), default=0.0) for column in range(3))
            impacts = sum(one[3] for one in known)
            rows.append(f"| {family} | {len(known)} | {impacts} | {ratio:.3f} | {off:.1e} | {share:.1e} | {over} |")
            sys.stderr.write("\n".join([rows[-1], *filter(None, (one[4] for one in found)), ""]))
            total, broken = total + len(known), broken + over
    command = f"python -m tools.contact_check --scenes {options.scenes} --seed {options.seed}"
    table = "\n".join(rows) + f"\n\n{total} scenes have a truth, {broken} of them beyond the bound: `{command}`\n"
    sys.stdout.write(table)
    if options.write:
        PAGE.write_text(between(PAGE.read_text(encoding="utf-8"), BEGIN, END, table), encoding="utf-8")
    return 1 if broken else 0


if __name__ == "__main__":
    raise SystemExit(main())
