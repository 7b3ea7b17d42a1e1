"""Files written whole or not at all, and through what is no plain file: a device, a pipe, a link."""

import errno
import os
import stat
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path


def write_whole(path: Path, text: str) -> None:
    """Write a file whole or not at all, making its folder where needed.  Raises OSError."""
    write_together({path: text})


def write_together(texts: Mapping[Path, str]) -> None:
    """Write files whole, and all of them or none, making their folders where needed.  Raises OSError.

    A file that is there keeps its mode and its owner, and a link goes on pointing to it.  What is no plain file is
    written to as it is, before any file is changed.
    """
    drafts: dict[Path, Path] = {}
    streams: dict[Path, str] = {}
    try:
        for path, text in texts.items():
            before = existing(path)
            if before is None or (stat.S_ISREG(before.st_mode) and standard_stream(before) is None):
                target = Path(os.path.realpath(path))
                target.parent.mkdir(parents=True, exist_ok=True)
                handle, draft = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
                drafts[target] = Path(draft)
                write(handle, text)
                if before is None:
                    os.chmod(draft, 0o666 & ~umask())
                else:
                    take_after(before, draft)
            else:
                streams[path] = text
        for path, text in streams.items():
            stream = standard_stream(path.stat())
            write(os.open(path, os.O_WRONLY) if stream is None else os.dup(stream), text)
        for target, draft in drafts.items():
            os.replace(draft, target)
    except BaseException:
        for draft in drafts.values():
            draft.unlink(missing_ok=True)
        raise


def existing(path: Path) -> os.stat_result | None:
    """Return what is there, at the end of all links, or None.  Raises OSError where it may not be written to."""
    try:
        found = path.stat()
    except FileNotFoundError:
        return None
    if not os.access(path, os.W_OK, effective_ids=os.access in os.supports_effective_ids):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
    return found


def standard_stream(found: os.stat_result) -> int | None:
    """Return the descriptor of our own output or error stream if that is what was found: /dev/stdout, for one."""
    for descriptor in (1, 2):
        with suppress(OSError):
            if os.path.samestat(found, os.fstat(descriptor)):
                return descriptor
    return None


def write(descriptor: int, text: str) -> None:
    """Write a text and close the descriptor, on the disk if that is where it leads."""
    # A file's name may hold bytes that are no text; they are written out rather than refused.
    with os.fdopen(descriptor, "w", encoding="utf-8", errors="backslashreplace", newline="") as file:
        file.write(text)
        file.flush()
        if stat.S_ISREG(os.fstat(descriptor).st_mode):
            os.fsync(descriptor)


def take_after(before: os.stat_result, draft: str) -> None:
    """Give a draft the owner, as far as we may, and the mode of the file that it replaces."""
    for owner, group in ((before.st_uid, -1), (-1, before.st_gid)):
        with suppress(PermissionError):
            os.chown(draft, owner, group)
    os.chmod(draft, stat.S_IMODE(before.st_mode))


def umask() -> int:
    """Return the process's file mode mask, which a private draft file must be given back."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
