"""Mistakes in contacts on fixtures whose shape is not fixed by the relations: named after few fits."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import tactfix
from tactfix.relations import branch_fits
from tactfix.relations.features_alone import thickness
from tactfix.relations.trials import MOST_FITS_FROM_MISS, MOST_TRIAL_FITS, CorrectionTrials
from tests.relations.touched_parts import few_contacts_on
from tests.validation.relation_geometry import KINDS, Angle
from tests.validation.relation_touches import Touched, by_geometry, by_relations, touches


def touched_part(kind, seed=3, angle=60.0):
    """A fixture by relations, with noisy contacts in a rotated base."""
    rng = np.random.default_rng([seed, *kind.encode()])
    part = KINDS[kind].make(Angle(angle, 0.0, angle, 0.0))
    base = np.eye(4)
    base[:3, :3], base[:3, 3] = Rotation.random(random_state=rng).as_matrix(), rng.uniform(-300, 300, 3)
    return part, touches(part, base, rng, nominal=False), rng.standard_normal(40)


def read(part, touched: Touched, noise, folder):
    (folder / "fixture.yaml").write_text(by_relations(part))
    (folder / "contacts.csv").write_text(touched.csv(0.01, noise[: len(touched.names)]))
    fixture = tactfix.load_fixture(folder / "fixture.yaml")
    return fixture, tactfix.load_contacts(folder / "contacts.csv", fixture)


@pytest.fixture
def fits(monkeypatch):
    """A counter of the joint fits started."""
    count, fit = [], branch_fits.joint_fit
    monkeypatch.setattr(branch_fits, "joint_fit", lambda *given: count.append(1) or fit(*given))
    return count


@pytest.mark.parametrize("kind", ["two pins pair by pair", "three faces and ball"])
@pytest.mark.parametrize("factor", [1 / 25.4, 25.4])
def test_a_wrong_unit_is_named_after_few_fits(kind, factor, tmp_path, fits):
    part, touched, noise = touched_part(kind)
    fixture, contacts = read(part, replace(touched, points=touched.points * factor), noise, tmp_path)
    result = tactfix.locate(fixture, contacts)
    assert result.status == "inconsistent"
    assert {cause.code for cause in result.diagnosis} == {"unit"}
    assert result.diagnosis[0].value == pytest.approx(1 / factor)
    # The noise is in the file's unit, so sigma is wrong by the same factor; only the unit is reported.
    assert ["all lengths" in cause.message for cause in result.diagnosis] == [True]
    assert len(fits) <= 2 * MOST_TRIAL_FITS


@pytest.mark.parametrize(("kind", "row"), [("crossed bars", 2), ("crossed bars", 18), ("three bars", 11)])
def test_one_bad_contact_is_named_wherever_it_stands_in_the_file(kind, row, tmp_path):
    """For an undetermined shape and for one of fourteen: neither is known if no pose explains the contacts."""
    part, touched, noise = touched_part(kind)
    points = touched.points.copy()
    points[row] += 1.5 * touched.normals[row]
    fixture, contacts = read(part, replace(touched, points=points), noise, tmp_path)
    result = tactfix.locate(fixture, contacts)
    assert result.status == "inconsistent"
    assert contacts.rows[row] in result.diagnosis[0].rows
    assert {cause.code for cause in result.diagnosis} == {"outlier"}


def test_two_labels_exchanged_are_named(tmp_path):
    part, touched, noise = touched_part("two bars on plate")
    names = list(touched.names)
    names[6], names[20] = names[20], names[6]
    fixture, contacts = read(part, replace(touched, names=tuple(names)), noise, tmp_path)
    causes = tactfix.locate(fixture, contacts).diagnosis
    assert causes[0].code == "swapped_labels"
    assert causes[0].rows == (contacts.rows[6], contacts.rows[20])


def test_of_many_shapes_with_few_contacts_the_pose_is_that_by_geometry(tmp_path):
    """Three contacts on each of three bars do not locate them alone: fourteen shapes are searched."""
    part, touched, noise = touched_part("three bars")
    few = [i for i, name in enumerate(touched.names) if touched.names[:i].count(name) < 3]
    parts = {n: getattr(touched, n)[few] for n in ("points", "normals", "approaches")}
    touched = replace(touched, names=tuple(touched.names[i] for i in few), **parts)
    fixture, contacts = read(part, touched, noise, tmp_path)
    (tmp_path / "geometry.yaml").write_text(by_geometry(part))
    one = tactfix.locate(fixture, contacts, explain=False)
    other = tactfix.locate(tactfix.load_fixture(tmp_path / "geometry.yaml"), contacts, explain=False)
    best = min(one.candidates, key=lambda c: np.abs(c.base_from_fixture - touched.base_from_fixture).max())
    assert one.status in ("located", "ambiguous")
    assert best.base_from_fixture == pytest.approx(other.base_from_fixture, abs=1e-6)


def test_units_are_not_doubted_where_the_fixture_has_no_length(tmp_path):
    """Faces with known angles fit contacts in any unit; in a larger unit only the noise grows."""
    part, touched, noise = touched_part("square block", angle=180.0)
    points = touched.points.copy()
    points[2] += 1.5 * touched.normals[2]
    fixture, contacts = read(part, replace(touched, points=points), noise, tmp_path)
    causes = tactfix.locate(fixture, contacts).diagnosis
    assert causes[0].code == "outlier"
    assert contacts.rows[2] in causes[0].rows
    assert "unit" not in {cause.code for cause in causes}


def test_contacts_bent_more_than_a_radius_allows_are_ruled_out_before_any_fit(tmp_path, fits):
    part, touched, noise = touched_part("bar on plate")
    fixture, contacts = read(part, touched, noise, tmp_path)
    trials = CorrectionTrials(fixture, contacts)
    assert trials.is_feasible(contacts)
    for factor in (1e-3, 25.4):
        assert not trials.is_feasible(replace(contacts, points=contacts.points * factor))
    for factor in (1 / 25.4, 1e-3, 25.4):
        sigmas = contacts.sigmas * factor
        assert not trials.is_feasible(replace(contacts, points=contacts.points * factor, sigmas=sigmas))
    assert not fits


def test_thickness_is_the_rms_distance_from_the_best_plane():
    corners = np.array([[1, 1, 0.2], [1, -1, -0.2], [-1, 1, -0.2], [-1, -1, 0.2]])
    assert thickness(corners) == pytest.approx(0.2)
    assert thickness(corners[:3]) == 0.0


@pytest.mark.parametrize("seed", [1, 2])
def test_one_bad_contact_is_named_where_a_feature_cannot_be_located_alone(seed, tmp_path):
    """With three contacts on each feature, only all together show which contact is off."""
    fixture, contacts, touched = few_contacts_on("bar beside ball on plate", seed, tmp_path, angle=(60.0, 0.02))
    points = contacts.points.copy()
    points[2] += 1.5 * touched.normals[2]
    result = tactfix.locate(fixture, replace(contacts, points=points))
    assert result.status == "inconsistent"
    assert any(contacts.rows[2] in cause.rows for cause in result.diagnosis)


def test_a_correction_that_removes_a_feature_keeps_the_fits_of_others(tmp_path):
    """Fits from the nearest miss have a limit of their own."""
    part, touched, noise = touched_part("bar on plate")
    fixture, contacts = read(part, touched, noise, tmp_path)
    trials = CorrectionTrials(fixture, contacts)
    lost = contacts.subset([i for i in range(len(contacts)) if i not in contacts.by_feature["bar"][2:]])
    trials.solutions(lost)
    for _ in range(MOST_FITS_FROM_MISS + 1):
        trials.solutions(contacts)
    assert not trials.is_cut
