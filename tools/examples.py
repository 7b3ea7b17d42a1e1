"""Writes the Python examples of the README and the guides to report/examples/, where pyright checks their types."""

import argparse
import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))
FOLDER = ROOT / "report" / "examples"


def examples(page: Path) -> list[str]:
    """Return the Python blocks of a page.

    Parameters
    ----------
    page : Markdown

    Returns
    -------
    code of each block; the cells of a notebook are one
    """
    text = page.read_text(encoding="utf-8")
    cells = re.findall(r"^```\{code-cell\} ipython3\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    return [*re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL), *(["\n".join(cells)] * bool(cells))]


def main() -> None:
    """Write every example to a file of its own."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    FOLDER.mkdir(parents=True, exist_ok=True)
    for old in FOLDER.glob("*.py"):
        old.unlink()
    for page in PAGES:
        for number, code in enumerate(examples(page)):
            (FOLDER / f"{page.stem.lower().replace('-', '_')}_{number}.py").write_text(code, encoding="utf-8")


if __name__ == "__main__":
    main()
