"""The application that typer makes of the commands: for help, completion, and complaints about a command line."""

import os
import sys
from collections.abc import Sequence
from types import FunctionType
from typing import Annotated, Any, Final

import typer

from tactfix.cli.commands import COMMANDS, Command, command_of
from tactfix.cli.completion import words_of_shell
from tactfix.cli.declarations import Argument, Option
from tactfix.cli.quick_values import QuickCommand, QuickGroup
from tactfix.version import VERSION

_HELP: Final = "Find where a fixture stands from a handful of touches on its spheres, cylinders and planes."


def run_application(words: Sequence[str]) -> int:
    """Let typer run the words of a command line and return the exit status; raises what it and the command raise."""
    command = typer.main.get_command(_application(words))
    try:
        return int(command.main(args=list(words), prog_name="tactfix", standalone_mode=False) or 0)
    except typer.Abort:  # what typer makes of an interrupt
        raise KeyboardInterrupt from None


def _application(words: Sequence[str]) -> typer.Typer:
    """All commands by name and help, but only the one among words with its options."""
    # Markup and pretty tracebacks would import rich; help in plain text is there in half the time.
    app = typer.Typer(
        name="tactfix",
        cls=QuickGroup,
        no_args_is_help=True,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        help=_HELP,
    )
    app.callback(context_settings={"help_option_names": ["-h", "--help"]})(_options)
    chosen = _chosen(words)
    for name, summary in COMMANDS.items():
        function = as_typer_wants(command_of(name)) if name == chosen else _placeholder
        app.command(name, cls=QuickCommand, short_help=summary)(function)
    return app


def _chosen(words: Sequence[str]) -> str | None:
    """The command among the words; for a shell that asks for completion, among those of its line."""
    if "_TACTFIX_COMPLETE" in os.environ:
        words = words_of_shell()
    return next((word for word in words if word in COMMANDS), None)


def as_typer_wants(command: Command) -> Command:
    """The same function, its parameters declared by typer's own words."""
    if not isinstance(command, FunctionType):
        return command
    twin = FunctionType(
        command.__code__, command.__globals__, command.__name__, command.__defaults__, command.__closure__
    )
    twin.__doc__, twin.__kwdefaults__ = command.__doc__, command.__kwdefaults__
    twin.__annotations__ = {name: _translated(hint) for name, hint in command.__annotations__.items()}
    return twin


def _translated(hint: Any) -> Any:
    """A type annotated with a declaration, annotated with typer's."""
    declared = next(iter(getattr(hint, "__metadata__", ())), None)
    if isinstance(declared, Option):
        return Annotated[hint.__origin__, typer.Option(*declared.names, **declared.settings)]
    if isinstance(declared, Argument):
        return Annotated[hint.__origin__, typer.Argument(**declared.settings)]
    return hint


def _placeholder() -> None:
    """Stands for a command that is listed and not run."""


def _version(wanted: bool) -> None:
    if wanted:
        sys.stdout.write(f"tactfix {VERSION}\n")
        raise typer.Exit


def _options(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and exit.", is_eager=True, callback=_version)
    ] = False,
) -> None:
    """What holds for tactfix as a whole."""
