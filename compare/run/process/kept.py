"""Answers that are kept on disk while a study works, a file a task, so that it goes on where it was interrupted.

They are data as engines send them (`message`), under names that are others for other circumstances: what was answered
by another version, to a changed scene or under another time limit is not found.  A study that is done forgets them.
"""

import hashlib
import os
import shutil
import struct
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from tumble.compare.run.process.message import PREFIX, Malformed, frame, lengths, unpacked
from tumble.scenarios.files import plain_bytes

FOLDER = ".unfinished"


class Kept:
    """The answers of tasks that are done.

    folder: that of the study's results; under: all that answers depend on but for the task.
    """

    def __init__(self, folder: Path, under: object) -> None:
        self._folder, self._under = folder / FOLDER, repr(under)

    def keep(self, key: Sequence[str], answer: object) -> None:
        """Keep the answer of a task: plain values, arrays and dataclasses of those.  Raises OSError."""
        self._folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=self._folder, delete=False) as draft:
            draft.writelines(frame(answer))
        os.replace(draft.name, self._place(key))

    def find(self, key: Sequence[str], hint: Any) -> Any:
        """Return the answer of a task as that type, None where there is none that can be read."""
        with suppress(OSError, Malformed, struct.error):
            data = plain_bytes(self._place(key))
            head, _ = lengths(data[: PREFIX.size])
            return unpacked(hint, data[PREFIX.size : PREFIX.size + head], data[PREFIX.size + head :])
        return None

    def forget(self) -> None:
        """Remove all answers: what was made of them is written."""
        shutil.rmtree(self._folder, ignore_errors=True)

    def _place(self, key: Sequence[str]) -> Path:
        return self._folder / hashlib.sha256(repr((tuple(key), self._under)).encode()).hexdigest()[:32]
