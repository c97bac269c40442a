"""The standard deviation of every residual."""

import numpy as np

from tactfix.fixture import Feature, Fixture, Probe
from tactfix.probe import residual_sigmas
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
