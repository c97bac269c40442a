"""Fixtures and contacts built in Python: checked by the same rules as files, and written as files."""

import sys
from pathlib import Path

import numpy as np
import pytest

import tactfix
from tactfix import Feature, Fixture
from tests.support.project import ROOT

SHIPPED = sorted((ROOT / "fixtures").glob("*.yaml"))
PLATE = {
    "plate": Feature.plane((0, 0, 0), (0, 0, 2.0), sigma=0.01),
    "pin": Feature.cylinder(10.0, (0, 0, 0), (0, 0, 1)),
    "ball": Feature.sphere(19.05, (300, 180, 60)),
    "seat": Feature.point((50.0, 20.0, -3.0)),
}


def plain(fixture: Fixture) -> dict:
    return fixture.to_dict()


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_fixture_is_written_as_it_was_read(path: Path) -> None:
    fixture = tactfix.load_fixture(path)
    again = Fixture.from_text(fixture.to_yaml())
    assert again.to_yaml() == fixture.to_yaml()
    assert plain(Fixture.from_dict(fixture.to_dict())) == plain(fixture)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_written_fixture_locates_the_same(path: Path) -> None:
    fixture = tactfix.load_fixture(path)
    contacts = tactfix.load_contacts(ROOT / "samples" / path.stem / "contacts.csv", fixture)
    one, other = (tactfix.locate(each, contacts) for each in (fixture, Fixture.from_text(fixture.to_yaml())))
    assert one.status == other.status == "located"
    np.testing.assert_allclose(one.base_from_fixture, other.base_from_fixture, rtol=0, atol=1e-9)


def test_a_fixture_made_of_features() -> None:
    fixture = Fixture.from_features("plate", "mm", PLATE, touch={"pin": {"z": (6.0, None)}})
    assert fixture.is_placed
    assert fixture.features["pin"].name == "pin"
    np.testing.assert_allclose(fixture.features["plate"].surface.normal, (0, 0, 1))
    assert fixture.touch["pin"].low[2] == 6.0
    assert "type: point" in fixture.to_yaml()


def test_a_placement_is_written_too() -> None:
    near = [[0, -1, 0, 5], [1, 0, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1]]
    document = Fixture.from_features("plate", "mm", PLATE).to_dict()
    document["placement"] = {
        "near": {"matrix": near},
        "within": {"translation": 20.0, "rotation": 5.0},
        "free": ["x", "rz"],
    }
    fixture = Fixture.from_text(Fixture.from_dict(document).to_yaml())
    np.testing.assert_array_equal(fixture.placement.near, near)
    assert fixture.placement.within == pytest.approx((20.0, np.deg2rad(5.0)), rel=1e-12)
    assert fixture.placement.free == {"x", "rz"}


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Feature.sphere(0.0), "radius of a sphere"),
        (lambda: Feature.sphere(float("nan")), "radius of a sphere"),
        (lambda: Feature.cylinder(1.0, (0, 0, 0)), "point and direction"),
        (lambda: Feature.cylinder(1.0, (0, 0, 0), (0, 0, 0)), "direction of a cylinder is zero"),
        (lambda: Feature.plane((0, 0), (0, 0, 1)), "three finite numbers"),
        (lambda: Feature.plane((0, 0, np.inf), (0, 0, 1)), "three finite numbers"),
        (lambda: Feature.sphere(1.0, side="within"), "outer or inner"),
        (lambda: Feature.point((0, 0, 0), sigma=-1.0), "sigma of a point"),
    ],
)
def test_features_that_cannot_be_are_refused(make, says: str) -> None:
    with pytest.raises(tactfix.UsageError, match=says):
        make()


def test_all_errors_are_reported_at_once() -> None:
    document = Fixture.from_features("plate", "mm", PLATE).to_dict()
    document["features"]["ball"]["radius"] = np.float64(-1.0)
    document["tuch"] = {}
    with pytest.raises(tactfix.FileError) as caught:
        Fixture.from_dict(document)
    message = str(caught.value)
    assert "features.ball.radius is -1.0" in message
    assert "did you mean 'touch'" in message


def contacts() -> tactfix.Contacts:
    points = np.arange(15.0).reshape(5, 3)
    return tactfix.contacts_from_arrays(["a", "b", "a", "b", "a"], points, sigma=0.1, tip_radius=1.0)


def test_masks_slices_and_indices() -> None:
    all_of_them = contacts()
    mask = np.array(all_of_them.features) == "a"
    assert all_of_them[mask].rows == all_of_them.subset(mask).rows == (1, 3, 5)
    assert all_of_them[1:3].rows == (2, 3)
    assert all_of_them[[4, 0]].rows == (5, 1)
    assert all_of_them[~mask].features == ("b", "b")
    with pytest.raises(tactfix.UsageError, match="one boolean for each"):
        all_of_them.subset([True, False])


def test_joining() -> None:
    one, other = contacts()[:2], contacts()[2:]
    joined = one + other
    np.testing.assert_array_equal(joined.points, contacts().points)
    assert joined.rows == contacts().rows
    bigger = tactfix.contacts_from_arrays("a", [[0, 0, 0]], sigma=0.1, tip_radius=2.0)
    with pytest.raises(tactfix.UsageError, match="different tips"):
        _ = one + bigger
    assert repr(joined) == "<Contacts: 5 (a 3, b 2), tip radius 1>"


def test_a_dataframe() -> None:
    frame = contacts().to_dataframe()
    assert list(frame.columns) == ["feature", "x", "y", "z", "ax", "ay", "az", "sigma", "id"]
    assert frame.loc[3, "z"] == 8.0
    assert frame["feature"].tolist() == ["a", "b", "a", "b", "a"]


def test_without_pandas_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(tactfix.MissingExtraError, match=r"pip install '\.\[dataframe\]'"):
        contacts().to_dataframe()
