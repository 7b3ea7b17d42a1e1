"""One shard of a command: its tasks are run, and their results left in a folder."""

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from tumble.compare.run.digest import code_digest
from tumble.compare.run.engines.registry import EngineInfo
from tumble.compare.run.execution import Execution, Incomplete, Shard, executing
from tumble.compare.run.pool import POOL, Pool
from tumble.compare.run.provenance import machine
from tumble.compare.run.shards.manifest import FILE, FORMAT, TASKS, Manifest, Recorded, write_manifest
from tumble.compare.run.status import Failure
from tumble.compare.run.task_cache import TaskCache

log = logging.getLogger(__name__)


class RecordingPool(Pool):
    """Engine processes whose engines are recorded."""

    def __init__(self) -> None:
        self.engines: dict[str, Recorded] = {}

    def started(self, engine: str, info: EngineInfo | Failure, source: str) -> None:
        """Record an engine."""
        self.engines[engine] = Recorded(info, source)


@contextmanager
def sharing(folder: Path, shard: Shard, words: Sequence[str], caches: Sequence[TaskCache] = ()) -> Iterator[None]:
    """Run the tasks of one shard in the block, and leave their results in a folder.

    An Incomplete block is a finished shard.

    Parameters
    ----------
    folder : of the results
    shard : which part
    words : of the whole command
    caches : where else finished tasks are found and saved

    Yields
    ------
    nothing
    """
    (folder / FILE).unlink(missing_ok=True)
    cache, pool = TaskCache(folder / TASKS), RecordingPool()
    before = POOL.set(pool)
    try:
        with executing(Execution((cache, *caches), shard)):
            yield
    except Incomplete as rest:
        log.info(f"shard {shard} is finished, its results are in {folder}; tasks of other shards: {len(rest.missing)}")
    finally:
        POOL.reset(before)
    found = Manifest(FORMAT, tuple(words), shard.number, shard.count, code_digest(), machine(), pool.engines)
    write_manifest(folder, found)
