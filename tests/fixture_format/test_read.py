"""Fixture files: values are read in the file's units, angles in rad."""

import math
from pathlib import Path

import numpy as np
import pytest

from tactfix.errors import FileError
from tactfix.files.fixture_file import load_fixture
from tactfix.fixture import AxisRule, Fixture, OriginRule, Probe, Relation
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tests.support.file_texts import PAPER, PLACED, written


def loaded(folder: Path, text: str | bytes) -> Fixture:
    return load_fixture(written(folder, text))


def refusal(folder: Path, text: str | bytes) -> FileError:
    with pytest.raises(FileError) as caught:
        loaded(folder, text)
    return caught.value


def test_the_paper_by_relations(tmp_path: Path) -> None:
    fixture = loaded(tmp_path, PAPER)
    assert (fixture.name, fixture.units, fixture.probe) == ("paper", "mm", Probe())
    assert list(fixture.features) == ["bar", "ball"]
    bar = fixture.features["bar"]
    assert (bar.type, bar.radius, bar.side, bar.sigma, bar.surface) == ("cylinder", 1.0, "outer", 0.0, None)
    assert fixture.relations == (Relation("distance", ("bar", "ball"), 3.0, 0.0),)
    assert not fixture.is_placed
    frame = fixture.frame
    assert frame is not None
    assert frame.origin == OriginRule("foot_of", ("ball", "bar"))
    assert frame.first == ("y", AxisRule("along", ("bar",)))
    assert frame.second == ("x", AxisRule("from_to", ("bar", "ball")))
    box = fixture.touch["bar"]
    np.testing.assert_array_equal(box.low, [-np.inf, 0.2, -np.inf])
    np.testing.assert_array_equal(box.high, [np.inf, 6.0, np.inf])


def test_places_in_the_fixture_frame(tmp_path: Path) -> None:
    fixture = loaded(tmp_path, PLACED)
    assert fixture.is_placed
    assert fixture.frame is None
    bar, ball, top = (feature.surface for feature in fixture.features.values())
    assert isinstance(bar, Cylinder)
    assert isinstance(ball, Sphere)
    assert isinstance(top, Plane)
    assert (bar.radius, bar.side) == (8.0, "outer")
    np.testing.assert_array_equal(bar.direction, [0, 1, 0])
    assert (ball.radius, ball.side) == (10.0, "inner")
    np.testing.assert_array_equal(ball.center, [30, 0, 0])
    np.testing.assert_array_equal(top.normal, [0, 0, 1])
    assert fixture.features["ball"].sigma == 0.001
    assert fixture.features["top"].radius is None


def test_the_default_name_is_that_of_the_file(tmp_path: Path) -> None:
    assert loaded(tmp_path, PLACED).name == "fixture"


def test_the_axis_written_first_is_the_first(tmp_path: Path) -> None:
    text = PAPER.replace(
        "  y: {along: bar}\n  x: {from: bar, to: ball}\n", "  x: {from: bar, to: ball}\n  y: {opposite: {along: bar}}\n"
    )
    frame = loaded(tmp_path, text).frame
    assert frame is not None
    assert frame.first == ("x", AxisRule("from_to", ("bar", "ball")))
    assert frame.second == ("y", AxisRule("along", ("bar",), opposite=True))


def test_a_plane_and_a_cylinder_meet_in_either_order(tmp_path: Path) -> None:
    features = "features:\n  bar: {type: cylinder, radius: 1}\n  top: {type: plane}\n  side: {type: plane}\n"
    recipe = "frame:\n  origin: {meet_of: [top, bar]}\n  z: {along: top}\n  x: {along: side}\n"
    text = f"tactfix: 1\nunits: mm\n{features}{recipe}"
    frame = loaded(tmp_path, text).frame
    assert frame is not None
    assert frame.origin == OriginRule("meet_of", ("bar", "top"))


def test_angles_arrive_in_rad(tmp_path: Path) -> None:
    text = PLACED + "angles:\n  - {between: [bar, top], value: 90, sigma: 0.5}\n"
    relation = loaded(tmp_path, text).relations[0]
    assert relation.value == pytest.approx(math.pi / 2)
    assert relation.sigma == pytest.approx(math.radians(0.5))


@pytest.mark.parametrize(("written", "read"), [("2.5e-15", 0.0), ("1e-6", 1e-6)])
def test_a_distance_of_zero_within_rounding(tmp_path: Path, written: str, read: float) -> None:
    text = PAPER.replace("distances:\n", f"distances:\n  - {{between: [ball, other], value: {written}}}\n")
    text = text.replace("features:\n", "features:\n  other: {type: sphere, radius: 1.0}\n")
    assert loaded(tmp_path, text).relations[0].value == read


def test_the_probe(tmp_path: Path) -> None:
    text = PAPER + "probe: {tip_radius: 1.5, sigma: 5e-3, approach_distance: 10}\n"
    assert loaded(tmp_path, text).probe == Probe(1.5, 0.005, 10)


@pytest.mark.parametrize("number", ["3e+0", "3.0", "3", "+3.", "30e-1", "0.3E1"])
def test_ways_to_write_a_number(tmp_path: Path, number: str) -> None:
    assert loaded(tmp_path, PAPER.replace("3.0", number)).relations[0].value == 3.0


@pytest.mark.parametrize(
    "text", ["0x10", "1_000", "1:30", "yes", "on", "~", "true", "2001-01-01", '"3"', "1,5", "1e", ".", "1e999"]
)
def test_invalid_numbers(tmp_path: Path, text: str) -> None:
    problems = refusal(tmp_path, PAPER.replace("value: 3.0", f"value: {text}")).problems
    assert [(p.line, p.column) for p in problems] == [(8, 35)] or text == "1,5"


def test_features_named_like_words_of_yaml(tmp_path: Path) -> None:
    text = PAPER.replace("bar", "no").replace("ball", "y")
    assert list(loaded(tmp_path, text).features) == ["no", "y"]


def test_byte_order_mark_and_crlf(tmp_path: Path) -> None:
    assert loaded(tmp_path, PAPER.replace("\n", "\r\n").encode("utf-8-sig")).name == "paper"


def test_columns_count_characters_and_not_bytes(tmp_path: Path) -> None:
    error = refusal(tmp_path, PAPER.replace("name: paper", "name: {\u00e4\u00f6\u00fc\U0001f600: 1}"))
    assert [(p.line, p.column) for p in error.problems] == [(2, 7)]
    error = refusal(
        tmp_path,
        PAPER.replace("  ball: {type: sphere, radius: 1.0}", "  b\u00e4ll\u00f6: {type: sphere, radius: -1.0}"),
    )
    assert (6, 33) in [(p.line, p.column) for p in error.problems]


def test_deep_nesting_is_refused_and_not_followed(tmp_path: Path) -> None:
    assert "levels" in str(refusal(tmp_path, "[" * 30 + "]" * 30))
    # Recent versions of libyaml stop earlier.
    assert "not YAML" in str(refusal(tmp_path, "[" * 100_000))


def test_all_errors_at_once_those_of_form_and_those_of_sense(tmp_path: Path) -> None:
    text = (
        PAPER.replace("units: mm", "units: feet")
        .replace("[bar, ball]", "[bar, bell]")
        .replace("{along: bar}", "{along: ball}")
    )
    lines = [problem.line for problem in refusal(tmp_path, text).problems]
    assert lines == [3, 8, 11]


def test_relations_keep_their_place_when_one_before_them_is_malformed(tmp_path: Path) -> None:
    text = PAPER.replace("distances:\n", "distances:\n  - {between: [bar], value: 1}\n  - 7\n").replace(
        "[bar, ball]", "[bar, bell]"
    )
    assert [problem.line for problem in refusal(tmp_path, text).problems] == [8, 9, 10]


def test_a_feature_that_is_refused_is_still_declared(tmp_path: Path) -> None:
    problems = refusal(tmp_path, PAPER.replace("sphere, radius: 1.0", "sphere, radius: -1.0")).problems
    assert len(problems) == 1


def test_missing_file_and_directory(tmp_path: Path) -> None:
    for path, word in (
        (tmp_path / "no.yaml", "no such file"),
        ("-", "there is no such file; name a file: this one is not read from standard input"),
        (tmp_path, "directory"),
        (Path("a\0b"), "cannot be read"),
    ):
        with pytest.raises(FileError, match=word) as caught:
            load_fixture(path)
        assert caught.value.path == str(path)
