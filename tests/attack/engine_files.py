"""Engine files that do what none should: each costs its own row, with a reason in one line, and nothing else."""

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

from left_running import left_running

from tumble.compare.judge.errors import Run
from tumble.compare.run.engines.registry import BadEngine
from tumble.compare.run.status import Failure
from tumble.compare.run.truths import true_answer
from tumble.compare.run.worker import Worker
from tumble.scenarios.read import read_scene

GOOD = """
import ctypes, gc, json, os, signal, struct, sys, threading, time, warnings
import numpy as np
METHODS = ("m",)
FEATURES = {"gravity"}
ABOUT = {"version": "1", "precision": "double", "switched_off": []}
def build(scene, method): return {"scene": scene}
def write(world, states): world["states"] = states
def advance(world, n, dt): world["states"][:, 0:3] += n * dt * world["states"][:, 7:10]
def read(world): return world["states"]
"""
LINES = "[int(name) for name in os.listdir('/proc/self/fd') if int(name) > 2]"
# What a run's status may say, whatever an engine does.
STATUS = re.compile(r"(ok|flagged: .+|diverged at .+ s|skipped: .+|missing: .+|crashed: .+|timeout: .+|untimed: .+)")
DIES, KILLED = "crashed: its process ended", "crashed: its process was killed by"
SENT = "crashed: what it sent"
RAISES = "crashed: "

# What is put before the first line of a verb, or in place of it.
ADVANCES = {
    "raises": ("raise ValueError('a\\nb')", "crashed: ValueError: a b"),
    "raises with control characters": ("raise ValueError('\\x1b[31m\\x00')", RAISES),
    "raises with a million letters": ("raise ValueError('a' * 1_000_000)", RAISES),
    "raises what is no exception": ("raise 5", "crashed: TypeError"),
    "raises what cannot be told": ("raise type('E', (Exception,), {'__str__': lambda e: 1 / 0})()", ""),
    "raises KeyboardInterrupt": ("raise KeyboardInterrupt", f"{KILLED} SIGINT|{DIES}"),
    "raises GeneratorExit": ("raise GeneratorExit", DIES),
    "raises BaseException": ("raise BaseException('x')", DIES),
    "raises StopIteration": ("raise StopIteration", RAISES),
    "raises MemoryError": ("raise MemoryError", "crashed: more than"),
    "raises NotImplementedError": ("raise NotImplementedError('no')", "skipped: no"),
    "raises OSError": ("open('/nowhere')", "crashed: FileNotFoundError"),
    "raises BrokenPipeError": ("raise BrokenPipeError", ""),
    "recurses": ("advance(world, n, dt)", "crashed: RecursionError"),
    "exits": ("sys.exit()", DIES),
    "exits with a number": ("sys.exit(3)", f"{DIES} with code 3"),
    "exits with words": ("sys.exit('no\\nlicence')", f"{DIES}: no licence"),
    "exits at once": ("os._exit(9)", f"{DIES} with code 9"),
    "aborts": ("os.abort()", f"{KILLED} SIGABRT"),
    "reads where nothing is": ("ctypes.string_at(0)", f"{KILLED} SIGSEGV"),
    "divides by zero in C": ("signal.raise_signal(signal.SIGFPE)", f"{KILLED} SIGFPE"),
    "is killed": ("os.kill(os.getpid(), signal.SIGKILL)", f"{KILLED} SIGKILL"),
    "is terminated": ("os.kill(os.getpid(), signal.SIGTERM)", f"{KILLED} SIGTERM"),
    "stops": ("os.kill(os.getpid(), signal.SIGSTOP)", "timeout: "),
    "kills its group": ("os.killpg(0, signal.SIGKILL)", f"{KILLED} SIGKILL"),
    "loops": ("\n    while True: pass", "timeout: "),
    "sleeps": ("time.sleep(1000)", "timeout: "),
    "waits for a lock": ("lock = threading.Lock(); lock.acquire(); lock.acquire()", "timeout: "),
    "holds Python's lock": ("ctypes.PyDLL(None).pause()", "timeout: "),
    "loops with signals ignored": (
        "[signal.signal(s, signal.SIG_IGN) for s in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)]"
        "\n    while True: pass",
        "timeout: ",
    ),
    "forks and waits": ("os.fork() or time.sleep(1000)", ""),
    "forks fifty": ("[os.fork() or time.sleep(1000) for _ in range(50)]", ""),
    "forks and dies": ("os.fork() and os._exit(4)\n    time.sleep(1000)", f"{DIES} with code 4"),
    "starts a program": ("os.spawnlp(os.P_NOWAIT, 'sleep', 'sleep', '1000', __file__, 'serve.py')", "ok|flagged: "),
    "starts a thread that stays": ("threading.Thread(target=time.sleep, args=(1000,)).start()", "ok|flagged: "),
    "starts a thread that raises": ("threading.Thread(target=lambda: 1 / 0).start()", "ok|flagged: "),
    "takes memory at once": ("world['hoard'] = np.ones(1 << 30)", "crashed: more than"),
    "takes memory bit by bit": (
        "\n    while True: world.setdefault('h', []).append(bytearray(1 << 24))", "crashed: more than"
    ),
    "opens files": (
        "import resource; resource.setrlimit(resource.RLIMIT_NOFILE, (99, 99))"
        "\n    world['f'] = [open(os.devnull) for _ in range(99)]",
        "crashed: OSError",
    ),
    "writes to every line": (f"[os.write(line, b'abcd') for line in {LINES} if line != world]", ""),
    "closes every line": ("os.closerange(3, 4096)", ""),
    "closes standard error": ("os.close(2)", ""),
    "prints a megabyte": ("print('x' * (1 << 20))", "ok|flagged: "),
    "prints bytes": ("os.write(1, bytes(range(256)))", "ok|flagged: "),
    "warns": ("warnings.warn('look')", "ok|flagged: "),
    "turns warnings into errors": ("warnings.simplefilter('error'); np.float64(1) / np.float64(0)", "crashed: Ru"),
    "leaves the folder": ("os.chdir('/')", "ok|flagged: "),
    "removes numpy": ("[sys.modules.pop(name) for name in list(sys.modules) if name.startswith('numpy')]", ""),
    "removes all modules": ("sys.modules.clear()", ""),
    "breaks json": ("json.dumps = lambda *_: 'broken'", ""),
    "breaks struct": ("struct.Struct.pack = None", RAISES),
    "breaks print": ("sys.stdout = sys.stderr = None", "ok|flagged: "),
    "sets the alarm": ("signal.alarm(1); time.sleep(1000)", f"{KILLED} SIGALRM"),
    "switches collection off": ("gc.disable()", "ok|flagged: "),
    "limits itself": (
        "import resource; resource.setrlimit(resource.RLIMIT_NOFILE, (3, 3))", "ok|flagged: |crashed: "
    ),
    "sets a trace": ("sys.settrace(lambda *_: 1 / 0)", ""),
    "alters the scene": ("world['scene'].start[0] = 0", "crashed: ValueError"),
    "replaces the scene": ("world['scene'].duration = 0", "crashed: FrozenInstanceError"),
    "gives the states a field less": ("world['states'] = world['states'][:, :12]", ""),
    "gives nothing": ("world['states'] = None", "crashed: "),
    "gives words": ("world['states'] = 'nothing'", RAISES),
    "gives another shape": ("world['states'] = np.zeros((13, 1))", "crashed: "),
    "gives a state too many": ("world['states'] = np.zeros((2, 13))", "crashed: "),
    "gives complex numbers": ("world['states'] = world['states'] * 1j", "crashed: ValueError: it answered complex"),
    "gives objects": ("world['states'] = world['states'].astype(object)", "ok|flagged: "),
    "gives objects that are none": ("world['states'] = np.array([[None] * 13])", "crashed: TypeError|diverged"),
    "gives lists of lists": ("world['states'] = world['states'].tolist()", ""),
    "gives a ragged list": ("world['states'] = [[1.0], [1.0, 2.0]]", RAISES),
    "gives NaN": ("world['states'][:] = np.nan", "diverged at"),
    "gives infinity": ("world['states'][:, 0] = np.inf", "diverged at"),
    "gives 1e300": ("world['states'][:, 0:3] = 1e300", ""),
    "gives a quaternion of zeros": ("world['states'][:, 3:7] = 0", ""),
    "gives single precision": ("world['states'] = world['states'].astype('f4')", "ok|flagged: "),
    "gives other bytes first": ("world['states'] = world['states'].astype('>f8')", "ok|flagged: "),
    "gives a view of itself": (
        "world['states'] = np.lib.stride_tricks.as_strided(world['states'], (1, 13), (8, 8))", "ok|flagged: "
    ),
}  # fmt: skip
# In place of the whole file, or of a line of it.
LOADS = {
    "is empty": ("", "has no build|has no METHODS|engine file needs"),
    "is no text": ("\xff\x00\xfe", "bad.py:1: "),
    "is no Python": ("def f(:\n", "bad.py:1"),
    "is nested beyond measure": ("x = " + "(" * 5000 + ")" * 5000, ""),
    "raises when loaded": ("raise RuntimeError('at home')", "cannot be loaded: RuntimeError: at home"),
    "exits when loaded": ("import os; os._exit(3)", "ended with code 3"),
    "exits with a reason": ("import sys; sys.exit('no licence')", "no licence"),
    "hangs when loaded": ("import time; time.sleep(1000)", "timeout: "),
    "takes memory when loaded": ("x = bytearray(1 << 40)", "more than"),
    "writes to every line when loaded": (
        "import os\nfor name in os.listdir('/proc/self/fd'):\n"
        "    try: os.write(int(name), b'TMBL' + bytes(60)) if int(name) > 2 else None\n    except OSError: pass\n",
        "what it sent",
    ),
    "has methods that are numbers": (GOOD.replace('("m",)', "(1, 2)"), ""),
    "has methods without end": (GOOD.replace('("m",)', "iter(int, 1)"), ""),
    "has a method of a megabyte": (GOOD.replace('("m",)', "('x' * (1 << 25),)"), ""),
    "has no features": (GOOD.replace('{"gravity"}', "None"), "must be names"),
    "has features that nobody knows": (GOOD.replace('{"gravity"}', '{"magnetism"}'), ""),
    "says nothing about itself": (GOOD.replace("ABOUT = {", "ABOUT = 5 #"), "ABOUT a dict"),
    "says that nothing was switched off": (GOOD.replace('"switched_off": []', '"switched_off": 5'), "ABOUT a dict"),
    "has a version in red": (GOOD.replace('"version": "1"', '"version": "\\x1b[31m1"'), ""),
    "has verbs that are none": (GOOD.replace("def read(world): return", "read ="), ""),
    "has an unknown law": (GOOD + "EXEMPT = {'gravity of the moon': ''}\n", "no check"),
    "takes no time at all": (GOOD + "STEP_NS = 0\n", "STEP_NS must be"),
    "builds nothing": (GOOD.replace('return {"scene": scene}', "return None"), ""),
    "builds for ever": (GOOD.replace('return {"scene": scene}', "time.sleep(1000)"), "timeout: "),
    "audits nonsense": (GOOD + "def audit(world): return [('nonsense', 'x')]\n", "crashed: ValueError"),
    "audits in red": (GOOD + "def audit(world): return ['\\x1b[31m']\n", "flagged: "),
    "audits a number": (GOOD + "def audit(world): return 5\n", "crashed: TypeError"),
    "has vertices of its own of no shape": (GOOD + "def vertices(world, points): return points[:1]\n", ""),
    "remarks a number": (GOOD + "def remark(world): return 5\n", SENT),
    "remarks a megabyte": (GOOD + "def remark(world): return 'x' * (1 << 25)\n", ""),
    "prepares badly": (GOOD + "def prepare(world, dt): raise ValueError('no')\n", "crashed: ValueError: no"),
}
ENGINE_FILES = {f"advance {name}": (body, expected, True) for name, (body, expected) in ADVANCES.items()} | {
    f"file {name}": (text, expected, False) for name, (text, expected) in LOADS.items()
}
SCENE = read_scene("die-straight")
true = cache(lambda: true_answer(SCENE, with_input_error=False).truth)
# More than the tests' own process has: what a new one is said to have held begins with that.
PATIENCE_S, SHORT_S, MEMORY = 60.0, 1.5, 1 << 30


def status(path: Path, hangs: bool, is_load: bool) -> str:
    """Return what became of one engine file: its run's status, or the line that refuses it."""
    with Worker(str(path), SHORT_S if hangs and is_load else PATIENCE_S, MEMORY) as worker:
        try:
            info = worker.describe()
        except BadEngine as refusal:
            return str(refusal)
        if isinstance(info, Failure):
            return str(info)
        # What is to hang is not waited for; all else has its time, on a busy machine too.
        worker.time_limit = SHORT_S if hangs else PATIENCE_S
        answer = worker.simulate(SCENE, info.methods[0], 0.01, probe=True)
    return Run(SCENE, "bad", "m", 0.01, answer, true()).outcome


def attack(folder: Path, name: str) -> None:
    """Have one engine file do its worst.  Raises AssertionError where that is told wrongly, or anything is left."""
    text, expected, is_advance = ENGINE_FILES[name]
    own = folder / re.sub(r"\W+", "-", name)
    own.mkdir(parents=True)
    path = own / "bad.py"
    if is_advance:
        text = GOOD.replace("def advance(world, n, dt): ", f"def advance(world, n, dt):\n    {text}\n    ")
    path.write_text(text, encoding="latin-1")
    said = status(path, expected in ("", "timeout: "), name == "file hangs when loaded")
    assert "\n" not in said, said
    assert STATUS.fullmatch(said) or said.startswith(str(path)), said
    assert re.search(expected, said), said
    left_running(path)


def all_attacks() -> dict[str, Callable[[Path], None]]:
    """Return every attack by its name."""
    return {name: lambda folder, name=name: attack(folder, name) for name in ENGINE_FILES}
