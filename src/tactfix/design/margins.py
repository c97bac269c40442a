"""How far the nearest wrong pose lies behind the right one, and which contacts the answer hangs on.

locate is asked with sigmas that are larger than they are: what it then still accepts is a wrong pose within reach.
"""

from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.design.blind_spots import Locator, Touched, shift_of
from tactfix.geometry.arrays import Floats, frozen
from tactfix.geometry.rigid import rotation_angle
from tactfix.refinement import contact_residuals
from tactfix.results import Candidate

Loss: TypeAlias = Literal["free", "ambiguous"]

# Sigmas are enlarged by this much: with locate's limit of about five sigma, wrong poses within some fifty are seen.
WIDENED: Final = 10.0
# Contacts taken away one by one, at most: with more of them no single one matters.
_MOST_LOSSES: Final = 16
# A candidate this near to the right pose is the right pose: rad, and share of the fixture's extent.
_SAME: Final = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Rival:
    """A wrong pose that the plan does not rule out: how many sigma behind the right one (root of chi-square)."""

    image_from_fixture: Floats
    sigmas_behind: float
    shift: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "image_from_fixture", frozen(self.image_from_fixture))


@dataclass(frozen=True, slots=True)
class Fragile:
    """A contact (as messages call it) whose loss leaves a motion free or the pose ambiguous."""

    label: str
    feature: str
    outcome: Loss


@dataclass(frozen=True, slots=True, eq=False)
class Margins:
    """rival: the nearest wrong pose, None where none is within reach sigma. fragile: contacts that must not be lost."""

    rival: Rival | None
    reach: float
    fragile: tuple[Fragile, ...]

    @property
    def is_unique(self) -> bool:
        """Whether locate would leave no wrong pose."""
        return self.rival is None or self.rival.sigmas_behind > self.reach / WIDENED


def margins(touched: Touched, locator: Locator, *, with_losses: bool = True) -> Margins:
    """The margins of nominal contacts on a fixture that stands at the origin; losses are left out where not wanted."""
    contacts = touched.contacts
    # The form errors of the features widen with the probe's sigma, so that all residuals are judged alike.
    widened = np.sqrt((WIDENED * touched.sigmas) ** 2 - (touched.sigmas**2 - contacts.sigmas**2))
    wide = locator(replace(contacts, sigmas=widened))
    rivals = [_rival(c, touched) for c in wide.candidates if c.accepted and not _is_right(c, touched.corners)]
    rival = min(rivals, key=lambda r: r.sigmas_behind, default=None)
    reach = WIDENED * float(np.sqrt(wide.chi2_limit or 0.0))
    found = Margins(rival, reach, ())
    # A contact is only missed where the pose is unique with it.
    return replace(found, fragile=_fragile(contacts, locator)) if found.is_unique and with_losses else found


def _rival(candidate: Candidate, touched: Touched) -> Rival:
    values, _ = contact_residuals(candidate.surfaces, touched.contacts)
    behind = float(np.linalg.norm(values / touched.sigmas))
    return Rival(candidate.base_from_fixture, behind, shift_of(candidate.base_from_fixture, touched.corners))


def _is_right(candidate: Candidate, corners: Floats) -> bool:
    pose = candidate.base_from_fixture
    extent = float(np.linalg.norm(np.ptp(corners, axis=0)))
    return rotation_angle(pose[:3, :3]) < _SAME and shift_of(pose, corners) < _SAME * extent


def _fragile(contacts: Contacts, locator: Locator) -> tuple[Fragile, ...]:
    """Each contact in turn left out, where there are few."""
    found = []
    for i in range(len(contacts) if len(contacts) <= _MOST_LOSSES else 0):
        rest = contacts.subset([j for j in range(len(contacts)) if j != i])
        status = "underdetermined" if len(rest) < 6 else locator(rest).status
        outcome: Loss | None = {"underdetermined": "free", "ambiguous": "ambiguous"}.get(status)  # type: ignore[assignment]
        if outcome is not None:
            found.append(Fragile(contacts.label(i), contacts.features[i], outcome))
    return tuple(found)
