"""The shipped JSON Schema is that of the models, and a document conforms to it exactly if pydantic accepts it."""

import copy
import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tactfix.fixture_format.json_schema import conforms, fixture_schema, is_well_formed
from tactfix.fixture_format.pydantic_errors import malformations
from tactfix.fixture_format.schema import FixtureDocument, schema_text
from tactfix.yaml_tree import read_tree
from tests.support.file_texts import PAPER, PLACED
from tests.support.project import ROOT

FIXTURES = ROOT / "fixtures"
FULL = read_tree(
    PLACED
    + "probe: {tip_radius: 1, sigma: 0.1, approach_distance: 3, tip_offset: [0, 0, 120], tip_within: 5}\n"
    + "placement: {near: {matrix: [[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}, free: [x, rz],\n"
    + "  within: {translation: 5, rotation: 2}, sigma: {translation: 5, rotation: 2}}\n"
    + "distances: [{between: [bar, ball], value: 30, sigma: 0.1}]\n"
    + "angles: [{between: [bar, top], value: 90}]\n"
    + "touch: {ball: {x: [null, 3], y: null}}\n"
    + PAPER[PAPER.index("frame:") : PAPER.index("touch:")].replace("{along: bar}", "{opposite: {along: bar}}")
).value
VALUES = [
    None,
    True,
    0,
    1,
    -1,
    1.0,
    0.5,
    181,
    float("nan"),
    float("inf"),
    "",
    "bar",
    "mm",
    "sphere",
    "outer",
    [],
    {},
    [1, 2, 3],
]
VALUES += [
    ["bar", "ball"],
    [None, 1.0],
    {"along": "bar"},
    {"from": "bar", "to": "ball"},
    {"opposite": {"along": "bar"}},
    {"kuka": "{X 1}"},
    {"file": "a.json"},
    ["x", "ry"],
]
KEYS = [
    "tactfix",
    "name",
    "radius",
    "side",
    "type",
    "center",
    "sigma",
    "x",
    "y",
    "z",
    "origin",
    "along",
    "opposite",
    "meet_of",
    "no",
]


def test_the_shipped_schema_is_that_of_the_models() -> None:
    """If this fails, the models have changed: write the new schema to fixtures/tactfix.schema.json."""
    assert fixture_schema() == schema_text(FixtureDocument, "tactfix fixture")
    kept = [path for path in ROOT.rglob("*.schema.json") if not {".git", "venv", ".venv"} & set(path.parts)]
    assert kept == [FIXTURES / "tactfix.schema.json"]


def test_every_key_has_a_description() -> None:
    schema = json.loads(fixture_schema())
    for place in (schema, *schema["$defs"].values()):
        assert place["description"]
        for name, key in place.get("properties", {}).items():
            assert key.get("description"), name


@pytest.mark.parametrize("path", sorted(FIXTURES.glob("*.yaml")), ids=lambda path: path.stem)
def test_the_fixtures_conform_to_the_schema_and_refer_to_it(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert text.startswith("# yaml-language-server: $schema=tactfix.schema.json\n")
    value = read_tree(text).value
    assert is_well_formed(value)
    assert malformations(value) == []


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The path of each value in a tree."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(place for key, part in inner for place in places(part, (*path, key)))]


@st.composite
def changed(draw: st.DrawFn) -> Any:
    """The full document with up to three values replaced, keys removed or keys added."""
    document = copy.deepcopy(FULL)
    for _ in range(draw(st.integers(1, 3))):
        *way, key = draw(st.sampled_from(places(document)[1:]))
        parent = document
        for part in way:
            parent = parent[part]
        match draw(st.sampled_from(["replace", "remove", "add"])):
            case "replace":
                parent[key] = copy.deepcopy(draw(st.sampled_from(VALUES)))
            case "remove":
                del parent[key]
            case "add" if isinstance(parent, dict):
                parent[draw(st.sampled_from(KEYS))] = copy.deepcopy(draw(st.sampled_from(VALUES)))
        if not document:
            break
    return document


def test_the_full_document_is_well_formed() -> None:
    assert is_well_formed(FULL)
    assert malformations(FULL) == []


@pytest.mark.parametrize("value", [0, -1, None, "bar"], ids=str)
def test_conformity_equals_acceptance_with_one_changed_value(value: Any) -> None:
    """One value at a time, because random changes seldom reach the limits of numbers."""
    for *way, key in places(FULL)[1:]:
        document = copy.deepcopy(FULL)
        parent = document
        for part in way:
            parent = parent[part]
        parent[key] = value
        assert is_well_formed(document) == (malformations(document) == []), (*way, key)


@settings(max_examples=250, deadline=None)
@given(changed())
def test_conformity_equals_acceptance_by_pydantic(document: Any) -> None:
    assert is_well_formed(document) == (malformations(document) == [])


@pytest.mark.slow
@settings(max_examples=10_000, deadline=None)
@given(changed())
def test_conformity_equals_acceptance_in_ten_thousand_documents(document: Any) -> None:
    assert is_well_formed(document) == (malformations(document) == [])


def test_a_word_that_is_not_known_is_not_passed_over() -> None:
    with pytest.raises(KeyError):
        conforms(3, {"multipleOf": 2}, {})
