"""A pose with its unit and covariance, its syntax errors, and inversion and composition of poses.

Covariances are of (d_rot, d_t) with R_true = exp([d_rot]) R and t_true = t + d_t, base axes. Inverses and products
propagate them to first order; the errors of two poses are taken as independent.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from tactfix.errors import Problem, TactfixError, UsageError
from tactfix.geometry.arrays import Floats, frozen
from tactfix.geometry.rigid import homogeneous, orthonormalized, skew
from tactfix.settings import Setting, joined
from tactfix.units import MOST_LENGTH, UNITS, factor, which_unit
from tactfix.values import frozen_value
from tactfix.wording import decimals, fixed

MOST_SKEW = 1e-5
"""Largest accepted entry of R^T R - 1: about 1e-6 for a matrix printed with six decimals, far more for a sheared,
scaled or mirrored one."""
_NO_COVARIANCE = 1e-4
"""Largest asymmetry or negative eigenvalue, relative to the sigmas, of a covariance printed with five digits."""
LEAST_SKEW = 1e-12
"""Largest entry of R^T R - 1 due to double arithmetic: such a matrix is kept unchanged."""


class PoseSyntaxError(TactfixError):
    """A text is not a pose in its dialect; callers that know the name of the file convert this to FileError."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        self.problems = tuple(problems)
        super().__init__(joined("\n", [problem.text for problem in self.problems]))


def syntax_error(message: str, remedy: str, line: int | None = None) -> PoseSyntaxError:
    """A PoseSyntaxError of one problem."""
    return PoseSyntaxError([Problem(message, remedy, line=line)])


def _frozen_motion(matrix: ArrayLike) -> Floats:
    try:
        return frozen(rigid_matrix(matrix, "base_from_fixture"))
    except PoseSyntaxError as error:
        raise UsageError(str(error)) from None


def _frozen_covariance(given: ArrayLike) -> Floats:
    covariance = frozen(given)
    if covariance.shape != (6, 6) or not np.isfinite(covariance).all():
        raise UsageError("the covariance of a pose is 6 x 6 finite numbers, or None")
    # Scaled by the largest sigma of rotation and of translation: a fixed direction has no variance, files few digits.
    sigmas = np.sqrt(np.abs(np.diag(covariance))).reshape(2, 3).max(axis=1)
    scale = np.repeat(np.where(sigmas > 0, sigmas, 1.0), 3)
    scaled = covariance / np.outer(scale, scale)
    if np.abs(scaled - scaled.T).max() > _NO_COVARIANCE or np.linalg.eigvalsh(scaled + scaled.T)[0] < -_NO_COVARIANCE:
        raise UsageError("the covariance of a pose is symmetric, with no negative variance in any direction")
    return covariance


def _known_unit(units: str) -> str:
    if units not in UNITS:
        raise UsageError(f"units is {units!r}; {which_unit(units)}")
    return units


@frozen_value
class Pose:
    """A pose base_from_fixture with its unit, covariance and fixture name.

    Parameters
    ----------
    base_from_fixture : (4, 4) array
        x_base = R x_fixture + t, in base, lengths in units.
    units : str or None
        Unit of lengths, None if unknown.
    covariance : (6, 6) array, optional
        Of (d_rot in rad, d_t in units), base axes, rotation about the fixture's origin; None if unknown.
    fixture : str
        Name of the fixture, "" if unknown.

    Raises
    ------
    UsageError
        Not a rigid motion (scaled, sheared, mirrored, nan), not a covariance, or not a unit.

    Examples
    --------
    >>> tactfix.Pose(np.eye(4), "mm").in_units("m").units
    'm'
    """

    base_from_fixture: Annotated[Floats, _frozen_motion]
    units: Annotated[str, _known_unit] | None
    covariance: Annotated[Floats, _frozen_covariance] | None = None
    fixture: str = ""

    def __repr__(self) -> str:
        sigmas = [0.0] * 3 if self.covariance is None else np.sqrt(np.diag(self.covariance)[3:]).tolist()
        # Without a sigma, three decimals identify a pose well enough.
        digits = [decimals(sigma) if sigma > 0 else 3 for sigma in sigmas]
        origin = ", ".join(fixed(value, n) for value, n in zip(self.translation.tolist(), digits, strict=True))
        cosine = (np.trace(self.rotation) - 1) / 2
        turned = f"turned {np.rad2deg(np.arccos(np.clip(cosine, -1, 1))):.4g} deg"
        name = f" {self.fixture!r}" if self.fixture else ""
        return f"<Pose{name}: origin ({origin}) {self.units or 'of unknown unit'}, {turned}>"

    @property
    def rotation(self) -> Floats:
        """R (3, 3) of x_base = R x_fixture + t."""
        return self.base_from_fixture[:3, :3]

    @property
    def translation(self) -> Floats:
        """The fixture's origin t (3,) in base."""
        return self.base_from_fixture[:3, 3]

    def in_units(self, units: str) -> "Pose":
        """The same pose with lengths in units; self.units must be known."""
        if self.units is None:
            raise ValueError("the units of this pose are not known")
        if units == self.units:
            return self
        ratio = factor(self.units, units)
        scale = np.r_[np.ones(3), np.full(3, ratio)]
        covariance = None if self.covariance is None else self.covariance * np.outer(scale, scale)
        moved = homogeneous(self.rotation, self.translation * ratio)
        return replace(self, base_from_fixture=moved, units=units, covariance=covariance)


def rigid_matrix(values: ArrayLike, place: str = "the matrix") -> Floats:
    """The rigid motion (4, 4) of values; PoseSyntaxError, with the reason, if they are not one.

    A rotation that is orthonormal to double precision is kept unchanged; one printed with few digits (off by up to
    1e-5) is replaced by the nearest rotation.
    """
    matrix = np.asarray(values, dtype=np.float64)
    if matrix.shape != (4, 4):
        raise syntax_error(f"{place} is {' x '.join(map(str, matrix.shape)) or 'a number'}", "a pose is 4 x 4 numbers")
    if not np.isfinite(matrix).all():
        raise syntax_error(f"{place} contains a value that is not a finite number", "write numbers")
    if np.abs(matrix).max() > MOST_LENGTH:
        raise syntax_error(
            f"{place} contains a value beyond {MOST_LENGTH:g}", "check the numbers: no length is so large"
        )
    if np.abs(matrix[3] - [0, 0, 0, 1]).max() > LEAST_SKEW:
        raise syntax_error(f"the last row of {place} is not 0 0 0 1", "transpose it if the translation is in that row")
    rotation = matrix[:3, :3]
    skew = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if skew > MOST_SKEW:
        raise syntax_error(
            f"{place} does not rotate: R R^T is off by {skew:.2g}", "no scale or shear, and six digits or more"
        )
    if np.linalg.det(rotation) < 0:
        raise syntax_error(f"{place} mirrors (det R = -1)", "both frames must be right-handed")
    return matrix if skew <= LEAST_SKEW else homogeneous(orthonormalized(rotation), matrix[:3, 3])


def inverted(pose: Pose) -> Pose:
    """fixture_from_base: x_fixture = R^T x_base - R^T t.

    exp(-[d_rot]) on the left of R^T is exp(-[R^T d_rot]) R^T, and -R^T exp(-[d_rot]) (t + d_t) is off by
    R^T (d_rot x t - d_t).
    """
    back = pose.rotation.T
    jacobian = np.block([[-back, np.zeros((3, 3))], [-back @ skew(pose.translation), -back]])
    return Pose(
        homogeneous(back, -back @ pose.translation), pose.units, _carried(jacobian, pose.covariance), pose.fixture
    )


def composed(outer: Pose, inner: Pose) -> Pose:
    """outer @ inner: the inner pose in the reference frame of outer; units of inner, or of outer if it has none.

    d_rot = d_outer + R_outer d_inner, and d_t = d_t_outer + d_outer x (R_outer t_inner) + R_outer d_t_inner.
    Raises UsageError if only one of them has a unit.
    """
    if (outer.units is None) != (inner.units is None):
        raise UsageError("one of the two poses does not say its unit; give " + Setting.UNITS.word)
    placed = outer if inner.units is None else outer.in_units(inner.units)
    arm = placed.rotation @ inner.translation
    by_inner = np.block([[placed.rotation, np.zeros((3, 3))], [np.zeros((3, 3)), placed.rotation]])
    by_outer = np.block([[np.eye(3), np.zeros((3, 3))], [-skew(arm), np.eye(3)]])
    parts = [_carried(by_inner, inner.covariance), _carried(by_outer, placed.covariance)]
    known = [part for part in parts if part is not None]
    return Pose(
        homogeneous(placed.rotation @ inner.rotation, arm + placed.translation),
        inner.units,
        np.sum(known, axis=0) if known else None,
        inner.fixture,
    )


def _carried(jacobian: Floats, covariance: Floats | None) -> Floats | None:
    return None if covariance is None else np.asarray(jacobian @ covariance @ jacobian.T)
