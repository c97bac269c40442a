"""Rules for every command line: numbers are decimal numbers, no output is one of the inputs, standard input is read
once, and --output - is standard output.

Python accepts more as a number: 1_0, nan, digits of other scripts. What is invalid everywhere, such as 3mm, gives the
same message.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from tactfix.cli.quick_values import QuickCommand
from tactfix.decimal_text import DECIMAL_COMMA, number_of
from tactfix.errors import UsageError

_NUMBER_TYPES: Final = ("float", "integer", "float range", "integer range")
"""Names of typer's types of numbers, in versions whose parameters have a type."""

_LONGEST_PATH: Final = 4096
"""Characters of a path (PATH_MAX of Linux)."""
_FURTHER_OUTPUTS: Final = ("junit", "next_contact", "history")
"""Parameters that name a file to write in addition to the result."""
_OUTPUTS: Final = ("output", *_FURTHER_OUTPUTS)
"""Parameters that name a file to write."""
_INPUTS: Final = (
    "contacts",
    "plan",
    "touches",
    "log",
    "pose",
    "on",
    "before",
    "after",
    "reference",
    "near",
    "work_offset",
)
"""Parameters that name a file to read, of which - is standard input."""


class CheckedCommand(QuickCommand):
    """A command whose line is checked by the rules for all commands."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the line; raises UsageError for a number that is none."""
        _check_numbers(self.get_params(ctx), args)
        return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Run the command; raises UsageError where it would write over a file that it reads, or read - twice.

        --output - is standard output, as if no output were given.
        """
        _check_standard_output(ctx.params)
        if str(ctx.params.get("output")) == "-":
            ctx.params["output"] = None
        _check_outputs(ctx.params)
        _check_standard_input(ctx.params)
        return super().invoke(ctx)


def _check_outputs(values: Mapping[str, Any]) -> None:
    for output in (values.get(name) for name in _OUTPUTS):
        # Before typer 0.29 the values of paths are texts here.
        if isinstance(output, Path | str) and any(_is_one_file(given, Path(output)) for given in _files(values)):
            raise UsageError(f"{output} is read by this command; write the result to another file")


def _check_standard_input(values: Mapping[str, Any]) -> None:
    given = [values.get(name) for name in _INPUTS]
    read = [one for value in given for one in (value if isinstance(value, list | tuple) else [value])]
    if read.count("-") > 1:
        raise UsageError("standard input, -, can be read only once; name files for the others")


def _check_standard_output(values: Mapping[str, Any]) -> None:
    further = next((name for name in _FURTHER_OUTPUTS if str(values.get(name)) == "-"), None)
    if further is not None:
        option = "--" + further.replace("_", "-")
        raise UsageError(f"{option} - would mix with the result on standard output; name a file")


def _is_one_file(given: Path, output: Path) -> bool:
    """Whether both are one regular file; errors of the file system are left to reading and writing."""
    try:
        return output.is_file() and given.is_file() and given.samefile(output)
    except (OSError, ValueError):
        return False


def _files(values: Mapping[str, Any]) -> Iterator[Path]:
    """The values of all other parameters that may be paths."""
    for name, value in values.items():
        for one in value if isinstance(value, list | tuple) else [value]:
            if name not in _OUTPUTS and isinstance(one, Path | str) and len(str(one)) < _LONGEST_PATH:
                yield Path(one)


def _check_numbers(parameters: Iterable[Any], words: Sequence[str]) -> None:
    options = {option for parameter in parameters if _is_number(parameter) for option in getattr(parameter, "opts", ())}
    for place, word in enumerate(words):
        if word == "--":
            return
        option, mark, value = word.partition("=")
        text = value if mark else words[place + 1] if place + 1 < len(words) else ""
        if option in options and DECIMAL_COMMA.fullmatch(text):
            raise UsageError(f"{option} {text!r} is not a number; write a decimal point, as in 0.005")
        if option in options and text and number_of(text.strip()) is None:
            shown = text if len(text) <= 40 else f"{text[:40]}..."
            remedy = "write decimal digits without a unit, such as 0.005; nothing is beyond 1e30"
            raise UsageError(f"{option} {shown!r} is not a number; {remedy}")


def _is_number(parameter: Any) -> bool:
    descriptor = getattr(parameter, "type_descriptor", None)
    if descriptor is not None:
        return descriptor.annotation in (int, float)
    return getattr(getattr(parameter, "type", None), "name", "") in _NUMBER_TYPES
