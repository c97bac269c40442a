"""The limits of chi-square against scipy, which the package does not import."""

import numpy as np
import pytest
from scipy.stats import chi2

from tactfix.noise import REJECTED_IN_ERROR, SUSPICIOUS, chi_square_limit


@pytest.mark.parametrize("dof", [1, 2, 3, 4, 7, 12, 30, 100, 999, 5_000, 9_994, 100_000, 1_000_000])
@pytest.mark.parametrize("probability", [0.05, SUSPICIOUS, REJECTED_IN_ERROR, 1e-12])
def test_limit_is_scipys_quantile(dof, probability):
    assert chi_square_limit(dof, probability) == pytest.approx(chi2.isf(probability, dof), rel=1e-7)


@pytest.mark.parametrize("dof", [0, -1, -5])
def test_without_redundancy_one_degree_counts(dof):
    assert chi_square_limit(dof) == chi_square_limit(1)


def test_limit_grows_with_the_degrees_of_freedom():
    assert (np.diff([chi_square_limit(dof) for dof in range(1, 400)]) > 0).all()
