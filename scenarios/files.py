"""Reading a file that a user names: plain files of sensible length only."""

import stat
from pathlib import Path

LARGEST_FILE = 100_000_000  # bytes


def plain_bytes(path: Path) -> bytes:
    """Return the content of a regular file.

    Parameters
    ----------
    path

    Returns
    -------
    content

    Raises
    ------
    OSError
        The file cannot be read, is not a regular file or is larger than 100 MB.
    """
    try:
        status = path.stat()
    except ValueError as error:  # a null character in the path
        raise OSError(0, str(error)) from None
    if not stat.S_ISREG(status.st_mode):
        raise OSError(0, "not a plain file")
    if status.st_size > LARGEST_FILE:
        raise OSError(0, f"larger than {LARGEST_FILE // 10**6} MB")
    return path.read_bytes()


def why_unread(error: OSError) -> str:
    """Return the reason why a file could not be read, for a message.

    Parameters
    ----------
    error

    Returns
    -------
    reason
    """
    return "no such file" if isinstance(error, FileNotFoundError) else f"cannot be read: {error.strerror}"
