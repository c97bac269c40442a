"""The study of random layouts: reproducible, its counts agree with locate, and it ends when all layouts are located."""

from itertools import pairwise
from statistics import median

import numpy as np
import pytest

from tactfix.design.design_check import design_check
from tactfix.design.design_report import Wishes
from tactfix.design.plan_findings import study_findings
from tactfix.design.random_layouts import LayoutStudy, Study, UniqueShare, study_layouts
from tactfix.errors import UsageError
from tactfix.files.fixture_file import load_fixture
from tactfix.localization.locate import locate
from tactfix.simulation.simulate import simulate
from tests.support.plans import quick_report
from tests.support.project import BAD_DESIGNS, ROOT

SETS = [("3-2-1", {"right": 3, "back": 2, "top": 1}), ("2-2-2", {"right": 2, "back": 2, "top": 2})]


def studied(tried=None, layouts=6, seed=4, sets=SETS, progress=lambda share, stage: None):
    """A study of the cube; the contacts of each call of locate are appended to tried."""
    fixture = load_fixture(ROOT / "fixtures" / "three-planes.yaml")

    def locator(contacts):
        if tried is not None:
            tried.append(contacts)
        return locate(fixture, contacts, explain=False)

    return study_layouts(fixture, Study(layouts, seed, 0.05, 1.5), sets, locator, progress=progress)


@pytest.fixture(scope="module")
def known():
    tried = []
    return studied(tried), tried


def test_one_seed_gives_one_study(known):
    study, tried = known
    again = []
    assert studied(again) == study
    assert [c.points.tolist() for c in again] == [c.points.tolist() for c in tried]
    other = []
    studied(other, seed=5)
    assert [c.points.tolist() for c in other] != [c.points.tolist() for c in tried]


def test_layouts_begin_with_the_minimal_sets_in_turn(known):
    _, tried = known
    first = tried[:6]
    for k, contacts in enumerate(first):
        assert len(contacts) == 6
        assert {name: contacts.features.count(name) for name in SETS[0][1]} == SETS[k % 2][1]


def test_shares_agree_with_locate_and_end_at_zero(known):
    study, tried = known
    assert [s.contacts for s in study.shares] == list(range(6, 6 + len(study.shares)))
    fixture = load_fixture(ROOT / "fixtures" / "three-planes.yaml")
    for share in study.shares:
        statuses = [locate(fixture, c, explain=False).status for c in tried if len(c) == share.contacts]
        assert share.ambiguous == statuses.count("ambiguous") / 6
        assert share.underdetermined == statuses.count("underdetermined") / 6
    assert study.shares[-1].ambiguous == study.shares[-1].underdetermined == 0
    assert all(a.ambiguous + a.underdetermined > 0 for a, _ in pairwise(study.shares))


def test_a_located_layout_is_not_located_again(known):
    study, tried = known
    left = [round(6 * (s.ambiguous + s.underdetermined)) for s in study.shares]
    assert [sum(len(c) == s.contacts for c in tried) for s in study.shares] == [6, *left[:-1]]
    longest = max(tried, key=len)
    shorter = [c for c in tried if len(c) < len(longest) and c.points.tolist() == longest.points[: len(c)].tolist()]
    assert len(shorter) == len(longest) - 6, "each layout goes on where it was"


def test_real_poses_are_those_of_six_contacts(known):
    study, tried = known
    fixture = load_fixture(ROOT / "fixtures" / "three-planes.yaml")
    results = [locate(fixture, c, explain=False) for c in tried[:6]]
    for k, kind in enumerate(("3-2-1", "2-2-2")):
        entry = study.real_poses[kind]
        counts = [len(r.candidates) for r in results[k::2] if r.status != "underdetermined"]
        assert (entry.layouts, entry.fewest_seen, entry.most_seen) == (len(counts), min(counts), max(counts))
        assert entry.median == median(counts)
        # Three planes 3-2-1: four, two for the side of the first and two for that of the second; at most eight.
        assert entry.most_seen <= (4, 8)[k]
    assert study.real_poses["3-2-1"].most_seen == 4


def test_many_minimal_sets_are_tried_from_all_along_their_list():
    sets = [(f"set {k}", dict(zip(("right", "back", "top"), c, strict=True))) for k, c in enumerate(
        [(3, 2, 1), (3, 1, 2), (2, 3, 1), (2, 2, 2), (2, 1, 3), (1, 3, 2), (1, 2, 3)]
    )]  # fmt: skip
    tried = []
    studied(tried, layouts=3, sets=sets)
    assert [tuple(c.features.count(n) for n in ("right", "back", "top")) for c in tried[:3]] == [
        (3, 2, 1), (2, 3, 1), (2, 1, 3)
    ]  # fmt: skip


def test_no_study_if_it_is_disabled_or_impossible():
    assert quick_report(ROOT / "fixtures" / "three-planes.yaml").study.shares == ()
    for name in ("ball-under-the-plate", "nearly-coaxial", "prism"):
        # A ball that cannot be touched, a weakly determined rotation, a free one: no layout would be located.
        assert design_check(load_fixture(BAD_DESIGNS / f"{name}.yaml")).study.shares == ()


def test_an_unbroken_symmetry_leaves_every_layout_ambiguous_and_is_not_tried_further():
    report = design_check(load_fixture(BAD_DESIGNS / "ball-beside-bar.yaml"), wishes=Wishes(layouts=2))
    assert [(s.contacts, s.ambiguous + s.underdetermined) for s in report.study.shares] == [(6, 1.0)]
    assert "uniqueness" not in {f.code for f in report.findings}
    assert all(entry is None or entry.fewest_seen >= 2 for entry in report.real_poses)


def test_the_study_reports_progress():
    shares = []
    studied(layouts=2, progress=lambda share, stage: shares.append(share))
    assert shares == sorted(shares)
    assert 0 <= shares[0] <= shares[-1] < 1


def test_real_poses_never_exceed_the_complex_ones():
    fixture = load_fixture(ROOT / "fixtures" / "cylinder-sphere.yaml")
    sets = [("4+2", {"bar": 4, "ball": 2}), ("3+3", {"bar": 3, "ball": 3})]
    study = Study(6, 1, fixture.probe.sigma, 0.0)
    found = study_layouts(fixture, study, sets, lambda c: locate(fixture, c, explain=False), up_to=6)
    assert len(found.shares) == 1
    for kind, most in (("4+2", 96), ("3+3", 48)):
        entry = found.real_poses[kind]
        assert 1 < entry.fewest_seen <= entry.median <= entry.most_seen <= most


@pytest.mark.parametrize(("left", "severity"), [(0.0, "ok"), (0.25, "ok"), (0.5, "warning")])
def test_the_finding_warns_where_many_layouts_are_left(left, severity):
    shares = (UniqueShare(6, 8, 0.75, 0.25), UniqueShare(7, 8, left, 0.0))
    (finding,) = study_findings(LayoutStudy(shares), is_symmetric=False)
    assert (finding.code, finding.status) == ("uniqueness", severity)
    assert f"of 8 random layouts 100 % with 6, {100 * left:.0f} % with 7 contacts" in finding.message
    assert bool(finding.hint) == (severity == "warning")
    assert list(study_findings(LayoutStudy(), is_symmetric=False)) == []


def test_impossible_layouts_are_reported(monkeypatch):
    def refuse(*arguments, **wishes):
        raise UsageError("top cannot be touched 4 times")

    monkeypatch.setattr("tactfix.design.random_layouts.simulate", refuse)
    report = design_check(load_fixture(ROOT / "fixtures" / "three-planes.yaml"), wishes=Wishes(layouts=1))
    (finding,) = [f for f in report.findings if f.code == "uniqueness"]
    assert finding.status == "warning"
    assert "top cannot be touched 4 times" in finding.message
    assert "leave the study out" in finding.hint
    assert report.study.shares == ()


def test_the_study_does_not_depend_on_given_contacts():
    """Contacts that leave a motion free are a bad plan; the study of the fixture does not depend on them."""
    fixture = load_fixture(ROOT / "fixtures" / "three-planes.yaml")
    contacts = simulate(fixture, base_from_fixture=np.eye(4), sigma=1e-6, seed=1).contacts
    few = contacts.subset([i for i, name in enumerate(contacts.features) if name != "top"])
    report = design_check(fixture, few, Wishes(layouts=1))
    assert report.certainty is None
    assert report.study.shares[0].layouts == 1
