"""The standard deviation of each residual."""

import numpy as np
import pytest

from tactfix.feature import Feature
from tactfix.fixture import Fixture, Probe
from tactfix.probe import implied_probe_sigma, residual_sigmas
from tests.support.touched_fixtures import problem


def test_sigmas_of_probe_and_feature_add_in_quadrature():
    surfaces, _, contacts = problem("plate")
    features = {
        name: Feature(name, "plane", None, "outer", 0.015 if name == "pin" else 0.0, surface)
        for name, surface in surfaces.items()
    }
    fixture = Fixture("plate", "mm", Probe(), features, (), None, {})
    found = residual_sigmas(fixture, contacts)
    on_pin = np.array(contacts.features) == "pin"
    np.testing.assert_allclose(found[on_pin], 0.025)
    np.testing.assert_allclose(found[~on_pin], 0.02)


def test_another_sigma_of_the_probe_leaves_the_features_their_own():
    _, _, contacts = problem("plate")
    assert implied_probe_sigma(contacts, np.full(len(contacts), 0.02), 3.0) == pytest.approx(0.06)
    residuals = np.hypot(0.02, np.full(len(contacts), 0.015))
    assert np.hypot(implied_probe_sigma(contacts, residuals, 3.0), 0.015) == pytest.approx(3 * 0.025)
    assert implied_probe_sigma(contacts, residuals, 0.5) == 0.0
