"""The YAML subset of this project: plain values, with the position of each key and value.

PyYAML's own constructors follow YAML 1.1: 1e-3 is text, yes is true, 1:30 is ninety, a date is an object, and the last
of two equal keys wins without a warning. So only its parser is used. The scalars are
those of YAML 1.2: null, true, false, decimal numbers, and text for all else. Anchors, aliases, tags and several
documents are refused: no fixture file and no pose needs them.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final, TypeAlias

import yaml

from tactfix.decimal_text import MOST_CHARACTERS, NUMBER
from tactfix.errors import Problem
from tactfix.values import frozen_value

Path: TypeAlias = tuple[str | int, ...]
"""Keys and indices from the root to a value."""

# The parser of libyaml is ten times as fast and marks lines and columns just as well.
_LOADER: Final[Any] = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_MOST_DEPTH: Final = 20
"""Largest nesting depth; no valid file has half of it."""
_INTEGER: Final = re.compile(r"[-+]?[0-9]+")
_NO_FINITE_NUMBER: Final = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_PLAIN_WORDS: Final[dict[str, bool | None]] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}


@frozen_value(eq=True)
class Mark:
    """A position in the file; line and column count from 1."""

    line: int
    column: int


@dataclass(slots=True)
class Tree:
    """The content of a YAML file: its value, the position of each key and value, and its YAML problems.

    is_complete: whether it was read to its end, so that its value can be checked despite its problems.
    """

    value: Any = None
    keys: dict[Path, Mark] = field(default_factory=dict)
    values: dict[Path, Mark] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    is_complete: bool = True

    def refuse(self, event: Any, message: str, remedy: str) -> None:
        """Add a problem at the position of a parser event."""
        mark = _mark(event.start_mark)
        self.problems.append(Problem(message, remedy, line=mark.line, column=mark.column))


def read_tree(text: str) -> Tree:
    """The tree of the single document in text; a syntax error is its last problem."""
    tree = Tree()
    try:
        events = yaml.parse(text, Loader=_LOADER)
        _read_stream(events, tree)
    except yaml.YAMLError as error:
        tree.problems.append(_syntax_problem(error, text))
        tree.is_complete = False
    return tree


def _read_stream(events: Iterator[Any], tree: Tree) -> None:
    documents = 0
    for event in events:
        if isinstance(event, yaml.DocumentStartEvent):
            documents += 1
            if documents > 1:
                tree.refuse(event, "a second document starts here", "keep one in the file, remove the line '---'")
                return
        elif not isinstance(event, yaml.StreamStartEvent | yaml.StreamEndEvent | yaml.DocumentEndEvent):
            tree.value = _read_value(event, events, (), tree)


def _read_value(event: Any, events: Iterator[Any], path: Path, tree: Tree) -> Any:
    tree.values[path] = _mark(event.start_mark)
    if isinstance(event, yaml.AliasEvent):
        tree.refuse(event, f"*{event.anchor} is an alias", "write the value itself")
        return None
    _refuse_extras(event, tree)
    if len(path) > _MOST_DEPTH:
        # The parser has no limit of depth itself.
        raise yaml.MarkedYAMLError(None, None, f"more than {_MOST_DEPTH} levels, one in another", event.start_mark)
    if isinstance(event, yaml.MappingStartEvent):
        return _read_mapping(events, path, tree)
    if isinstance(event, yaml.SequenceStartEvent):
        return _read_sequence(events, path, tree)
    return scalar(event.value) if event.implicit[0] and not event.style else event.value


def _refuse_extras(event: Any, tree: Tree) -> None:
    """Refuse an anchor or a tag, before a value and before a key."""
    if event.anchor is not None:
        tree.refuse(event, f"&{event.anchor} is an anchor", "write the value without it")
    if event.tag is not None:
        tree.refuse(event, f"{event.tag.replace('tag:yaml.org,2002:', '!!')} is a tag", "write the value without it")


def _read_sequence(events: Iterator[Any], path: Path, tree: Tree) -> list[Any]:
    values: list[Any] = []
    while not isinstance(event := next(events), yaml.SequenceEndEvent):
        values.append(_read_value(event, events, (*path, len(values)), tree))
    return values


def _read_mapping(events: Iterator[Any], path: Path, tree: Tree) -> dict[str, Any]:
    mapping: dict[str, Any] = {}
    while not isinstance(event := next(events), yaml.MappingEndEvent):
        key = event.value if isinstance(event, yaml.ScalarEvent) else None
        if key is not None:
            _refuse_extras(event, tree)
        if key is None:
            tree.refuse(event, "a key must be plain text", "write 'name: value'")
            _read_value(event, events, (*path, ""), tree)
        elif key in mapping:
            first = tree.keys[(*path, key)]
            tree.refuse(event, f"{key!r} is given twice, first in line {first.line}", "remove one of the two")
        else:
            tree.keys[(*path, key)] = _mark(event.start_mark)
        child = (*path, f"{key} again" if key in mapping else key or "")
        value = _read_value(next(events), events, child, tree)
        if key is not None:
            mapping.setdefault(key, value)
    return mapping


def scalar(text: str) -> Any:
    """The value of an unquoted scalar, by YAML 1.2: 1e-3 is a number; yes, 1_000 and 0x10 are text."""
    if text in _PLAIN_WORDS:
        return _PLAIN_WORDS[text]
    if len(text) > MOST_CHARACTERS:
        return text
    if _INTEGER.fullmatch(text):
        return int(text)
    if NUMBER.fullmatch(text):
        return float(text)
    if _NO_FINITE_NUMBER.fullmatch(text):
        return float(text.replace(".", ""))
    return text


def _mark(mark: Any) -> Mark:
    return Mark(mark.line + 1, mark.column + 1)


def _syntax_problem(error: yaml.YAMLError, text: str) -> Problem:
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    cause = getattr(error, "problem", None) or getattr(error, "reason", None) or "not readable"
    if mark is not None:
        line, column = mark.line + 1, mark.column + 1
    else:
        before = text[: getattr(error, "position", 0) or 0]
        line, column = before.count("\n") + 1, len(before) - (before.rfind("\n") + 1) + 1
    remedy = "check indentation (blanks, no tabs), brackets, quotes and colons from here on upwards"
    return Problem(f"this is not YAML: {cause}", remedy, line=line, column=column)


class _OnOneLine(dict[str, Any]):
    """A mapping that is written on one line."""


class _Dumper(yaml.SafeDumper):
    """PyYAML's dumper, with such mappings on one line."""


_Dumper.add_representer(
    _OnOneLine, lambda dumper, value: dumper.represent_mapping("tag:yaml.org,2002:map", value, flow_style=True)
)


def yaml_text(value: dict[str, Any]) -> str:
    """A mapping as YAML: keys in their order, each entry of an inner mapping or list on a line, doubles in full."""
    lines = {key: _entries(item) for key, item in value.items()}
    return str(yaml.dump(lines, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=1000))


def _entries(item: Any) -> Any:
    if isinstance(item, dict):
        return {key: _OnOneLine(entry) if isinstance(entry, dict) else entry for key, entry in item.items()}
    return [_OnOneLine(entry) for entry in item] if isinstance(item, list) else item
