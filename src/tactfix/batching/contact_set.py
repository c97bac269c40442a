"""One of many contact sets, as it is sent to whoever locates it."""

from hashlib import sha256

from tactfix.values import frozen_value


@frozen_value(eq=True)
class ContactSet:
    """The contacts of one set as the bytes of a file, so that the worker needs neither the file nor its disk.

    name: what results call it. unreadable: why there is no content, None where there is. lines: the line of the table
    that each line of content comes from, None where content is a file of its own, empty where there are no lines.
    """

    name: str
    content: bytes = b""
    unreadable: str | None = None
    lines: tuple[int, ...] | None = None

    def key(self, task_digest: str) -> str:
        """A checksum of all that its row depends on: the task's digest, the name and the contacts."""
        parts = (task_digest.encode(), self.name.encode(), self.content)
        return sha256(b"".join(len(part).to_bytes(8, "big") + part for part in parts)).hexdigest()
