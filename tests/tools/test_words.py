"""Refused words are found in text for users, at their line, and nowhere else."""

import subprocess
import sys
from pathlib import Path

import pytest

from tools.words import GLOSSARY, found, main, pattern, refused

ROOT = Path(__file__).parents[2]
WORDS = refused(GLOSSARY.read_text(encoding="utf-8"))
# What is planted, in the file that it is planted in, and the lines where it must be found.
PLANTED = {
    "page.md": ("# Fine\n\nThe user is told it.\nHas not\ngot.\n", [3, 4]),
    "module.py": (
        'MESSAGE = (\n    "an engine of its own "\n    "that nobody asked for"\n)\n'
        'def say(name):\n    """Tell."""\n    return f"{name} flew away"\n',
        [3, 7],
    ),
    "schemas.py": ('class RunRow:\n    """One run as it was flown."""\n', [2]),
    "page.js": ("const words = [\n  `in ${count} runs, ${f('was told so')}, flown`,\n];\n", [2, 2]),
    "page.html": ('<p\n>Who is told?</p><button aria-label="Nobody">x</button>\n', [2, 2]),
    "scene.toml": ('title = "A brick, struck"\n', [1]),
}
# The same words as names, in code, in comments, in docstrings and in compounds.
FINE = {
    "page.md": "Call `able.fly(scene)`:\n\n    tumble told\n\n```sh\nflown\n```\nA right-handed frame, in flight.\n",
    "module.py": '"""Tell."""\ndef fly(told):\n    """Tell whom."""\n    return told["flown"], "nobody"  # so many\n',
    "allowed.py": 'CLASS = "cell told apart"  # words: allow\n',
    "page.js": "// told\nconst told = { flown: 1 }; /* nobody */ element.className = 'told';\n",
    "page.html": '<p class="told flown">Flight</p>\n',
}


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_word_is_found_at_its_line(name, tmp_path):
    text, lines = PLANTED[name]
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    problems = list(found(path, WORDS))
    assert [int(problem.removeprefix(f"{path}:").partition(":")[0]) for problem in problems] == lines
    assert all(": write " in problem for problem in problems)


@pytest.mark.parametrize("name", FINE)
def test_names_code_and_comments_are_no_text(name, tmp_path):
    (tmp_path / name).write_text(FINE[name], encoding="utf-8")
    assert list(found(tmp_path / name, WORDS)) == []


def test_the_table_of_the_glossary_is_read_whole():
    assert {"told", "nobody", "so many", "not got"} <= set(WORDS)
    assert all(pattern(WORDS).fullmatch(word) for word in WORDS)
    assert all(WORDS.values())


def test_the_command_fails_on_a_planted_word_and_passes_without(tmp_path, capsys):
    (tmp_path / "page.md").write_text("Nobody flies.\n", encoding="utf-8")
    command = [sys.executable, "-m", "tools.words", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, len(done.stdout.splitlines())) == (1, 2)
    (tmp_path / "page.md").write_text("No engine runs.\n", encoding="utf-8")
    assert main([tmp_path]) == 0
    assert capsys.readouterr().out == ""
