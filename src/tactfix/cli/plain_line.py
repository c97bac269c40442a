"""Command lines that are typed without a mistake, understood without typer.

Importing typer and letting it build a command takes as long as reading a fixture and its contacts. What it would tell
of a plain line is told by the line itself: each word is an option that the command has, its value, or an argument.
Wherever there is any doubt (help, an unknown option, a number that is none, a value that begins with a dash) the line
is left to typer as it came, and so is every complaint.
"""

import inspect
import re
from collections.abc import Sequence
from enum import Enum
from pathlib import Path
from types import UnionType
from typing import Any, Final, Literal, get_args, get_origin

from tactfix.cli.commands import Command
from tactfix.cli.declarations import Argument, Option, Parameter

_NOT_PLAIN: Final = object()
_GIVEN: Final = "given"
"""Stands for the value of a flag."""
_NUMBERS: Final[dict[type, str]] = {
    int: r"[-+]?[0-9]{1,15}",
    float: r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?",
}


class _Place:
    """A parameter of a command: its declaration, the type of its value, and whether it may be left out."""

    __slots__ = ("declared", "has_default", "is_many", "kind")

    def __init__(self, parameter: inspect.Parameter) -> None:
        hint = parameter.annotation
        self.declared: Parameter | None = next(iter(getattr(hint, "__metadata__", ())), None)
        kind = getattr(hint, "__origin__", hint)
        if isinstance(kind, UnionType):
            kind = next(choice for choice in get_args(kind) if choice is not type(None))
        self.is_many = get_origin(kind) is list
        self.kind = get_args(kind)[0] if self.is_many else kind
        self.has_default = parameter.default is not inspect.Parameter.empty

    def value(self, text: str) -> Any:
        """What text says here; _NOT_PLAIN where that is not beyond doubt."""
        value = _value(text, self.kind)
        least = self.declared.min if self.declared else None
        return _NOT_PLAIN if value is _NOT_PLAIN or (least is not None and value < least) else value


def plain_values(command: Command, words: Sequence[str]) -> dict[str, Any] | None:
    """The values of the parameters that a line gives, None where it is not plain.

    command: a function whose parameters are Annotated with Argument and Option; words: what follows its name.
    """
    places = {name: _Place(parameter) for name, parameter in inspect.signature(command).parameters.items()}
    if not all(isinstance(place.declared, Argument | Option) for place in places.values()):
        return None
    sorted_words = _sorted_words(words, places)
    if sorted_words is None:
        return None
    texts, rest = sorted_words
    arguments = _arguments(rest, {name: p for name, p in places.items() if isinstance(p.declared, Argument)})
    if arguments is None:
        return None
    values = {name: [places[name].value(text) for text in given] for name, given in (texts | arguments).items()}
    if any(_NOT_PLAIN in given for given in values.values()):
        return None
    return {name: given if places[name].is_many else given[0] for name, given in values.items()}


def _sorted_words(words: Sequence[str], places: dict[str, _Place]) -> tuple[dict[str, list[str]], list[str]] | None:
    """The texts of each option that is given, one unless it may be repeated; and the words that are arguments."""
    spelled = {
        spelling: name
        for name, place in places.items()
        if isinstance(place.declared, Option)
        for spelling in place.declared.spellings(name)
    }
    texts: dict[str, list[str]] = {}
    rest: list[str] = []
    coming = iter(words)
    for word in coming:
        if word == "-" or not word.startswith("-"):
            rest.append(word)
            continue
        spelling, equals, text = word.partition("=") if word.startswith("--") else (word, "", "")
        name = spelled.get(spelling)
        if name is None or (name in texts and not places[name].is_many):
            return None
        if places[name].kind is bool:
            text = "" if equals else _GIVEN
        elif not equals:
            text = next(coming, "")
        if not text or text.startswith("-"):
            return None
        texts.setdefault(name, []).append(text)
    return texts, rest


def _arguments(words: list[str], places: dict[str, _Place]) -> dict[str, list[str]] | None:
    """The words of each argument, in order; None where there are too few or too many."""
    given: dict[str, list[str]] = {}
    left = list(words)
    for name, place in places.items():
        taken, left = (left, []) if place.is_many else (left[:1], left[1:])
        if taken:
            given[name] = taken
        elif not place.has_default:
            return None
    return None if left else given


def _value(text: str, kind: Any) -> Any:
    """The text as a kind of value, _NOT_PLAIN where there is any doubt."""
    if kind is bool:
        return True
    if kind in _NUMBERS:
        return kind(text) if re.fullmatch(_NUMBERS[kind], text) else _NOT_PLAIN
    if kind in (str, Path) and text:
        return kind(text)
    if get_origin(kind) is Literal:
        return text if text in get_args(kind) else _NOT_PLAIN
    if isinstance(kind, type) and issubclass(kind, Enum):
        return next((member for member in kind if member.value == text), _NOT_PLAIN)
    return _NOT_PLAIN
