"""What a fixture file may say, and what it means: the only room that knows pydantic.

document, features, frame, strict: the models of pydantic, from which fixture.schema.json is made, and which say what is
wrong with a file. conformity: whether a file keeps to that schema; one that does never pays for importing pydantic.
entries, *_sense, agreement, build: from a file that keeps to the schema to a fixture.
"""
