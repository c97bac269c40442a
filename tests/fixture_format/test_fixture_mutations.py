"""Every value of a fixture file is replaced or removed, and keys are added: always a result, never an exception."""

import copy
from collections.abc import Iterator
from itertools import islice
from typing import Any

import pytest

from tactfix.errors import FileError, Problem
from tactfix.fixture import Fixture
from tactfix.fixture_format.entries import Finding
from tactfix.fixture_format.read import read_fixture
from tactfix.pose_formats.pose import Pose
from tactfix.yaml_tree import read_tree
from tests.support.file_texts import PAPER, PLACED

_SECTIONS = """
probe: {tip_radius: 1, sigma: 0.1, approach_distance: 3, tip_offset: [0, 0, 120], tip_within: 5}
placement:
  near: {matrix: [[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}
  free: [x, rz]
  within: {translation: 5, rotation: 2}
distances: [{between: [bar, ball], value: 30, sigma: 0.1}, {between: [ball, seat], value: 5}]
angles: [{between: [bar, top], value: 90, sigma: 1}]
touch: {bar: {y: [null, 5]}, ball: {x: [35, null]}, top: {x: [0, 1]}}
frame: {origin: {foot_of: ball, on: bar}, y: {along: bar}, x: {from: bar, to: ball}}
"""
_MEETING = "frame: {origin: {meet_of: [bar, top]}, z: {along: top}, x: {opposite: {from: bar, to: ball}}}\n"
_PLANE_AND_POINT = "top: {type: plane}\n  seat: {type: point}\n  ball: {"
DOCUMENTS = {
    "relations": PAPER[: PAPER.index("distances")].replace(
        "ball: {",
        "top: {type: plane}\n  seat: {type: point}\n  ball: {",
    )
    + _SECTIONS[: _SECTIONS.index("frame")]
    + _MEETING,
    "places": PLACED + "  seat: {type: point, point: [30, 0, 5]}\n" + _SECTIONS,
}
VALUES: list[Any] = [
    *(None, True, 0, -1, 181, 10**25, -(10**299), 1e308, 5e-324, float("nan"), float("inf")),
    *("", "bar", "nobody", "plane", "\x1b[31m"),
    *([], {}, [1, 2, 3], [0, 0, 0], [1e308] * 3, [5e-324, 0, 0], [10**25, 1, 1], ["bar", "ball"], ["bar"]),
    *({"kuka": "{X 1, Y 2, Z 3, A 4, B 5, C 6}"}, {"file": "a.json"}, [[1e300] * 4] * 4, ["x", "x"]),
    *([None, 1.0], [2, 1], [10**25, None], {"along": "bar"}, {"along": "nobody"}, {"opposite": {"opposite": {}}}),
    *({"from": "bar", "to": "top"}, {"meet_of": ["top", "bar"]}, {"type": "plane"}, {"bar": 1}, {"between": []}),
]


def no_files(file: str) -> Pose:
    raise FileError(file, [Problem("there is no such file", "check the path")])


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The path of each value in a tree below its root; of a list of scalars only the first."""
    if isinstance(value, list):
        value = dict(enumerate(value if value and isinstance(value[0], dict) else value[:1]))
    inner = value.items() if isinstance(value, dict) else ()
    for key, part in inner:
        yield (*path, key)
        yield from places(part, (*path, key))


def mutants(document: Any) -> Iterator[tuple[str, Any]]:
    """The document with one value replaced, with one value removed, and with one key added."""
    for *way, key in places(document):
        for number, value in enumerate([*VALUES, ...]):
            mutant = copy.deepcopy(document)
            parent = mutant
            for part in way:
                parent = parent[part]
            if value is ...:
                del parent[key]
            else:
                parent[key] = copy.deepcopy(value)
            yield f"{'.'.join(map(str, (*way, key)))} <- {'removed' if value is ... else VALUES[number]!r}", mutant
            if value == {} and isinstance(parent, dict):
                parent[key], parent["nobody"] = copy.deepcopy(document), 1
                yield f"{'.'.join(map(str, (*way, key)))} <- the whole", mutant


SHARE = 5
"""The fast test reads every fifth mutant. 5 is coprime to the 41 or 42 mutants of a place, so every value occurs."""


@pytest.mark.parametrize("share", [SHARE, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", DOCUMENTS)
def test_no_mutant_ends_in_an_exception(name: str, share: int) -> None:
    document = read_tree(DOCUMENTS[name]).value
    assert isinstance(read_fixture(document, "sound", no_files), Fixture)
    refused = 0
    for description, mutant in islice(mutants(document), 0, None, share):
        try:
            answer = read_fixture(mutant, "mutant", no_files)
        except Exception as error:
            raise AssertionError(f"{description}: {error!r}") from error
        assert isinstance(answer, Fixture) or (answer and all(isinstance(f, Finding) and f.remedy for f in answer)), (
            description
        )
        refused += not isinstance(answer, Fixture)
    assert refused > 1000 / share


def test_all_errors_of_a_malformed_file_are_reported() -> None:
    """Two malformed features that relations, boxes and frame use: their errors are reported, and all others as well."""
    text = DOCUMENTS["places"].replace("radius: 8", "radius: -8").replace("normal: [0, 0, 2]", "normal: [0, 0]")
    text = (
        text.replace("value: 30", "value: thirty")
        .replace("y: [null, 5]", "y: [5, 4]")
        .replace("along: bar", "along: ball")
    )
    findings = read_fixture(read_tree(text).value, "", no_files)
    assert isinstance(findings, list)
    assert {finding.path for finding in findings} == {
        ("features", "bar", "radius"),
        ("features", "top", "normal"),
        ("distances", 0, "value"),
        ("touch", "bar", "y"),
        ("frame", "y", "along"),
    }
