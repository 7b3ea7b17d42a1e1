"""Where a command runs its tasks, by its options; and how `tumble merge` gives the command of shards again."""

import os
from argparse import Namespace
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from tumble.compare.run.cluster.address import TLS, check_address
from tumble.compare.run.cluster.connecting import connected
from tumble.compare.run.cluster.on_worker import BadCluster
from tumble.compare.run.cluster.quiet import QuietWorkers
from tumble.compare.run.execution import EXECUTION, Shard, executing, interrupted
from tumble.compare.run.provenance import circumstances
from tumble.compare.run.shards.manifest import BadShard, read_manifest
from tumble.compare.run.shards.sharing import sharing
from tumble.compare.run.task_cache import TaskCache
from tumble.notes import note
from tumble.parser import PAGE, parser

# Options of one machine alone, which a merged command does not have; all have a value.
OWN = ("--shard", "--cache", "--output", "--workers", "--scheduler", "--tls-ca", "--tls-cert", "--tls-key")
# What a shard of `tumble.session` has for the words of its command.
IN_PYTHON = ("tumble.session",)


def main(command: Callable[[Namespace], int], options: Namespace) -> int:
    """Run a command, or its share, with finished tasks found and saved in folders; return the exit code."""
    if not hasattr(options, "shard"):  # with --parquet alone
        return with_parquet(command, options)
    if (options.shard or options.workers) and options.scheduler == os.environ.get("TUMBLE_SCHEDULER"):
        options.scheduler = None  # a default for all commands, which what is asked of this one replaces
    if not options.shard:
        return run_whole(command, options)
    if options.workers or options.scheduler:
        raise BadCluster("--shard runs here: leave out --scheduler and --workers")
    return run_shard(command, options)


def run_whole(command: Callable[[Namespace], int], options: Namespace) -> int:
    """Run a command here or on workers; return the exit code."""
    tls = {name: file for name in TLS if (file := getattr(options, f"tls_{name}"))}
    try:
        with placed(options.cache, options.workers, options.scheduler, tls, options.insecure_scheduler):
            return with_parquet(command, options)
    except KeyboardInterrupt:
        if not options.cache:
            raise
        raise interrupted(options.cache) from None


def run_shard(command: Callable[[Namespace], int], options: Namespace) -> int:
    """Run the share of a command, whose results it leaves in a folder; return 0."""
    shard = Shard(*options.shard)
    named = options.output not in (None, PAGE)
    folder = Path(options.output if named else f"shard-{shard.number}-of-{shard.count}")
    folder.mkdir(parents=True, exist_ok=True)
    options.output = str(folder / PAGE if options.command == "report" else folder)
    if getattr(options, "accept", False) and options.baseline:
        options.output = None  # the record goes there when it is merged
    try:
        with sharing(folder, shard, ["tumble", *whole(options.words[1:])], caches_of(options.cache)):
            command(options)
    except KeyboardInterrupt:
        raise interrupted(folder) from None
    with suppress(OSError):
        (folder / f"{Path(PAGE).stem}-tables").rmdir()  # a report begins with it; a shard has nothing for it
    note(f"when all {shard.count} shards are finished, type `tumble merge DIR...` with their folders")
    return 0


@contextmanager
def placed(
    cache: str | Path | None,
    workers: int | None,
    scheduler: str | None,
    tls: Mapping[str, str] = MappingProxyType({}),
    is_insecure: bool = False,
) -> Iterator[None]:
    """Run tasks on workers in the block, and find and save finished ones in a folder, where either is given."""
    with ExitStack() as stack:
        execution = EXECUTION.get()
        if cache:
            execution = replace(execution, caches=caches_of(cache))
        if workers is not None and (workers < 1 or scheduler):
            raise BadCluster(f"--workers {workers}: must be at least 1, and without --scheduler, which has its own")
        check_address(scheduler, tls, is_insecure)
        if workers or scheduler:
            cluster = stack.enter_context(connected(scheduler, workers, tls))
            execution = replace(
                execution, work=cluster.work, workers=cluster.workers, times=QuietWorkers(cluster.client)
            )
        stack.enter_context(executing(execution))
        yield


def caches_of(folder: str | Path | None) -> tuple[TaskCache, ...]:
    """Return the cache in a folder, of what this machine and its versions ran."""
    return (TaskCache(Path(folder), circumstances()),) if folder else ()


def whole(words: Sequence[str]) -> Iterator[str]:
    """Yield the words of a command without the options of one machine."""
    left = iter(words)
    for word in left:
        name, is_joined, _ = word.partition("=")
        if word == "-o" or (len(name) > 2 and any(option.startswith(name) for option in OWN)):
            if not is_joined:
                next(left, None)
        elif not (word.startswith("-o") and not word.startswith("--")):
            yield word


def with_parquet(command: Callable[[Namespace], int], options: Namespace) -> int:
    """Run a command, and write its tables as Parquet too where that is asked for; return the exit code."""
    if not getattr(options, "parquet", False):
        return command(options)
    from tumble.compare.tables.parquet import check_parquet, write_parquet  # pandas is slow to load

    check_parquet(options.output)
    code = command(options)
    write_parquet(options.output)
    return code


def merged_options(folders: Sequence[str], output: str | None = None, quiet: bool = False) -> Namespace:
    """Return the options of the command whose shards left these folders.  Raises BadShard."""
    before = read_manifest(Path(folders[0])).words
    if before == IN_PYTHON:
        raise BadShard(f"{folders[0]} was run in Python: make the same call in `with tumble.session(merge=[...])`")
    _, *words = before
    words += ["-o", output] if output else []
    options = parser().parse_args(words)
    options.words, options.quiet, options.install = ["tumble", *words], quiet, False
    return options
