"""What --shard and --cache make of a command, and how `tumble merge` gives the command again."""

from argparse import Namespace
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from tumble.compare.run.execution import Execution, Shard, executing
from tumble.compare.run.provenance import circumstances
from tumble.compare.run.shards import read_manifest, sharing
from tumble.compare.run.task_cache import TaskCache
from tumble.compare.tables.parquet import check_parquet, write_parquet
from tumble.notes import note
from tumble.parser import PAGE, parser

# Options of one machine alone, which a merged command does not have; all have a value.
OWN = ("--shard", "--cache", "--output")


def main(command: Callable[[Namespace], int], options: Namespace) -> int:
    """Run a command, or its share, with finished tasks found and saved in folders; return the exit code."""
    caches = (TaskCache(Path(options.cache), circumstances()),) if options.cache else ()
    if not options.shard:
        try:
            with executing(Execution(caches)):
                return with_parquet(command, options)
        except KeyboardInterrupt:
            if not caches:
                raise
            raise interrupted(options.cache) from None
    shard = Shard(*options.shard)
    named = options.output not in (None, PAGE)
    folder = Path(options.output if named else f"shard-{shard.number}-of-{shard.count}")
    folder.mkdir(parents=True, exist_ok=True)
    options.output = str(folder / PAGE if options.command == "report" else folder)
    if getattr(options, "accept", False) and options.baseline:
        options.output = None  # the record goes there when it is merged
    try:
        with sharing(folder, shard, ["tumble", *whole(options.words[1:])], caches):
            command(options)
    except KeyboardInterrupt:
        raise interrupted(str(folder)) from None
    with suppress(OSError):
        (folder / f"{Path(PAGE).stem}-tables").rmdir()  # a report begins with it; a shard has nothing for it
    note(f"when all {shard.count} shards are finished, type `tumble merge DIR...` with their folders")
    return 0


def interrupted(folder: str) -> KeyboardInterrupt:
    """Return the interrupt that says how to continue."""
    return KeyboardInterrupt(
        f"interrupted; finished results are saved in {folder}; run the same command again to continue"
    )


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
    check_parquet(options.output)
    code = command(options)
    write_parquet(options.output)
    return code


def merged_options(folders: Sequence[str], output: str | None = None, quiet: bool = False) -> Namespace:
    """Return the options of the command whose shards left these folders.  Raises BadShard."""
    _, *words = read_manifest(Path(folders[0])).words
    words += ["-o", output] if output else []
    options = parser().parse_args(words)
    options.words, options.quiet, options.install = ["tumble", *words], quiet, False
    return options
