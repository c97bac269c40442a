"""The number of complex poses of six contacts: the shipped counts against the reference table and derivations.

data/pose_counts.json is the project's reference table, computed by another method. validation.kinds holds the counts
found by path tracking. The counts of kinds with a feature that is located alone are derived here by hand: after a
plane is located (three contacts, two sides), the body slides and turns in it, and each further contact moves on a
line, circle or ellipse; after a sphere is located (two centres), the body turns about it.
"""

import json
from itertools import combinations_with_replacement, product
from pathlib import Path

import numpy as np
import pytest

from tactfix.design import pose_counts
from tactfix.design.pose_counts import pose_count
from tests.validation.kinds import BY_HAND, CONFIRMED, UNCONFIRMED, feature_list
from tests.validation.monodromy import solve_by_monodromy

REFERENCE = json.loads((Path(__file__).parent / "data" / "pose_counts.json").read_text())["rows"]
SHIPPED = json.loads((Path(pose_counts.__file__).parent / "pose_counts.json").read_text())["rows"]


def count_of(features):
    """The number of poses for features given as (type, contacts)."""
    names = [f"f{i}" for i in range(len(features))]
    types = {name: kind for name, (kind, _) in zip(names, features, strict=True)}
    return pose_count(types, {name: n for name, (_, n) in zip(names, features, strict=True)})


def shipped_kind(row):
    """The features of a row as (type, contacts)."""
    return [(word.split(" ")[0], int(word.split(" ")[1])) for word in row["kind"].split(", ")]


def test_counts_are_those_of_the_reference():
    for row in REFERENCE:
        found = count_of(list(zip(row["features"], row["contacts"], strict=True)))
        assert (found.complex_poses, found.source) == (row["complex_poses"], "reference")
    # The table also has the general platform with six legs.
    platform = count_of([("sphere", 1)] * 6)
    assert (platform.complex_poses, platform.source) == (40, "reference")
    assert sum(row["source"] == "reference" for row in SHIPPED) == len(REFERENCE) + 1 == len(CONFIRMED)


@pytest.mark.parametrize(("table", "source"), [(BY_HAND, "reasoned"), (UNCONFIRMED, "tracked")])
def test_counts_are_those_of_path_tracking(table, source):
    for kind, poses in table.items():
        found = count_of(list(zip(*feature_list(kind), strict=True)))
        assert (found.complex_poses, found.source) == (poses, source), kind


# In a plane, three points of a moving body run on given curves. Two on lines: the third runs on an ellipse (an
# elliptic trammel, degree 2 in the plane, not through the circle points). A line and a circle: slider and crank, a
# quartic that passes through each circle point once. Two circles: the coupler of a four-bar, a sextic that passes
# through each three times. Bezout, without the circle points where the third curve is a circle; an ellipse misses them.
COUPLERS = {"ll": (2, 0), "lo": (4, 1), "oo": (6, 3)}
CURVE = {"plane": "l", "sphere": "o", "cylinder": "c"}


def planar(curves):
    """The number of positions of a body in a plane with three points on lines l, circles o, ellipses c."""
    conics = curves.count("c")
    if conics == 0:
        degree, through = COUPLERS[curves[:2]]
        return degree if curves[2] == "l" else 2 * degree - 2 * through
    # The third curve is an ellipse in general position: twice as many as for a line.
    rest = curves.replace("c", "", 1)
    return 2 * planar("".join(sorted(rest + "l", key="loc".index)))


def test_planar_counts_do_not_depend_on_which_point_comes_last():
    """Slider and crank against a line, an ellipse against a circle: the same problem counted twice."""
    trammel, _ = COUPLERS["ll"]
    crank, crank_through = COUPLERS["lo"]
    sextic, sextic_through = COUPLERS["oo"]
    assert 2 * trammel == crank == planar("llo") == 4
    assert 2 * crank - 2 * crank_through == sextic == planar("loo")
    assert 2 * sextic - 2 * sextic_through == planar("ooo") == 6, "the three-legged platform in the plane"


SINGLES = list(combinations_with_replacement(("plane", "sphere", "cylinder"), 3))


@pytest.mark.parametrize("others", SINGLES, ids="-".join)
def test_a_located_plane_and_three_features(others):
    curves = "".join(sorted((CURVE[name] for name in others), key="loc".index))
    found = count_of([("plane", 3), *((name, 1) for name in others)])
    assert found.complex_poses == 2 * planar(curves)


@pytest.mark.parametrize("others", SINGLES, ids="-".join)
def test_a_located_sphere_and_three_features(others):
    """Turns about the centre: q has three quadrics (a distance to a plane or centre is linear in R) or quartics."""
    degrees = [4 if name == "cylinder" else 2 for name in others]
    assert count_of([("sphere", 3), *((name, 1) for name in others)]).complex_poses == 2 * np.prod(degrees)


def test_a_count_does_not_decrease_if_a_feature_is_split_in_two():
    """Two contacts on one feature are a special case of contacts on two features: not more isolated poses."""
    known = {row["kind"]: row["complex_poses"] for row in SHIPPED}
    compared = 0
    for row in SHIPPED:
        features = shipped_kind(row)
        for i, (name, count) in enumerate(features):
            for part in range(1, count // 2 + 1):
                split = [*features[:i], *features[i + 1 :], (name, part), (name, count - part)]
                kind = pose_counts.kind_of(split)
                if kind in known:
                    assert known[kind] >= row["complex_poses"], (kind, row)
                    compared += 1
    assert compared > 60


def bound(features):
    """An upper bound of the count.

    Six contacts on planes and spheres have 40 poses at most: six legs of a general platform (Raghavan 1993, Husty
    1996); a plane is a sphere of infinite radius, and contacts that share a feature are a special choice. With
    cylinders it is Bezout's: in Study's coordinates a pose lies on a quadric, a contact with a plane or sphere is one
    of degree 2 and one with a cylinder of degree 4.
    """
    on_cylinders = sum(n for name, n in features if name == "cylinder")
    return 2 * 2 ** (6 - on_cylinders) * 4**on_cylinders if on_cylinders else 40


def test_no_count_is_above_its_bound():
    for row in SHIPPED:
        assert 0 < row["complex_poses"] <= bound(shipped_kind(row))


def test_every_way_to_share_out_six_contacts_over_four_features_or_more_has_a_count():
    types = ("plane", "sphere", "cylinder")
    for counts in ((3, 1, 1, 1), (2, 2, 1, 1), (2, 1, 1, 1, 1), (1,) * 6):
        for choice in product(types, repeat=len(counts)):
            assert count_of(list(zip(choice, counts, strict=True))).complex_poses > 0
    assert len(SHIPPED) == 188


def test_kinds_that_do_not_locate_have_no_count():
    assert count_of([("plane", 3), ("sphere", 2)]) is None, "five contacts leave a motion free"
    assert count_of([("plane", 3), ("sphere", 3)]) is None, "the ball turns on its plane"


def test_every_row_is_unique_and_states_its_source():
    kinds = [row["kind"] for row in SHIPPED]
    assert len(set(kinds)) == len(kinds)
    for row in SHIPPED:
        assert row["source"] in ("reference", "reasoned", "tracked")
        features = shipped_kind(row)
        assert sum(n for _, n in features) == 6
        assert pose_counts.kind_of(features) == row["kind"]


@pytest.mark.parametrize("kind", ["sphere1+sphere1+plane3+plane1", "sphere3+sphere1+sphere1+plane1"])
def test_path_tracking_confirms_derived_counts(kind):
    found = solve_by_monodromy(kind, np.random.default_rng(3), idle=4)
    features = list(zip(*feature_list(kind), strict=True))
    assert len(found.roots) == count_of(features).complex_poses


@pytest.mark.slow
def test_path_tracking_finds_every_count_of_many_features():
    """With another seed than those of the study that made the counts."""
    pytest.importorskip("numba", reason="compiled loops need the extra study")
    from tests.validation.compiled_paths import track
    from tests.validation.pose_counts import kinds

    for kind in kinds():
        found = solve_by_monodromy(kind, np.random.default_rng(7), idle=6, follow=track)
        assert len(found.roots) == count_of(list(zip(*feature_list(kind), strict=True))).complex_poses, kind
