"""For grading a scene needs neither a step nor instants; every other command asks for them as before."""

import re
from pathlib import Path

import pytest

from tumble.__main__ import main

TWO_HITS = (Path(__file__).parents[3] / "scenarios/catalogue/two-hits.toml").read_text()
BARE = re.sub(r"(?m)^(step|samples|times) *=.*\n", "", TWO_HITS)


def test_a_scene_without_step_and_instants_is_graded_alike(tmp_path, capsys):
    scene, file = tmp_path / "bare.toml", tmp_path / "mine.csv"
    scene.write_text(BARE)
    assert main(["run", "two-hits", "-e", "tumble:rk4", "-o", str(file)]) == 0
    capsys.readouterr()
    printed = []
    for name in ("two-hits", str(scene)):
        assert main(["grade", str(file), "--scene", name]) == 0
        printed.append(capsys.readouterr().out.partition(" rows, ")[2])
        assert printed[-1]
    assert printed[0] == printed[1]


@pytest.mark.parametrize(
    ("added", "why"),
    [
        ("samples = 10\n", "step: missing; must be a number > 0"),
        ("step = 0.01\n", "times: missing; must be a list of instants, or samples a number of them"),
    ],
)
def test_other_commands_ask_for_both(tmp_path, capsys, added, why):
    scene = tmp_path / "bare.toml"
    scene.write_text(added + BARE)
    assert main(["compare", str(scene), "-e", "tumble:rk4"]) == 2
    assert capsys.readouterr().err == f"tumble: {scene}: {why}\n"
