"""The commands by name, the application made of them, and what becomes of errors."""

import importlib
import os
import sys
from collections.abc import Callable, Sequence
from typing import Annotated, Any, Final

import typer

from tactfix.cli.completion import words_of_shell
from tactfix.cli.exits import Exit, exit_of_error
from tactfix.cli.quick_values import QuickCommand, QuickGroup
from tactfix.errors import TactfixError
from tactfix.version import VERSION

COMMANDS: Final[dict[str, str]] = {
    "locate": "Find where a fixture stands from contacts.",
    "batch": "Locate many contact sets, on all cores or a Dask cluster, into one table.",
    "fit": "Find one plane, sphere or cylinder from contacts.",
    "design-check": "Tell whether a fixture will locate, how surely, and what it would not notice.",
    "schema": "Print the JSON Schema of fixture files, for editors.",
    "init": "Write a commented fixture file to start from.",
    "simulate": "Make a contact file as a probe would report it, with the truth in it.",
    "plan": "Choose the contacts to make: reachable, unique and as sure as can be.",
    "convert": "Write a pose in the words of a controller, a machine tool or ROS.",
    "compare": "Tell how far a fixture has moved between two poses.",
    "import": "Write the log of a machine as a contact file.",
    "report": "Locate a fixture, or check its design, and write the record as one HTML page.",
}
"""Each command and its help in one line; design-check is the function `command` of `tactfix.cli.design_check`.

Only the module of the command that runs is imported, so a module may import at its top what it needs."""


def module_of(command: str) -> str:
    """The module of a command; one named like a Python keyword ends with an underscore."""
    name = command.replace("-", "_")
    return f"tactfix.cli.{name}_" if command == "import" else f"tactfix.cli.{name}"


def run(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status; every error is told on standard error, in its own words."""
    words = sys.argv[1:] if arguments is None else list(arguments)
    try:
        command = typer.main.get_command(_application(words))
        status = command.main(args=words, prog_name="tactfix", standalone_mode=False)
        sys.stdout.flush()
    except Exception as error:
        return _told(error)
    except KeyboardInterrupt:
        return _say("interrupted", Exit.INTERRUPTED)
    return int(status or Exit.DONE)


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
        function = importlib.import_module(module_of(name)).command if name == chosen else _placeholder
        app.command(name, cls=QuickCommand, short_help=summary)(function)
    return app


_HELP: Final = "Find where a fixture stands from a handful of touches on its spheres, cylinders and planes."


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
        bool,
        typer.Option("--version", help="Print the version and exit.", is_eager=True, callback=_version),
    ] = False,
) -> None:
    """What holds for tactfix as a whole."""


def _told(error: Exception) -> int:
    """The exit status of an error, after it has been told."""
    show: Callable[[], None] | None = getattr(error, "show", None)
    status: Any = getattr(error, "exit_code", None)
    if isinstance(error, TactfixError):
        return _say(str(error), exit_of_error(error))
    if isinstance(error, typer.Abort):
        return _say("interrupted", Exit.INTERRUPTED)
    if show is not None and status is not None:
        # typer's usage errors share no public base class over its versions; what they share is how they are shown.
        show()
        return int(status)
    if os.environ.get("TACTFIX_DEBUG") == "1":
        raise error
    return _say(
        f"a bug in tactfix: {type(error).__name__}: {error}".replace("\n", " ")
        + "; please report it with your files; TACTFIX_DEBUG=1 shows where",
        Exit.BUG,
    )


def _say(message: str, status: Exit) -> int:
    """Tell it on standard error, each line as tactfix's."""
    for line in message.splitlines():
        sys.stderr.write(f"tactfix: {line}\n")
    return status
