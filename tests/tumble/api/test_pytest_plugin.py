"""The pytest plugin in a project of its own: a test a check and scene, expected failures, and guarded baselines."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from patience import PATIENCE_S

import tumble
from tumble.compare.engines import CHECKS
from tumble.testing import ON_A_SCENE, contract, parametrize_with_laws, slug

ROOT = Path(__file__).parents[3]
TESTS = """\
import sys; sys.path.insert(0, ".")
import mine
import tumble
from tumble.testing import parametrize_with_laws

FREE = tumble.Scene.box((0.4, 0.2, 0.1), 1.0, angular_velocity=(1, 2, 3), duration=0.5, samples=2, step=0.01)
FREE = FREE.replace(name="free")

@parametrize_with_laws("./mine.py", scenes=[FREE], expected_failures={failures})
def test_laws(law):
    law()
"""
CHECK = """\
def test_guard(tumble_check):
    tumble_check("die-straight", "./mine.py", times=False)
"""
# The attitude is not advanced: it stays where it was put, and its error does not fall with the step.
SPOILED = ("    q[:] = product(q, rotation_by(dt * w_body))\n", "")


def project(folder: Path, tests: str, spoiled: bool = False) -> None:
    text = (ROOT / "tests/plugins/mine.py").read_text(encoding="utf-8")
    assert SPOILED[0] in text
    (folder / "mine.py").write_text(text.replace(*SPOILED) if spoiled else text, encoding="utf-8")
    (folder / "test_own.py").write_text(tests, encoding="utf-8")


def run(folder: Path, *words: str) -> tuple[int, dict[str, str], str]:
    """Return the exit code, what came of each test, and everything that was printed."""
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-v", *words]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    named = r"test_own\.py::([\w\[\]-]+)"
    ended = "PASSED|FAILED|XFAIL|SKIPPED|ERROR"
    lines = re.findall(rf"^(?:\[gw\d\] \[ *\d+%\] )({ended}) {named}|^{named} ({ended})", done.stdout, re.MULTILINE)
    return done.returncode, {one or other: ended or end for ended, one, other, end in lines}, done.stdout + done.stderr


@pytest.mark.parametrize(("workers", "which"), [("0", "laws"), ("2", "two-hits or turns or optional")])
def test_a_correct_engine_passes_every_check(tmp_path, workers, which):
    """As the engine author's guide prints it."""
    guide = (ROOT / "docs/guides/engine-author.md").read_text(encoding="utf-8")
    _, tests = re.findall(r"^```python\n(.*?)^```", guide, re.MULTILINE | re.DOTALL)
    project(tmp_path, tests)
    code, found, said = run(tmp_path, "-n", workers, "-k", which)
    assert code == 0, said
    assert {"test_laws[mine-two-hits-finishes]", "test_laws[mine-two-hits-converges-on-it]"} <= set(found)
    assert all(re.fullmatch(r"test_laws\[mine-(contract|two-hits)-[\w-]+\]", name) for name in found)
    assert set(found.values()) <= {"PASSED", "SKIPPED"}
    assert sum(outcome == "PASSED" for outcome in found.values()) >= (12 if which == "laws" else 3)


def test_a_faulty_engine_fails_by_name_and_an_expected_failure_is_strict(tmp_path):
    project(tmp_path, TESTS.replace("{failures}", "{}"), spoiled=True)
    code, found, said = run(tmp_path)
    failed = [name for name, outcome in found.items() if outcome == "FAILED"]
    assert code == 1, said
    assert "test_laws[mine-free-converges-on-it]" in failed
    assert "PASSED" in found.values()
    assert "at a step of 0.01 s" in said
    checks = dict.fromkeys(map(name_of, failed), "known")
    project(tmp_path, TESTS.replace("{failures}", repr(checks)), spoiled=True)
    code, found, said = run(tmp_path)
    assert code == 0, said
    assert {found[name] for name in failed} == {"XFAIL"}
    project(tmp_path, TESTS.replace("{failures}", repr(checks)))
    code, found, said = run(tmp_path)
    assert code == 1
    assert {found[name] for name in failed} == {"FAILED"}
    assert "XPASS(strict)" in said


def name_of(test: str) -> str:
    """Return the check of a test id."""
    return next(name for name in (*CHECKS, *ON_A_SCENE) if test.endswith(f"-{slug(name)}]"))


def test_an_expected_failure_of_no_check_is_refused(tmp_path):
    project(tmp_path, TESTS.replace("{failures}", '{"convergess": "typing error"}'))
    code, _, said = run(tmp_path)
    assert code == 2
    assert "no check 'convergess'" in said


@pytest.mark.parametrize("check", ON_A_SCENE)
def test_a_scene_that_an_engine_has_no_force_for_is_skipped(check):
    fast = tumble.Scene.read("die-straight").replace(gravity=(0, 0, -9.81))
    with pytest.raises(pytest.skip.Exception, match="gravity"):
        ON_A_SCENE[check](lambda state, dt, body: state, fast)


def test_a_scene_with_a_plane_asks_for_the_checks_of_contact():
    laws = parametrize_with_laws("physx", ["two-hits", "box-slide-22"], expected_failures={"holds": "x"}).args[1]
    ids = [law.id for law in laws]
    assert {"physx-contract-mirror-images", "physx-two-hits-converges-on-it", "physx-box-slide-22-finishes"} <= set(ids)
    assert "physx-box-slide-22-converges-on-it" not in ids
    with pytest.raises(tumble.UserError, match="no check 'holds'"):
        parametrize_with_laws("physx", ["two-hits"], expected_failures={"holds": "x"})


def test_a_known_failure_of_an_engine_is_an_expected_one():
    with pytest.raises(pytest.xfail.Exception, match="pyramid"):
        contract("ode", "any direction")


def test_a_baseline_is_written_on_request_only_and_then_guards(tmp_path):
    project(tmp_path, CHECK)
    code, found, said = run(tmp_path)
    assert (code, found) == (1, {"test_guard": "FAILED"})
    assert "--tumble-accept" in said
    assert not (tmp_path / "tumble-baselines").exists()
    code, found, said = run(tmp_path, "--tumble-accept")
    assert (code, found) == (1, {"test_guard": "FAILED"})
    assert (tmp_path / "tumble-baselines/test-own-test-guard/cells.csv").is_file()
    assert run(tmp_path)[:2] == (0, {"test_guard": "PASSED"})
    text = (tmp_path / "mine.py").read_text(encoding="utf-8")
    (tmp_path / "mine.py").write_text(text.replace("x += dt * v", "x += 0.999 * dt * v"), encoding="utf-8")
    code, found, said = run(tmp_path)
    assert (code, found) == (1, {"test_guard": "FAILED"})
    assert "die-straight" in said
