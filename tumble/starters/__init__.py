"""Engines to begin with, one a language: `tumble engines --template` writes them, and docs/programs.md shows them."""

from pathlib import Path
from typing import NamedTuple

FOLDER = Path(__file__).parent


class Starter(NamedTuple):
    """An engine's source; of a program how it is started, and what builds it, '' where nothing does."""

    source: str
    started: str = ""
    build: str = ""

    @property
    def engine(self) -> str:
        """The file that an engine is named by: `-e ./mine.toml`."""
        return "mine.toml" if self.started else self.source

    @property
    def files(self) -> dict[str, str]:
        """Its files by name, with what is in them."""
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
