"""What a newcomer meets first: help with examples that work, the nearest word, completion in a real shell."""

import argparse
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from patience import PATIENCE_S

from tumble.compare.grade.grade import SEARCH_S, SHORTEST_S, search_time
from tumble.examples import EXAMPLES
from tumble.parser import parser
from tumble.scenarios.read import catalogue

COMMANDS = next(one for one in parser()._actions if isinstance(one, argparse._SubParsersAction)).choices


@pytest.mark.parametrize("command", COMMANDS)
def test_every_help_has_an_example_and_units_within_80_columns(command, tumble):
    said = tumble(command, "--help", env={**os.environ, "COLUMNS": "80"}).stdout
    assert f"\n  tumble {command}" in said
    assert "SI: m, s, kg, rad" in said
    assert max(map(len, said.splitlines())) <= 80


@pytest.mark.parametrize("line", [line for lines in EXAMPLES.values() for line in lines])
def test_an_example_is_understood(line):
    words = shlex.split(line.partition(" > ")[0])
    assert words[0] == "tumble"
    options = parser().parse_args(words[1:])
    asked = getattr(options, "scene", None) or []
    for scene in [asked] if isinstance(asked, str) else asked:
        assert scene in catalogue() or scene.endswith(".toml")


@pytest.mark.parametrize(
    ("words", "offer"),
    [
        (["compar", "table-4-1"], "did you mean 'compare'?"),
        (["grade", "x.csv", "--scene", "table-4-1", "--by", "poze"], "did you mean 'pose'?"),
        (["xyz"], "there are scenes, engines, run"),
        (["scenes", "table41"], "did you mean 'table-4-1'?"),
    ],
)
def test_an_unknown_word_is_answered_with_the_nearest(words, offer, tumble):
    done = tumble(*words)
    assert done.returncode == 2
    assert offer in done.stderr
    assert done.stderr.count("\n") == 1


def test_a_scene_is_printed_as_it_is_written(tumble, tmp_path):
    (tmp_path / "mine.toml").write_text(tumble("scenes", "brick-tumble").stdout)
    assert tumble("run", "./mine.toml").stdout == tumble("run", "brick-tumble").stdout


def test_a_folder_is_no_file(tumble, tmp_path):
    (tmp_path / "there").mkdir()
    done = tumble("run", "die-straight", "-o", "there")
    assert done.returncode == 2
    assert "-o there: is a folder" in done.stderr
    assert list((tmp_path / "there").iterdir()) == []


# What each shell's own way of asking for words is: a function bash calls, a protocol zsh and fish speak through it.
BASH = """
eval "$(tumble --completion bash)"
COMP_WORDS=(tumble {words}); COMP_CWORD={last}; COMP_LINE="tumble {words}"; COMP_POINT=${{#COMP_LINE}}; COMP_TYPE=9
_python_argcomplete tumble "" tumble
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


@pytest.mark.parametrize(
    ("words", "wanted"),
    [("comp", {"compare"}), ("compare brick-t", {"brick-tumble"}), ("sweep --ref", {"--reference"})],
)
def test_bash_completes(words, wanted, tmp_path):
    there = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    script = BASH.format(words=words, last=len(words.split()))
    done = subprocess.run(
        ["bash", "-c", script], capture_output=True, text=True, timeout=PATIENCE_S, cwd=tmp_path, env=there, check=True
    )
    assert {word.strip() for word in done.stdout.split()} == wanted


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_is_a_script_of_that_shell(shell, tumble, tmp_path):
    script = tumble("--completion", shell).stdout
    assert "tumble" in script
    if shutil.which(shell):
        (tmp_path / "script").write_text(script)
        subprocess.run([shell, "-n", "script"], cwd=tmp_path, check=True, timeout=PATIENCE_S)


def test_a_search_that_nobody_asked_for_is_shorter_on_a_slow_machine(monkeypatch):
    """Of an answer that is due after 2.7 s of processor time, if the search begins after 0.5, 1.2 or 9 s of it."""
    times = []
    monkeypatch.setattr("tumble.compare.grade.grade.compilation", SimpleNamespace(processor_s=0.0))
    for begun_s in (0.5, 1.2, 9.0):
        monkeypatch.setattr("tumble.compare.grade.grade.process_time", lambda begun_s=begun_s: begun_s)
        assert search_time(30.0, np.inf) == 30.0
        times.append(search_time(SEARCH_S, 2.7))
    assert times == pytest.approx([SEARCH_S, 1.5, SHORTEST_S])
    assert parser().parse_args(["grade", "rows.csv", "--scene", "scene"]).search is None
