"""The JSON Schema of fixture files, for editors."""

import json


def fixture_schema() -> str:
    """JSON Schema (draft 2020-12) of format 1, as text with a newline at its end."""
    from pydantic.json_schema import GenerateJsonSchema

    from tactfix.models.document import FixtureDocument

    schema = FixtureDocument.model_json_schema(by_alias=True)
    head = {"$schema": GenerateJsonSchema.schema_dialect, "title": "tactfix fixture"}
    return json.dumps({**head, **{key: value for key, value in schema.items() if key != "title"}}, indent=2) + "\n"
