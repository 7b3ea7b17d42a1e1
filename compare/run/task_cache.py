"""Finished tasks on disk: of a study until it ends, of a shard until it is merged, or of all who share a folder.

A result is data as engines send it (`message`), in a file named by the digest of its task (`Task.digest`) and of the
circumstances: with another version, a changed scene or another time limit, none is found.  Files are written whole, so
that any number of processes and machines can share a folder.
"""

import hashlib
import json
import os
import shutil
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any
from uuid import uuid4

from tumble.compare.run.digest import digest
from tumble.compare.run.process.message import Malformed, frame, split, unpacked
from tumble.scenarios.files import plain_bytes

DIGEST_BYTES = 32
# The only figures of a result that differ between two runs of one task on one machine (`Trajectory`).
TIMES = ("wall_s", "cpu_s")


class TaskCache:
    """The results of finished tasks in a folder.

    Parameters
    ----------
    folder : made when the first result is saved
    depends_on : everything that results depend on beside the task
    """

    def __init__(self, folder: Path, depends_on: object = "") -> None:
        self.folder, self._depends_on = folder, digest(depends_on)

    def save(self, task: str, key: Sequence[str], result: object) -> None:
        """Save the result of a task: plain values, arrays and dataclasses of those.  Raises OSError, TypeError.

        task: its digest; key: its name, for messages.
        """
        data = b"".join((*frame(list(key)), *frame(result)))
        write_whole(self.path(task), hashlib.sha256(data).digest() + data)

    def find(self, task: str, kind: Any) -> Any:
        """Return the result of a task as that type, None if there is none or its file is damaged."""
        with suppress(OSError, Malformed):
            _, head, body = parts(self.path(task))
            return unpacked(kind, head, body)
        return None

    def path(self, task: str) -> Path:
        """Return the file of a task."""
        return self.folder / digest([task, self._depends_on])

    def remove(self) -> None:
        """Remove all results."""
        shutil.rmtree(self.folder, ignore_errors=True)


def write_whole(path: Path, data: bytes) -> None:
    """Write a file whole or not at all, while others write it too.

    Parameters
    ----------
    path : of the file; its folder is made if needed
    data : all of it

    Raises
    ------
    OSError : it cannot be written
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(f".{path.name}-{uuid4().hex}")  # not of tempfile, which others could not read
    try:
        draft.write_bytes(data)
        os.replace(draft, path)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise


def parts(file: Path) -> tuple[str, bytes, bytes]:
    """Return the name of a task, and the head and the body of its result, from its file.  Raises OSError, Malformed."""
    saved = plain_bytes(file)
    checksum, data = saved[:DIGEST_BYTES], saved[DIGEST_BYTES:]
    if hashlib.sha256(data).digest() != checksum:
        raise Malformed(f"{file}: damaged")
    key, result = split(data)
    return " ".join(unpacked(list[str], key, b"")), *split(result)


def apart_from_times(file: Path) -> tuple[object, bytes]:
    """Return what two results of one task have in common, times apart.  Raises OSError, Malformed."""
    _, head, body = parts(file)
    return _without_times(json.loads(head)), body


def _without_times(plain: Any) -> Any:
    if isinstance(plain, dict):
        return {name: _without_times(value) for name, value in plain.items() if name not in TIMES}
    return [_without_times(item) for item in plain] if isinstance(plain, list) else plain
