"""`tumble WORDS` within the tests' own process: what starts Python and imports numpy for a process costs half a second.

Standard output and error are files, as they are for a process: children write to them, and neither is a terminal.
"""

import contextlib
import io
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from patience import without_progress

from tumble.__main__ import main

HANDLED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGCHLD)


def tumble(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run a command in a folder, and return what a process would: code, standard output, standard error."""
    with contextlib.chdir(folder), as_it_was(), redirected("stdout") as out, redirected("stderr") as err:
        try:
            code = main(list(words))
        except SystemExit as end:  # argparse's own refusal, and --help
            code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
        sys.stdout.flush()
        sys.stderr.flush()
        said = [out.read(), err.read()]
    return subprocess.CompletedProcess(["tumble", *words], code, said[0], without_progress(said[1]))


@contextlib.contextmanager
def as_it_was() -> Iterator[None]:
    """Put back the handlers of signals and the environment variables that a command sets."""
    handlers, variables = {number: signal.getsignal(number) for number in HANDLED}, dict(os.environ)
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        os.environ.clear()
        os.environ.update(variables)


@contextlib.contextmanager
def redirected(name: str) -> Iterator[io.TextIOWrapper]:
    """Send a standard stream to a file, for Python and for its descriptor; yield that file to be read."""
    descriptor, before = {"stdout": 1, "stderr": 2}[name], getattr(sys, name)
    before.flush()
    kept = os.dup(descriptor)
    # A command that drops its output has its own file lead nowhere: what was written is read by another.
    with tempfile.NamedTemporaryFile("w", encoding="utf-8") as file, open(file.name, encoding="utf-8") as written:
        os.dup2(file.fileno(), descriptor)
        setattr(sys, name, file.file)
        try:
            yield written
        finally:
            setattr(sys, name, before)
            os.dup2(kept, descriptor)
            os.close(kept)
