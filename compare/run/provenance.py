"""What the numbers were measured on: machine, versions, and the command that reruns them."""

import importlib.metadata
import os
import platform
from collections.abc import Iterator
from contextlib import suppress
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from tumble.compare.run.condition import ConditionRow
from tumble.compare.run.digest import code_digest
from tumble.compare.run.engines import registry
from tumble.compare.run.timing import machine_load

# What the tables of a comparison or a sweep are called; to be counted up when a column changes its name or meaning.
FORMAT = "tumble tables 3"
PACKAGES = ("tumble", "numpy", "numba", "mpmath")


@dataclass(frozen=True)
class Machine:
    """What tasks ran on."""

    processor: str
    cores: str
    system: str
    versions: tuple[ConditionRow, ...]


# The machines of a merged run; None: this one.
MACHINE: ContextVar[Machine | None] = ContextVar("machine", default=None)


def machine() -> Machine:
    """Return what tasks run on: this machine, or those whose results are merged."""
    return MACHINE.get() or Machine(processor(), str(os.cpu_count()), platform.platform(), tuple(found_versions()))


def conditions(command: str) -> Iterator[ConditionRow]:
    """Yield the format of the tables beside it, command, machine and versions.

    Parameters
    ----------
    command : the command line that produced the tables

    Yields
    ------
    one row a condition
    """
    yield ConditionRow("format", FORMAT)
    yield ConditionRow("command", command)
    found = machine()
    yield ConditionRow("processor", found.processor)
    yield ConditionRow("cores", found.cores)
    yield ConditionRow("system", found.system)
    yield from timed_under()
    yield from found.versions


def timed_under() -> Iterator[ConditionRow]:
    """Yield what else the machine did while times were taken, and where they were taken if that was on a worker."""
    yield from (ConditionRow("other work", words) for words in machine_load.seen)
    yield from (ConditionRow(f"times of {scene}", "; ".join(each)) for scene, each in machine_load.measured.items())


def versions() -> tuple[ConditionRow, ...]:
    """Return the versions of what tasks run on."""
    return machine().versions


def circumstances() -> list[object]:
    """Return all that every result of this machine depends on.

    Returns
    -------
    the format of results, the digest of Tumble's code, and the machine with its versions
    """
    return [FORMAT, code_digest(), replace(machine(), cores="")]


def found_versions() -> Iterator[ConditionRow]:
    """Yield the version of Python, and of the packages installed that figures depend on: ours and every engine's."""
    yield ConditionRow("python", platform.python_version())
    engines = sorted(package for engine in registry.names() for package in registry.package(engine).packages)
    for package in dict.fromkeys((*PACKAGES, *engines)):
        with suppress(importlib.metadata.PackageNotFoundError):
            yield ConditionRow(package, installed(package))


@cache
def installed(package: str) -> str:
    """Return the version of a package that is installed, looked up once: it is a file of thousands of lines.

    Raises PackageNotFoundError.
    """
    return importlib.metadata.version(package)


def processor() -> str:
    """Return the processor's name as the system tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()
