"""Format 1 of fixture files: its schema, and the conversion from the plain values of a file to a fixture.

schema: pydantic models, the only definition of the format. json_schema: checks files against the JSON Schema generated
from them. pydantic_errors: explains schema violations; only this imports pydantic. entries, *_rules: the well-formed
entries, and their consistency. build, read: conversion to the fixture.
"""
