"""`tumble.merge`: the results of all shards of a command, as if it had run whole."""

from argparse import Namespace
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from tumble.api.check import Check, check
from tumble.api.compare import compare
from tumble.api.releases import releases
from tumble.api.report import report
from tumble.api.result import Result
from tumble.api.stability import stability
from tumble.api.sweep import sweep
from tumble.compare.check.tolerances import read_tolerances
from tumble.compare.run.shards.merging import merging
from tumble.scenarios.refusal import UserError
from tumble.shares import merged_options


def of_check(options: Namespace, limits: Mapping[str, Any]) -> Check:
    """Return what a check found.  Raises UserError where a record is to be accepted: its folder is not given here."""
    if options.accept:
        raise UserError("a record is accepted by the command: type `tumble merge DIR... -o BASELINE`")
    tolerances, times = read_tolerances(options.tolerances), not options.no_times
    return check(options.scene, options.engine, baseline=options.baseline, times=times, tolerances=tolerances, **limits)


STUDIES: Mapping[str, Callable[[Namespace, Mapping[str, Any]], Result | Check]] = MappingProxyType(
    {
        "compare": lambda asked, limits: compare(asked.scene, asked.engine, dt=asked.dt, **limits),
        "sweep": lambda asked, limits: sweep(
            asked.scene or "yardstick", asked.engine, reference=asked.reference, observable=asked.observable, **limits
        ),
        "stability": lambda asked, limits: stability(asked.scene, asked.engine, **limits),
        "check": of_check,
        "releases": lambda asked, limits: releases(
            asked.engine, *([asked.scene] if asked.scene else []), first=asked.first, last=asked.last, **limits
        ),
        "report": lambda asked, limits: report(
            asked.scene, asked.engine, dt=asked.dt, every_method=asked.all, **limits
        ),
    }
)


def merge(folders: Sequence[str | Path], *, progress: bool = True) -> Result | Check:
    """Merge the results of all shards of a command (`--shard I/N`), in any order, into those of the whole.

    Scene files and engine files must be where the shards had them.  Run times that are compared are measured here.

    Parameters
    ----------
    folders : folder that each shard left.
    progress : draw a bar in a terminal or a notebook.

    Returns
    -------
    Result or Check
        What the function of the command returns.

    Raises
    ------
    UserError
        For folders that are no shards of one command and of the same versions, and where one is missing.

    Examples
    --------
    >>> import tumble
    >>> tumble.merge(["shard-1-of-2", "shard-2-of-2"]).runs  # doctest: +SKIP
    """
    if not folders:
        raise UserError("folders: give the folder of each shard")
    options = merged_options([str(folder) for folder in folders])
    with merging([Path(folder) for folder in folders]):
        limits = {
            "time_limit": options.time_limit, "memory_limit": options.memory_limit, "progress": progress,
        }  # fmt: skip
        return STUDIES[options.command](options, limits)
