"""The covariance of a point of the fixture, and the limits that make a located pose acceptable."""

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import skew
from tactfix.locate_result import LocateResult


def point_covariance(base_from_fixture: Floats, covariance: Floats, points_fixture: Floats) -> Floats:
    """Covariances (..., 3, 3) in base axes of points (..., 3) of the fixture frame.

    x = R p + t moves by d_x = d_rot x (R p) + d_t, so that cov_x = J cov J^T with J = [-[R p]x, I].
    """
    arms = points_fixture @ base_from_fixture[:3, :3].T
    jacobian = np.concatenate([-skew(arms), np.broadcast_to(np.eye(3), (*arms.shape[:-1], 3, 3))], axis=-1)
    return np.asarray(jacobian @ covariance @ np.swapaxes(jacobian, -1, -2))


def worst_sigma(covariances: Floats) -> Floats:
    """The largest standard deviation (...,) over all directions, of covariances (..., 3, 3)."""
    return np.asarray(np.sqrt(np.maximum(np.linalg.eigvalsh(covariances)[..., -1], 0.0)))


def sigma_at(result: LocateResult, point_fixture: Floats | None = None) -> float | None:
    """The worst sigma (units) of a point (3,) of the fixture frame, by default its origin; None if unknown."""
    if result.base_from_fixture is None or result.covariance is None:
        return None
    point = np.zeros(3) if point_fixture is None else point_fixture
    return float(worst_sigma(point_covariance(result.base_from_fixture, result.covariance, point)))


def shown_sigma(result: LocateResult, point_fixture: Floats | None = None) -> str:
    """The worst sigma of a point (3,) of the fixture frame, by default its origin, as text with its unit."""
    return _shown(sigma_at(result, point_fixture), result.units)


def exceeded_gates(
    result: LocateResult, point_fixture: Floats | None, max_sigma: float | None, max_rms: float | None
) -> list[str]:
    """Messages about the limits that a located result exceeds, if any. An unknown value exceeds any limit.

    max_sigma: limit of the worst sigma of point_fixture (3,), by default the origin; both limits in units.
    """
    point = "the origin" if point_fixture is None else f"({', '.join(f'{x:g}' for x in point_fixture)})"
    checks = (
        (f"the worst sigma of {point}", sigma_at(result, point_fixture), max_sigma),
        ("the rms of the residuals", result.rms, max_rms),
    )
    return [
        f"not acceptable: {quantity} is {_shown(value, result.units)}, above the limit of {limit:g} {result.units}"
        for quantity, value, limit in checks
        if limit is not None and (value is None or not value <= limit)
    ]


def _shown(value: float | None, units: str) -> str:
    return "not known" if value is None else f"{value:.3g} {units}"
