"""Case deletion by linearised residuals, against least squares without the deleted contacts."""

from typing import NamedTuple

import numpy as np
import pytest

from tactfix.diagnosis.deletion import CaseDeletion
from tactfix.localization.locate import locate
from tactfix.poses.rigid import rigid_solutions
from tests.support.problems import PLATE, placed, touch_all


class Spoilt(NamedTuple):
    rows: np.ndarray
    deletion: CaseDeletion


@pytest.fixture
def outlier_problem():
    """Forty linear residuals, three of them gross errors, and their derivatives by six unknowns."""
    rng = np.random.default_rng(5)
    rows = rng.standard_normal((40, 6))
    values = rng.standard_normal(40)
    values[[3, 17, 30]] += [400.0, -900.0, 250.0]
    best, *_ = np.linalg.lstsq(rows, values, rcond=None)
    span = np.linalg.qr(rows)[0]
    return Spoilt(rows=rows, deletion=CaseDeletion(values - rows @ best, span))


def chi2_without(rows, residuals, index):
    keep = np.setdiff1d(np.arange(len(rows)), index)
    _, (left,), *_ = np.linalg.lstsq(rows[keep], residuals[keep], rcond=None)
    return left


@pytest.mark.parametrize("index", [[17], [3, 17], [3, 17, 30], [0, 1, 2, 3, 4]])
def test_gain_equals_the_decrease_of_least_squares(outlier_problem, index):
    chi2 = outlier_problem.deletion.scaled @ outlier_problem.deletion.scaled
    left = chi2_without(outlier_problem.rows, outlier_problem.deletion.scaled, index)
    assert outlier_problem.deletion.gain(index) == pytest.approx(chi2 - left, rel=1e-9)
    assert outlier_problem.deletion.remaining_share(index) == pytest.approx(left / chi2, rel=1e-6, abs=1e-12)


def test_outliers_come_first_and_explain_everything(outlier_problem):
    assert outlier_problem.deletion.order[0] == 17
    assert set(outlier_problem.deletion.order[:3]) == {3, 17, 30}
    assert outlier_problem.deletion.is_explained_without([3, 17, 30])
    assert not outlier_problem.deletion.is_explained_without([3, 17])


def test_deleting_a_contact_that_alone_constrains_a_direction_gains_nothing():
    """Deleting a contact that alone determines a direction gains nothing: the pose absorbs its residual."""
    rows = np.vstack([np.eye(6), np.eye(6)[:5]])
    span = np.linalg.qr(rows)[0]
    deletion = CaseDeletion(np.zeros(11), span)
    assert deletion.gain([5]) == 0
    assert deletion.remaining_share([5]) == 1


def test_case_deletion_of_located_contacts_uses_their_residuals():
    truth = touch_all(PLATE, {"plate": 5, "pin": 5, "ball": 5}, np.random.default_rng(1), sigma=0.01)
    contacts = truth.contacts(np.random.default_rng(2))
    result = locate(placed(PLATE), contacts)
    surfaces = {name: feature.surface for name, feature in placed(PLATE).features.items()}
    (best,) = rigid_solutions(surfaces, contacts, contacts.sigmas).found
    deletion = CaseDeletion.of(contacts, contacts.sigmas, best)
    assert deletion.scaled @ deletion.scaled == pytest.approx(result.chi2, rel=1e-9)
    assert np.abs(deletion.span.T @ deletion.scaled).max() < 1e-2, (
        "nothing is left that a motion of the fixture explains"
    )
