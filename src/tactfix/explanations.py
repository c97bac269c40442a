"""Explanations of codes, as `locate --explain CODE` and `design-check --explain CODE` print them.

Each package has its own in explanations.txt: a line [code], followed by a text of about ten lines.
"""

from functools import cache
from importlib import resources
from typing import Final, Literal, TypeAlias

from tactfix.errors import UsageError
from tactfix.wording import did_you_mean

Room: TypeAlias = Literal["localization", "design"]
"""The command of the codes: those of results of locate, or of findings of design-check."""
_CODES_OF: Final = {"localization": "status, reason or diagnosis", "design": "finding"}


@cache
def explanations(room: Room) -> dict[str, str]:
    """All explanations by code."""
    text = resources.files(f"tactfix.{room}").joinpath("explanations.txt").read_text(encoding="utf-8")
    parts = (part.partition("]\n") for part in text.split("\n[")[1:])
    return {code: body.strip() for code, _, body in parts}


def explanation(room: Room, code: str) -> str:
    """A code and its explanation. Raises UsageError for an unknown one."""
    texts = explanations(room)
    if code not in texts:
        raise UsageError(f"no {_CODES_OF[room]} is called {code!r}; {did_you_mean(code, texts)}")
    return f"{code}\n\n{texts[code]}\n"
