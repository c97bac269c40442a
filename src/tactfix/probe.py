"""Tip radius and sigma of contacts still to be made, and the standard deviations of residuals."""

from collections.abc import Iterable

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import UsageError
from tactfix.feature import Feature
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.settings import Setting
from tactfix.units import LEAST_LENGTH, MOST_LENGTH


def probe_settings(
    fixture: Fixture, contacts: Contacts | None, sigma: float | None, tip_radius: float | None
) -> tuple[float, float]:
    """Sigma and tip radius: the arguments, else those of the contacts, else those of the fixture's probe block.

    Raises UsageError if they are not given, or not lengths: nothing is guessed.
    """
    if sigma is None:
        sigma = fixture.probe.sigma if contacts is None else float(contacts.sigmas.max())
    if tip_radius is None:
        tip_radius = fixture.probe.tip_radius if contacts is None else contacts.tip_radius
    if sigma is None or tip_radius is None:
        quantity, setting = ("sigma", Setting.SIGMA) if sigma is None else ("tip radius", Setting.TIP_RADIUS)
        problem = f"{fixture.name}: the {quantity} is not given; "
        raise UsageError(problem + "give " + setting.word + ", or add it to the probe block of the fixture file")
    if not (LEAST_LENGTH <= sigma <= MOST_LENGTH and 0 <= tip_radius <= MOST_LENGTH):
        raise UsageError("sigma must be a length above zero and the tip radius one not below")
    return sigma, tip_radius


def residual_sigmas(fixture: Fixture, contacts: Contacts) -> Floats:
    """Standard deviation (n,) of each residual: the probe's and the feature's own in quadrature."""
    return with_feature_sigmas(contacts.sigmas, (fixture.features[name] for name in contacts.features))


def implied_probe_sigma(contacts: Contacts, sigmas: Floats, factor: float) -> float:
    """The median sigma of the probe with which the sigmas (n,) of the residuals are multiplied by factor.

    The features' sigmas are unchanged: s^2 = factor^2 sigma^2 - feature^2, or 0 if that is negative.
    """
    features = np.square(sigmas) - np.square(contacts.sigmas)
    return float(np.sqrt(max(np.median(np.square(factor * sigmas) - features), 0.0)))


def with_feature_sigmas(probe_sigmas: Floats, features: Iterable[Feature]) -> Floats:
    """Sigmas (n,) of residuals: those (n,) of the probe and of the feature of each contact in quadrature."""
    return np.asarray(np.hypot(probe_sigmas, [feature.sigma for feature in features]))
