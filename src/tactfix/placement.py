"""Prior knowledge of a fixture's pose: limits, a measured pose, constrained directions."""

from collections.abc import Sequence
from functools import cached_property
from typing import Annotated, Literal, TypeAlias, get_args

import numpy as np

from tactfix.errors import UsageError
from tactfix.geometry.arrays import Bools, Floats, Frozen, frozen
from tactfix.values import frozen_value

Direction: TypeAlias = Literal["x", "y", "z", "rx", "ry", "rz"]
"""A translation along a base axis, or a rotation about one."""


DIRECTIONS: tuple[Direction, ...] = get_args(Direction)


SINGULAR_CORRELATION = 1e-12
"""Smallest eigenvalue of a correlation matrix below which the covariance counts as singular."""


def _frozen_if_array(sigma: tuple[float, float] | Floats) -> tuple[float, float] | Floats:
    return frozen(sigma) if isinstance(sigma, np.ndarray) else sigma


@frozen_value
class Placement:
    """Prior knowledge of the fixture's pose.

    Parameters
    ----------
    near : (4, 4) array
        base_from_fixture, in the fixture's units.
    within : tuple of two floats, optional
        Limits of the translation of the fixture's origin (length) and of the rotation (rad) from near.
    sigma : tuple of two floats or (6, 6) array, optional
        near is a measurement with these standard deviations of each component, translation (length) and rotation (rad),
        or with this covariance in the order of a pose's: rotation (rad), translation, base axes.
    free : frozenset of {"x", "y", "z", "rx", "ry", "rz"}, optional
        Only these may differ from near, rotations about base axes through the fixture's origin at near, then
        translations; None: all.

    Raises
    ------
    UsageError
        within and sigma together, negative limits, no free direction, or a singular covariance.

    Examples
    --------
    >>> tactfix.Placement(np.eye(4), within=(20.0, 0.1)).within
    (20.0, 0.1)
    """

    near: Frozen
    within: tuple[float, float] | None = None
    sigma: Annotated[tuple[float, float] | Floats, _frozen_if_array] | None = None
    free: frozenset[Direction] | None = None

    def __post_init__(self) -> None:
        if self.within is not None and self.sigma is not None:
            raise UsageError("the pose known beforehand has limits or a sigma, not both")
        if self.within is not None and not min(self.within) >= 0:
            raise UsageError("the limits of the pose known beforehand must not be negative")
        if self.free is not None and not self.free:
            raise UsageError(f"nothing may differ from the pose known beforehand; name one of {', '.join(DIRECTIONS)}")
        covariance = self.covariance
        if covariance is not None and not _is_positive_definite(covariance):
            problem = "the sigma of the pose known beforehand must be above zero in every direction"
            raise UsageError(f"{problem}; for a fixed direction, name the others as free")

    @property
    def is_in_fit(self) -> bool:
        """Whether it enters the fit, as a measurement or by constrained directions; limits only eliminate poses."""
        return self.sigma is not None or self.free is not None

    @property
    def is_known(self) -> bool:
        """Whether it restricts the pose; near alone does not."""
        return self.within is not None or self.is_in_fit

    @cached_property
    def covariance(self) -> Floats | None:
        """The covariance (6, 6) of near if it is a measurement: rx ry rz (rad), tx ty tz (length)."""
        if self.sigma is None or isinstance(self.sigma, np.ndarray):
            return self.sigma
        translation, rotation = self.sigma
        return frozen(np.diag([rotation**2] * 3 + [translation**2] * 3))

    @cached_property
    def whitening(self) -> Floats | None:
        """W (6, 6) with W^T W the inverse of the covariance: of a measured pose, residuals over sigma."""
        return None if self.covariance is None else frozen(np.linalg.inv(np.linalg.cholesky(self.covariance)))

    @property
    def dof(self) -> int:
        """The number of equations of a measurement less the unknowns of the pose."""
        return (6 if self.sigma is not None else 0) - int(self.turns.sum() + self.shifts.sum())

    @cached_property
    def turns(self) -> Bools:
        """The base axes (3,) about which the fixture may be rotated from near."""
        return _are_free(self.free, ("rx", "ry", "rz"))

    @cached_property
    def shifts(self) -> Bools:
        """The base axes (3,) along which the fixture may be translated from near."""
        return _are_free(self.free, ("x", "y", "z"))


def _are_free(free: frozenset[Direction] | None, names: Sequence[Direction]) -> Bools:
    found = np.array([free is None or name in free for name in names])
    found.flags.writeable = False
    return found


def _is_positive_definite(covariance: Floats) -> bool:
    """Whether it is a finite covariance (6, 6) of full rank, whatever the unit of length."""
    if covariance.shape != (6, 6) or not np.isfinite(covariance).all():
        return False
    sigmas = np.sqrt(np.abs(np.diag(covariance)))
    scaled = covariance / np.outer(sigmas, sigmas) if sigmas.all() else np.zeros((6, 6))
    return bool(np.allclose(scaled, scaled.T) and np.linalg.eigvalsh(scaled)[0] > SINGULAR_CORRELATION)
