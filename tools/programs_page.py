"""Copies the starters that `tumble engines --template` writes into docs/programs.md.

.venv/bin/python -m tools.programs_page
"""

import re
from argparse import ArgumentParser
from pathlib import Path

from tumble.starters import FOLDER

PAGE = Path(__file__).parents[1] / "docs/programs.md"
# A comment names the file of each block of code.
BLOCK = re.compile(r"(<!-- tumble/starters/(\S+) -->\n```(\w+)\n)(.*?)(```\n)", re.DOTALL)


def page(text: str) -> str:
    """Return the page with the code of the files."""
    return BLOCK.sub(lambda found: f"{found[1]}{(FOLDER / found[2]).read_text(encoding='utf-8')}{found[5]}", text)


if __name__ == "__main__":
    ArgumentParser(prog="tools.programs_page", description="Copy the starters into docs/programs.md.").parse_args()
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
