"""Example engines, one per language: `tumble engines --template` writes them, and docs/programs.md shows them."""

from pathlib import Path
from typing import NamedTuple

FOLDER = Path(__file__).parent


class Starter(NamedTuple):
    """An engine's source file; for a program also its start command and its build command, '' without one."""

    source: str
    started: str = ""
    build: str = ""

    @property
    def engine(self) -> str:
        """The file to name with -e, such as ./mine.toml."""
        return "mine.toml" if self.started else self.source

    @property
    def files(self) -> dict[str, str]:
        """The contents of its files by name."""
        texts = {self.source: (FOLDER / self.source).read_text(encoding="utf-8")}
        if self.started:
            before, command, after = (FOLDER / "mine.toml").read_text(encoding="utf-8").partition(CPP.started)
            assert command
            texts["mine.toml"] = f"{before}{self.started}{after}"
        return texts


CPP = Starter("engine.cpp", '["./engine"]', "g++ -O2 -o engine engine.cpp")
STARTERS = {
    "cpp": CPP,
    "js": Starter("engine.mjs", '["node", "engine.mjs"]'),
    "rust": Starter("engine.rs", '["./engine"]', "rustc -O -o engine engine.rs"),
    "csharp": Starter("engine.cs", '["mono", "engine.exe"]', "mcs -optimize engine.cs"),
    "python": Starter("mine.py"),
}
