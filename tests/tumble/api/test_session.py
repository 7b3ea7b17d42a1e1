"""Engine processes: ended with the call, or with the session that keeps them ready, also when interrupted."""

import os
import signal
import subprocess
import sys
import textwrap

import psutil
import pytest
from patience import PATIENCE_S, until

import tumble


def children() -> set[int]:
    """Return the processes that this one has started, without those that have ended."""
    found = psutil.Process().children(recursive=True)
    return {one.pid for one in found if one.status() != psutil.STATUS_ZOMBIE}


@pytest.fixture
def before():
    return children()


def test_without_a_session_none_is_left_after_a_call(before):
    tumble.run("two-hits", "mujoco:rk4")
    assert children() == before
    tumble.compare("two-hits", ["mujoco:rk4", "tumble:rk4"], film=True)
    assert children() == before
    with pytest.raises(tumble.UserError):
        tumble.compare("two-hits", ["mujoco:rk4", "mujoco:nothing"])
    assert children() == before


def test_in_a_session_the_next_call_has_the_same_process(before):
    with tumble.session():
        assert children() == before
        first = tumble.run("two-hits", "mujoco:rk4")
        ready = children() - before
        assert ready
        assert tumble.run("two-hits", "mujoco:rk4").equals(first)
        tumble.compare("two-hits", "mujoco", film=False)
        assert children() - before == ready
    assert children() == before


def test_an_error_inside_the_block_ends_them(before):
    def fails():
        with tumble.session():
            tumble.run("two-hits", "tumble:rk4")
            assert children() - before
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fails()
    assert children() == before


def test_a_file_that_was_edited_is_loaded_again(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "")
    text = "def step(state, dt, body):\n    state[0:3] += dt * state[7:10] * {}\n"
    scene = tumble.Scene.sphere(0.1, 1.0, velocity=(1, 0, 0), duration=1.0, samples=2)
    file = tmp_path / "mine.py"
    with tumble.session():
        moved = []
        for factor in (1, 2):
            file.write_text(text.format(factor), encoding="utf-8")
            os.utime(file, (1e9, 1e9))  # as an edit within the second looks to Python
            moved.append(tumble.run(scene, file)["x_m"].iloc[-1])
    assert moved[1] == pytest.approx(2 * moved[0])


@pytest.mark.parametrize("opened", ["with tumble.session():", "if True:"])
def test_ctrl_c_in_the_middle_leaves_no_process(opened, tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        textwrap.dedent(f"""\
        import tumble
        {opened}
            tumble.run("two-hits", "tumble:rk4")
            print("ready", flush=True)
            while True:
                tumble.compare("brick-tumble", ["mujoco:rk4", "tumble:rk4"], film=False)
        """)
    )
    with subprocess.Popen(
        [sys.executable, "-P", str(script)], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as started:
        assert started.stdout.readline() == "ready\n"
        own = psutil.Process(started.pid)
        until(lambda: own.children(recursive=True))
        known = own.children(recursive=True)
        os.kill(started.pid, signal.SIGINT)
        _, said = started.communicate(timeout=PATIENCE_S)
    assert "KeyboardInterrupt" in said
    assert started.returncode != 0
    _, alive = psutil.wait_procs(known, timeout=30)
    assert alive == []
