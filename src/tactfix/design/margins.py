"""How far the nearest wrong pose lies behind the right one, and on which contacts that depends.

1. locate is asked with sigmas larger than they are (WIDENED): a wrong pose that it still accepts is near.
2. Approach and touch boxes had a grace in those sigmas: a pose is left out that they exclude by the true ones.
3. The nearest is the one with the least chi-square by the true sigmas; where there is none, sigmas are widened further.
4. Where the pose is unique, each contact is left out in turn: a motion may then be free, or the pose ambiguous.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, Literal, TypeAlias

import numpy as np

from tactfix.design.nominal_contacts import Locator, Touched, most_telling, shift_of
from tactfix.geometry.arrays import Floats, Frozen
from tactfix.geometry.rigid import inverse, rotation_angle
from tactfix.poses.pose_fit import contact_residuals
from tactfix.results import Candidate
from tactfix.values import frozen_value

Loss: TypeAlias = Literal["free", "ambiguous"]

WIDENED: Final = (10.0, 100.0)
"""Factors on all sigmas, tried in turn. locate accepts poses within some five sigma: with the first factor wrong
poses within some fifty sigma are seen, with the second, asked only where there is none, within some five hundred."""
_MOST_LOSSES: Final = 24
"""Contacts that are taken away one by one, at most: locate is asked for each, some 5 ms. Plans have fewer (14 at
most without a number, `task._LARGEST_PLAN`); of more contacts those of the most leverage are taken, whose loss
weighs most."""
_FITS_AS_WELL: Final = 1e-3
"""Sigma behind the right pose, below which a pose fits as well and 0 is written: a symmetric pose is behind by
rounding alone, and no contact tells a thousandth of sigma."""
_RIGHT_POSE: Final = 1e-3
"""How near to the right pose a candidate is that pose: rad, and share of the fixture's extent. Nominal contacts have
no noise, so the right pose is met to rounding; two poses nearer than 1e-3 to each other harm nobody."""


@frozen_value
class Rival:
    """A wrong pose that the plan does not rule out: how many sigma behind the right one (root of chi-square)."""

    image_from_fixture: Frozen
    sigmas_behind: float
    shift: float

    @property
    def words(self) -> str:
        """How far behind; what rounding leaves of nothing is 0."""
        return f"{self.sigmas_behind if self.sigmas_behind > _FITS_AS_WELL else 0.0:.2g} sigma behind"


@frozen_value(eq=True)
class Fragile:
    """A contact (as messages call it) whose loss leaves a motion free or the pose ambiguous."""

    label: str
    feature: str
    outcome: Loss


@frozen_value
class Margins:
    """What lies near the right pose.

    rival: the nearest wrong pose, None where none is within reach (in sigma). limit: within so many sigma
    locate accepts a pose. fragile: contacts that must not be lost, among as many as losses.
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
    """The margins of nominal contacts on a fixture that stands at the origin; losses are left out where not wanted."""
    found = _nearest(touched, locator)  # steps 1 to 3
    # A contact is only missed where the pose is unique with it.
    if not with_losses or not found.is_unique:
        return found
    tried = sorted(most_telling(touched)[:_MOST_LOSSES])  # step 4
    return replace(found, fragile=_fragile(touched, tried, locator), losses=len(tried))


def _nearest(touched: Touched, locator: Locator) -> Margins:
    """The nearest wrong pose, with sigmas widened until there is one."""
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
    """The probe's sigmas (n,) with which all residuals, the features' form errors in them, are factor as uncertain."""
    form = touched.sigmas**2 - touched.contacts.sigmas**2
    return np.asarray(np.sqrt((factor * touched.sigmas) ** 2 - form))


def _is_admitted(candidate: Candidate, touched: Touched, locator: Locator) -> bool:
    """Whether nothing but its residuals speaks against a pose at the true sigmas.

    Approach and touch boxes are asked with a grace in sigma, which was widened too. Contacts that fit this pose exactly
    are given to locate: it accepts the pose, or something else excludes it.
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
    """Those of the contacts with the indices tried that must not be lost: each is left out in turn."""
    found, contacts = [], touched.contacts
    for i in tried:
        rest = contacts.subset([j for j in range(len(contacts)) if j != i])
        left = replace(touched, contacts=rest)
        status = "underdetermined" if left.dof < 0 else locator(rest).status
        outcome: Loss | None = {"underdetermined": "free", "ambiguous": "ambiguous"}.get(status)  # type: ignore[assignment]
        if outcome is not None:
            found.append(Fragile(contacts.label(i), contacts.features[i], outcome))
    return tuple(found)
