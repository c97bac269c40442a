"""Values of arguments and options without pydantic.

typer, from version 0.29 on, makes a pydantic validator for each parameter, even for one that is not given. Importing
pydantic takes longer than importing numpy: without this module `locate` takes more than twice as long
(tests/benchmarks/bench_prompt.py measures both). So plain texts, paths, numbers and choices are converted here;
everything else, errors included, is left to typer. In a version of typer that works differently nothing is replaced,
and only the time is lost.
"""

import re
from enum import Enum
from pathlib import Path
from typing import Any, Final, Literal, get_args, get_origin

from typer.core import TyperCommand, TyperGroup

from tactfix.decimal_text import NUMBER

_NOT_PLAIN: Final = object()
_NUMBER_TEXTS: Final[dict[type, str]] = {
    int: r"[-+]?[0-9]{1,15}",
    float: NUMBER.pattern,
}
"""Texts that can only be numbers of a kind."""


class QuickCommand(TyperCommand):
    """A command whose parameters take plain values as they are."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Its parameters and --help."""
        return _sparing_pydantic(super().get_params(ctx))


class QuickGroup(TyperGroup):
    """A group of commands whose own parameters take plain values as they are."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Its parameters and --help."""
        return _sparing_pydantic(super().get_params(ctx))


def _sparing_pydantic(parameters: list[Any]) -> list[Any]:
    """The same parameters, their converters replaced where typer has them."""
    for parameter in parameters:
        thorough = getattr(parameter, "get_runtime_param", None)
        if thorough is not None and not isinstance(thorough, _Coercion) and hasattr(parameter, "type_descriptor"):
            parameter.get_runtime_param = _Coercion(thorough, parameter.type_descriptor)
    return parameters


class _Coercion:
    """Replaces get_runtime_param of a parameter: calling it returns itself, whose coerce converts the value."""

    def __init__(self, thorough: Any, descriptor: Any) -> None:
        self._thorough = thorough
        self._annotation = descriptor.annotation
        self._limits = descriptor.parameter_info.min, descriptor.parameter_info.max

    def __call__(self) -> "_Coercion":
        return self

    def coerce(self, value: Any, param: Any, ctx: Any) -> Any:
        """The plain value, or the conversion by typer."""
        if param.nargs == 1 and not param.multiple:
            plain = plain_value(value, self._annotation, *self._limits)
            if plain is not _NOT_PLAIN:
                return plain
        return self._thorough().coerce(value, param=param, ctx=ctx)


def plain_value(value: Any, annotation: Any, low: float | None, high: float | None) -> Any:
    """value converted to annotation, between low and high; _NOT_PLAIN if that needs typer."""
    if value is None or (type(value) is annotation and annotation not in (int, float)):
        return value
    if annotation is Path and isinstance(value, str):
        path = Path(value)
        # ./- is a file, and - standard input or output; as paths they would be equal.
        return path.absolute() if str(path) == "-" != value else path
    if annotation in (int, float):
        return _plain_number(value, annotation, low, high)
    if get_origin(annotation) is Literal and value in get_args(annotation):
        return value
    if isinstance(annotation, type) and issubclass(annotation, Enum):
        return next((member for member in annotation if value in (member, member.value)), _NOT_PLAIN)
    return _NOT_PLAIN


def _plain_number(value: Any, kind: type, low: float | None, high: float | None) -> Any:
    if isinstance(value, str) and not re.fullmatch(_NUMBER_TEXTS[kind], value):
        return _NOT_PLAIN
    number = kind(value)
    is_within = (low is None or number >= low) and (high is None or number <= high)
    return number if is_within else _NOT_PLAIN
