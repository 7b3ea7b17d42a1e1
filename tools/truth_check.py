"""Makes the table of docs/truth.md: the truth of random scenes against a second formulation with 60 digits.

make truth-check  (or: python -m tools.truth_check --scenes 30 --write)
"""

import argparse
import os
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / "tests/support")]

from random_scenes import COSTLY, FAMILIES, REACHED, drawn  # noqa: E402
from second_truth import worst  # noqa: E402

from tools.generated import between  # noqa: E402
from tumble.scenarios.read import read_scene  # noqa: E402
from tumble.scenarios.truth import NoTruth, truth  # noqa: E402

PAGE = ROOT / "docs" / "truth.md"
BEGIN, END = "<!-- truth-check begins -->\n", "<!-- truth-check ends -->\n"


def compared(family: str, seed: int) -> tuple[float, float, str]:
    """Return error over bound and error [m] at the worst of a scene's samples, and why there is no truth."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drawn.toml"
        path.write_text(drawn(family, seed), encoding="utf-8")
        try:
            return *worst(path, truth(read_scene(str(path))), REACHED.get(family)), ""
        except NoTruth as why:
            return 0.0, 0.0, f"{family} {seed}: {why}"


def main() -> int:
    """Print the table; exit 1 if a bound is broken."""
    parser = argparse.ArgumentParser()
    parser.add_argument(
        "--scenes",
        type=int,
        default=30,
        help="scenes of each family; costly families get two fifths of it (default 30)",
    )
    parser.add_argument("--write", action="store_true", help="write the table into docs/truth.md")
    options = parser.parse_args()
    rows, broken = (
        ["| scenes | how many | error / bound, worst | error, worst [m] | beyond the bound |\n|---|---|---|---|---|"],
        0,
    )
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for family in FAMILIES:
            count = options.scenes * 2 // 5 if family in COSTLY else options.scenes
            found = list(pool.map(compared, [family] * count, range(count)))
            over = sum(ratio > 1 for ratio, _, _ in found)
            known = [one for one in found if not one[2]]
            ratio, off = (max((one[column] for one in known), default=0.0) for column in (0, 1))
            rows.append(f"| {family} | {len(known)} | {ratio:.3f} | {off:.1e} | {over} |")
            sys.stderr.write("\n".join([rows[-1], *filter(None, (why for _, _, why in found)), ""]))
            broken += over
    table = "\n".join(rows) + "\n"
    sys.stdout.write(table)
    if options.write:
        PAGE.write_text(between(PAGE.read_text(encoding="utf-8"), BEGIN, END, table), encoding="utf-8")
    return 1 if broken else 0


if __name__ == "__main__":
    raise SystemExit(main())
