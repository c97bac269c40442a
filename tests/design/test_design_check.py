"""Each shipped fixture and each deliberately bad fixture gives the expected finding."""

import re
from pathlib import Path

import numpy as np
import pytest

from tactfix.design.design_check import design_check
from tactfix.design.design_report import Wishes
from tactfix.errors import UsageError
from tactfix.explanations import explanation, explanations
from tactfix.files.fixture_file import load_fixture
from tactfix.mistakes import BLIND_SPOTS
from tactfix.simulation.simulate import simulate
from tests.support.plans import QUICK, contacts_of, plan_at, quick_report
from tests.support.project import BAD_DESIGNS, ROOT

# Expected status and finding: code, severity, words of the message, and words of the remedy.
SHIPPED = {
    "cylinder-sphere": ("warning", ("blind_distance", "warning", "farther from", "have the fixture measured")),
    "machine-tool-ball-bar": ("ok", ("symmetry", "ok", "no motion maps", "")),
    "robot-cell-plate": ("ok", ("blind_tip_radius", "ok", "the residuals show it", "")),
    "three-planes": ("error", ("blind_tip_radius", "error", "off by 2.6 mm", "opposite face, a bore or a sphere")),
    "three-spheres": ("ok", ("margin", "ok", "no wrong pose", "")),
}


def checked(name):
    return quick_report(ROOT / "fixtures" / f"{name}.yaml")


def codes(report, *severities):
    return {f.code for f in report.findings if f.status in severities}


def test_there_are_at_least_five_bad_fixtures():
    assert len(list(BAD_DESIGNS.glob("*.yaml"))) >= 5


@pytest.mark.parametrize("path", sorted(BAD_DESIGNS.glob("*.yaml")), ids=lambda p: p.stem)
def test_bad_fixture(path):
    code, severity = re.match(r"# must give: (\w+) (\w+)\n", path.read_text()).groups()
    report = quick_report(path)
    assert code in codes(report, severity)
    assert report.status == severity or (severity == "warning" and report.status == "error")
    assert all(f.hint for f in report.findings if f.status != "ok"), "each finding says what to do"


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_fixture(name):
    status, (code, severity, words, remedy) = SHIPPED[name]
    report = checked(name)
    assert report.status == status
    (finding,) = [f for f in report.findings if f.code == code]
    assert finding.status == severity
    assert words in finding.message
    assert remedy in finding.hint
    assert bool(finding.hint) == (severity != "ok")
    assert len(codes(report, "error")) == (status == "error")


def test_the_touch_box_of_the_worked_example_settles_its_half_turn():
    (finding,) = [f for f in checked("cylinder-sphere").findings if f.code == "symmetry"]
    assert (finding.status, "1 by touch" in finding.message) == ("ok", True)


def test_a_forgotten_tip_of_3_mm_moves_a_corner_by_5_2_mm_undetected():
    """Theory: each face moves by the tip radius along its normal, so the corner moves by 3 sqrt 3."""
    report = quick_report(BAD_DESIGNS / "corner.yaml")
    spots = {spot.error: spot for spot in report.blind_spots}
    assert not spots["tip_radius"].detectable
    assert spots["tip_radius"].pose_shift == pytest.approx(3 * np.sqrt(3), rel=1e-9)
    assert spots["tip_sign"].pose_shift == pytest.approx(6 * np.sqrt(3), rel=1e-9)


def test_an_opposite_face_or_a_ball_shows_the_tip():
    """The remedy proposed by the finding is tried."""
    text = (BAD_DESIGNS / "corner.yaml").read_text()
    for feature in (
        "  left: {type: plane, point: [-100.0, 0.0, 0.0], normal: [-1.0, 0.0, 0.0]}\n",
        "  ball: {type: sphere, radius: 12.7, center: [-50.0, -50.0, 60.0]}\n",
    ):
        report = design_check(_written(text.replace("touch:\n", feature + "touch:\n")), wishes=QUICK)
        assert "blind_tip_radius" not in codes(report, "warning", "error")


def _written(text, tmp=None):
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        path = Path(folder) / "fixture.yaml"
        path.write_text(text)
        return load_fixture(path)


def test_the_touch_box_that_the_remedy_proposes_breaks_the_symmetry():
    text = (BAD_DESIGNS / "ball-beside-bar.yaml").read_text()
    report = design_check(_written(text), wishes=QUICK)
    hint = next(f.hint for f in report.findings if f.code == "symmetry")
    line = re.search(r"touch: (bar: \{y: \[[^]]*\]\})", hint).group(1)
    mended = design_check(_written(f"{text}touch:\n  {line}\n"), wishes=QUICK)
    assert [s.broken_by for s in mended.symmetries] == ["touch"]
    assert "symmetry" not in codes(mended, "error")


def test_contacts_outside_the_overlap_settle_it():
    """Only a plan with contacts outside the part that both poses share, between -20 and 20, distinguishes the poses."""
    fixture = load_fixture(BAD_DESIGNS / "box-across-the-middle.yaml")
    settled, open_ = (
        design_check(fixture, plan_at((-15, 55)), wishes=QUICK),
        design_check(fixture, plan_at((-15, 15)), wishes=QUICK),
    )
    assert "symmetry_overlap" in codes(settled, "warning")
    assert "symmetry_overlap" not in codes(settled, "error")
    assert "symmetry_overlap" in codes(open_, "error")


def test_contacts_in_base_are_located_and_give_the_same_certainty_as_their_plan():
    fixture = load_fixture(ROOT / "fixtures" / "robot-cell-plate.yaml")
    here = simulate(fixture, base_from_fixture=np.eye(4), sigma=1e-6, seed=5, count=12).contacts
    plan = contacts_of(here.features, here.points, here.approaches, 0.08, here.tip_radius)
    contacts = simulate(fixture, plan=plan, seed=7).contacts
    planned, measured = design_check(fixture, plan, wishes=QUICK), design_check(fixture, contacts, wishes=QUICK)
    assert (planned.certainty.source, measured.certainty.source) == ("plan", "contacts")
    assert np.linalg.norm(contacts.points - plan.points, axis=1).min() > 100
    np.testing.assert_allclose(measured.certainty.covariance, planned.certainty.covariance, rtol=0.02, atol=1e-6)


def test_inconsistent_contacts_are_reported():
    fixture = load_fixture(ROOT / "fixtures" / "robot-cell-plate.yaml")
    contacts = simulate(fixture, seed=1).contacts
    wrong = contacts_of(
        contacts.features, contacts.points * [1.0, 1.0, 0.5], contacts.approaches, 0.08, contacts.tip_radius
    )
    report = design_check(fixture, wrong, wishes=QUICK)
    assert "contacts_not_located" in codes(report, "error")
    assert report.certainty.source == "spread"


def test_contacts_that_leave_a_motion_free_are_an_error():
    fixture = load_fixture(ROOT / "fixtures" / "robot-cell-plate.yaml")
    contacts = simulate(fixture, base_from_fixture=np.eye(4), sigma=1e-6, seed=1).contacts
    report = design_check(
        fixture, contacts.subset([i for i, name in enumerate(contacts.features) if name != "ball"]), wishes=QUICK
    )
    finding = next(f for f in report.findings if f.code == "plan_free_motion")
    assert finding.status == "error"
    assert "rotates about the axis of pin" in finding.message


def test_a_plan_of_six_contacts_has_no_redundancy():
    fixture = load_fixture(ROOT / "fixtures" / "robot-cell-plate.yaml")
    plan = simulate(fixture, base_from_fixture=np.eye(4), sigma=1e-6, seed=3, count=6).contacts
    report = design_check(fixture, plan, wishes=QUICK)
    assert "no_redundancy" in codes(report, "warning")
    assert not any(s.detectable for s in report.blind_spots if s.error in ("pretravel", "contact", "distance"))


def test_no_accuracy_is_reported_without_sigma():
    text = (BAD_DESIGNS / "equal-balls.yaml").read_text().replace(", sigma: 0.01", "")
    report = design_check(_written(text), wishes=QUICK)
    assert "sigma_missing" in codes(report, "warning")
    assert report.certainty is None
    assert report.blind_spots == ()
    assert design_check(_written(text), wishes=Wishes(sigma=0.01, layouts=0)).certainty is not None


def test_max_sigma_is_a_gate():
    fixture = load_fixture(ROOT / "fixtures" / "robot-cell-plate.yaml")
    sigma = checked("robot-cell-plate").certainty.worst.sigma
    assert "accuracy" in codes(design_check(fixture, wishes=Wishes(max_sigma=0.99 * sigma, layouts=0)), "error")
    assert "accuracy" not in codes(design_check(fixture, wishes=Wishes(max_sigma=1.01 * sigma, layouts=0)), "error")


def test_the_verdict_does_not_depend_on_the_unit():
    text = (ROOT / "fixtures" / "robot-cell-plate.yaml").read_text()
    number = r"(?<![\w.])-?\d+\.\d+"
    features, touch = text.index("features:"), len(text)
    in_metres = (
        text[: text.index("probe:")].replace("units: mm", "units: m")
        + "probe:\n  tip_radius: 0.003\n  sigma: 0.00008\n"
    )
    lines = []
    for line in text[features:touch].splitlines():
        fixed = re.sub(r"(normal|direction): \[[^]]*\]", lambda m: m.group().replace(".0", "@0"), line.split("#")[0])
        lines.append(re.sub(number, lambda m: repr(float(m.group()) / 1000), fixed).replace("@0", ".0"))
    here, there = (
        checked("robot-cell-plate"),
        design_check(_written(in_metres + "\n".join(lines) + "\n"), wishes=QUICK),
    )
    assert [(f.code, f.status) for f in here.findings] == [(f.code, f.status) for f in there.findings]
    # Rounding decides which of several equally well distributed points of a square face are chosen.
    assert there.certainty.worst.sigma == pytest.approx(here.certainty.worst.sigma / 1000, rel=0.02)
    assert there.certainty.observability.indices == pytest.approx(here.certainty.observability.indices, rel=0.02)


def test_foreign_contacts_are_refused():
    fixture = load_fixture(ROOT / "fixtures" / "robot-cell-plate.yaml")
    foreign = contacts_of(["bowl"], np.zeros((1, 3)), np.array([[0, 0, -1.0]]), 0.01, 0.0)
    with pytest.raises(UsageError, match="bowl"):
        design_check(fixture, foreign)


def test_every_finding_has_an_explanation_of_about_ten_lines():
    sources = [*(ROOT / "src/tactfix/design").glob("*.py")]
    text = "".join(path.read_text() for path in sources)
    found = set(re.findall(r'Finding\(\s*"(\w+)"', text))
    found |= {f"blind_{code}" for code in BLIND_SPOTS}
    assert found == set(explanations("design"))
    for code in found:
        lines = explanations("design")[code].splitlines()
        assert 7 <= len(lines) <= 12, code
        assert max(map(len, lines)) <= 79, code
    with pytest.raises(UsageError, match="did you mean 'symmetry'"):
        explanation("design", "symetry")
