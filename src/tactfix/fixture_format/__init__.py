"""Format 1 of fixture files: its description, and the way from the plain values of a file to a fixture.

schema: pydantic's models, the one description of the format. json_schema: the JSON Schema generated from them, to
which a good file is held; pydantic_errors: what is wrong with the form of a bad one; only this imports pydantic.
entries, *_rules: what is well formed, and whether it makes sense together. build, read: on to the fixture.
"""
