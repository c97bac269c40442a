"""The typer application of the commands: it reads a command line, helps, completes and complains."""

import os
import sys
from collections.abc import Sequence
from typing import Annotated, Final

import typer

from tactfix.cli.commands import COMMANDS, command_of
from tactfix.cli.completion import words_of_shell
from tactfix.cli.line_checks import CheckedCommand
from tactfix.cli.quick_values import QuickGroup
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
    """All commands by name and help, but only the one among words with its options, and it alone where it comes first.

    typer works out the parameters of every command that it is given: that takes longer than reading the files.
    """
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
    known = [chosen] if chosen is not None and [chosen] == list(words[:1]) else list(COMMANDS)
    for name in known:
        function = command_of(name) if name == chosen else _placeholder
        app.command(name, cls=CheckedCommand, short_help=COMMANDS[name])(function)
    return app


def _chosen(words: Sequence[str]) -> str | None:
    """The command among the words; for a shell that asks for completion, among those of its line."""
    if "_TACTFIX_COMPLETE" in os.environ:
        words = words_of_shell()
    return next((word for word in words if word in COMMANDS), None)


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
