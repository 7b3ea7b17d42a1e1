"""A command of which no contestant finished a run fails; one that finished is enough."""

import pytest

ENGINE = """
METHODS = ("falls-over",)
FEATURES = {"gravity", "tether", "drag", "floor"}
ABOUT = {"version": "1", "precision": "double"}
OPTIONAL = ("ballast",)
def build(scene, method, keep=()): return {}
def write(world, states): world["states"] = states
def advance(world, n, dt): raise RuntimeError("as ever")
def read(world): return world["states"]
"""
SCENE = """
title = "A brick on a spring"
duration = 0.2
samples = 2
step = 0.01
[body]
shape = "box"
size = [0.4, 0.15, 0.1]
mass = 2.4
angular_velocity = [0.2, 3.0, 0.4]
[[tether]]
vertex = 7
anchor = [0.0, 1.0, 0.0]
stiffness = 80.0
damping = 0.6
"""
NONE_FINISHED = "tumble: exit code 1: no contestant finished a run"
COMMANDS = {
    "compare": (),
    "sweep": (),
    "advise": ("--tolerance", "1e-3"),
    "stability": (),
    "ablate": (),
    "report": ("-o", "page.html"),
}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "broken.py").write_text(ENGINE)
    (tmp_path / "spring.toml").write_text(SCENE)
    return tmp_path


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_of_which_no_contestant_finished_fails(tumble, folder, command):
    said = tumble(command, "spring.toml", "-e", "./broken.py", *COMMANDS[command])
    assert said.returncode == 1, said.stderr
    assert NONE_FINISHED in said.stderr
    shown = (folder / "page.html").read_text() if command == "report" else said.stdout
    assert "as ever" in shown, "and the reason is there"


@pytest.mark.parametrize("command", ["compare", "ablate"])
def test_one_that_finished_is_enough(tumble, folder, command):
    said = tumble(command, "spring.toml", "-e", "./broken.py", "-e", "tumble:rk4", *COMMANDS[command])
    assert (said.returncode, NONE_FINISHED in said.stderr) == (0, False), said.stderr


def test_a_sweep_that_is_found_done_is_judged_by_its_tables(tumble, folder):
    words = ("sweep", "spring.toml", "-e", "./broken.py", "-o", "out")
    assert [tumble(*words).returncode for _ in range(2)] == [1, 1]
