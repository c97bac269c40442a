"""Lines of consoles: what a sender or terminal writes around what the machine said, and the commands it repeats.

Before the machine's own words stand, in any order and number: time stamps, with brackets or without; prompts such as
>>> and <-; labels of letters; a repeated command in brackets; and what noise on a serial line leaves.
"""

import re
from typing import Final

from tactfix.gcode import Block, read_block
from tactfix.lexer import Lexer, TextError
from tactfix.values import frozen_value

_NOISE: Final = re.compile(r"[\x00-\x08\x0e-\x1f\x7f-\x9f\udc80-\udcff\ufffd]+")
_STAMP: Final = re.compile(r"[0-9]{1,4}[-:/.][0-9]{1,3}(?:[-:/.,TZ+ ]?[0-9]{1,9})*Z?(?=[\s\]>|,-]|$)")
_PROMPT: Final = re.compile(r"[<>|:-]+(?=\s|\[|\{|[A-Za-z$])")
_LABEL: Final = re.compile(r"[A-Za-z]+[0-9]?(?:[ \t]*[:>]|(?=[ \t]+[-<>\[{]))")
_BRACKETS: Final = re.compile(r"\[[ \t]*([^\[\]]*?)[ \t]*\]")
_WORD: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


@frozen_value(eq=True)
class Opening:
    """What stood before the machine's words: the command repeated in brackets, and whether there was noise."""

    command: Block | None = None
    noise: bool = False


def read_opening(lexer: Lexer) -> Opening:
    """Pass all that a console may write before the machine's words."""
    command: Block | None = None
    noise = False
    while True:
        lexer.blanks()
        if lexer.match(_NOISE):
            noise = True
        elif not (lexer.match(_STAMP) or lexer.match(_PROMPT) or lexer.match(_LABEL)):
            inside = _BRACKETS.match(lexer.text, lexer.position)
            repeated = None if inside is None else _bracketed(inside.group(1))
            if inside is None or repeated is None:
                return Opening(command, noise)
            command = repeated if repeated.words else command
            lexer.position = inside.end()


def read_closing(lexer: Lexer, remedy: str) -> None:
    """Nothing but an ok and noise may follow the machine's words."""
    lexer.take("ok")
    lexer.blanks().match(_NOISE)
    lexer.end(remedy)


def _bracketed(inside: str) -> Block | None:
    """A command in brackets; without words where it is a stamp or a label; None where it is neither."""
    if _STAMP.fullmatch(inside) or _WORD.fullmatch(inside):
        return Block(())
    return block_of(inside)


def block_of(text: str) -> Block | None:
    """The text as a block of G-code, None where it is none."""
    try:
        return read_block(Lexer(text))
    except TextError:
        return None
