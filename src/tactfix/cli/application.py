"""The typer application of the commands, by name, each with its module; only the one that runs is imported."""

import importlib
import os
import sys
from collections.abc import Callable, Sequence
from typing import Annotated, Final, TypeAlias, cast

import typer

from tactfix.cli.completion import words_of_shell
from tactfix.cli.line_checks import CheckedCommand
from tactfix.cli.quick_values import QuickGroup
from tactfix.version import VERSION

Command: TypeAlias = Callable[..., int]
"""What a command does; its parameters are Annotated with typer.Option and typer.Argument."""

COMMANDS: Final[dict[str, str]] = {
    "locate": "Find the pose of a fixture from contacts.",
    "batch": "Locate many contact sets, on all cores or a Dask cluster, into one table.",
    "fit": "Find one plane, sphere or cylinder from contacts.",
    "qualify": "Determine the uncertainty of a probe from repeated touches or a reference ball.",
    "design-check": "Check whether a fixture can be located, how accurately, and which mistakes stay hidden.",
    "schema": "Print the JSON Schema of fixture files, for editors.",
    "init": "Write a commented fixture file to start from.",
    "simulate": "Make a contact file as a probe would report it, with the true pose in it.",
    "plan": "Choose the contacts to make: reachable, unique and as accurate as possible.",
    "calibrate": "Calibrate a robot from touches on fixtures at unknown places.",
    "convert": "Write a pose in the format of a controller, a machine tool or ROS.",
    "compare": "Compute how far a fixture has moved between two poses.",
    "check": "Check whether a fixture has moved since it was located.",
    "guide": "Report after each touch what is still undetermined, and where to touch next.",
    "import": "Write the log of a machine as a contact file.",
    "report": "Locate a fixture, or check its design, and write the record as one HTML page.",
}
"""Each command and its help in one line; design-check is the function `command` of `tactfix.cli.design_check`.

Only the module of the command that runs is imported. At its top it imports what its parameters name; everything
else that is slow is imported in the function that uses it, so that help and completion do not wait for numpy."""


def module_of(command: str) -> str:
    """The module of a command; one named like a Python keyword ends with an underscore."""
    name = command.replace("-", "_")
    return f"tactfix.cli.{name}_" if command == "import" else f"tactfix.cli.{name}"


def command_of(name: str) -> Command:
    """The function of a command."""
    return cast(Command, importlib.import_module(module_of(name)).command)


_HELP: Final = "Find the pose of a fixture from a few touches on its spheres, cylinders and planes."


def run_application(words: Sequence[str]) -> int:
    """Let typer run the words of a command line and return the exit status; raises what it and the command raise."""
    command = typer.main.get_command(_application(words))
    try:
        return int(command.main(args=list(words), prog_name="tactfix", standalone_mode=False) or 0)
    except typer.Abort:  # what typer makes of an interrupt
        raise KeyboardInterrupt from None


def _application(words: Sequence[str]) -> typer.Typer:
    """All commands by name and help, but only the one among words with its options, and it alone if it comes first.

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
    """Replaces a command that is listed and not run."""


def _version(wanted: bool) -> None:
    if wanted:
        sys.stdout.write(f"tactfix {VERSION}\n")
        raise typer.Exit


def _options(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and exit.", is_eager=True, callback=_version)
    ] = False,
) -> None:
    """The options of tactfix itself."""
