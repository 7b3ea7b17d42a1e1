"""The one runner: order, what is done already, dead and hanging engines, and that nothing is left of it."""

import os
import signal
import subprocess
import sys
import threading
import time
import uuid
import weakref
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from patience import PATIENCE_S, until

from tumble.compare.judge.errors import RunAnswer
from tumble.compare.run import tasks as tasks_module
from tumble.compare.run.execution import FOLDER, Execution, Incomplete, Shard, executing, resumable
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.process.callers import Callers
from tumble.compare.run.process.process import Died
from tumble.compare.run.running_engines import Halted, RunningEngine, launched
from tumble.compare.run.task_cache import TaskCache
from tumble.compare.run.tasks import WINDOW, Queue, Task, run, stream
from tumble.compare.run.truths import Truths
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Scene

# It dies where the scene is called `die`, hangs where it is called `hang`, waits for a file where `slow`, and leaves
# its number in a file beside it.
ENGINE = """
import os, pathlib, time
METHODS = ("still",)
OPTIONAL = ("gyroscopic",)
FEATURES = {"gravity"}
ABOUT = {"version": "1", "precision": "double", "switched_off": []}
def build(scene, method, keep=()):
    pathlib.Path(__file__).with_suffix(".pid").write_text(str(os.getpid()))
    if scene.title == "die": os._exit(3)
    if scene.title == "hang": time.sleep(1000)
    while scene.title == "slow" and not pathlib.Path(__file__).with_suffix(".go").exists(): time.sleep(0.01)
    return {}
def write(world, states): world["states"] = states
def advance(world, n, dt): world["states"][:, 0:3] += n * dt * world["states"][:, 7:10]
def read(world): return world["states"]
"""
SCENE = read_scene("die-straight")


def engine_file(folder: Path, name: str) -> str:
    path = folder / f"{name}.py"
    path.write_text(ENGINE)
    return str(path)


def flight(number: int, running_engine: RunningEngine, title: str = "") -> Task:
    scene = replace(SCENE, title=title)
    key = f"{number}", running_engine.title, "still"
    return Task(key, running_engine, lambda able: (number, able.simulate(scene, "still", scene.step)))


def statuses(results) -> list[str]:
    return ["ok" if isinstance(answer, Trajectory) else str(answer) for _, answer in results]


def test_results_are_in_the_order_of_the_tasks_whoever_is_first(tmp_path):
    finished = []
    slow = threading.Event()
    with launched([engine_file(tmp_path, "a"), engine_file(tmp_path, "b")]) as (a, b):
        b_is_done = Task(("b", "last"), b, lambda able: slow.set())
        tasks = [
            Task(("a", "first"), a, lambda able: slow.wait(PATIENCE_S)),  # goes on when all of the other's are done
            *(flight(number, (a, b)[number % 2]) for number in range(6)),
        ]
        results = run([*tasks, b_is_done], finished=lambda key, result: finished.append(key))
    assert results[0] is True
    assert [number for number, _ in results[1:-1]] == list(range(6))  # pyright: ignore[reportGeneralTypeIssues]
    assert finished.index(("b", "last")) < finished.index(("a", "first")), "they were not side by side"


asked: list[int] = []


def ask(able: RunningEngine, number: int) -> int:
    asked.append(number)
    return number


def test_the_engine_with_most_left_to_do_is_next(monkeypatch):
    """Before its first task is done it may have any; it does one at a time."""
    now = [0.0]
    monkeypatch.setattr(tasks_module, "monotonic", lambda: now[0])
    engines = {name: cast(RunningEngine, object()) for name in "abc"}
    queue = Queue([Task((name,), engines[name], lambda able: None) for name in "abbbcc"])

    def following() -> Task:
        task = queue.next()
        assert task is not None
        return task

    first, second = following(), following()
    assert [first.key, second.key] == [("b",), ("c",)]
    now[0] = 1.0
    queue.done(first)
    assert following().key == ("a",), "not known yet"
    now[0] = 3.0
    queue.done(second)
    assert following().key == ("c",), "3 s, of b two tasks of 1 s"
    assert following().key == ("b",)
    assert queue.next() is None, "what is left is of one that is at work"


def test_a_stream_of_tasks_holds_only_some_of_them(tmp_path):
    held, most = weakref.WeakSet(), 0

    def tasks(count: int):
        for number in range(count):
            task = Task((str(number),), a, partial(ask, number=number))
            held.add(task)
            yield task

    count = 3 * WINDOW + 5
    with launched([engine_file(tmp_path, "a")]) as (a,):
        found = []
        for _, number in stream(tasks(count)):
            found.append(number)
            most = max(most, len(held))
        assert found == [*range(count)]
        assert most <= 2 * WINDOW
        with executing(Execution(shard=Shard(2, 2))), pytest.raises(Incomplete) as missing:
            assert not [*stream(tasks(WINDOW + 1))]
        assert len(missing.value.missing) == WINDOW // 2


def test_what_is_done_already_is_not_flown_again(tmp_path):
    asked.clear()
    with launched([engine_file(tmp_path, "a")]) as (a,):

        def counted(number: int) -> Task:
            return Task((str(number),), a, partial(ask, number=number))

        tasks = [counted(number) for number in range(5)]
        results = {}

        def interrupt(key, result):
            results[key] = result
            if len(results) == 2:
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt, match="again to continue"), resumable(tmp_path):
            run(tasks, finished=interrupt)
        assert asked == [0, 1]
        results.clear()
        with resumable(tmp_path):
            assert run(tasks, finished=results.__setitem__) == [0, 1, 2, 3, 4]
        assert asked == [0, 1, 2, 3, 4]
        assert [*results.values()] == [0, 1, 2, 3, 4], "results that were found count as finished"
        assert not (tmp_path / FOLDER).exists()
        assert statuses(run([flight(9, a)])) == ["ok"], "it flies again after it was stopped"
        a.halt(for_good=True)
        with pytest.raises(Halted):
            run([flight(9, a)])


def test_an_engine_that_dies_or_hangs_is_replaced_for_the_next_task(tmp_path):
    def limited(number: int, title: str) -> Task:
        """The time limit is short only where it is to be passed: starting a process is no part of the question."""

        def ask(able: RunningEngine):
            able.ensure_running()
            able.worker.time_limit = 1.0 if title == "hang" else PATIENCE_S
            answer = able.simulate(replace(SCENE, title=title), "still", SCENE.step)
            able.worker.time_limit = PATIENCE_S
            return number, answer

        return Task((f"{number}",), a, ask)

    with launched([engine_file(tmp_path, "a")], time_limit=PATIENCE_S) as (a,):
        titles = ["", "die", "", "hang", "", "die", "die", ""]
        found = statuses(run([limited(number, title) for number, title in enumerate(titles)]))
    dead = "crashed: its process ended with code 3"
    late = "timeout: no answer within 1 s (--time-limit)"
    assert found == ["ok", dead, "ok", late, "ok", dead, dead, "ok"]


def test_two_studies_at_once_put_their_questions_to_an_engine_in_turn(tmp_path):
    go_on, limit_s = tmp_path / "a.go", 5.0
    with launched([engine_file(tmp_path, "a")], time_limit=PATIENCE_S) as (a,), ThreadPoolExecutor(2) as both:
        first = both.submit(run, [flight(0, a, "slow")])
        until((tmp_path / "a.pid").exists)
        a.worker.time_limit = limit_s  # of the second, which has its turn only when the first is over
        second = both.submit(run, [flight(1, a)])
        time.sleep(limit_s + 1)
        go_on.touch()
        assert statuses(first.result()) == ["ok"]
        assert statuses(second.result()) == ["ok"], "to wait for one's turn is no part of one's time"


def test_a_task_that_fails_stops_the_others_at_once(tmp_path):
    with launched([engine_file(tmp_path, "a"), engine_file(tmp_path, "b")], time_limit=1.5 * PATIENCE_S) as (a, b):
        hanging = tmp_path / "b.pid"

        def fail(able):
            while not hanging.exists():
                time.sleep(0.01)
            raise ValueError("lost")

        kept = []
        begin = time.monotonic()
        with pytest.raises(ValueError, match="lost"):
            run(
                [Task(("a",), a, fail), flight(0, b, "hang"), flight(1, b)],
                finished=lambda key, result: kept.append(key),
            )
        assert time.monotonic() - begin < PATIENCE_S, "it waited for an engine that hangs"
        assert kept == [], "a flight that was killed is no result"
        assert not Path(f"/proc/{hanging.read_text()}").exists()


def test_truths_end_when_they_are_stopped_and_who_waits_is_told():
    many = read_scene("many-throws")
    begun = replace(many, start=np.tile(many.start, (200, 1)))  # minutes of work
    truths = Truths([SCENE, begun, replace(begun, duration=1.9)])
    truths.futures[0].result()
    told: list[BaseException | None] = []
    waiting = threading.Thread(target=lambda: told.append(truths.futures[1].exception()), daemon=True)
    waiting.start()
    truths.stop()
    waiting.join(60)
    assert isinstance(told[0], Died), "its process went on to the end"
    assert all(future.done() for future in truths.futures)


def test_truths_of_several_scenes_are_those_of_each_alone():
    scenes = [SCENE, read_scene("table-4-1")]
    ticks = []
    with Truths(scenes, ticks.append) as several:
        together = [future.result().truth for future in several.futures]
    assert sorted(ticks) == ["die-straight truth", "table-4-1 truth"]
    for scene, one in zip(scenes, together, strict=True):
        with Truths([scene]) as alone:
            assert alone.futures[0].result().truth.vertices.tolist() == one.vertices.tolist()


@pytest.mark.parametrize("asked", [1, 3], ids=["in a thread", "in processes"])
def test_what_follows_of_some_of_the_scenes_is_worked_out_where_their_truths_were(asked):
    scenes = [read_scene(name) for name in ("two-hits", "tether-critical", "die-straight")]
    with Truths(scenes[:asked]) as truths:
        made = [future.result() for future in truths.each(getattr, scenes[:2], ["name", "duration"])]
        assert made == [scenes[0].name, scenes[1].duration]
        asked_of = truths.each(getattr, scenes[:2], ["nobody has it"] * 2, [WhereItIsRead()] * 2)
        whose = [future.result() for future in asked_of]
    elsewhere = asked > 1
    assert [isinstance(one, int) and one != os.getpid() for one in whose] == [elsewhere] * 2


@pytest.mark.parametrize("asked", [0, 1, 2], ids=["with none before", "after one in a thread", "in its processes"])
def test_more_truths_are_asked_of_those_that_are_at_work(asked):
    scenes = [SCENE, read_scene("two-hits")]
    more = [read_scene("table-4-1"), replace(SCENE, times=SCENE.times[:3], duration=float(SCENE.times[2]))]
    ticks: list[str] = []
    with Truths(scenes[:asked], lambda what, share=1.0: ticks.append(what)) as truths:
        found = [future.result().truth for future in truths.more(more)]
        assert [len(one.times) for one in found] == [len(scene.rows) for scene in more]
        assert len(truths.futures) == asked + 2
        if asked:
            assert len(truths.answer(SCENE).truth.times) == len(SCENE.rows), "it is found by the name of another"
    assert sorted(ticks) == sorted(f"{scene.name} truth" for scene in (*scenes[:asked], *more))


def test_two_scenes_of_one_name_have_each_its_own_truth():
    one, other = read_scene("die-straight"), read_scene("die-vertex")
    other = replace(other, name=one.name)
    with Truths([one, other]) as truths:
        assert truths.answer(other).truth.vertices.tolist() == truths.futures[1].result().truth.vertices.tolist()
        fewer = replace(other, times=other.times[1::2])
        assert truths.answer(fewer).truth.times.tolist() == fewer.rows.tolist()
        with pytest.raises(KeyError):
            truths.answer(read_scene("die-vertex"))


def test_truths_asked_for_later_end_with_the_others():
    many = read_scene("many-throws")
    begun = replace(many, start=np.tile(many.start, (200, 1)))  # minutes of work
    with Truths([SCENE, read_scene("two-hits")]) as truths:
        late = truths.more([begun, replace(begun, duration=1.9)])
    assert all(future.done() for future in late)
    never = truths.more([SCENE, read_scene("two-hits")])
    assert all(future.cancelled() for future in never), "somebody waits for them for ever"


def test_studies_that_share_truths_end_them_one_after_the_other(monkeypatch):
    """On Ctrl-C all of them do; at once they would close a descriptor twice, and the command would blame a file."""
    ending, most = [], []

    def end(callers: Callers) -> None:
        ending.append(callers)
        most.append(len(ending))
        time.sleep(0.1)
        really(callers)
        ending.pop()

    really = Callers.end
    monkeypatch.setattr(Callers, "end", end)
    with Truths([SCENE, read_scene("two-hits")]) as truths, ThreadPoolExecutor(3) as threads:
        for done in [threads.submit(truths.stop) for _ in range(3)]:
            done.result()
    assert max(most) == 1
    assert len(most) == 4


class WhereItIsRead:
    """What another process reads as its own number."""

    def __reduce__(self):
        return os.getpid, ()


@pytest.mark.parametrize("others", [(), (SCENE,)], ids=["in a thread", "in a process"])
def test_a_long_truth_tells_how_far_it_is(others, monkeypatch):
    monkeypatch.setattr("tumble.compare.run.progress.QUICK_S", 0.0)
    shares: list[float] = []
    on_progress = lambda what, share=1.0: shares.append(share) if what == "many-throws truth" else None  # noqa: E731
    with Truths([read_scene("many-throws"), *others], on_progress) as truths:
        for future in truths.futures:
            future.result()
    assert len(shares) > 1, "its end alone was told"
    assert sum(shares) == pytest.approx(1.0)


def carrying(mark: str) -> list[int]:
    """Return the processes, also those of other sessions, whose environment carries a mark."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if mark.encode() in (folder / "environ").read_bytes():
                found.append(int(folder.name))
        except OSError:
            continue
    return found


@pytest.mark.parametrize(
    "words",
    [
        ("compare", "brick-tumble"),
        ("compare", "brick-tumble", "--workers", "1"),
        ("sweep", "die-straight"),
        ("ablate", "die-straight"),
        ("stability", "spin-fast"),
        ("check", "many-throws", "brick-tumble", "dzhanibekov", "--accept", "-o", "record"),
        ("report", "many-throws", "brick-tumble", "dzhanibekov", "-o", "page.html"),
    ],
    ids=lambda words: words[0] + "-on-a-worker" * ("--workers" in words),
)
def test_ctrl_c_leaves_no_process(tmp_path, words):
    path = Path(engine_file(tmp_path, "hanging"))
    hanging = ENGINE.replace('scene.title == "hang"', "True")
    path.write_text(hanging)
    mark = f"TUMBLE_TEST={uuid.uuid4()}"
    command = subprocess.Popen(
        [sys.executable, "-P", "-m", "tumble", *words, "-e", "tumble:rk4", "-e", str(path), "--time-limit", "900"],
        cwd=tmp_path,
        env=os.environ | dict([mark.split("=")]),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    try:
        until(path.with_suffix(".pid").exists)
        assert len(carrying(mark)) >= 3, "command and two engines"
        os.killpg(command.pid, signal.SIGINT)  # as a terminal does
        _, err = command.communicate(timeout=PATIENCE_S)
        assert command.returncode == 130, err
        assert b"Traceback" not in err
        until(lambda: not carrying(mark))
    finally:
        command.kill()
        for left in carrying(mark):
            os.kill(left, signal.SIGKILL)


counted: list[str] = []


def counting(able: RunningEngine, scene: Scene) -> list[RunAnswer]:
    counted.append(scene.title)
    return [RunAnswer("still", dt, able.simulate(scene, "still", dt)) for dt in (scene.step, scene.step / 2)]


def test_a_cached_task_is_found_again_bit_for_bit_and_under_the_same_circumstances_only(tmp_path):
    scenes = [replace(SCENE, title=title) for title in ("one", "die", "three")]
    with launched([engine_file(tmp_path, "a")]) as (a,):

        def flown(under: object, most: int | None = None) -> list[list[RunAnswer]]:
            counted.clear()
            tasks = [Task((scene.title, "a"), a, partial(counting, scene=scene)) for scene in scenes[:most]]
            with executing(Execution((TaskCache(tmp_path / "out" / FOLDER, under),))):
                return run(tasks)

        first = flown("then", 2)
        assert counted == ["one", "die"]
        again = flown("then")
        assert counted == ["three"], "what was done is flown again"
        assert [[each.answer for each in ladder] for ladder in again][1] == [each.answer for each in first[1]]
        for before, after in zip(first[0], again[0], strict=True):
            assert before.dt == after.dt
            assert before.answer.vertices.tobytes() == after.answer.vertices.tobytes()
            assert before.answer.wall_s == after.answer.wall_s
        flown("now")
        assert counted == ["one", "die", "three"]
        for damage in (lambda data: data[:-1], lambda data: data[:5], lambda data: data[:-1] + bytes([data[-1] ^ 1])):
            for file in (tmp_path / "out" / FOLDER).iterdir():
                file.write_bytes(damage(file.read_bytes()))
            flown("then")
            assert counted == ["one", "die", "three"], "a damaged file is taken for a result"
        for file in (tmp_path / "out" / FOLDER).iterdir():
            file.unlink()
            os.mkfifo(file)
        flown("then")
        assert counted == ["one", "die", "three"], "a pipe is not waited for"
        TaskCache(tmp_path / "out" / FOLDER).remove()
        assert list((tmp_path / "out").iterdir()) == []


def interrupted(folder: Path, *words: str) -> tuple[list[str], str, str]:
    """Run a command with an engine whose second method hangs until a file is there, and interrupt it then.

    Return its words, output and notes; every build leaves a line in the file `log`.
    """
    path = Path(engine_file(folder, "slow"))
    slow = ENGINE.replace('("still",)', '("still", "later")', 1).replace(
        "    if scene.title",
        "    with open(str(pathlib.Path(__file__).with_name('log')), 'a') as log: log.write(method + '\\n')\n"
        "    while method == 'later' and not pathlib.Path(__file__).with_name('go').exists(): time.sleep(0.05)\n"
        "    if scene.title",
        1,
    )
    path.write_text(slow)
    whole = [*words, "-e", str(path), "-o", "out", "--time-limit", "900"]
    command = subprocess.Popen(
        [sys.executable, "-P", "-m", "tumble", *whole],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # Whoever started the tests, `nohup` for one, may have told them to ignore it.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    log = folder / "log"
    try:
        until(lambda: log.exists() and "later" in log.read_text())
        command.send_signal(signal.SIGINT)
        out, err = command.communicate(timeout=PATIENCE_S)
    finally:
        command.kill()
    assert command.returncode == 130, err
    assert "Traceback" not in err
    assert not list((folder / "out").glob("*.csv"))
    (folder / "go").touch()
    return whole, out, err


def test_an_interrupted_study_runs_only_what_is_missing(tmp_path, tumble):
    words, out, err = interrupted(tmp_path, "stability", "spin-fast")
    assert "run the same command again to continue" in err
    assert "still" in out, "what was finished is shown"
    log = tmp_path / "log"
    assert log.read_text().split().count("still") > 1
    log.unlink()
    done = tumble(*words)
    assert done.returncode == 0, done.stderr
    assert "continuing: 1 of 2" in done.stderr
    assert {*log.read_text().split()} == {"later"}, "what was finished is run again"
    assert not (tmp_path / "out" / FOLDER).exists()
    resumed = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    assert tumble(*words).returncode == 0
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == resumed


@pytest.mark.parametrize("words", [("sweep", "die-straight"), ("check", "die-straight", "--accept", "--no-times")])
def test_an_interrupted_command_of_seconds_writes_nothing(tmp_path, words):
    _, _, err = interrupted(tmp_path, *words)
    assert "interrupted; nothing was written" in err
    assert not list((tmp_path / "out").iterdir())
