"""Atomic writing of files: complete, or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from tactfix.errors import FileError, Problem


def write_whole(path: str | Path, content: str | bytes) -> None:
    """Write content (text as UTF-8, LF) to path atomically: readers see the old file or the new one, nothing between.

    An existing file keeps its permissions, a symbolic link its target, and what is no regular file (/dev/null, a pipe)
    is written to directly. Raises FileError on failure; then the old file is unchanged.
    """
    with whole_file(path) as file:
        file.write(content.encode() if isinstance(content, str) else content)


@contextmanager
def whole_file(path: str | Path) -> Iterator[BinaryIO]:
    """The same for content too large for memory: a file that replaces path when the block ends without an error."""
    target = Path(os.path.realpath(path))
    try:
        if target.exists() and not target.is_file():
            with target.open("wb") as file:
                yield file
        else:
            with _replacing(target) as file:
                yield file
    except IsADirectoryError:
        raise FileError(str(path), [Problem("this is a directory", "name a file in it")]) from None
    except FileNotFoundError:
        raise FileError(str(path), [Problem("its directory does not exist", "make the directory first")]) from None
    except OSError as error:
        raise FileError(str(path), [Problem(f"cannot be written: {error.strerror}", "check path and disk")]) from None


@contextmanager
def _replacing(target: Path) -> Iterator[BinaryIO]:
    import tempfile  # imported late: not needed for standard output

    handle, temporary = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        Path(temporary).chmod(_mode(target))
        Path(temporary).replace(target)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def _mode(target: Path) -> int:
    """The permissions of the existing file, or those that open() would give a new one."""
    if target.exists():
        return target.stat().st_mode & 0o7777
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask
