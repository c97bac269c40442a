"""The one pose of a text, wherever it stands: found by how it begins, then read whole."""

import re
from collections.abc import Callable
from typing import Final, TypeVar

from tactfix.lexer import Lexer, TextError
from tactfix.pose_formats.pose import PoseSyntaxError, syntax_error

Found = TypeVar("Found")

_BLANKED: Final = re.compile(r"[^\r\n]")


def without_comments(text: str, comment: re.Pattern[str]) -> str:
    """The text with blanks for its comments: each character that is left keeps its line and column."""
    return comment.sub(lambda found: _BLANKED.sub(" ", found.group()), text)


def the_one(text: str, begins: re.Pattern[str], read: Callable[[Lexer], Found], example: str) -> Found:
    """What read gives at the one place that begins finds; PoseSyntaxError for none, two, or a damaged one."""
    lexer = Lexer(text)
    found: list[Found] = []
    while (beginning := begins.search(text, lexer.position)) is not None:
        lexer.position = beginning.start()
        try:
            found.append(read(lexer))
        except TextError as error:
            raise PoseSyntaxError([error.problem]) from error
    if len(found) != 1:
        what = f"holds {len(found)} poses of this form" if found else "holds no pose of this form"
        raise syntax_error(what, f"write one, like {example}")
    return found[0]
