"""Reads files as bytes or text; each kind of failure has its own message.

Machine logs are not always UTF-8: invalid bytes become U+FFFD. The reader of the format rejects such a line if it
holds a contact; in a comment, or as noise of a serial line, the character is harmless.
"""

import sys
from pathlib import Path
from typing import BinaryIO, Final, TextIO, TypeAlias

from tactfix.errors import FileError, Problem

FIXTURE_FIRST: Final = "give the fixture file first, then the contact file: tactfix locate FIXTURE CONTACTS"
"""Advice if a fixture file is given as a contact file, or the reverse."""
NO_FIXTURE: Final = "give the contact file here; contacts on a fixture are located with tactfix locate FIXTURE CONTACTS"
"""Advice if a fixture file is given as a contact file to a command that takes no fixture."""
Source: TypeAlias = str | Path | bytes | TextIO | BinaryIO
"""A path, "-" for standard input, the bytes themselves, or an open file."""

_UTF_16 = (b"\xff\xfe", b"\xfe\xff")
"""Byte order marks."""


def read_bytes(path: str | Path) -> bytes:
    """The bytes of the file; FileError if it does not exist, is a directory, or cannot be read."""
    try:
        return Path(path).read_bytes()
    except FileNotFoundError:
        remedy = "name a file: this one is not read from standard input" if str(path) == "-" else near_name(Path(path))
        raise FileError(str(path), [Problem("there is no such file", remedy)]) from None
    except IsADirectoryError:
        raise FileError(str(path), [Problem("this is a directory", "name a file in it")]) from None
    except PermissionError:
        raise FileError(
            str(path), [Problem("no permission to read it", "check the owner and mode of the file")]
        ) from None
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        raise FileError(str(path), [Problem(f"cannot be read: {error}", "check the path and the disk")]) from None


def near_name(path: Path) -> str:
    """The advice for a missing file: one with another ending or a similar name, if there is one."""
    from difflib import get_close_matches

    try:
        names = sorted(entry.name for entry in path.parent.iterdir() if entry.is_file())
    except OSError:
        return "check the path"
    endings = [name for name in names if Path(name).stem.lower() == path.stem.lower()]
    near = endings if len(endings) == 1 else get_close_matches(path.name, names, n=1, cutoff=0.8)
    return f"did you mean {str(path.with_name(near[0]))!r}?" if near else "check the path"


def source_bytes(source: Source) -> tuple[str, bytes | str]:
    """The name of a source for messages, and its content: text for a file opened in text mode, otherwise bytes."""
    if isinstance(source, bytes):
        return "contacts", source
    if isinstance(source, str | Path):
        if str(source) == "-":
            return "standard input", sys.stdin.buffer.read()
        return str(source), read_bytes(source)
    return str(getattr(source, "name", "contacts")), source.read()


def read_source(source: Source) -> tuple[str, str]:
    """The name of a source for messages, and its text."""
    name, content = source_bytes(source)
    return name, decode(name, content) if isinstance(content, bytes) else composed(content.removeprefix("\ufeff"))


def composed(text: str) -> str:
    """The text with each accented letter as one character (NFC), so that names that look the same are equal."""
    if text.isascii():
        return text
    import unicodedata

    return unicodedata.normalize("NFC", text)


def lines_of(text: str) -> list[str]:
    """The lines of a text, with any kind of line ending."""
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def decode(name: str, content: bytes) -> str:
    """UTF-8 with or without byte order mark as text, composed; FileError names the first byte that is not UTF-8."""
    if content.startswith(_UTF_16):
        raise FileError(name, [Problem("this is UTF-16", "save it as UTF-8")])
    try:
        return composed(content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        before = error.object[: error.start]
        line, column = before.count(b"\n") + 1, error.start - before.rfind(b"\n")
        message = f"byte 0x{error.object[error.start]:02x} is not UTF-8"
        raise FileError(name, [Problem(message, "save the file as UTF-8", line=line, column=column)]) from None


def read_log_text(source: Source) -> tuple[str, str]:
    """The name of a source for messages, and its text."""
    name, content = source_bytes(source)
    if isinstance(content, str):
        return name, composed(content.removeprefix("\ufeff"))
    if content.startswith(_UTF_16):
        return name, composed(content.decode("utf-16", errors="replace"))
    return name, composed(content.decode("utf-8-sig", errors="replace"))
