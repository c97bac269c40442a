"""The predicted accuracy of a calibrated robot against random draws of the linear model."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.calibration.accuracy import covariance, undetermined

PRIOR = np.array([1.0, 0.5, 2.0])
MATRIX = np.array([[1.0, 2.0, 0.0], [0.5, -1.0, 0.3], [0.0, 0.2, 0.1], [1.0, 1.0, 0.1]])
VARIANCE = 2.0


@pytest.mark.parametrize("believed", [(1.0, 0.5, 2.0), (0.3, 0.15, 2.0), (0.0, 0.0, 2.0)])
def test_the_covariance_is_that_of_draws(believed: tuple[float, ...]) -> None:
    rng = np.random.default_rng(1)
    true = rng.normal(size=(40_000, 3)) * PRIOR
    observed = true @ MATRIX.T + rng.normal(size=(40_000, 4)) * np.sqrt(VARIANCE)
    # Least squares with the rows of the observations above those of the prior; fixed parameters have no column.
    free = np.array(believed) > 0
    stacked = np.vstack([MATRIX[:, free] / np.sqrt(VARIANCE), np.diag(1 / np.array(believed)[free])])
    rows = np.hstack([observed / np.sqrt(VARIANCE), np.zeros((40_000, int(free.sum())))])
    estimate = np.zeros_like(true)
    estimate[:, free] = np.linalg.lstsq(stacked, rows.T, rcond=None)[0].T
    off = (estimate - true) / PRIOR
    found = covariance(MATRIX, PRIOR, np.array(believed), VARIANCE) / np.outer(PRIOR, PRIOR)
    assert found == pytest.approx(off.T @ off / len(off), abs=0.02)


def test_undetermined_is_the_share_left_by_touches_and_tip() -> None:
    moves = np.random.default_rng(2).normal(size=(50, 3, 3))
    tip = np.array([False, False, True])
    nothing, all_of_it = np.zeros((1, 3)), 1e6 * np.eye(3)
    assert undetermined(nothing, PRIOR, tip, moves, 1.0) == pytest.approx(1.0)
    assert undetermined(all_of_it, PRIOR, tip, moves, 1.0) < 1e-5
    # The rows and the sigma of the tip have no influence.
    of_tip = np.array([[0.0, 0.0, 100.0]])
    assert undetermined(of_tip, PRIOR, tip, moves, 1.0) == pytest.approx(1.0)
    assert undetermined(of_tip, PRIOR * [1, 1, 99], tip, moves, 1.0) == pytest.approx(1.0)
    # Two parameters move the tip alike and one is known: the square root of the other's share remains.
    alike = np.stack([moves[:, :, 0], moves[:, :, 0], moves[:, :, 2]], axis=2)
    first = np.array([[1e6, 0.0, 0.0]])
    assert undetermined(first, PRIOR, tip, alike, 1.0) == pytest.approx(np.sqrt(0.25 / 1.25), rel=1e-3)


def test_an_error_that_the_tip_absorbs_counts_as_none() -> None:
    """The first error moves the tip as a tip offset does and is not identified; the second is, to a thousandth."""
    turns = Rotation.from_euler("z", [[0.0], [90.0], [180.0]], degrees=True).as_matrix()
    height = np.array([[0, 0, 0.0], [0, 0, 1], [0, 0, 3]])
    moves = np.concatenate([turns[:, :, :1], height[:, :, None], turns], axis=2)
    tip = np.array([False, False, True, True, True])
    rows = np.array([[0.0, 1e3, 0, 0, 0]])
    assert undetermined(rows, np.ones(5), tip, moves, 1.0) == pytest.approx(1e-3, rel=1e-3)
