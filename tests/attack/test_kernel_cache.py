"""Compiled kernels are a convenience: where they cannot be kept, or are damaged, everything still flies."""

import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from patience import PATIENCE_S, without_progress

ROOT = Path(__file__).parents[2]
ANEW = "each process compiles them again"


def run(folder: Path, *, root: Path = ROOT, env=None, **settings) -> subprocess.CompletedProcess[str]:
    """Run a free flight by two methods, which takes a kernel of each: those that are compiled soonest."""
    env = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"} | (env or {})
    words = ["compare", "two-hits", "-e", "tumble:quaternion-euler", "-e", "tumble:matrix-euler", "--quiet"]
    return subprocess.run(
        [sys.executable, "-P", "-m", "tumble", *words],
        cwd=folder,
        env=env | {"PYTHONPATH": str(root)},
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        **settings,
    )


@pytest.fixture(scope="module")
def kept(tmp_path_factory) -> tuple[Path, str]:
    """A folder of compiled kernels, and what was printed when they were compiled."""
    folder = tmp_path_factory.mktemp("kernels")
    done = run(folder, env={"NUMBA_CACHE_DIR": str(folder / "kept")})
    assert done.returncode == 0, done.stderr
    assert "crashed" not in done.stdout
    return folder / "kept", done.stdout


@pytest.mark.parametrize("share", [0.0, 0.5])
def test_a_damaged_kernel_is_compiled_anew(tmp_path, kept, share):
    folder, said = kept
    shutil.copytree(folder, tmp_path / "kept")
    damaged = list((tmp_path / "kept").rglob("*.nbc"))
    assert len(damaged) > 1
    for path in damaged:
        path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    first = run(tmp_path, env={"NUMBA_CACHE_DIR": str(tmp_path / "kept")})
    assert (first.returncode, first.stdout.count("crashed")) == (0, 0), first.stderr
    assert "cannot be read" in first.stderr
    assert first.stdout.splitlines()[0] == said.splitlines()[0]
    again = run(tmp_path, env={"NUMBA_CACHE_DIR": str(tmp_path / "kept")})
    assert (again.returncode, without_progress(again.stderr)) == (0, ""), "what was compiled anew is kept"


def test_kernels_on_disk_load_no_compiler(kept):
    folder, said = kept
    again = run(folder, env={"NUMBA_CACHE_DIR": str(folder), "PYTHONPROFILEIMPORTTIME": "1"})
    assert again.stdout == said
    assert "numba.core.dispatcher" in again.stderr
    assert "numba.np.arraymath" not in again.stderr


def test_a_full_disk_costs_only_time(tmp_path):
    done = run(
        tmp_path,
        env={"NUMBA_CACHE_DIR": str(tmp_path / "kept")},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)),
    )
    assert (done.returncode, done.stdout.count("crashed")) == (0, 0), done.stderr
    assert ANEW in done.stderr


def test_without_a_folder_to_write_to_the_next_is_taken(tmp_path):
    """The package's own folders cannot be written to, and then the home cannot, and then nothing can."""
    root = tmp_path / "package"
    shutil.copytree(ROOT / "tumble", root / "tumble", ignore=shutil.ignore_patterns("__pycache__"))
    for folder in (path for path in [root, *root.rglob("*")] if path.is_dir()):
        (folder / "__pycache__").write_text("a file, where a folder would be made")
    home, temporary = tmp_path / "home", tmp_path / "temporary"
    temporary.mkdir()
    base = {"HOME": str(home), "TMPDIR": str(temporary), "XDG_CACHE_HOME": ""}
    first = run(tmp_path, root=root, env=base)
    assert (first.returncode, without_progress(first.stderr)) == (0, "")
    assert list(home.rglob("*.nbc"))
    second = run(tmp_path, root=root, env=base | {"HOME": os.devnull})
    assert (second.returncode, without_progress(second.stderr)) == (0, "")
    assert list(temporary.rglob("*.nbc"))
    shutil.rmtree(temporary)
    temporary.mkdir()
    (temporary / f"tumble-{os.getuid()}").write_text("in the way")
    third = run(tmp_path, root=root, env=base | {"HOME": os.devnull})
    assert third.returncode == 0
    assert third.stdout.count("crashed") == 0
    assert ANEW in third.stderr


def test_a_folder_of_somebody_else_is_not_run(tmp_path, monkeypatch):
    from tumble import kernel_cache

    monkeypatch.setattr(kernel_cache.tempfile, "gettempdir", lambda: str(tmp_path))
    own = tmp_path / f"tumble-{os.getuid()}"
    assert own in list(kernel_cache.folders(tmp_path))
    own.chmod(0o777)
    assert own not in list(kernel_cache.folders(tmp_path))
    own.rmdir()
    (tmp_path / "elsewhere").mkdir(mode=0o700)
    own.symlink_to(tmp_path / "elsewhere")
    assert own not in list(kernel_cache.folders(tmp_path))


TWICE = """
import sys
from pathlib import Path
from numba import njit
from tumble import kernel_cache
saved = kernel_cache.KernelCache.save_overload
def save(self, sig, data):
    print("compiled", flush=True)
    saved(self, sig, data)
kernel_cache.KernelCache.save_overload = save
sys.path.insert(0, sys.argv[1])
import slow
kernel_cache.keep(slow.slow, Path(sys.argv[1]))(1.0)
"""


def test_two_processes_that_need_one_kernel_compile_it_once(tmp_path):
    body = "".join(f"    x = x * {n}.5 + x / {n + 1}\n" for n in range(400))
    (tmp_path / "slow.py").write_text(f"from numba import njit\n@njit\ndef slow(x):\n{body}    return x\n")
    env = os.environ | {"PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(tmp_path / "kept")}
    both = [
        subprocess.Popen([sys.executable, "-c", TWICE, str(tmp_path)], env=env, stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    said = "".join(process.communicate(timeout=PATIENCE_S)[0] for process in both)
    assert [process.returncode for process in both] == [0, 0]
    assert said == "compiled\n"


AT_ONCE = """
import sys
import time
from pathlib import Path
import numpy as np
from numba import njit
from numba.core.caching import IndexDataCacheFile
from tumble import kernel_cache
dumped, pauses = IndexDataCacheFile._dump, [float(each) for each in sys.argv[3:]]
def dump(self, data):
    is_runtime = data[0] == "nrt"
    time.sleep(pauses.pop(0) if pauses and not is_runtime else 0)
    return dumped(self, data)
IndexDataCacheFile._dump = dump
sys.path.insert(0, sys.argv[1])
import second
kernel = kernel_cache.keep(second.second, Path(sys.argv[1]))
rows = np.arange(6.0)
print(*(kernel(rows[:: int(step)]) for step in sys.argv[2]))
"""


def test_two_processes_save_kernels_for_different_arguments_at_once(tmp_path):
    (tmp_path / "second.py").write_text("from numba import njit\n@njit\ndef second(rows):\n    return rows[1]\n")
    env = os.environ | {"PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(tmp_path / "kept")}
    command = [sys.executable, "-c", AT_ONCE, str(tmp_path)]
    # With numba's index: both look for a free number, the second process writes the index last, the first its kernel.
    both = [
        subprocess.Popen([*command, step, *pauses], env=env, stdout=subprocess.PIPE, text=True)
        for step, *pauses in (("1", "2", "4"), ("2", "4", "0"))
    ]
    assert [process.communicate(timeout=PATIENCE_S)[0] for process in both] == ["1.0\n", "2.0\n"]
    then = subprocess.run([*command, "12"], env=env, capture_output=True, text=True, timeout=PATIENCE_S)
    assert (then.stdout, then.stderr) == ("1.0 2.0\n", "")
    assert len(list((tmp_path / "kept").rglob("*.nbc"))) == 3, "and the code that allocates memory"


CALLS = """
import sys
from pathlib import Path
from numba import njit
from tumble import kernel_cache
from tumble.kernel_parts import KernelCompiler
sys.path.insert(0, sys.argv[1])
import half
kernel = kernel_cache.keep(njit(pipeline_class=KernelCompiler)(half.half), Path(sys.argv[1]))
kernel(1.0)
library = next(iter(kernel.overloads.values())).library
print(bool(library._saved_text), library._shared_module is not None)
@njit
def calls(x):
    return kernel(x) + 1.0
print(calls(3.0), library._shared_module is not None)
"""


def test_a_saved_kernel_is_read_without_its_text_until_another_function_calls_it(tmp_path):
    (tmp_path / "half.py").write_text("def half(x):\n    return x / 2.0\n")
    first, then = twice(tmp_path, CALLS)
    assert first == "False True\n2.5 True\n"
    assert then == "True False\n2.5 True\n"


ALLOCATES = """
import sys
from pathlib import Path
from tumble import kernel_cache
sys.path.insert(0, sys.argv[1])
import zeros
kernel = kernel_cache.keep(zeros.zeros, Path(sys.argv[1]))
print(kernel(7))
print("numba.np.arrayobj" in sys.modules)
"""


def test_a_saved_kernel_needs_no_modules_of_numbas_own_functions(tmp_path):
    """It allocates an array, as `numba.np.arrayobj` does it."""
    (tmp_path / "zeros.py").write_text(
        "import numpy as np\nfrom numba import njit\n@njit\ndef zeros(n):\n    return np.empty(n).size\n"
    )
    assert twice(tmp_path, ALLOCATES) == ["7\nTrue\n", "7\nFalse\n"]


def twice(folder: Path, program: str) -> list[str]:
    """Run a program in two processes, one after the other, and return what each prints."""
    env = os.environ | {"PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(folder / "kept")}
    command = [sys.executable, "-c", program, str(folder)]
    return [subprocess.run(command, env=env, capture_output=True, text=True, check=True).stdout for _ in range(2)]
