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
def spoilt():
    """Forty linear residuals, three of them gross errors, and their derivatives by six unknowns."""
    rng = np.random.default_rng(5)
    rows = rng.standard_normal((40, 6))
    values = rng.standard_normal(40)
    values[[3, 17, 30]] += [400.0, -900.0, 250.0]
    best, *_ = np.linalg.lstsq(rows, values, rcond=None)
    span = np.linalg.qr(rows)[0]
    return Spoilt(rows=rows, deletion=CaseDeletion(values - rows @ best, span))


def left_without(rows, residuals, index):
    keep = np.setdiff1d(np.arange(len(rows)), index)
    _, (left,), *_ = np.linalg.lstsq(rows[keep], residuals[keep], rcond=None)
    return left


@pytest.mark.parametrize("index", [[17], [3, 17], [3, 17, 30], [0, 1, 2, 3, 4]])
def test_gain_is_what_least_squares_without_them_gains(spoilt, index):
    chi2 = spoilt.deletion.scaled @ spoilt.deletion.scaled
    left = left_without(spoilt.rows, spoilt.deletion.scaled, index)
    assert spoilt.deletion.gain(index) == pytest.approx(chi2 - left, rel=1e-9)
    assert spoilt.deletion.remaining_share(index) == pytest.approx(left / chi2, rel=1e-6, abs=1e-12)


def test_those_that_are_off_are_doubted_first_and_are_all(spoilt):
    assert spoilt.deletion.order[0] == 17
    assert set(spoilt.deletion.order[:3]) == {3, 17, 30}
    assert spoilt.deletion.is_explained_without([3, 17, 30])
    assert not spoilt.deletion.is_explained_without([3, 17])


def test_what_a_contact_alone_holds_is_no_gain():
    """Deleting a contact that alone determines a direction gains nothing: the pose absorbs its residual."""
    rows = np.vstack([np.eye(6), np.eye(6)[:5]])
    span = np.linalg.qr(rows)[0]
    deletion = CaseDeletion(np.zeros(11), span)
    assert deletion.gain([5]) == 0
    assert deletion.remaining_share([5]) == 1


def test_the_doubts_of_located_contacts_are_their_residuals():
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
