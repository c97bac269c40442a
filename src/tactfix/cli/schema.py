"""tactfix schema."""

from typing import Annotated

import typer

from tactfix.cli import completion
from tactfix.cli.options import Output
from tactfix.cli.output import emit


def command(
    of: Annotated[
        str | None,
        typer.Option(
            "--of",
            metavar="COMMAND",
            help="Print the JSON Schema of what this command prints with --json; cell: of cell files.",
            autocompletion=completion.json_commands,
        ),
    ] = None,
    output: Output = None,
) -> int:
    """Print the JSON Schema of fixture files (format 1), for editors that check YAML during editing.

    The first line of a fixture file makes an editor use it:

        # yaml-language-server: $schema=tactfix.schema.json

    With --of it is the schema of the JSON of a command (calibrate-plan: of calibrate --plan), or of cell files.
    """
    if of == "cell":
        from tactfix.fixture_format.cell import cell_schema

        emit(cell_schema(), output)
        return 0
    if of is not None:
        from tactfix.report.json_schema import schema_of

        emit(schema_of(of), output)
        return 0
    from tactfix.fixture_format.json_schema import fixture_schema

    emit(fixture_schema(), output)
    return 0
