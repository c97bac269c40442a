"""Blocks of G-code: letters with numbers, with or without blanks between; comments are ignored."""

import re
from collections.abc import Sequence
from typing import Final

from tactfix.lexer import Lexer
from tactfix.values import frozen_value

GCODE_COMMENT: Final = re.compile(r"\([^()]*\)|;.*")
_GCODE_REMEDY: Final = "write each word as a letter and a number, such as X-12.5"


@frozen_value(eq=True)
class Block:
    """The words of a block in order, letters in capitals."""

    words: tuple[tuple[str, float], ...]

    def codes(self, letter: str) -> tuple[float, ...]:
        """The numbers of all words of a letter, such as the G of G20 G91."""
        return tuple(number for found, number in self.words if found == letter)

    def only(self, letters: str, lexer: Lexer, remedy: str) -> dict[str, float]:
        """The words by letter; a repeated letter, or one not in letters, is an error."""
        found: dict[str, float] = {}
        for letter, number in self.words:
            if letter not in letters:
                lexer.refuse(f"the word {letter}{number:g} is not known here", remedy)
            if letter in found:
                lexer.refuse(f"{letter} is given twice", remedy)
            found[letter] = number
        return found


def read_block(lexer: Lexer, *, comments: bool = True) -> Block:
    """All words up to the end of the text, without its comments, if these are allowed."""
    words: list[tuple[str, float]] = []
    while True:
        if comments and lexer.blanks().match(GCODE_COMMENT):
            continue
        if not lexer.blanks().rest:
            return Block(tuple(words))
        letter = lexer.rest[0]
        if not (letter.isascii() and letter.isalpha()):
            lexer.refuse(f"{letter!r} does not begin a word", _GCODE_REMEDY)
        lexer.position += 1
        words.append((letter.upper(), lexer.number(_GCODE_REMEDY, glued=True)))


def missing(words: dict[str, float], letters: str) -> Sequence[str]:
    """Those of letters that are missing in words."""
    return [letter for letter in letters if letter not in words]
