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

from compare.run.examine import examined
from compare.run.flight import Trajectory
from compare.run.participants import launched
from compare.run.readings import DISAGREE, round_robin
from compare.run.timer import Pace
from compare.run.worker import Failure
from scenarios.read import read_scene

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "programs.md").read_text(encoding="utf-8")
# What the page's examples are called, and what makes a program of them.
EXAMPLES = {
    "cpp": ("engine.cpp", ["g++", "-O2", "-o", "engine", "engine.cpp"]),
    "js": ("engine.mjs", ["node", "--version"]),
    "cs": ("engine.cs", ["mcs", "-optimize", "engine.cs"]),
    "rust": ("engine.rs", ["rustc", "-O", "-o", "engine", "engine.rs"]),
}
# Who needs something to start it, as a comment on the page says.
STARTED = {"js": '["node", "engine.mjs"]', "cs": '["mono", "engine.exe"]'}
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


@pytest.mark.parametrize("language", EXAMPLES)
def test_the_pages_examples_keep_the_laws_and_fly_as_the_engine_file_of_the_tests_does(language, tmp_path):
    file, make = EXAMPLES[language]
    if not shutil.which(make[0]):
        pytest.skip(f"no {make[0]}")  # which fails in CI
    (tmp_path / file).write_text(re.search(rf"```{language}\n(.*?)```", PAGE, re.DOTALL).group(1))
    subprocess.run(make, cwd=tmp_path, check=True, capture_output=True)
    stated = re.search(r"```toml\n(.*?)```", PAGE, re.DOTALL).group(1)
    if language in STARTED:
        stated = stated.replace('["./engine"]', STARTED[language])
    (tmp_path / "mine.toml").write_text(stated)
    scene = read_scene("two-hits")
    file = str(ROOT / "tests" / "plugins" / "mine.py")
    with launched([str(tmp_path / "mine.toml"), f"{file}:semi-implicit-euler"]) as (ours, reference):
        assert [one for one in examined(ours) if one.broken] == []
        flown, expected = (each.fly(scene, each.methods[0], scene.step) for each in (ours, reference))
    assert isinstance(flown, Trajectory), flown
    assert ours.info.version == "1.0"
    np.testing.assert_allclose(flown.vertices, expected.vertices, rtol=0, atol=1e-9)


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
        answer = ours.fly(scene, "euler", scene.step)
        ours.worker.time_limit = PATIENCE_S
        assert isinstance(answer, Failure)
        assert answer.status.startswith(said), answer.status
        assert len(answer.status) < 300
        again = ours.fly(scene, "euler", scene.step)
        if always:
            assert again == answer
        else:
            assert isinstance(again, Trajectory), again


def test_what_is_not_finite_is_null(tmp_path):
    scene = read_scene("die-straight")
    with launched([script(tmp_path, "if told['do'] == 'read' and states[0][0]: states[0][0] = None")]) as (ours,):
        assert ours.fly(scene, "euler", scene.step).diverged_at == scene.times[0]


def test_numbers_round_trip(tmp_path):
    scene = read_scene("brick-tumble")
    with launched([script(tmp_path)]) as (ours,):
        flown = ours.fly(scene, "euler", scene.duration)
        assert flown.states[0, 0].tolist() == ours.fly(scene, "euler", scene.duration).states[0, 0].tolist()
        assert ours.worker.law_broken("read after write", "euler") == ""


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
        assert ours.fly(scene, "euler", scene.step).status.startswith("timeout")
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


def test_a_record_does_not_run_the_program_that_it_names(tumble, tmp_path):
    script(tmp_path, "open('ran', 'a').close()")
    done = tumble("check", "die-straight", "-e", "./mine.toml", "--no-times", "--accept", "-o", "baseline")
    assert done.returncode == 0, done.stderr
    os.remove(tmp_path / "ran")
    done = tumble("check", "--baseline", "baseline", "--no-times")
    assert done.returncode == 2
    assert "the record asks for ./mine.toml, and what a record names is not run by itself" in done.stderr
    assert not (tmp_path / "ran").exists()


def test_a_changed_program_is_another_circumstance(tmp_path):
    from compare.run.registry import files

    path = script(tmp_path)
    assert files(path) == [Path(path), Path(sys.executable), tmp_path / "engine.py"]


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
