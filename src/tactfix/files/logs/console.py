"""Console lines: what a sender or terminal adds around a report of the machine, and the commands that it echoes.

Before a report there may be, in any order and number: time stamps, with brackets or without; prompts such as
>>> and <-; labels; an echoed command, in brackets or followed by < or a tab; colour codes; and noise of a serial line.
Servers and scripts quote the whole line, or send it as a string in JSON.
"""

import json
import re
from typing import Final

from tactfix.gcode import Block, read_block
from tactfix.lexer import Lexer, TextError
from tactfix.values import frozen_value

_NOISE: Final = re.compile(r"[\x00-\x08\x0e-\x1f\x7f-\x9f\udc80-\udcff\ufffd]+")
_COLOUR: Final = re.compile(r"\x1b\[[0-9;]*m")
# A date and time, or the seconds since 1970.
_STAMP: Final = re.compile(
    r"(?:[0-9]{1,4}[-:/.][0-9]{1,3}(?:[-:/.,TZ+ ]?[0-9]{1,9})*Z?|[0-9]{10}(?:\.[0-9]{1,9})?)(?=[\s\]>|,:-]|$)"
)
_PROMPT: Final = re.compile(r"[<>|:-]+(?=\s|\[|\{|[A-Za-z$])")
_LABEL: Final = re.compile(r"[A-Za-z]+[0-9]?(?:[ \t]*[:>]|(?=[ \t]+[-<>\[{]))")
_BRACKETS: Final = re.compile(r"\[[ \t]*([^\[\]]*?)[ \t]*\]")
_WORD: Final = re.compile(r"\$?[A-Za-z][A-Za-z0-9_]*|\$[$#]")
_REPEATED: Final = re.compile(
    r"([A-Za-z][^<>\[\]{}\t]*?)[ \t]*(?:<|\t)[ \t]*(?=\[|\{|ok\b|error:|ALARM:)", re.IGNORECASE
)
_QUOTED: Final = re.compile(r"\s*b?(['\"])((?:(?!\1).)*?)(?:\\[rn])*\1\s*")
_CARRIERS: Final = ("D", "Data", "data", "line", "message", "msg", "text")
"""JSON keys under which servers and senders send a console line; D is that of the Serial Port JSON Server."""


@frozen_value(eq=True)
class Opening:
    """The text before a report: the command echoed in brackets, and whether there was noise."""

    command: Block | None = None
    noise: bool = False


def read_opening(lexer: Lexer) -> Opening:
    """Skip everything that a console may write before a report."""
    command: Block | None = None
    noise = False
    while True:
        lexer.blanks()
        if lexer.match(_COLOUR):
            continue
        if lexer.match(_NOISE):
            noise = True
        elif not (lexer.match(_STAMP) or lexer.match(_PROMPT) or lexer.match(_LABEL)):
            inside = _REPEATED.match(lexer.text, lexer.position)
            repeated = None if inside is None else block_of(inside.group(1))
            if repeated is None:
                inside = _BRACKETS.match(lexer.text, lexer.position)
                repeated = None if inside is None else _bracketed(inside.group(1))
            if inside is None or repeated is None:
                return Opening(command, noise)
            command = repeated if repeated.words else command
            lexer.position = inside.end()


def read_closing(lexer: Lexer, remedy: str) -> None:
    """Skip an ok, the end of a colour and noise after a report; anything else is an error."""
    lexer.blanks().match(_COLOUR)
    lexer.take(";")
    lexer.take("ok")
    lexer.blanks().match(_COLOUR)
    lexer.blanks().match(_NOISE)
    lexer.end(remedy)


def unwrapped(lexer: Lexer) -> Lexer:
    """The line inside quotes or JSON, without them; any other line unchanged.

    If the JSON string holds an escape, columns within it are unknown: the column is then that of the string.
    """
    quoted = _QUOTED.fullmatch(lexer.text)
    if quoted is not None:
        return Lexer(quoted.group(2), lexer.line, quoted.start(2) + 1)
    if not lexer.text.lstrip().startswith("{"):
        return lexer
    try:
        tree = json.loads(lexer.text)
    except (ValueError, RecursionError):
        return lexer
    if not isinstance(tree, dict) or any(isinstance(value, dict) for value in tree.values()):
        return lexer  # a report of the machine itself, which may hold such a key too
    carried = [tree[name] for name in _CARRIERS if isinstance(tree.get(name), str)]
    return Lexer(carried[0].strip(), lexer.line, lexer.text.find("{") + 1) if len(carried) == 1 else lexer


def _bracketed(inside: str) -> Block | None:
    """A command in brackets; an empty Block for a time stamp or label; None for anything else."""
    block = block_of(inside)
    return Block(()) if block is None and (_STAMP.fullmatch(inside) or _WORD.fullmatch(inside)) else block


def block_of(text: str) -> Block | None:
    """The text as a block of G-code, None if it is not one."""
    try:
        return read_block(Lexer(text))
    except TextError:
        return None
