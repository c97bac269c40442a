"""Rules beyond the schema: valid files close to invalid ones."""

from pathlib import Path

import pytest

from tactfix.errors import FileError
from tactfix.files.fixture_file import load_fixture
from tactfix.geometry.surfaces import Point
from tests.support.file_texts import PAPER, PLACED, written


def problems(folder: Path, text: str) -> list[str]:
    try:
        load_fixture(written(folder, text))
    except FileError as error:
        return [problem.what for problem in error.problems]
    return []


@pytest.mark.parametrize(
    ("distance", "is_right"),
    [
        ("30.0", True),
        ("30.0003, sigma: 0.00001", False),
        ("30.011, sigma: 0.003", True),  # within four sigma and the rounding of the value
        ("30.02, sigma: 0.003", False),
        ("30.00003", True),  # rounding of the value, and of the coordinates
        ("30.0004", False),
    ],
)
def test_a_distance_agrees_with_the_places_within_its_sigma(tmp_path: Path, distance: str, is_right: bool) -> None:
    text = PLACED + f"distances:\n  - {{between: [ball, bar], value: {distance}}}\n"
    assert (problems(tmp_path, text) == []) == is_right


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1.0, 1e3])
def test_the_verdict_on_places_is_the_same_in_every_unit(tmp_path: Path, scale: float) -> None:
    def text(distance: float) -> str:
        return (
            "tactfix: 1\nunits: mm\nfeatures:\n"
            f"  bar: {{type: cylinder, radius: {8 * scale!r}, point: [0, 0, 0], direction: [0, 1, 0]}}\n"
            f"  ball: {{type: sphere, radius: {10 * scale!r}, center: [{30 * scale!r}, 0, 0]}}\n"
            f"distances:\n  - {{between: [bar, ball], value: {distance * scale!r}}}\n"
        )

    assert problems(tmp_path, text(30.0)) == []
    assert len(problems(tmp_path, text(30.1))) == 1


@pytest.mark.parametrize(
    ("between", "value", "is_right"),
    [
        ("[ball, top]", "-15", True),  # below the face: negative
        ("[top, ball]", "-15.0", True),
        ("[ball, top]", "15", False),
        ("[bar, top]", "15", True),
        ("[bar, top]", "16", False),
    ],
)
def test_distances_from_a_plane(tmp_path: Path, between: str, value: str, is_right: bool) -> None:
    text = PLACED + f"distances:\n  - {{between: {between}, value: {value}}}\n"
    assert (problems(tmp_path, text) == []) == is_right


@pytest.mark.parametrize("length", ["1.1e30", "-1e31", "1e300"])
@pytest.mark.parametrize(
    "line",
    [
        "distances:\n  - {{between: [ball, top], value: {}}}\n",
        "touch:\n  ball: {{y: [null, {}]}}\n",
        "touch:\n  ball: {{y: [{}, null]}}\n",
    ],
)
def test_a_length_that_is_too_large_in_every_unit(tmp_path: Path, line: str, length: str) -> None:
    (message,) = problems(tmp_path, PLACED + line.format(length))
    assert "no length in any unit" in message


@pytest.mark.parametrize(
    ("key", "value", "is_right"),
    [
        ("radius", "1e31", False),
        ("radius", "1e-31", False),
        ("radius", "1e29", True),
        ("sigma", "1e-40", False),
        ("sigma", "0", True),
        ("sigma", "1e40", False),
        ("tip_radius", "1e40", False),
        ("approach_distance", "1e-200", False),
    ],
)
def test_invalid_sizes(tmp_path: Path, key: str, value: str, is_right: bool) -> None:
    in_probe = key in ("tip_radius", "approach_distance")
    radius = value if key == "radius" else "8"
    rest = f", sigma: {value}" if key == "sigma" else ""
    text = "tactfix: 1\nunits: mm\n" + (f"probe: {{{key}: {value}}}\n" if in_probe else "")
    found = problems(
        tmp_path, text + f"features:\n  ball: {{type: sphere, radius: {radius}, center: [0, 0, 0]{rest}}}\n"
    )
    assert (found == []) == is_right


@pytest.mark.parametrize(("place", "is_right"), [("1e40", False), ("-1e31", False), ("1e-300", True)])
def test_invalid_places(tmp_path: Path, place: str, is_right: bool) -> None:
    text = "tactfix: 1\nunits: mm\nfeatures:\n"
    text += f"  top: {{type: plane, point: [0, {place}, 0], normal: [0, 0, 1e200]}}\n"
    assert (problems(tmp_path, text) == []) == is_right


TWO_BARS = """tactfix: 1
units: mm
features:
  a: {{type: cylinder, radius: 1, point: [0, 0, 0], direction: [1, 0, 0]}}
  b: {{type: cylinder, radius: 1, point: [5, 0, 7], direction: {direction}}}
distances:
  - {{between: [a, b], value: {value}}}
"""


@pytest.mark.parametrize(
    ("direction", "value"), [("[0, 1, 0]", 7), ("[1, 1, 0]", 7), ("[-1, 0, 0]", 7), ("[0, 0, 1]", 0), ("[1, 0, 1]", 0)]
)
def test_distance_of_two_axes_along_their_common_perpendicular(tmp_path: Path, direction: str, value: float) -> None:
    assert problems(tmp_path, TWO_BARS.format(direction=direction, value=value)) == []
    assert len(problems(tmp_path, TWO_BARS.format(direction=direction, value=value + 1))) == 1


@pytest.mark.parametrize(("value", "is_right"), [(3.0, True), (5.0, True), (4.0, False)])
def test_axes_with_places_that_are_nearly_parallel(tmp_path: Path, value: float, is_right: bool) -> None:
    """Axes at 0.01 rad: the distance is 3 along the common perpendicular, and 5 from the given point of the first."""
    text = TWO_BARS.replace("[5, 0, 7]", "[0, 4, 3]").format(direction="[1, 0.01, 0]", value=value)
    assert (problems(tmp_path, text) == []) == is_right


RELATED_BARS = """tactfix: 1
units: mm
features:
  a: {{type: cylinder, radius: 1}}
  b: {{type: cylinder, radius: 1}}
  ball: {{type: sphere, radius: 1}}
distances:
  - {{between: [a, b], value: 7}}
angles: [{angle}]
frame: {{origin: {{foot_of: ball, on: a}}, z: {{along: a}}, x: {{from: a, to: ball}}}}
"""


@pytest.mark.parametrize(
    ("angle", "is_right"),
    [("", True), ("0", True), ("1", False), ("1.1", False), ("1.2", True), ("90", True), ("0.001", False)],
)
def test_axes_have_a_distance_where_they_are_parallel_or_clearly_askew(
    tmp_path: Path, angle: str, is_right: bool
) -> None:
    relation = f"{{between: [b, a], value: {angle}}}" if angle else ""
    found = problems(tmp_path, RELATED_BARS.format(angle=relation))
    assert (found == []) == is_right
    assert is_right or "only if clearly skew or parallel" in found[0]


def test_a_frame_that_agrees_with_the_places_is_accepted(tmp_path: Path) -> None:
    frame = "frame:\n  origin: {foot_of: ball, on: bar}\n  y: {along: bar}\n  x: {from: bar, to: ball}\n"
    assert problems(tmp_path, PLACED + frame) == []
    # An axis has no sign; a direction between features and a normal have one.
    assert problems(tmp_path, PLACED + frame.replace("y: {along: bar}", "y: {opposite: {along: bar}}")) == []
    assert (
        len(problems(tmp_path, PLACED + frame.replace("{from: bar, to: ball}", "{opposite: {from: bar, to: ball}}")))
        == 1
    )
    assert problems(tmp_path, PLACED + frame.replace("x: {from: bar, to: ball}", "z: {along: top}")) == []
    assert (
        len(problems(tmp_path, PLACED + frame.replace("x: {from: bar, to: ball}", "z: {opposite: {along: top}}"))) == 1
    )


@pytest.mark.parametrize(
    ("box", "leaves_something"),
    [
        ("{x: [39.9, null]}", True),
        ("{x: [40.1, null]}", False),
        ("{x: [29, 31], y: [-1, 1], z: [-1, 1]}", False),
        ("{x: [29, 31], y: [-1, 1], z: [-1, 11]}", True),
        ("{x: [36, 41], y: [8.1, null]}", False),  # the corner (36, 8.1) is 10.08 away from the centre
        ("{x: [36, 41], y: [7.9, null]}", True),
        ("{}", True),
    ],
)
def test_boxes_that_contain_no_point_of_a_ball(tmp_path: Path, box: str, leaves_something: bool) -> None:
    assert (problems(tmp_path, PLACED + f"touch:\n  ball: {box}\n") == []) == leaves_something


@pytest.mark.parametrize(
    ("box", "leaves_something"),
    [
        ("{y: [100, 200]}", True),
        ("{x: [-7, 7], z: [-3.9, 3.9]}", True),  # hypot(7, 3.9) = 8.01
        ("{x: [-7, 7], z: [-3.8, 3.8]}", False),  # hypot(7, 3.8) = 7.96: inside the bar
        ("{x: [8.1, null]}", False),
        ("{x: [5.7, null], z: [5.7, null]}", False),  # hypot(5.7, 5.7) = 8.06
        ("{x: [5.6, null], z: [5.6, null], y: [1, 2]}", True),
    ],
)
def test_boxes_that_contain_no_point_of_a_bar(tmp_path: Path, box: str, leaves_something: bool) -> None:
    assert (problems(tmp_path, PLACED + f"touch:\n  bar: {box}\n") == []) == leaves_something


@pytest.mark.parametrize(
    ("box", "leaves_something"), [("{z: [15, 16]}", True), ("{z: [15.1, 16]}", False), ("{x: [1, 2]}", True)]
)
def test_boxes_that_contain_no_point_of_a_face(tmp_path: Path, box: str, leaves_something: bool) -> None:
    assert (problems(tmp_path, PLACED + f"touch:\n  top: {box}\n") == []) == leaves_something


def test_spheres_in_a_row_are_no_contradiction(tmp_path: Path) -> None:
    text = """tactfix: 1
units: mm
features:
  a: {type: sphere, radius: 1}
  b: {type: sphere, radius: 1}
  c: {type: sphere, radius: 1}
distances:
  - {between: [a, b], value: 10, sigma: 0.01}
  - {between: [b, c], value: 10, sigma: 0.01}
  - {between: [a, c], value: 20.05, sigma: 0.01}
frame:
  origin: {center_of: a}
  x: {from: a, to: b}
  y: {from: a, to: c}
"""
    assert problems(tmp_path, text) == []
    assert len(problems(tmp_path, text.replace("20.05", "20.1"))) == 1


def test_an_axis_between_features_that_touch_has_no_direction(tmp_path: Path) -> None:
    assert problems(tmp_path, PAPER.replace("value: 3.0", "value: 0")) == [
        "there is no direction from bar to ball: their distance is 0"
    ]


SEATS = """tactfix: 1
units: mm
features:
  a: {type: point, point: [0, 0, 0], sigma: 0.01}
  b: {type: point, point: [100, 0, 0]}
  ball: {type: sphere, radius: 10, center: [0, 50, 30]}
  top: {type: plane, point: [0, 0, -5], normal: [0, 0, 1]}
"""


def test_points_carry_their_place(tmp_path: Path) -> None:
    fixture = load_fixture(written(tmp_path, SEATS))
    seat = fixture.features["a"]
    assert (seat.type, seat.radius, seat.sigma) == ("point", None, 0.01)
    assert isinstance(fixture.features["b"].surface, Point)
    assert fixture.features["b"].surface.point.tolist() == [100, 0, 0]


@pytest.mark.parametrize(
    ("rest", "expected"),
    [
        (
            "distances: [{between: [a, b], value: 100}, {between: [a, top], value: 5}]",
            "",
        ),
        ("distances: [{between: [ball, b], value: 116}]", ""),
        ("distances: [{between: [a, b], value: 101}]", "distance of a and b is 101"),
        ("distances: [{between: [a, top], value: -5}]", "distance of a and top is -5"),
        ("distances: [{between: [a, b], value: -100}]", "has no sign"),
        ("angles: [{between: [a, top], value: 90}]", "a is a point and has no direction"),
        ("touch: {a: {x: [-1, 1]}}", "a is a point, which is touched at one place only"),
        ("frame: {origin: {center_of: a}, x: {from: a, to: b}, z: {along: top}}", ""),
        ("frame: {origin: {foot_of: a, on: top}, x: {from: a, to: b}, z: {along: top}}", "origin at (0, 0, -5)"),
        ("frame: {origin: {center_of: a}, x: {from: a, to: b}, z: {along: b}}", "b is a point and has no direction"),
        ("frame: {origin: {foot_of: a, on: b}, x: {from: a, to: b}, z: {along: top}}", "a, a point, has no foot on b"),
    ],
)
def test_relations_of_points(tmp_path: Path, rest: str, expected: str) -> None:
    rest = rest.replace("116", repr((100**2 + 50**2 + 30**2) ** 0.5))
    found = problems(tmp_path, f"{SEATS}{rest}\n")
    assert len(found) == bool(expected)
    assert not expected or expected in found[0]


@pytest.mark.parametrize("rest", ["radius: 3", "side: inner", "center: [0, 0, 0]", "normal: [0, 0, 1]"])
def test_keys_that_a_point_does_not_have(tmp_path: Path, rest: str) -> None:
    (message,) = problems(tmp_path, SEATS.replace("sigma: 0.01", rest))
    assert "unknown key" in message


def test_points_by_relations(tmp_path: Path) -> None:
    text = "tactfix: 1\nunits: mm\nfeatures:\n" + "".join(f"  {name}: {{type: point}}\n" for name in "abc")
    text += "distances: [{between: [a, b], value: 10}, {between: [b, c], value: 10}, {between: [a, c], value: 30}]\n"
    text += "frame: {origin: {center_of: a}, x: {from: a, to: b}, y: {from: a, to: c}}\n"
    assert problems(tmp_path, text) == ["a and c are farther apart than their distances from b allow"]
    assert problems(tmp_path, text.replace("30", "15")) == []
