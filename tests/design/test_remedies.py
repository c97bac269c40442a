"""The remedy of each finding is applied, and the finding must disappear."""

import re
from dataclasses import replace

import numpy as np
import pytest

from tactfix.design.design_check import design_check
from tactfix.files.fixture_file import load_fixture
from tactfix.geometry.surfaces import Sphere
from tests.support.plans import QUICK, quick_report
from tests.support.project import BAD_DESIGNS


def finding_of(path):
    """The code and remedy stated in the file, and the finding of design-check."""
    code, severity, remedy = re.match(r"# must give: (\w+) (\w+)\n# remedy: (.*)\n", path.read_text()).groups()
    report = quick_report(path)
    return remedy, [f for f in report.findings if (f.code, f.status) == (code, severity)]


@pytest.mark.parametrize("path", sorted(BAD_DESIGNS.glob("*.yaml")), ids=lambda p: p.stem)
def test_the_finding_comes_with_its_remedy(path):
    remedy, found = finding_of(path)
    assert any(remedy in f.hint for f in found), [f.hint for f in found]


def with_move(fixture, hint):
    """The fixture with the feature moved as the hint proposes."""
    name, by, axis = re.search(r"move (\w+) by ([\d.e+-]+) along ([xyz])", hint).groups()
    feature = fixture.features[name]
    step = float(by) * np.eye(3)["xyz".index(axis)]
    key = "center" if isinstance(feature.surface, Sphere) else "point"
    surface = replace(feature.surface, **{key: getattr(feature.surface, key) + step})
    return replace(fixture, features={**fixture.features, name: replace(feature, surface=surface)})


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("balls-square-to-a-bar", "symmetry"),
        ("equal-balls", "equal_features"),
        ("nearly-equal-balls", "equal_features"),
    ],
)
def test_the_move_that_is_proposed_mends_it(name, code):
    fixture = load_fixture(BAD_DESIGNS / f"{name}.yaml")
    (finding,) = [f for f in quick_report(BAD_DESIGNS / f"{name}.yaml").findings if f.code == code and f.status != "ok"]
    after = design_check(with_move(fixture, finding.hint), wishes=QUICK)
    assert not [f for f in after.findings if f.code in (code, "free_motion", "near_symmetry") and f.status != "ok"]


def test_no_move_is_proposed_where_none_helps():
    """Bar and ball have a half-turn wherever the ball is, three faces of a cube the rotations about the diagonal."""
    for name, code in (("ball-beside-bar", "symmetry"), ("corner", "equal_features")):
        report = quick_report(BAD_DESIGNS / f"{name}.yaml")
        hints = [f.hint for f in report.findings if f.code == code and f.status != "ok"]
        assert hints
        assert not any("move" in hint for hint in hints)


def test_a_weakly_determined_direction_is_an_error_with_the_motion():
    report = quick_report(BAD_DESIGNS / "nearly-coaxial.yaml")
    (finding,) = [f for f in report.findings if f.code == "accuracy"]
    assert finding.status == "error"
    assert "underdetermined" in finding.message
    assert "rotat" in finding.hint or "screws" in finding.hint
