"""Files written whole or not at all, and through what is no plain file; folders of tables that are all of one run.

A folder's new files are made in a folder of drafts inside it, which is then renamed to READY: from that moment the
folder has them, wherever they still lie.  Whoever reads asks `place` where; who writes next puts them where they
belong, and removes the drafts of runs that are dead.
"""

import errno
import os
import shutil
import stat
import tempfile
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from glob import escape
from pathlib import Path

from tumble.compare.tables.data_package import with_package

# What is written: at once, or piece by piece.
Text = str | bytes | Iterable[str]

READY, DRAFTS = ".tables-ready", ".tables-draft-"


def write_whole(path: Path, text: Text) -> None:
    """Write a file whole or not at all.

    Parameters
    ----------
    path : the file; its folder is made if needed
    text : text, bytes, or pieces of text

    Raises
    ------
    OSError : it cannot be written
    """
    write_together({path: text})


def write_together(texts: Mapping[Path, Text]) -> None:
    """Write files whole, and all of them or none.

    A file that is there keeps its mode and its owner, and a link goes on pointing to it.  What is no plain file is
    written to as it is, before any file is changed.

    Parameters
    ----------
    texts : text, bytes, or pieces of text of each file; folders are made if needed

    Raises
    ------
    OSError : one cannot be written
    """
    drafts: dict[Path, Path] = {}
    streams: dict[Path, Text] = {}
    try:
        for path, text in texts.items():
            before = existing(path)
            if before is None or (stat.S_ISREG(before.st_mode) and standard_stream(before) is None):
                target = Path(os.path.realpath(path))
                target.parent.mkdir(parents=True, exist_ok=True)
                for left in left_behind(target.parent, f".{target.name}."):
                    left.unlink(missing_ok=True)
                handle, draft = tempfile.mkstemp(prefix=f".{target.name}.{os.getpid()}-", dir=target.parent)
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


def write_folder(folder: Path, texts: Mapping[str, str | bytes], without: Collection[str] = ()) -> None:
    """Write files into a folder so that it has all of them or none, whenever it is stopped.

    Beside tables it writes the datapackage.json that describes all tables of the folder.

    Parameters
    ----------
    folder : made if needed
    texts : text or bytes of each file by its name
    without : names of files of an earlier run, which are removed

    Raises
    ------
    OSError : one cannot be written
    """
    folder.mkdir(parents=True, exist_ok=True)
    settle(folder)
    texts = with_package(folder, texts, without)
    for name in texts:
        if (found := existing(folder / name)) and stat.S_ISDIR(found.st_mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(folder / name))
    drafts = Path(tempfile.mkdtemp(prefix=f"{DRAFTS}{os.getpid()}-", dir=folder))
    try:
        for name, text in texts.items():
            fill(drafts / name, text)
        for name in without:
            (folder / name).unlink(missing_ok=True)
        drafts.rename(folder / READY)
    except BaseException:
        shutil.rmtree(drafts, ignore_errors=True)
        raise
    settle(folder)


def settle(folder: Path) -> None:
    """Put what a run left READY where it belongs, and remove the drafts of dead ones.  Raises OSError."""
    for drafts in left_behind(folder, DRAFTS):
        shutil.rmtree(drafts, ignore_errors=True)
    ready = folder / READY
    if ready.is_dir():
        for draft in sorted(ready.iterdir()):
            put(draft, folder / draft.name)
        ready.rmdir()


def place(folder: Path, name: str) -> Path:
    """Return where a file of a folder lies, which may have been stopped while it was written."""
    ready = folder / READY / name
    return ready if ready.exists() else folder / name


def left_behind(folder: Path, prefix: str) -> Iterator[Path]:
    """Yield what was begun in a folder under names PREFIX + PID-... by processes that are no more."""
    for path in folder.glob(f"{escape(prefix)}[0-9]*-*"):
        pid = path.name.removeprefix(prefix).partition("-")[0]
        if pid.isdecimal() and not lives(int(pid)):
            yield path


def lives(pid: int) -> bool:
    """Whether there is a process of that number."""
    import psutil  # 20 ms, and there is seldom anything left to ask about

    try:
        return psutil.pid_exists(pid)
    except OverflowError:
        return False


def fill(path: Path, text: str | bytes) -> None:
    """Write a draft of a file that is not there yet."""
    write(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL), text)
    os.chmod(path, 0o666 & ~umask())


def put(draft: Path, path: Path) -> None:
    """Give a draft its name, or where that is a link, a pipe or a device, write it there."""
    if path.is_symlink() or (path.exists() and not path.is_file()):
        write_whole(path, draft.read_bytes())
        draft.unlink()
        return
    if path.exists():
        take_after(path.stat(), str(draft))
    os.replace(draft, path)


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


def write(descriptor: int, text: Text) -> None:
    """Write a text, or bytes as they are, and close the descriptor, on the disk if that is where it leads."""
    # A file's name may hold bytes that are no text; they are written out rather than refused.
    with os.fdopen(descriptor, "wb") as file:
        for piece in [text] if isinstance(text, str | bytes) else text:
            file.write(piece if isinstance(piece, bytes) else piece.encode("utf-8", "backslashreplace"))
        file.flush()
        if stat.S_ISREG(os.fstat(descriptor).st_mode):
            os.fsync(descriptor)


def take_after(before: os.stat_result, draft: str) -> None:
    """Give a draft the owner, as far as we may, and the mode of the file that it replaces."""
    for owner, group in ((before.st_uid, -1), (-1, before.st_gid)):
        with suppress(PermissionError, AttributeError):  # Windows has no chown
            os.chown(draft, owner, group)
    os.chmod(draft, stat.S_IMODE(before.st_mode))


def umask() -> int:
    """Return the process's file mode mask, which a private draft file must be given back."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
