"""tactfix schema."""

from tactfix.cli.options import Output
from tactfix.cli.output import emit


def command(output: Output = None) -> int:
    """Print the JSON Schema of fixture files (format 1), for editors that check YAML while you write.

    The first line of a fixture file makes an editor use it:

        # yaml-language-server: $schema=tactfix.schema.json
    """
    from tactfix.fixture_format.json_schema import fixture_schema

    emit(fixture_schema(), output)
    return 0
