"""Arguments and options as the commands declare them: what typer is told, without importing it.

A command that is typed without a mistake is understood by `tactfix.cli.plain_line`, which needs no more than this.
Help, complaints and completion are typer's, and only they wait for it.
"""

from collections.abc import Callable
from typing import Any, TypeAlias

Complete: TypeAlias = Callable[[str], list[str]]
"""What a shell may offer for a value that begins like this."""


class Parameter:
    """One parameter of a command; it stands in the Annotated[...] of its type."""

    __slots__ = ("autocompletion", "help", "metavar", "min", "names", "show_default")

    def __init__(
        self,
        *names: str,
        metavar: str | None = None,
        help: str | None = None,  # noqa: A002 - as typer has it
        min: float | None = None,  # noqa: A002 - as typer has it
        show_default: bool = True,
        autocompletion: Complete | None = None,
    ) -> None:
        self.names, self.metavar, self.help, self.min = names, metavar, help, min
        self.show_default, self.autocompletion = show_default, autocompletion

    @property
    def settings(self) -> dict[str, Any]:
        """All of it but the names, by the words of typer."""
        return {name: getattr(self, name) for name in Parameter.__slots__ if name != "names"}


class Argument(Parameter):
    """An argument: known by its place."""

    __slots__ = ()


class Option(Parameter):
    """An option: known by its names, or by that of the parameter where there are none."""

    __slots__ = ()

    def spellings(self, parameter: str) -> tuple[str, ...]:
        """How it is written on a command line; parameter: the name of the function's parameter."""
        return self.names or (f"--{parameter.replace('_', '-')}",)
