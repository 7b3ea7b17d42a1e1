"""The command line: words in, exit code out.  Heavy imports happen in the command that needs them."""

import os
import sys
from os.path import dirname, realpath

# `python -m tumble` puts the working directory first on the path: its files are the user's, not our modules.
if __name__ == "__main__" and not sys.flags.safe_path and sys.path[0] != dirname(dirname(realpath(__file__))):
    del sys.path[0]

# Until main() can print one line, an interrupt ends the process silently.  Importing `signal` would take a millisecond.
import _signal  # type: ignore

try:
    before = _signal.signal(_signal.SIGINT, _signal.SIG_DFL)
except ValueError:  # another thread, of a program that imported this
    before = None

import argparse
import importlib
import io
import signal
import threading
from collections.abc import Mapping
from contextlib import suppress

from tumble.garbage import importing
from tumble.parser import EXIT_USER, Parser, complete, parser
from tumble.reports.output import drop_output

if before is not None:
    signal.signal(signal.SIGINT, before)

EXIT_DONE, EXIT_BUG, EXIT_INTERRUPTED = 0, 3, 130
# Options that say where tasks run, or that tables have a copy: `tumble.shares` deals with them.
SHARED = ("shard", "cache", "parquet", "workers", "scheduler", "tls_ca", "tls_cert", "tls_key")
# What the engines installed with Tumble share and is slow to import.
OF_ALL_ENGINES = ("numba",)
INTERRUPTED = "interrupted; nothing was written"
# Signals received that end this process.
interrupts: list[int] = []


def main(words: list[str] | None = None) -> int:
    """Run one command and return its exit code: 0 done, 1 a check failed, 2 the user's mistake, 3 a bug in Tumble."""
    # The matrices here are 3 x 3: starting BLAS threads would take longer than the work.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    interrupts.clear()
    try:
        set_signals()
        open_streams()
        top = parser()
        if "_ARGCOMPLETE" in os.environ:
            complete(top)
        options = top.parse_args(words)
        options.words = ["tumble", *(sys.argv[1:] if words is None else words)]
        if why := numba_refused(os.environ):
            return refuse(why, EXIT_USER)
        code = answer(top, options)
        sys.stdout.flush()
    except KeyboardInterrupt as stop:
        return refuse(str(stop) or INTERRUPTED, EXIT_INTERRUPTED)
    except BrokenPipeError:
        drop_output()
        return EXIT_DONE  # the reader has read all it wanted
    except OSError as error:
        drop_output()
        place = f"{error.filename}: " if error.filename else ""
        return refuse(f"{place}{error.strerror or error}", EXIT_USER)
    except Exception as error:
        if is_users(error):
            return refuse(str(error), EXIT_USER)
        if interrupts:
            return refuse(INTERRUPTED, EXIT_INTERRUPTED)
        sys.excepthook(type(error), error, error.__traceback__)
        return refuse(f"a bug in Tumble: {type(error).__name__}: {error}", EXIT_BUG)
    return code


def answer(top: Parser, options: argparse.Namespace) -> int:
    """Run the command, or print version, completion script or help; return the exit code."""
    if options.version:
        print(importlib.import_module("importlib.metadata").version("tumble"))  # noqa: T201
    elif options.completion:
        # A script by which the shell asks tumble for completions.
        print(importlib.import_module("argcomplete").shellcode(["tumble"], shell=options.completion))  # noqa: T201
    elif options.command is None:
        top.print_help()
    elif hasattr(options, "memory_limit"):  # it starts engines, which import what they need beside its own imports
        imports = () if getattr(options, "engine", None) else OF_ALL_ENGINES
        with importlib.import_module("tumble.compare.run.process.fork_server").fork_server(imports):
            return run(options)
    else:
        return run(options)
    return EXIT_DONE


def run(options: argparse.Namespace) -> int:
    """Run the command; return the exit code."""
    with importing():
        command = importlib.import_module(f"tumble.commands.{options.command}")
    importlib.import_module("tumble.notes").show_log()
    if any(getattr(options, name, None) for name in SHARED):
        return importlib.import_module("tumble.shares").main(command.main, options)
    return command.main(options)


def numba_refused(environment: Mapping[str, str]) -> str:
    """Return why these environment variables keep kernels from being compiled, '' if they do not.

    numba ignores values that are not integers.
    """
    values = {}
    for name in ("NUMBA_DISABLE_JIT", "NUMBA_NUM_THREADS"):
        with suppress(ValueError):
            values[name] = int(environment.get(name, ""))
    if values.get("NUMBA_DISABLE_JIT"):
        own = "an engine file of your own can say numba.config.DISABLE_JIT = 1"
        return f"NUMBA_DISABLE_JIT is set, but Tumble must compile its kernels: unset it ({own})"
    if (threads := values.get("NUMBA_NUM_THREADS", 1)) < 1:
        return f"NUMBA_NUM_THREADS = {threads}: must be at least 1, or unset"
    return ""


def open_streams() -> None:
    """Open closed standard streams, so that no file takes their numbers: writing results fails, notes are discarded."""
    for descriptor, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            # The lowest free number is this one.  A stream open for reading refuses to be written.
            os.open(os.devnull, os.O_WRONLY if name == "stderr" else os.O_RDONLY)
            os.set_inheritable(descriptor, True)
            setattr(sys, name, os.fdopen(descriptor, "r" if name == "stdin" else "w", closefd=False))
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # Characters that its encoding lacks are written as escapes.
            stream.reconfigure(errors="backslashreplace")


def set_signals() -> None:
    """Let signals that end a process do what Ctrl-C does, except those already handled or ignored (`nohup`)."""
    if threading.current_thread() is not threading.main_thread():
        return
    asking = (getattr(signal, name, None) for name in ("SIGINT", "SIGTERM", "SIGHUP"))  # Windows has no SIGHUP
    for number in filter(None, asking):
        if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, interrupt)
    # Children are waited for, even if the parent process ignores its own.
    if hasattr(signal, "SIGCHLD") and signal.getsignal(signal.SIGCHLD) == signal.SIG_IGN:
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)


def interrupt(number: int, frame: object) -> None:
    """Raise KeyboardInterrupt, and record it: a library being imported may turn it into another error."""
    interrupts.append(number)
    raise KeyboardInterrupt


def is_users(error: Exception) -> bool:
    """Whether the mistake is the user's."""
    from tumble.scenarios.refusal import UserError

    return isinstance(error, UserError)


def refuse(line: str, code: int) -> int:
    """Print the reason in one line and return the exit code."""
    one_line = "".join(char if char.isprintable() else repr(char)[1:-1] for char in line)
    print(f"tumble: {one_line}", file=sys.stderr)  # noqa: T201
    return code


if __name__ == "__main__":
    sys.exit(main())
