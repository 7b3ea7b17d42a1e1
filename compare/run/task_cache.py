"""Finished tasks of a study, cached on disk until it ends, so that the same command continues an interrupted one.

A result is data as engines send it (`message`), in a file named by a hash of its task and everything that results
depend on: with another version, a changed scene or another time limit, none is found.
"""

import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from tumble.compare.run.process.message import PREFIX, Malformed, frame, lengths, unpacked
from tumble.scenarios.files import plain_bytes

FOLDER = ".unfinished"
DIGEST_BYTES = 32


@contextmanager
def resumable(folder: Path | None, depends_on: object) -> Iterator["TaskCache | None"]:
    """Provide the cache of a study's finished tasks, removed when the study ends.

    Parameters
    ----------
    folder : where the study writes its results; None: nothing is cached
    depends_on : everything that results depend on except the task

    Raises
    ------
    KeyboardInterrupt : with the line that says how to continue
    """
    if folder is None:
        yield None
        return
    cache = TaskCache(folder, depends_on)
    try:
        yield cache
    except KeyboardInterrupt:
        saved = f"finished results are saved in {folder}; run the same command again to continue"
        raise KeyboardInterrupt(f"interrupted; {saved}") from None
    cache.remove()


class TaskCache:
    """The results of finished tasks in a folder; depends_on: as of `resumable`."""

    def __init__(self, folder: Path, depends_on: object) -> None:
        self._folder, self._depends_on = folder / FOLDER, repr(depends_on)

    def save(self, key: Sequence[str], result: object) -> None:
        """Save the result of a task: plain values, arrays and dataclasses of those.  Raises OSError."""
        self._folder.mkdir(parents=True, exist_ok=True)
        data = b"".join(frame(result))
        with tempfile.NamedTemporaryFile(dir=self._folder, delete=False) as draft:
            draft.write(hashlib.sha256(data).digest() + data)
        os.replace(draft.name, self._path(key))

    def find(self, key: Sequence[str], hint: Any) -> Any:
        """Return the result of a task as that type, None if there is none or its file is damaged."""
        with suppress(OSError, Malformed):
            saved = plain_bytes(self._path(key))
            digest, data = saved[:DIGEST_BYTES], saved[DIGEST_BYTES:]
            if hashlib.sha256(data).digest() == digest:
                head, _ = lengths(data[: PREFIX.size])
                return unpacked(hint, data[PREFIX.size : PREFIX.size + head], data[PREFIX.size + head :])
        return None

    def remove(self) -> None:
        """Remove all results."""
        shutil.rmtree(self._folder, ignore_errors=True)

    def _path(self, key: Sequence[str]) -> Path:
        return self._folder / hashlib.sha256(repr((tuple(key), self._depends_on)).encode()).hexdigest()[:32]
