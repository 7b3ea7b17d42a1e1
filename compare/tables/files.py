"""Files written whole or not at all."""

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path


def write_whole(path: Path, text: str) -> None:
    """Write a file whole or not at all, making its folder where needed.  Raises OSError."""
    write_together({path: text})


def write_together(texts: Mapping[Path, str]) -> None:
    """Write files whole, and all of them or none, making their folders where needed.  Raises OSError."""
    drafts: dict[Path, Path] = {}
    try:
        for path, text in texts.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            handle, draft = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
            drafts[path] = Path(draft)
            # A file's name may hold bytes that are no text; they are written out rather than refused.
            with os.fdopen(handle, "w", encoding="utf-8", errors="backslashreplace", newline="") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
            os.chmod(draft, 0o666 & ~umask())
        for path, draft in drafts.items():
            os.replace(draft, path)
    except BaseException:
        for draft in drafts.values():
            draft.unlink(missing_ok=True)
        raise


def umask() -> int:
    """Return the process's file mode mask, which a private draft file must be given back."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
