"""Programs as contestants: the page's examples, what one may do wrong, its time, and that none runs unasked."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from patience import PATIENCE_S, until

from tools import programs_page
from tumble.compare.engines import CHECKS
from tumble.compare.run.engines.examine import examined
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.running_engines import launched
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.timing.readings import DISAGREE, round_robin
from tumble.compare.run.timing.timer import Pace
from tumble.scenarios.read import read_scene
from tumble.starters import STARTERS

ROOT = Path(__file__).parents[3]
# An engine that moves bodies along straight lines, and one thing it does otherwise.
HONEST = """
import json, os, sys, time
SAYS = 1.0
def answer(told):
    global states, length
    if told["do"] == "write":
        states = told["states"]
    if told["do"] == "advance":
        begun = time.perf_counter_ns()
        for state in states:
            for _ in range(told["n"]):
                state[0:3] = [x + told["dt"] * v for x, v in zip(state[0:3], state[7:10])]
        return {"ns": SAYS * (time.perf_counter_ns() - begun)}
    if told["do"] == "read":
        return {"states": states}
    return {}
def send(text):
    sys.stdout.write(text)
    sys.stdout.flush()
for line in sys.stdin:
    told = json.loads(line)
    WRONG
    send(json.dumps(answer(told)) + "\\n")
"""
ONE_LEG = """
title = "A brick"
duration = 0.5
samples = 1
step = 0.01
[body]
shape = "box"
size = [0.4, 0.15, 0.1]
mass = 2.4
velocity = [1.0, 2.0, 3.0]
angular_velocity = [0.2, 3.0, 0.4]
"""
ON_READ = "if told['do'] == 'read': "
WRONGS = {
    "dies": (ON_READ + "os._exit(7)", "crashed: its program ended with code 7"),
    "is killed": (ON_READ + "os.abort()", "crashed: its program was killed by SIGABRT"),
    "closes its line": (ON_READ + "(os.close(1), time.sleep(600))", "crashed: its program closed its line"),
    "hangs": (ON_READ + "time.sleep(600)", "timeout: no answer within 1 s (--time-limit)"),
    "rubbish": (ON_READ + "send('<html>\\n'); continue", "crashed: its program answered read with no JSON: '<html>'"),
    "a list": (ON_READ + "send('[1]\\n'); continue", "crashed: its program answered read with no object: '[1]'"),
    "half a line": (
        ON_READ + """(send('{"states": [[1, 2'), os._exit(0))""",
        """crashed: its program ended with code 0 in the middle of a line: '{"states": [[1, 2'""",
    ),
    "half a line and no more": (
        ON_READ + """(send('{"states'), time.sleep(600))""",
        "timeout: no answer within 1 s (--time-limit)",
    ),
    "floods": (
        ON_READ + "[send('x' * 4096) for _ in range(10**9)]",
        f"crashed: its program said more than 65952 bytes: {'x' * 60!r} ...",
    ),
    "floods lines": (
        ON_READ + "[send('{}\\n' * 4096) for _ in range(10**9)]",
        "crashed: its program said more than it was asked: ",
    ),
    "too few numbers": (
        "if told['do'] == 'read': states[0].pop()",
        "crashed: its program answered read with no 1 rows of 13 numbers: ",
    ),
    "words for numbers": (
        "if told['do'] == 'read': states[0] = ['1.0'] * 13",
        "crashed: its program answered read with no 1 rows of 13 numbers: ",
    ),
    "says so": (
        """if told['do'] == 'advance': send('{"error": "singular"}\\n'); continue""",
        "crashed: its program says: singular",
    ),
    "cannot": ("""if told['do'] == 'build': send('{"skipped": "no boxes"}\\n'); continue""", "skipped: no boxes"),
    "finds what is none": (
        """if told['do'] == 'audit': send('{"findings": [["lazy", "x"]]}\\n'); continue""",
        "crashed: ValueError: audit() found 'lazy'; there are reset, ",
    ),
}


def program(folder: Path, command: list[str], name: str = "mine", **more: str) -> str:
    lines = [f"command = {command}", 'methods = ["euler"]', 'features = ["gravity"]', 'precision = "double"']
    (folder / f"{name}.toml").write_text("\n".join([*lines, *(f"{key} = {value}" for key, value in more.items())]))
    return str(folder / f"{name}.toml")


def script(folder: Path, wrong: str = "", says: float = 1.0) -> str:
    (folder / "engine.py").write_text(HONEST.replace("WRONG", wrong or "pass").replace("SAYS = 1.0", f"SAYS = {says}"))
    return program(folder, [sys.executable, "-I", "engine.py"])


def begun(language: str, folder: Path, tumble) -> str:
    """Write a language's template into a folder, as a user does, and build it; return the engine's file."""
    done = tumble("engines", "--template", language, cwd=folder)
    assert done.returncode == 0, done.stderr
    told = re.findall(r"^  (.+)$", done.stdout, re.MULTILINE)
    for line in told[:-2]:
        if not shutil.which(line.split()[0]):
            pytest.skip(f"no {line.split()[0]}")  # which fails in CI
        subprocess.run(line.split(), cwd=folder, check=True, capture_output=True)
    (file,) = re.findall(r"^tumble engines --check (\S+)$", told[-2])
    return str(folder / file)


@pytest.mark.parametrize("language", [language for language in STARTERS if language != "python"])
def test_a_template_keeps_the_laws_and_flies_as_the_one_in_python_does(language, tmp_path, tumble):
    (tmp_path / "python").mkdir()
    names = [begun(language, tmp_path, tumble), begun("python", tmp_path / "python", tumble)]
    scene = read_scene("two-hits")
    with launched(names) as (ours, reference):
        for each in (ours, reference):
            asked = list(examined(each))
            assert [one for one in asked if one.broken] == []
            assert {one.check for one in asked if one.holds} == {*CHECKS} - {"optional", "sensors"}
        flown, expected = (each.simulate(scene, each.methods[0], scene.step) for each in (ours, reference))
    assert isinstance(flown, Trajectory), flown
    assert ours.info.version == "1.0"
    np.testing.assert_allclose(flown.vertices, expected.vertices, rtol=0, atol=1e-9)


def test_a_template_overwrites_nothing(tmp_path, tumble):
    (tmp_path / "mine.toml").write_text("mine")
    done = tumble("engines", "--template", "js")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "tumble: mine.toml exists already: nothing was written\n"
    assert (tmp_path / "mine.toml").read_text() == "mine"
    assert not (tmp_path / "engine.mjs").exists()


def test_the_page_shows_the_templates_as_they_are():
    page = programs_page.PAGE.read_text(encoding="utf-8")
    assert programs_page.page(page) == page, "python -m tools.programs_page"
    shown = {found[2] for found in programs_page.BLOCK.finditer(page)}
    assert shown == {"mine.toml", *(each.source for name, each in STARTERS.items() if name != "python")}


@pytest.mark.parametrize("name", WRONGS)
def test_what_a_program_does_wrong_costs_one_row(name, tmp_path):
    wrong, said = WRONGS[name]
    scene = read_scene("die-straight")
    always = "continue" in wrong or "numbers" in name
    first = ON_READ.replace(":", " and not os.path.exists('done'): open('done', 'a').close();")
    once = wrong if always else wrong.replace(ON_READ, first)
    with launched([script(tmp_path, once)], time_limit=PATIENCE_S) as (ours,):
        if said.startswith("timeout"):
            ours.worker.time_limit = 1.0  # only where it is to be passed
        answer = ours.simulate(scene, "euler", scene.step)
        ours.worker.time_limit = PATIENCE_S
        assert isinstance(answer, Failure)
        assert str(answer).startswith(said), str(answer)
        assert len(answer.reason) < 300
        again = ours.simulate(scene, "euler", scene.step)
        if always:
            assert again == answer
        else:
            assert isinstance(again, Trajectory), again


def test_what_is_not_finite_is_null(tmp_path):
    scene = read_scene("die-straight")
    with launched([script(tmp_path, "if told['do'] == 'read' and states[0][0]: states[0][0] = None")]) as (ours,):
        assert ours.simulate(scene, "euler", scene.step).diverged_at == scene.times[0]


def test_numbers_round_trip(tmp_path):
    scene = read_scene("brick-tumble")
    with launched([script(tmp_path)]) as (ours,):
        flown = ours.simulate(scene, "euler", scene.duration)
        assert flown.states[0, 0].tolist() == ours.simulate(scene, "euler", scene.duration).states[0, 0].tolist()
        assert ours.worker.check_failure("read after write", "euler") == ""


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        ({"command": '"node"'}, "command = 'node': must be a list of words"),
        ({"command": "[]"}, "command = []: must be a list of words"),
        ({"command": '["no-such-program"]'}, "there is no 'no-such-program' here"),
        ({"precision": '"half"'}, "precision = 'half': must be single or double"),
        ({"duration": "4.0"}, "duration: no such key of a program's file; there are command, methods,"),
        ({"methods": "[]"}, "METHODS is empty"),
        ({"schemes": '{ euler = "leapfrog" }'}, "SCHEMES: euler: no 'leapfrog'"),
        ({"features": None}, "has no features; a program's file needs command, methods, features, precision"),
        ({"x": "["}, "is no TOML: "),
    ],
)
def test_a_file_that_is_wrong_is_refused_in_one_line(tumble, tmp_path, stated, said):
    file = {"command": '["true"]', "methods": '["euler"]', "features": "[]", "precision": '"double"', **stated}
    (tmp_path / "mine.toml").write_text("".join(f"{key} = {value}\n" for key, value in file.items() if value))
    done = tumble("compare", "die-straight", "-e", "./mine.toml")
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "mine" in line
    assert said in line


def test_its_whole_group_ends_with_it(tmp_path):
    """A program that hangs, and what it has started itself, end when its time is over."""
    sleeper = "subprocess.Popen(['sleep', '61']).pid"
    wrong = f"if told['do'] == 'read': import subprocess; open('pid', 'w').write(str({sleeper})); time.sleep(600)"
    scene = read_scene("die-straight")
    with launched([script(tmp_path, wrong)], time_limit=PATIENCE_S) as (ours,):
        ours.worker.time_limit = 20.0  # by then the program has begun what it hangs in
        assert ours.simulate(scene, "euler", scene.step).status is Status.TIMEOUT
    child = int((tmp_path / "pid").read_text())
    until(lambda: not alive(child))


def alive(pid: int) -> bool:
    """Whether a process is there that has not ended; one that nobody has waited for yet has."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.parametrize("says", [1.0, 0.2, 3.0])
def test_its_time_is_that_of_the_steps_and_what_it_says_itself_stands_beside_it(says, tmp_path):
    scene = read_scene("die-straight")
    with launched([script(tmp_path, says=says)]) as (ours,):
        ready = ours.prepare_timer("one", scene, "euler", Pace(((1, scene.step),), True))
        assert not isinstance(ready, Failure), ready
        readings = round_robin({"one": lambda: ours.sample("one")}, span_s=0.0, rounds=12, budget_s=1.0)
    found = readings["one"]
    assert found.clock == "wall"
    assert "what `advance 0` takes is taken off; it says" in found.finding
    told = float(re.search(r"it says ([\d.e+]+) ns", found.finding).group(1))
    # In the best round nothing but the steps was timed; in no round less than them.
    assert found.samples.min() == pytest.approx(told / says, rel=0.5)
    if says < 1 - DISAGREE:
        assert "too little at least" in found.finding
    elif says > 1 + DISAGREE:
        assert "too much at least" in found.finding


def test_a_program_whose_time_is_less_than_none_is_untimed_and_no_end_of_the_sweep(tumble, tmp_path):
    """Its whole flights take less than the way to it and back, which is taken off."""
    script(tmp_path, "told['do'] == 'advance' and not told['n'] and time.sleep(0.02)")
    (tmp_path / "one-leg.toml").write_text(ONE_LEG)
    path = tmp_path / "mine.toml"
    path.write_text(path.read_text() + '\nwhole = ["euler"]\n')
    done = tumble("sweep", "one-leg.toml", "-e", "./mine.toml", "-e", "tumble:rk4", "-o", "out")
    assert done.returncode == 0, done.stderr
    assert "mine:euler: untimed: the clock stood still while it was timed" in done.stdout
    table = (tmp_path / "out" / "work-precision.csv").read_text()
    assert "tumble,rk4" in table
    assert "mine" not in table


def test_a_program_that_leaves_out_work_for_the_clock_is_untimed(tmp_path):
    """What a flight never asks for, no steps at all, says that a clock is running."""
    script(
        tmp_path,
        """if told['do'] == 'build': clocked = False
    if told.get('n') == 0: clocked = True
    if told.get('n') and clocked: told['n'] = -(-told['n'] // 8)""",
    )
    scene = read_scene("brick-tumble")
    with launched([str(tmp_path / "mine.toml")]) as (ours,):
        shown = ours.prepare_timer("one", scene, "euler", Pace(((1, scene.step),), True))
    assert isinstance(shown, Failure)
    assert shown.reason.endswith("they are not the same work")


def test_a_record_does_not_run_the_program_that_it_names(tumble, tmp_path):
    script(tmp_path, "open('ran', 'a').close()")
    done = tumble("check", "die-straight", "-e", "./mine.toml", "--no-times", "--accept", "-o", "baseline")
    assert done.returncode == 0, done.stderr
    os.remove(tmp_path / "ran")
    done = tumble("check", "--baseline", "baseline", "--no-times")
    assert done.returncode == 2
    assert "engine files ./mine.toml" in done.stderr
    assert not (tmp_path / "ran").exists()


def test_the_memory_that_is_told_is_the_programs(tmp_path):
    """A hundred megabytes are the program's, not those of the process that talks to it."""
    script(tmp_path)
    engine = (tmp_path / "engine.py").read_text()
    (tmp_path / "engine.py").write_text(engine.replace("SAYS = 1.0", "SAYS = 1.0; kept = os.urandom(100 << 20)"))
    mine = program(tmp_path, [sys.executable, "-I", "engine.py"])
    scene = read_scene("die-straight")
    with launched([mine]) as (ours,):
        ready = ours.prepare_timer("one", scene, "euler", Pace(((1, 0.01),), True))
    assert 100 << 20 < ready.peak_bytes < 180 << 20
