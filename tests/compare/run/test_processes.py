"""Calls shared out among processes: which of them takes what, what comes back, and what is told where one dies."""

import os
import subprocess
import sys

import pytest
from patience import PATIENCE_S

from tumble.compare.run.process.callers import FEW, Call, Callers
from tumble.compare.run.process.process import Died

OF_A_KIND = [False] * 5 + [True] * 3 + [False] * 5


@pytest.fixture
def processes():
    both = Callers(2)
    yield both
    both.end()


def pid(number):
    """Return a call that takes a while, of what another process can import: no module of the tests."""
    return Call(eval, (f"(__import__('time').sleep(0.2), {number}, __import__('os').getpid())[1:]",))


def test_those_of_a_kind_are_one_processs_and_the_rest_of_both(processes):
    calls = [pid(number) for number in range(len(OF_A_KIND))]
    results = [future.result() for future in processes.share_out(calls, OF_A_KIND)]
    assert [number for number, _ in results] == list(range(len(OF_A_KIND)))
    first = {process for (_, process), one in zip(results, OF_A_KIND, strict=True) if one}
    assert len(first) == 1
    assert first < {process for _, process in results}, "the other process made no call"
    taken = [process for _, process in results].count(*first)
    assert taken > OF_A_KIND.count(True), "it ended with those of a kind"


def test_a_few_of_a_kind_are_left_to_one_process_and_of_many_some_are_not(processes):
    for count, takers in ((FEW, 1), (FEW + 4, 2)):
        futures = processes.share_out([pid(number) for number in range(count)], [True] * count)
        results = [future.result() for future in futures]
        assert [number for number, _ in results] == list(range(count))
        assert len({process for _, process in results}) == takers


def test_a_call_that_nobody_waits_for_any_more_is_not_made(processes, tmp_path):
    calls = [pid(0), Call(os.mkdir, (tmp_path / "made",)), *(pid(number) for number in range(1, 7))]
    futures = processes.share_out(calls, [True] + [False] * 7)
    assert futures[1].cancel()
    assert [future.result()[0] for number, future in enumerate(futures) if number != 1] == list(range(7))
    assert not (tmp_path / "made").exists()


def test_who_waits_is_told_of_errors_and_of_death(processes):
    calls = [Call(os._exit, (3,)), *[Call(eval, ("1 / 0",))] * 4, pid(1)]
    futures = processes.share_out(calls, [True] + [False] * 5)
    with pytest.raises(Died):
        futures[0].result()
    # It takes on what is left, and whoever waits for that is told as well; the other one makes what it takes.
    ends = [type(future.exception()) for future in futures[1:]]
    assert set(ends) <= {ZeroDivisionError, Died, type(None)}
    assert ends[-1] is type(None), "the other process was to begin at the end"


def test_calls_that_wait_are_not_made_when_it_ends(processes):
    futures = processes.share_out([pid(number) for number in range(40)], [False] * 40)
    futures[0].result()
    for future in futures:
        future.cancel()
    processes.end()
    assert all(future.done() for future in futures)
    assert sum(not future.cancelled() for future in futures) < 10


def test_a_plain_script_without_a_guard_asks_for_two_truths(tmp_path):
    """Multiprocessing would run the script once more in each process, and end in BrokenProcessPool."""
    script = tmp_path / "script.py"
    script.write_text(
        "from tumble.compare.run.truths import Truths\nfrom tumble.scenarios.read import read_scene\n"
        "with Truths([read_scene('die-straight'), read_scene('two-hits')]) as truths:\n"
        "    print(*(future.result().truth.known for future in truths.futures))\n"
    )
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.split()) == 2, "the script ran more than once"
