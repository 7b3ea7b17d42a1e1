"""Packs the rooms into one package, tumble: what lands in somebody's environment takes no name but that.

In the repository the rooms lie at the top and import each other by their own names.  In a wheel `solver` is
`tumble.solver`, and so are the others; what imports them is rewritten on the way.
"""

import re
import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.command.egg_info import egg_info

ROOMS = ("solver", "scenarios", "compare", "reports")
IMPORTED = re.compile(rf"^(\s*)from ({'|'.join(ROOMS)})(?=[.\s])", re.MULTILINE)


class PackedRooms(build_py):
    """Build the rooms inside tumble."""

    def run(self) -> None:
        """Build as ever, then move the rooms and rewrite imports; an editable install keeps the repository's names."""
        super().run()
        if self.editable_mode:
            return
        built = Path(self.build_lib)
        for room in ROOMS:
            shutil.rmtree(built / "tumble" / room, ignore_errors=True)
            shutil.move(built / room, built / "tumble" / room)
        for path in (built / "tumble").rglob("*.py"):
            path.write_text(IMPORTED.sub(r"\1from tumble.\2", path.read_text(encoding="utf-8")), encoding="utf-8")


class OneName(egg_info):
    """Say that tumble is the one name."""

    def run(self) -> None:
        """Write as ever, then the top-level names."""
        super().run()
        (Path(self.egg_info) / "top_level.txt").write_text("tumble\n", encoding="utf-8")


setup(cmdclass={"build_py": PackedRooms, "egg_info": OneName})
