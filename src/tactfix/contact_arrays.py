"""Contacts from arrays, with checks."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from tactfix.contacts import Contacts
from tactfix.errors import UsageError
from tactfix.geometry.arrays import Floats
from tactfix.units import LEAST_LENGTH, MOST_LENGTH, UNITS, which_unit

_NOT_A_ROTATION = 1e-3
"""Largest entry by which a rotation matrix times its transpose may differ from the identity. Entries typed with four
digits are off by 5e-5 and the product by up to 2e-4; a sheared or unrelated matrix by far more."""


def contacts_from_arrays(
    features: str | Sequence[str],
    points: ArrayLike,
    approaches: ArrayLike | None = None,
    *,
    sigma: ArrayLike,
    tip_radius: float,
    flange_rotations: ArrayLike | None = None,
    tip_offset: ArrayLike | None = None,
    units: str | None = None,
) -> Contacts:
    """Make contacts from arrays; nothing is guessed.

    Parameters
    ----------
    features : str or sequence of str
        The feature that each contact touched, or one name for all.
    points : (n, 3) array
        In base, in units: centres of the tip where tip_radius > 0, points of the surface where it is 0.
    approaches : (n, 3) array, optional
        The direction of the probe's travel into the material, in base, of any length but zero; a row of nan, or None
        for all, if unknown.
    sigma : float or (n,) array
        One standard deviation of a contact along the surface normal.
    tip_radius : float
        Of the probe's tip.
    flange_rotations : (n, 3, 3) array, optional
        base_from_flange at each touch, for a tip whose offset is to be found.
    tip_offset : (3,) array, optional
        The tip's centre in the flange frame with which the points were made.
    units : {"mm", "m", "um", "in"}, optional
        Of all lengths; `locate` refuses contacts in another unit than the fixture's. None: the fixture's.

    Returns
    -------
    Contacts

    Raises
    ------
    UsageError
        Inconsistent shapes, and values that are invalid for a contact.

    Notes
    -----
    The contact with a surface of outward normal n lies at x - tip_radius n, whatever the approach.

    Examples
    --------
    >>> tactfix.contacts_from_arrays("top", [[0, 0, 3], [9, 0, 3]], [[0, 0, -1]] * 2, sigma=0.01, tip_radius=3.0)
    <Contacts: 2 (top 2), tip radius 3>
    """
    places = np.asarray(points, dtype=np.float64)
    if places.ndim != 2 or places.shape[1] != 3:
        raise UsageError(f"points have the shape {places.shape}; give one row x, y, z for each contact")
    count = len(places)
    names = (features,) * count if isinstance(features, str) else tuple(features)
    travels = np.full((count, 3), np.nan) if approaches is None else np.array(approaches, dtype=np.float64)
    if len(names) != count or travels.shape != (count, 3):
        raise UsageError(
            f"{count} points, {len(names)} features, approaches of shape {travels.shape}; give one of each"
        )
    lengths = np.linalg.norm(travels, axis=1)
    partial = np.isnan(travels).any(axis=1) & ~np.isnan(travels).all(axis=1)
    sigmas = np.broadcast_to(np.asarray(sigma, dtype=np.float64), (count,))
    if not np.isfinite(places).all() or np.isinf(travels).any() or (lengths == 0).any() or partial.any():
        raise UsageError("points must be finite, and an approach three finite numbers that are not all 0, or three nan")
    if not ((sigmas > 0) & np.isfinite(sigmas)).all() or not 0 <= tip_radius < np.inf:
        raise UsageError("sigma must be above 0, tip_radius 0 or above, and both finite")
    if units is not None and units not in UNITS:
        raise UsageError(f"units is {units!r}; {which_unit(units)}")
    flanges = None if flange_rotations is None else np.array(flange_rotations, dtype=np.float64)
    offset = None if tip_offset is None else np.array(tip_offset, dtype=np.float64)
    _refuse_bad_flange(count, flanges, offset)
    largest = max(np.abs(places).max(initial=0.0), sigmas.max(initial=0.0), tip_radius)
    if largest > MOST_LENGTH or sigmas.min(initial=1.0) < LEAST_LENGTH:
        raise UsageError(
            f"a length is below {LEAST_LENGTH:g} or above {MOST_LENGTH:g}; check the numbers and the units"
        )
    return Contacts(
        features=names,
        points=places,
        approaches=travels / lengths[:, None],
        sigmas=sigmas,
        tip_radius=float(tip_radius),
        rows=tuple(range(1, count + 1)),
        ids=(None,) * count,
        flange_rotations=flanges,
        tip_offset=offset,
        units=units,
    )


def _refuse_bad_flange(count: int, flanges: Floats | None, offset: Floats | None) -> None:
    """Raise UsageError for flange rotations that are invalid or not one per contact, and for an invalid tip offset."""
    if offset is not None and (offset.shape != (3,) or not (np.abs(offset) <= MOST_LENGTH).all()):
        raise UsageError("tip_offset must be three lengths: the tip's centre in the flange frame")
    if flanges is None:
        return
    if flanges.shape != (count, 3, 3) or not np.isfinite(flanges).all():
        raise UsageError(f"{count} points need flange_rotations of shape ({count}, 3, 3), not {flanges.shape}")
    square = np.abs(flanges @ np.swapaxes(flanges, 1, 2) - np.eye(3)).max(initial=0.0)
    if square > _NOT_A_ROTATION or (np.linalg.det(flanges) < 0).any():
        raise UsageError("flange_rotations must be rotation matrices: square rows of length 1, right-handed")
