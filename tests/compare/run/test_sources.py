"""The files on which the results of a user's own engine depend."""

import sys
from pathlib import Path

import pytest

from tumble.compare.run.engines.sources import sources


@pytest.fixture
def folder(tmp_path) -> Path:
    """Return a folder with modules that import each other, one with what is no Python, and one that nothing imports."""
    (tmp_path / "parts").mkdir()
    for name, text in {
        "forces.py": "import numpy\nfrom parts import drag",
        "parts/__init__.py": "",
        "parts/drag.py": "from .. import mine",
        "late.py": "",
        "alone.py": "",
        "broken.py": "def",
    }.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def test_an_engine_file_depends_on_the_modules_beside_it_that_it_imports(folder):
    mine = folder / "mine.py"
    mine.write_text("import json\nimport forces\ndef build(scene, method):\n    import late\n")
    expected = [mine, *(folder / name for name in ("forces.py", "late.py", "parts/__init__.py", "parts/drag.py"))]
    assert sources(str(mine)) == expected
    mine.write_text("import broken")
    assert sources(str(mine)) == [mine]


def test_a_program_depends_on_what_its_command_names_and_that_imports(folder):
    (folder / "engine.py").write_text("import late")
    program = folder / "mine.toml"
    program.write_text(
        f"""version = "1"\nprecision = "double"\nmethods = ["euler"]\nfeatures = []
command = ["{sys.executable}", "-I", "engine.py"]"""
    )
    assert sources(str(program)) == [program, Path(sys.executable), folder / "engine.py", folder / "late.py"]
