"""The files that a user's own engine consists of, on which its results depend."""

from modulefinder import ModuleFinder
from pathlib import Path

from tumble.compare.run.engines.program import stated_in


def sources(engine: str) -> list[Path]:
    """Return the files of a user's own engine: its file, what a program's command names beside it, what they import.

    engine: path of the file.  What it opens by itself is not known.
    """
    own = Path(engine)
    named = [own.resolve().parent / word for word in stated_in(own)["command"]] if own.suffix == ".toml" else []
    found = [own, *(file for file in named if file.is_file())]
    return [*dict.fromkeys(file for one in found for file in (one, *imported(one)))]


def imported(file: Path) -> list[Path]:
    """Return the modules beside a Python file that it or they import, also in a function; none of another file."""
    if file.suffix != ".py":
        return []
    finder = ModuleFinder([str(file.resolve().parent)])
    try:
        finder.run_script(str(file))
    except (OSError, SyntaxError, ValueError):
        return []  # the engine cannot be loaded, and has no results
    found = {getattr(module, "__file__", None) for name, module in finder.modules.items() if name != "__main__"}
    return sorted(Path(name) for name in found if name)
