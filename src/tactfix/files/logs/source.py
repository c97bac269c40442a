"""The text of a machine's log. Machines write what they like: a byte that is no UTF-8 stands there as U+FFFD.

Where such a byte stands in a line that tells a contact the reader of the format refuses the line; in a remark or on a
noisy serial line it does no harm.
"""

from tactfix.files.reading import Source, composed, source_bytes

_UTF_16 = (b"\xff\xfe", b"\xfe\xff")


def read_log_text(source: Source) -> tuple[str, str]:
    """The name of a source for messages, and its text."""
    name, content = source_bytes(source)
    if isinstance(content, str):
        return name, composed(content.removeprefix("\ufeff"))
    if content.startswith(_UTF_16):
        return name, composed(content.decode("utf-16", errors="replace"))
    return name, composed(content.decode("utf-8-sig", errors="replace"))
