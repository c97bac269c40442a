"""What a fixture file may say, and what it means: the only room that knows pydantic.

schema, features, frame, strict: pydantic's models, from which fixture.schema.json is made, and which say what is wrong
with a file. json_schema: whether a file keeps to that schema; one that does never pays for importing pydantic.
entries, *_rules, build: from a file that keeps to the schema to a fixture.
"""
