"""Whether a plan leaves one pose only, and tilted approaches that exclude the other poses.

1. The nominal contacts are located with their own sigma.
2. If one pose is left, they are located with a larger sigma: accepted candidates are then all poses with a root of
   chi-square of at most ten.
3. The candidate nearest to the identity is right, the others are rivals.
4. For each rival one approach is tilted: the one with the least tilt at which it comes out of the rival's material.
"""

from dataclasses import replace

import numpy as np

from tactfix.accessibility.access import Access
from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats, unit
from tactfix.geometry.surfaces import Point, outward_normals
from tactfix.localization.nominal import locate_nominal
from tactfix.locate_result import LocateResult
from tactfix.noise import chi_square_limit
from tactfix.results import Candidate
from tactfix.values import frozen_value

BEHIND = 10.0
"""Root of chi-square up to which a second pose is a rival, as plan_findings.ENOUGH_BEHIND for a design. With 5 and 20
none of five plans of 7 to 9 contacts (three planes, sphere and cylinder, three spheres, plate with pin and ball) has
another answer."""
_MOST_TILT_DEG = 45.0
"""Largest tilt of an approach from the normal, in degrees: a tip still touches without sliding, and machines
usually allow it. With 22.5 and 70 none of those five plans changes."""
_BEYOND_DEG = 15.0
"""Angle at which a tilted approach comes out of the rival's material, in degrees: SURE (5) sigma of a normal that is
known to three degrees. With 7.5 and 30 none of those five plans changes."""


@frozen_value
class Uniqueness:
    """Nominal contacts, located. result: with their own sigma; rivals: wrong poses within BEHIND sigma.

    located: whether the contacts determine a pose.
    """

    result: LocateResult
    located: bool
    rivals: tuple[Candidate, ...]

    @property
    def unique(self) -> bool:
        """Whether the right pose is the only one left."""
        return self.located and not self.rivals


def uniqueness_of(fixture: Fixture, contacts: Contacts, base_from_fixture: Floats | None = None) -> Uniqueness:
    """Whether nominal contacts in the fixture frame leave one pose only: the identity.

    base_from_fixture (4, 4): the expected pose of the fixture, to which its placement applies.
    """
    result = locate_nominal(fixture, contacts, base_from_fixture)  # step 1
    if result.status not in ("located", "ambiguous"):
        return Uniqueness(result, False, ())
    if result.status == "located":  # step 2
        coarse = BEHIND / np.sqrt(chi_square_limit(result.dof))
        coarser = replace(contacts, sigmas=max(coarse, 1.0) * contacts.sigmas)
        wide = locate_nominal(fixture, coarser, base_from_fixture)
    else:
        wide = result
    accepted = [candidate for candidate in wide.candidates if candidate.accepted]
    if not accepted:
        return Uniqueness(result, False, ())
    # Step 3.
    offs = [float(np.abs(candidate.base_from_fixture - np.eye(4)).max()) for candidate in accepted]
    right = int(np.argmin(offs))
    return Uniqueness(result, True, tuple(candidate for i, candidate in enumerate(accepted) if i != right))


def separating_approaches(
    access: Access, contacts: Contacts, normals: Floats, rivals: tuple[Candidate, ...]
) -> Contacts:
    """The contacts, in the fixture frame, with as few approaches as possible tilted so that no rival passes eq. 11.

    normals (n, 3): outward at the contacts. For each rival one contact, that with the least tilt, comes out of the
    rival's material. A rival that no approach excludes is left.
    """
    approaches = contacts.approaches.copy()  # step 4
    turned: set[int] = set()
    for rival in rivals:
        wrong = _rival_normals(rival, contacts)
        if ((approaches * wrong).sum(axis=1) > np.sin(np.radians(_BEYOND_DEG))).any():
            continue
        tilted, tilts = _least_tilts(normals, wrong)
        # A point has no side.
        tilts[[isinstance(access.surfaces[name], Point) for name in contacts.features]] = np.pi
        for i in np.argsort(tilts):
            if tilts[i] > np.radians(_MOST_TILT_DEG):
                break
            if int(i) not in turned and _reaches(access, contacts, normals, int(i), tilted[i]):
                approaches[i] = tilted[i]
                turned.add(int(i))
                break
    return replace(contacts, approaches=approaches)


def _rival_normals(rival: Candidate, contacts: Contacts) -> Floats:
    pairs = zip(contacts.features, contacts.points, strict=True)
    return np.array([outward_normals(rival.surfaces[name], point) for name, point in pairs])


def _least_tilts(normals: Floats, wrong: Floats) -> tuple[Floats, Floats]:
    """Approaches (n, 3) nearest to -normals that leave surfaces wrong at _BEYOND_DEG, and their tilts (n,) in rad."""
    facing = (normals * wrong).sum(axis=1)
    # In the plane of both normals the approach -n is at angle(n, wrong) - 90 degrees beyond the wrong surface.
    past = np.arccos(np.clip(facing, -1.0, 1.0)) - np.pi / 2
    tilts = np.maximum(np.radians(_BEYOND_DEG) - past, 0.0)
    aside = wrong - facing[:, None] * normals
    flat = np.linalg.norm(aside, axis=1) < 1e-6
    aside = unit(np.where(flat[:, None], np.roll(normals, 1, axis=1) + 1e-3, aside))
    turned = -np.cos(tilts)[:, None] * normals + np.sin(tilts)[:, None] * aside
    # With parallel normals there is no direction to tilt in.
    return turned, np.where(flat & (tilts > 0), np.pi, tilts)


def _reaches(access: Access, contacts: Contacts, normals: Floats, at: int, approach: Floats) -> bool:
    point = contacts.points[at] - access.tip_radius * normals[at]
    return bool(access.can_touch(contacts.features[at], point[None], normals[at][None], approach[None])[0])
