"""An interrupt while a command is only starting: one line or none, and never a traceback or a bug of ours."""

import signal
import subprocess
import sys

import pytest
from patience import PATIENCE_S

# A library that is being imported makes an ImportError of an interrupt, as numpy does.
AT_IMPORT = """
import os, signal, sys
class Interrupts:
    def find_spec(self, name, *_):
        if name != {module!r}:
            return
        try:
            os.kill(os.getpid(), signal.{how})
        except KeyboardInterrupt:
            raise ImportError("PLEASE READ THIS FOR ADVICE")
sys.meta_path.insert(0, Interrupts())
from tumble.__main__ import main
sys.exit(main(["run", "die-straight", "-e", "tumble:rk4"]))
"""
BEFORE_THE_COMMAND = """
import os, signal, sys
import tumble.__main__ as start
def parser():
    os.kill(os.getpid(), signal.{how})
start.parser = parser
sys.exit(start.main(["scenes"]))
"""


def said(code: str) -> tuple[int, str]:
    done = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, timeout=PATIENCE_S)
    return done.returncode, done.stderr


@pytest.mark.parametrize("how", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_an_interrupt_that_a_library_makes_something_else_of_is_an_interrupt(how):
    code, told = said(AT_IMPORT.format(module="numpy", how=how))
    assert (code, told) == (130, "tumble: interrupted; nothing was written\n")


@pytest.mark.parametrize("how", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_an_interrupt_before_the_command_is_known_is_told_in_a_line(how):
    code, told = said(BEFORE_THE_COMMAND.format(how=how))
    assert (code, told) == (130, "tumble: interrupted; nothing was written\n")


def test_an_interrupt_before_anything_can_be_said_says_nothing():
    assert said(AT_IMPORT.format(module="argparse", how="SIGINT")) == (-signal.SIGINT, "")


def test_importing_the_command_line_leaves_signals_alone():
    code, told = said(
        "import signal; before = signal.getsignal(signal.SIGINT); import tumble.__main__;"
        "assert signal.getsignal(signal.SIGINT) is before is signal.default_int_handler"
    )
    assert code == 0, told
