"""The commands by name, and where each is at home."""

import importlib
from collections.abc import Callable
from typing import Final, TypeAlias, cast

Command: TypeAlias = Callable[..., int]
"""What a command does; its parameters are Annotated with typer.Option and typer.Argument."""

COMMANDS: Final[dict[str, str]] = {
    "locate": "Find where a fixture stands from contacts.",
    "batch": "Locate many contact sets, on all cores or a Dask cluster, into one table.",
    "fit": "Find one plane, sphere or cylinder from contacts.",
    "qualify": "Tell what a probe is good for, from repeated touches or a reference ball.",
    "design-check": "Tell whether a fixture will locate, how surely, and what it would not notice.",
    "schema": "Print the JSON Schema of fixture files, for editors.",
    "init": "Write a commented fixture file to start from.",
    "simulate": "Make a contact file as a probe would report it, with the truth in it.",
    "plan": "Choose the contacts to make: reachable, unique and as sure as can be.",
    "calibrate": "Calibrate a robot from touches on fixtures at unknown places.",
    "convert": "Write a pose in the words of a controller, a machine tool or ROS.",
    "compare": "Tell how far a fixture has moved between two poses.",
    "check": "Tell whether a fixture still stands where it was located.",
    "guide": "Tell after each touch what is still open, and where to touch next.",
    "import": "Write the log of a machine as a contact file.",
    "report": "Locate a fixture, or check its design, and write the record as one HTML page.",
}
"""Each command and its help in one line; design-check is the function `command` of `tactfix.cli.design_check`.

Only the module of the command that runs is imported. At its top it imports what its parameters name; what is heavy
besides is imported in the function that uses it, so that help and completion do not wait for numpy."""


def module_of(command: str) -> str:
    """The module of a command; one named like a Python keyword ends with an underscore."""
    name = command.replace("-", "_")
    return f"tactfix.cli.{name}_" if command == "import" else f"tactfix.cli.{name}"


def command_of(name: str) -> Command:
    """The function of a command."""
    return cast(Command, importlib.import_module(module_of(name)).command)
