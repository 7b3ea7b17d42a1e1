"""The command line: words in, exit code out.  Heavy imports happen in the command that needs them."""

import os
import sys
from os.path import dirname, realpath

# `python -m tumble` puts the working directory first: what lies there is the user's, and none of our modules.
if __name__ == "__main__" and not sys.flags.safe_path and sys.path[0] != dirname(dirname(realpath(__file__))):
    del sys.path[0]

# Until there is somebody to say so in one line, an interrupt ends the process and says nothing.  `signal` would take a
# millisecond to be read.
import _signal  # type: ignore

try:
    before = _signal.signal(_signal.SIGINT, _signal.SIG_DFL)
except ValueError:  # another thread of somebody else's program
    before = None

import argparse
import importlib
import io
import signal
import threading
from collections.abc import Mapping
from contextlib import suppress

from tumble.parser import EXIT_USER, Parser, complete, parser
from tumble.reports.output import drop_output

if before is not None:
    signal.signal(signal.SIGINT, before)

EXIT_DONE, EXIT_BUG, EXIT_INTERRUPTED = 0, 3, 130
INTERRUPTED = "interrupted; nothing was written"
# The signals that have asked this process to end.
interrupts: list[int] = []


def main(words: list[str] | None = None) -> int:
    """Run one command and return its exit code: 0 done, 1 a check failed, 2 the user's mistake, 3 a bug of ours."""
    # The matrices here are 3 x 3: waking a BLAS's threads would take longer than all that it does.
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
        return EXIT_DONE  # the reader has had all it wanted
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
        return refuse(f"a bug of ours: {type(error).__name__}: {error}", EXIT_BUG)
    return code


def answer(top: Parser, options: argparse.Namespace) -> int:
    """Run the command, or answer what is asked of the program itself; return the exit code."""
    if options.version:
        print(importlib.import_module("importlib.metadata").version("tumble"))  # noqa: T201
    elif options.completion:
        # A few lines by which the shell asks tumble itself for the words that fit.
        print(importlib.import_module("argcomplete").shellcode(["tumble"], shell=options.completion))  # noqa: T201
    elif options.command is None:
        top.print_help()
    else:
        command = importlib.import_module(f"tumble.commands.{options.command}")
        importlib.import_module("tumble.notes").show_log()
        return command.main(options)
    return EXIT_DONE


def numba_refused(environment: Mapping[str, str]) -> str:
    """Return why kernels cannot be compiled under these environment variables, '' where they can.

    numba takes no notice of what is no whole number.
    """
    asked = {}
    for name in ("NUMBA_DISABLE_JIT", "NUMBA_NUM_THREADS"):
        with suppress(ValueError):
            asked[name] = int(environment.get(name, ""))
    if asked.get("NUMBA_DISABLE_JIT"):
        own = "an engine file of your own can say numba.config.DISABLE_JIT = 1"
        return f"NUMBA_DISABLE_JIT is set, and Tumble's kernels must be compiled: unset it ({own})"
    if (threads := asked.get("NUMBA_NUM_THREADS", 1)) < 1:
        return f"NUMBA_NUM_THREADS = {threads}: must be at least 1, or unset"
    return ""


def open_streams() -> None:
    """Open closed standard streams, so that no file takes their numbers: results are refused, notes are dropped."""
    for descriptor, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            # The lowest number that is free is this one.  What is open to be read refuses to be written.
            os.open(os.devnull, os.O_WRONLY if name == "stderr" else os.O_RDONLY)
            os.set_inheritable(descriptor, True)
            setattr(sys, name, os.fdopen(descriptor, "r" if name == "stdin" else "w", closefd=False))
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # What its encoding has no letters for, or is no text at all, is written out.
            stream.reconfigure(errors="backslashreplace")


def set_signals() -> None:
    """Let the signals that ask to end do what Ctrl-C does, but for those that somebody has set, `nohup` for one."""
    if threading.current_thread() is not threading.main_thread():
        return
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, interrupt)
    # Children that end are waited for, also where whoever started this process waits for none of his.
    if signal.getsignal(signal.SIGCHLD) == signal.SIG_IGN:
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)


def interrupt(number: int, frame: object) -> None:
    """Raise KeyboardInterrupt, and remember: a library that is just being imported may make something else of it."""
    interrupts.append(number)
    raise KeyboardInterrupt


def is_users(error: Exception) -> bool:
    """Whether the mistake is the user's."""
    from tumble.scenarios.refusal import UserError

    return isinstance(error, UserError)


def refuse(line: str, code: int) -> int:
    """Say why in one line and return the exit code."""
    one_line = "".join(char if char.isprintable() else repr(char)[1:-1] for char in line)
    print(f"tumble: {one_line}", file=sys.stderr)  # noqa: T201
    return code


if __name__ == "__main__":
    sys.exit(main())
