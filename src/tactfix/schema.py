"""The JSON Schema of fixture files, for editors."""

import json
from typing import Final

from tactfix.fixture_format.json_schema import fixture_schema_text

DIALECT: Final = "https://json-schema.org/draft/2020-12/schema"


def fixture_schema() -> str:
    """JSON Schema (draft 2020-12) of format 1, as text with a newline at its end."""
    return fixture_schema_text()


def schema_of_models() -> str:
    """The same, made anew of the models: what fixture_format/fixture.schema.json must hold after they have changed."""
    from tactfix.fixture_format.schema import FixtureDocument

    schema = FixtureDocument.model_json_schema(by_alias=True)
    head = {"$schema": DIALECT, "title": "tactfix fixture"}
    return json.dumps({**head, **{key: value for key, value in schema.items() if key != "title"}}, indent=2) + "\n"
