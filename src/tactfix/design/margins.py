"""Margins: the chi-square of the nearest wrong pose, and the contacts without which the pose is not unique.

1. The contacts are located with enlarged sigmas (WIDENED): a wrong pose that is then accepted is near.
2. The tolerances of approaches and touch boxes are enlarged too: a pose that they reject at the true sigmas is dropped.
3. The nearest is the one with the least chi-square at the true sigmas; if there is none, sigmas are enlarged further.
4. If the pose is unique, each contact is deleted in turn: a motion may then be free, or the pose ambiguous.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, Literal, TypeAlias

import numpy as np

from tactfix.design.nominal_contacts import Locator, Touched, most_influential, shift_of
from tactfix.geometry.arrays import Floats, Frozen
from tactfix.geometry.rigid import inverse, rotation_angle
from tactfix.poses.pose_fit import contact_residuals
from tactfix.results import Candidate
from tactfix.values import frozen_value

Loss: TypeAlias = Literal["free", "ambiguous"]

WIDENED: Final = (10.0, 100.0)
"""Factors on all sigmas, tried in turn. locate accepts poses within some five sigma: with the first factor wrong
poses within some fifty sigma are found, with the second, tried only if there is none, within some five hundred."""
_MOST_LOSSES: Final = 24
"""Contacts that are deleted one by one, at most: each takes a call of locate, some 5 ms. Plans have fewer (14 at most
without a number, `task._LARGEST_PLAN`); of more contacts those with the most leverage are deleted, whose loss matters
most."""
_FITS_AS_WELL: Final = 1e-3
"""Root of chi-square below which a wrong pose fits as well as the right one, and 0 is written: that of a symmetric pose
is rounding, and no contact shows a thousandth of sigma."""
_RIGHT_POSE: Final = 1e-3
"""Rad, and share of the fixture's extent, within which a candidate is the right pose. Nominal contacts have no noise,
so the right pose is found to rounding; a pose nearer than 1e-3 to it is no danger."""


@frozen_value
class Rival:
    """A wrong pose that the contacts do not exclude; sigmas_behind: root of its chi-square with nominal contacts."""

    image_from_fixture: Frozen
    sigmas_behind: float
    shift: float

    @property
    def words(self) -> str:
        """The root of chi-square in words; rounding is shown as 0."""
        return f"{self.sigmas_behind if self.sigmas_behind > _FITS_AS_WELL else 0.0:.2g} sigma behind"


@frozen_value(eq=True)
class Fragile:
    """A contact (as messages call it) whose loss leaves a motion free or the pose ambiguous."""

    label: str
    feature: str
    outcome: Loss


@frozen_value
class Margins:
    """The nearest wrong pose, and the contacts without which the pose is not unique.

    rival: the nearest wrong pose, None if none is within reach (sigma). limit (sigma): locate accepts poses within it.
    fragile: contacts that must not be lost; losses: how many contacts were deleted one by one.
    """

    rival: Rival | None
    reach: float
    limit: float
    fragile: tuple[Fragile, ...] = ()
    losses: int = 0

    @property
    def is_unique(self) -> bool:
        """Whether locate would leave no wrong pose."""
        return self.rival is None or self.rival.sigmas_behind > self.limit


def margins(touched: Touched, locator: Locator, *, with_losses: bool = True) -> Margins:
    """The margins of nominal contacts on a fixture at the origin; contacts are deleted only with with_losses."""
    found = _nearest(touched, locator)  # steps 1 to 3
    # Only a unique pose can become ambiguous.
    if not with_losses or not found.is_unique:
        return found
    tried = sorted(most_influential(touched)[:_MOST_LOSSES])  # step 4
    return replace(found, fragile=_fragile(touched, tried, locator), losses=len(tried))


def _nearest(touched: Touched, locator: Locator) -> Margins:
    """The nearest wrong pose, with sigmas enlarged until there is one."""
    found = Margins(None, 0.0, 0.0)
    for factor in WIDENED:
        wide = locator(replace(touched.contacts, sigmas=_widened(touched, factor)))  # step 1
        limit = float(np.sqrt(wide.chi2_limit or 0.0))
        wrong = [c for c in wide.candidates if c.accepted and not _is_right(c, touched.corners)]
        rivals = [_rival(c, touched) for c in wrong if _is_admitted(c, touched, locator)]  # step 2
        # Step 3.
        found = Margins(min(rivals, key=lambda r: r.sigmas_behind, default=None), factor * limit, limit)
        if found.rival is not None:
            break
    return found


def _widened(touched: Touched, factor: float) -> Floats:
    """The probe's sigmas (n,) with which those of the residuals, form errors included, are factor times as large."""
    form = touched.sigmas**2 - touched.contacts.sigmas**2
    return np.asarray(np.sqrt((factor * touched.sigmas) ** 2 - form))


def _is_admitted(candidate: Candidate, touched: Touched, locator: Locator) -> bool:
    """Whether residuals alone can reject a pose at the true sigmas.

    The tolerances of approaches and touch boxes were enlarged with sigma. So contacts that fit this pose exactly are
    located with the true sigmas: if the pose is not accepted then, another test rejects it.
    """
    values, normals = contact_residuals(candidate.surfaces, touched.contacts)
    there = replace(touched.contacts, points=touched.contacts.points - values[:, None] * normals)
    back = inverse(candidate.base_from_fixture)
    return any(
        other.accepted and _is_right(replace(other, base_from_fixture=back @ other.base_from_fixture), touched.corners)
        for other in locator(there).candidates
    )


def _rival(candidate: Candidate, touched: Touched) -> Rival:
    values, _ = contact_residuals(candidate.surfaces, touched.contacts)
    behind = float(np.linalg.norm(values / touched.sigmas))
    return Rival(candidate.base_from_fixture, behind, shift_of(candidate.base_from_fixture, touched.corners))


def _is_right(candidate: Candidate, corners: Floats) -> bool:
    pose = candidate.base_from_fixture
    extent = float(np.linalg.norm(np.ptp(corners, axis=0)))
    return rotation_angle(pose[:3, :3]) < _RIGHT_POSE and shift_of(pose, corners) < _RIGHT_POSE * extent


def _fragile(touched: Touched, tried: Sequence[int], locator: Locator) -> tuple[Fragile, ...]:
    """The contacts of the indices tried that must not be lost: each is deleted in turn."""
    found, contacts = [], touched.contacts
    for i in tried:
        rest = contacts.subset([j for j in range(len(contacts)) if j != i])
        left = replace(touched, contacts=rest)
        status = "underdetermined" if left.dof < 0 else locator(rest).status
        outcome: Loss | None = {"underdetermined": "free", "ambiguous": "ambiguous"}.get(status)  # type: ignore[assignment]
        if outcome is not None:
            found.append(Fragile(contacts.label(i), contacts.features[i], outcome))
    return tuple(found)
