"""tactfix init."""

import os
from pathlib import Path
from typing import Annotated

import typer

from tactfix.cli import completion
from tactfix.cli.output import emit
from tactfix.errors import UsageError
from tactfix.formats import TEMPLATES


def command(
    output: Annotated[
        Path | None,
        typer.Argument(metavar="[FILE]", help="The file to write; by default standard output.", show_default=False),
    ] = None,
    like: Annotated[
        str,
        typer.Option(
            metavar="NAME", help=f"What to start from: {', '.join(TEMPLATES)}.", autocompletion=completion.templates
        ),
    ] = "robot-cell-plate",
    force: Annotated[bool, typer.Option("--force", help="Replace FILE if it exists.")] = False,
) -> int:
    """Write a commented fixture file to start from."""
    from tactfix.files.fixture_file import template_text

    if output is not None and os.path.exists(output) and not force:  # noqa: PTH110 - where one may not look it says no
        raise UsageError(f"{output} exists; choose another name, or replace it with --force")
    emit(template_text(like), output)
    return 0
