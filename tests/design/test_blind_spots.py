"""Predicted blind spots against simulation: each mistake is simulated with noise and located many times."""

import re
from pathlib import Path

import numpy as np
import pytest

from tactfix.contacts import Contacts
from tactfix.design.blind_spot import power_of
from tactfix.design.design_check import design_check
from tactfix.files.fixture_file import load_fixture
from tactfix.localization.locate import locate
from tactfix.simulation.faults import Fault
from tactfix.simulation.simulate import simulate
from tests.support.plans import QUICK
from tests.support.project import ROOT

CORNER = Path(__file__).parent / "bad" / "corner.yaml"
FAULTS = {"tip_radius": "forgotten-tip", "pretravel": "late-trigger", "scale": "thermal-growth"}
SEEDS = 4


def quiet_plan(fixture, count):
    """Simulated touches without noise."""
    contacts = simulate(fixture, base_from_fixture=np.eye(4), sigma=1e-7, seed=11, count=count).contacts
    n = len(contacts)
    sigma = fixture.probe.sigma
    return Contacts(
        contacts.features,
        contacts.points,
        contacts.approaches,
        np.full(n, sigma),
        contacts.tip_radius,
        contacts.rows,
        contacts.ids,
    )


# A fixture by relations; fixtures by geometry are in test_blind_spots_simulated.py.
CASES = [(ROOT / "fixtures/three-spheres.yaml", error) for error in FAULTS]


@pytest.mark.parametrize(("path", "error"), CASES, ids=[f"{p.stem}-{error}" for p, error in CASES])
def test_locate_confirms_predicted_blind_spots(path, error):
    fixture = load_fixture(path)
    plan = quiet_plan(fixture, 18)
    report = design_check(fixture, plan, wishes=QUICK)
    spot = next(s for s in report.blind_spots if s.error == error)
    flagged, shifts = 0, []
    corners = np.array([report.certainty.worst.point])
    for seed in range(SEEDS):
        contacts = simulate(
            fixture, plan=plan, base_from_fixture=np.eye(4), seed=seed, fault=Fault(FAULTS[error])
        ).contacts
        result = locate(fixture, contacts, explain=False)
        doubted = any("sigma" in w for w in result.warnings)
        flagged += result.status != "located" or doubted
        if result.base_from_fixture is not None:
            pose = result.base_from_fixture
            shifts.append(np.linalg.norm(corners @ pose[:3, :3].T + pose[:3, 3] - corners, axis=1).max())
    if spot.detectable:
        assert flagged >= SEEDS - 1
    elif spot.power < 0.01:
        assert flagged <= 1
        # The corner that the mistake moves most need not be the one with the largest sigma, but no point moves farther.
        assert np.median(shifts) <= spot.pose_shift + 3 * report.certainty.worst.sigma
        if error == "tip_radius":
            assert np.median(shifts) == pytest.approx(spot.pose_shift, rel=0.05)


def test_power_is_that_of_a_simulated_chi_square():
    """The share of simulated noncentral chi-squares above the limit of 1 in 1000 (tables: 22.458 for 6)."""
    rng = np.random.default_rng(5)
    for noncentrality in (5.0, 20.0, 40.0):
        z = rng.normal(size=(200_000, 6))
        z[:, 0] += np.sqrt(noncentrality)
        share = ((z**2).sum(axis=1) > 22.4577).mean()
        assert power_of(noncentrality, 6) == pytest.approx(share, abs=0.005)
    assert power_of(1e9, 6) == 1.0
    assert power_of(0.0, 0) == 0.0


def test_a_bad_contact_is_detected_by_its_redundancy():
    """One contact off by 10 sigma has the noncentrality 100 (1 - leverage), with the leverage from plain algebra."""
    fixture = load_fixture(ROOT / "fixtures/robot-cell-plate.yaml")
    plan = quiet_plan(fixture, 12)
    report = design_check(fixture, plan, wishes=QUICK)
    spot = next(s for s in report.blind_spots if s.error == "contact")
    surfaces = {name: f.surface for name, f in fixture.features.items()}
    rows = []
    for name, p in zip(plan.features, plan.points, strict=True):
        s = surfaces[name]
        if name == "plate":
            n = s.normal
        elif name == "ball":
            n = (p - s.center) / np.linalg.norm(p - s.center)
        else:
            n = np.array([p[0], p[1], 0.0]) / np.hypot(p[0], p[1])
        rows.append(np.concatenate([n, np.cross(p, n)]))
    sigmas = np.array([np.hypot(0.08, fixture.features[n].sigma) for n in plan.features])
    a = np.array(rows) / sigmas[:, None]
    hat = a @ np.linalg.pinv(a)
    powers = [power_of(100 * (1 - h), 6) for h in np.diag(hat)]
    row = int(re.match(r"row (\d+) ", spot.message).group(1))
    assert spot.power == pytest.approx(powers[row - 1], abs=0.02)
    assert spot.detectable == (min(powers) >= 0.95)


def test_exchanged_labels_of_equal_balls_are_not_detected():
    fixture = load_fixture(Path(__file__).parent / "bad" / "equal-balls.yaml")
    spot = next(s for s in design_check(fixture, wishes=QUICK).blind_spots if s.error == "labels")
    assert not spot.detectable
    contacts = simulate(fixture, base_from_fixture=np.eye(4), seed=2).contacts
    other = {"left": "right", "right": "left", "far": "far"}
    swapped = Contacts(
        tuple(other[n] for n in contacts.features),
        contacts.points,
        contacts.approaches,
        contacts.sigmas,
        contacts.tip_radius,
        contacts.rows,
        contacts.ids,
    )
    result = locate(fixture, swapped)
    assert result.status == "located"
    assert result.base_from_fixture[0, 0] == pytest.approx(-1, abs=1e-3), "half a turn off"


def test_a_wrong_unit_fits_only_planes_without_boxes():
    text = CORNER.read_text()
    import tempfile

    def spot_of(text):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "f.yaml"
            path.write_text(text)
            return next(s for s in design_check(load_fixture(path), wishes=QUICK).blind_spots if s.error == "unit")

    bare = text[: text.index("touch:")].replace("tip_radius: 3.0", "tip_radius: 0.0")
    assert not spot_of(bare).detectable
    assert spot_of(text).detectable
