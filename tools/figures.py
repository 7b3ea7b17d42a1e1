"""Makes the tables of docs/figures.md from what `make bench` wrote.

.venv/bin/python -m tools.figures [report/bench]    records these figures in docs/figures/, and makes the tables of them
"""

import csv
import re
import shutil
from argparse import ArgumentParser
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"
PAGE, RECORDED = DOCS / "figures.md", DOCS / "figures"
CONDITIONS = ".conditions.csv"
# A marker names the benchmark of each table.
BLOCK = re.compile(r"(<!-- figures of (\S+) -->\n)(.*?)(<!-- end of figures -->\n)", re.DOTALL)
# Of no interest beside a time.
LEFT_OUT = ("format", "command", "system", "tumble")
COLUMNS = "what", "compared with", "at an error of", "asked", "measured", "least", "greatest"
HEADER = f"| {' | '.join(COLUMNS)} |\n{'|---' * len(COLUMNS)}|\n"


def page(text: str) -> str:
    """Return the page with the tables of what is recorded."""
    return BLOCK.sub(lambda found: f"{found[1]}{block(found[2])}{found[4]}", text)


def block(name: str) -> str:
    """Return the table of one benchmark and its conditions."""
    conditions = [row for row in rows_of(RECORDED / f"{name}{CONDITIONS}") if row["what"] not in LEFT_OUT]
    under = ", ".join(f"{row['what']} {row['value']}" for row in conditions)
    return f"\n{HEADER}{''.join(map(line, rows_of(RECORDED / f'{name}.csv')))}\nMeasured with: {under}.\n\n"


def line(row: dict[str, str]) -> str:
    """Return a figure's line of the table."""
    found = [with_unit(row[key], row["unit"]) for key in ("asked", "reached", "low", "high")]
    found[1] = found[1] or "not reached"
    error = f"{float(row['error_m']):.0e} m" if row["error_m"] else ""
    return f"| {' | '.join((row['what'], row['peer'], error, *found))} |\n"


def with_unit(cell: str, unit: str) -> str:
    """Return a number of three digits with its unit; nothing of an empty cell."""
    if not cell:
        return ""
    number = float(f"{float(cell):.3g}")
    text = f"{number:.3g}" if not 1e3 <= abs(number) < 1e6 else f"{number:,.0f}".replace(",", " ")
    return text if unit == "x" else f"{text} {unit}"


def rows_of(path: Path) -> list[dict[str, str]]:
    """Return the rows of a CSV file."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def main() -> None:
    """Record figures where a folder is given, and make the tables."""
    parser = ArgumentParser(prog="tools.figures", description="Make the tables of docs/figures.md.")
    parser.add_argument("folder", nargs="?", type=Path, help="with what `make bench` wrote: record it in docs/figures/")
    folder = parser.parse_args().folder
    if folder:
        RECORDED.mkdir(exist_ok=True)
        for path in sorted(folder.glob("*.csv")):
            shutil.copy(path, RECORDED)
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
