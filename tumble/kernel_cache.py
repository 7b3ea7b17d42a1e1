"""Saves compiled kernels on disk if possible; a damaged one is compiled again.

Below `solver` and `scenarios`, which do not know each other.
"""

import contextlib
import hashlib
import importlib
import logging
import os
import pickle
import tempfile
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.environment import Environment, _rebuild_env, lookup_environment
from numba.core.event import Event, Listener, register
from numba.core.runtime import nrtdynmod
from numba.core.runtime.nrt import rtsys

from tumble.kernel_parts import IS_KNOWN, KernelLibrary

# Of what is saved; to be counted up when that changes.
FORMAT = 1
# Longest time to compile a kernel, and how often a process checks whether another has compiled it [s].
LONGEST_WAIT_S, LOOK_AGAIN_S = 60.0, 0.02

log = logging.getLogger(__name__)


class Compilation(Listener):
    """Adds up the processor time that compiling has taken in this process, processor_s [s]."""

    def __init__(self) -> None:
        self.processor_s = 0.0
        self._depth, self._begun_at = 0, 0.0

    def on_start(self, event: Event) -> None:
        """Note when the outermost of nested compilations begins."""
        if self._depth == 0:
            self._begun_at = time.thread_time()
        self._depth += 1

    def on_end(self, event: Event) -> None:
        """Add the outermost one."""
        self._depth -= 1
        if self._depth == 0:
            self.processor_s += time.thread_time() - self._begun_at


compilation = Compilation()
register("numba:compile", compilation)


@cache
def load_array_functions() -> None:
    """Load numba's functions of arrays, for its compiler, without scipy, whose BLAS it looks for: 0.3 s.

    It looks once, to decide whether its np.convolve may use BLAS; whatever else needs BLAS looks again.
    Source: numba 0.61 to 0.68, numba/np/arraymath.py.
    """
    from numba.np import linalg

    looked_for = linalg.ensure_blas
    linalg.ensure_blas = no_blas
    try:
        importlib.import_module("numba.np.arraymath")
    finally:
        linalg.ensure_blas = looked_for


def no_blas() -> None:
    """Raise ImportError, as numba does where scipy is not installed."""
    raise ImportError


class KernelReader(pickle.Unpickler):
    """Reads what was saved, without importing the modules of numba's own functions: only its compiler needs these."""

    def find_class(self, module: str, name: str) -> Any:
        """Return what a name in a file means."""
        if (module, name) == (_rebuild_env.__module__, _rebuild_env.__name__):
            return environment
        return super().find_class(module, name)


def environment(module: str, constants: list, name: str) -> Environment:
    """Return what holds the constants of a compiled function."""
    if not module.startswith("numba."):
        return _rebuild_env(module, constants, name)
    found = lookup_environment(name)
    if found is None:
        found = Environment._memo[name] = Environment({"__name__": module})
        found.consts[:], found.env_name = constants, name
    return found


class KernelFiles(IndexDataCacheFile):
    """Saves each kernel of a function in a file that is named after what the kernel is compiled for.

    numba numbers the files and has an index of them.  Of two processes that save at once, both can take the same
    number: then a later process loads a kernel that is compiled for other arguments.
    """

    def load(self, key: Any) -> Any:
        """Return what was saved for a key, or None."""
        try:
            return self._load_data(self._name(key))
        except OSError:
            return None

    def save(self, key: Any, data: Any) -> None:
        """Save what was compiled for a key."""
        self._save_data(self._name(key), data)

    def _load_data(self, name: str) -> Any:
        if not IS_KNOWN:
            return super()._load_data(name)
        with open(self._data_path(name), "rb") as file:
            return KernelReader(file).load()

    def _name(self, key: Any) -> str:
        compiled_for = hashlib.sha256(str((FORMAT, self._version, self._source_stamp, key)).encode())
        return f"{Path(self._index_name).stem}.{compiled_for.hexdigest()[:16]}.nbc"


class KernelCache(FunctionCache):
    """numba's cache, which tolerates damaged files and full disks and compiles nothing twice."""

    def __init__(self, py_func: Any) -> None:
        super().__init__(py_func)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = KernelFiles(self._cache_path, self._impl.filename_base, stamp)
        self._turns: dict[str, int] = {}

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the kernel compiled before, or by another process just now, or None."""
        found = self._loaded(sig, target_context)
        if found is not None:
            return found
        load_array_functions()
        if not self._wait_for_turn(sig):
            return None
        found = self._loaded(sig, target_context)
        if found is not None:
            self._end_turn(sig)
        return found

    def _wait_for_turn(self, sig: Any) -> bool:
        """Wait while another process compiles the same kernel; return whether it is this process's turn.

        The turn ends when the kernel is saved, or the process ends; after a long wait this process compiles it itself.
        """
        from filelock import lock_descriptor  # 40 ms, and most kernels are compiled already

        name = f"{self._impl.filename_base}-{hashlib.sha256(str(sig).encode()).hexdigest()[:16]}.lock"
        try:
            self._impl.locator.ensure_cache_path()
            turn = os.open(Path(self.cache_path) / name, os.O_RDWR | os.O_CREAT, 0o600)
        except OSError:
            return False
        until = time.monotonic() + LONGEST_WAIT_S
        while str(sig) not in self._turns and time.monotonic() < until:
            try:
                if lock_descriptor(turn, blocking=False):
                    self._turns[str(sig)] = turn
                    return True
            except OSError:  # a file system without locks
                break
            time.sleep(LOOK_AGAIN_S)
        os.close(turn)
        return False

    def _end_turn(self, sig: Any) -> None:
        turn = self._turns.pop(str(sig), None)
        if turn is not None:
            os.close(turn)

    def _loaded(self, sig: Any, target_context: Any) -> Any:
        try:
            if not IS_KNOWN:
                return super().load_overload(sig, target_context)
            # As numba does, but for all that only its compiler needs to know, which takes 0.1 s to load.
            with self._guard_against_spurious_io_errors(), kernel_libraries(target_context.codegen()):
                self._start_runtime(target_context)
                return self._load_overload(sig, target_context)
        except Exception as error:  # whatever unpickling makes of bytes that are not what was written
            warn_once(
                f"a compiled kernel in {self.cache_path} cannot be read ({type(error).__name__}): compiling it again"
            )
            return None

    def _start_runtime(self, target_context: Any) -> None:
        """Start what allocates memory for kernels; its code is saved too, as it takes 0.04 s to compile."""
        compiled_anew = nrtdynmod.compile_nrt_functions
        nrtdynmod.compile_nrt_functions = self._runtime
        try:
            rtsys.initialize(target_context)
        finally:
            nrtdynmod.compile_nrt_functions = compiled_anew

    def _runtime(self, target_context: Any) -> Any:
        codegen = target_context.codegen()
        key = "runtime", codegen.magic_tuple()
        with contextlib.suppress(Exception):  # a damaged file
            if (saved := self._cache_file.load(key)) is not None:
                return codegen.unserialize_library(saved)
        module, library = nrtdynmod.create_nrt_module(target_context)
        library.enable_object_caching()
        library.add_ir_module(module)
        library.finalize()
        with contextlib.suppress(OSError):  # it says so when it saves a kernel
            self._cache_file.save(key, library.serialize_using_object_code())
        return library

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save a compiled kernel, if there is room."""
        try:
            super().save_overload(sig, data)
        except Exception as error:
            warn_once(f"cannot save compiled kernels in {self.cache_path} ({error}): each process compiles them again")
            self.disable()
        finally:
            self._end_turn(sig)


@contextlib.contextmanager
def kernel_libraries(codegen: Any) -> Iterator[None]:
    """Let numba make libraries of ours meanwhile."""
    codegen._library_class = KernelLibrary
    try:
        yield
    finally:
        del codegen._library_class


def keep(dispatcher: Any, source: Path, others: tuple[Path, ...] = ()) -> Any:
    """Return a compiled function that is saved on disk, if there is a folder for it.

    source, others: the folders of its source code; each state of that has its own folder of kernels.
    """
    name = f"kernels-{state(source, *others)}"
    before = numba.config.CACHE_DIR  # type: ignore[attr-defined]
    try:
        for folder in folders(source):
            numba.config.CACHE_DIR = str(folder / name)  # type: ignore[attr-defined]
            with contextlib.suppress(OSError, RuntimeError):  # numba raises it if nothing can be written there
                (folder / name).mkdir(parents=True, exist_ok=True)
                dispatcher._cache = KernelCache(dispatcher.py_func)
                return dispatcher
    finally:
        numba.config.CACHE_DIR = before  # type: ignore[attr-defined]
    warn_once("no folder to save compiled kernels in: each process compiles them again")
    return dispatcher


@cache
def state(*sources: Path) -> str:
    """Return a hash of sixteen digits of the source in these folders."""
    return hashlib.sha256(b"".join(map(source_text, sources))).hexdigest()[:16]


@cache
def source_text(source: Path) -> bytes:
    """Return the source in a folder: most kernels have parts in the solver's."""
    return b"".join(path.read_bytes() for path in sorted(source.rglob("*.py")))


def folders(source: Path) -> Iterator[Path]:
    """Yield folders for kernels: the user's choice, beside the source, in the user's own folders."""
    if chosen := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(chosen)
    yield source / "__pycache__"
    from platformdirs import user_cache_path  # 20 ms, and seldom needed

    if (own := user_cache_path("tumble", appauthor=False)).is_absolute():  # and no ~ of a user without a home
        yield own
    if not hasattr(os, "getuid"):  # Windows has no folder for temporary files that users share
        return
    with contextlib.suppress(OSError):
        shared = Path(tempfile.gettempdir()) / f"tumble-{os.getuid()}"
        shared.mkdir(mode=0o700, exist_ok=True)
        # Code in it is run: it must belong to this user.
        if shared.lstat().st_uid == os.getuid() and not shared.lstat().st_mode & 0o077 and not shared.is_symlink():
            yield shared


@cache
def warn_once(line: str) -> None:
    """Log a warning, once a process."""
    log.warning(line)
