"""Contacts on a rigid fixture: the accuracy of the pose, other poses that fit, mistakes that stay undetected.

1. Well spread contacts are chosen among the touches that the probe can make; features that it cannot touch are named.
2. The given contacts are transformed to the fixture frame and projected onto its surfaces. Without any, the spread
   contacts are checked.
3. Motions that they leave free, and the cylinders that they lie on, are determined.
4. If no motion is free, the accuracy of the pose follows, and margins and blind spots if its rotation is determined.
5. Whether locate could find a pose at all is decided by the spread contacts, whatever contacts were given.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from tactfix.accessibility.access import Access, access_of
from tactfix.accessibility.touchable import extreme_points
from tactfix.contacts import Contacts
from tactfix.design.accuracy import Certainty, certainty, free_of
from tactfix.design.blind_spot import BlindSpot, Case
from tactfix.design.blind_spots import blind_spots, forgotten_tip
from tactfix.design.cylinder_layouts import CylinderLayout, cylinder_layouts
from tactfix.design.findings import Finding
from tactfix.design.geometry_check import GeometryCheck
from tactfix.design.known_place import settled
from tactfix.design.margins import Margins, margins
from tactfix.design.nominal_contacts import ERROR_SIGMAS, Locator, Source, Touched, lies_on, nominal, spread_contacts
from tactfix.design.plan_findings import (
    blind_spot_findings,
    certainty_findings,
    contact_findings,
    layout_findings,
    margin_findings,
)
from tactfix.design.symmetries import symmetries
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import inverse
from tactfix.geometry.scale import size_of
from tactfix.geometry.surfaces import Cylinder, Sphere, Surface
from tactfix.localization.free_motions import UNDERDETERMINED_ANGLE
from tactfix.localization.nominal import expected_pose, locate_nominal
from tactfix.probe import residual_sigmas
from tactfix.units import factor
from tactfix.values import frozen_value

_USUAL_TIP: Final = 0.003
"""Radius (m) of the tip whose radius is forgotten if nothing gives one: 3 mm, that of the 6 mm balls that styli of
machine tools and robots commonly have. Never more than _BORE_SHARE of a bore."""
_BORE_SHARE: Final = 0.5
"""Share of the radius of the smallest bore: the largest tip that is assumed."""
_PLACES_EXCHANGED: Final = 0.02
"""Share of the fixture's size, or ERROR_SIGMAS sigma if that is more: features that change places to within it are
tried with their labels exchanged. On the plate with pin and ball half and twice as much give the same report."""
_LOOSEST: Final = 0.1
"""The same at most, however large sigma is: features that are a tenth of the fixture's size from each other's places
are distinguished by eye."""


@frozen_value
class ContactCheck:
    """The check of contacts. certainty is None if they leave a motion free, margins also if one is nearly free.

    is_unique: contacts were given and leave one pose only. unreachable: features that no spread contact can touch.
    layouts: of each cylinder with four contacts or more. can_be_located: well spread contacts determine the pose well
    enough for locate.
    """

    certainty: Certainty | None
    margins: Margins | None
    blind_spots: tuple[BlindSpot, ...]
    is_unique: bool
    unreachable: tuple[str, ...]
    findings: tuple[Finding, ...]
    layouts: tuple[CylinderLayout, ...] = ()
    can_be_located: bool = False


def check_contacts(
    fixture: Fixture,
    geometry: GeometryCheck,
    given: Contacts | None,
    probe: tuple[float, float],
    at: Floats,
    max_sigma: float | None,
    locator: Locator,
) -> ContactCheck:
    """Check the given contacts, or well spread ones if there are none.

    probe: sigma and tip radius of the spread contacts. at (m, 3): points of the fixture frame whose sigma is computed.
    locator: for contacts in base. The fixture is checked at the pose near of its placement, whatever pose the contacts
    have.
    """
    access = access_of(fixture, geometry.surfaces, probe[1])
    spread, unreachable = spread_contacts(access, probe[0])  # step 1
    if geometry.free_motions or (given is None and unreachable):
        return ContactCheck(None, None, (), False, unreachable, ())
    spread_touched = None if unreachable else _touched(fixture, geometry.surfaces, spread, access)
    contacts, source, findings = _in_fixture_frame(fixture, geometry.surfaces, given, spread, locator)  # step 2
    nominal_locator: Locator = partial(locate_nominal, fixture, base_from_fixture=expected_pose(fixture))
    touched = _touched(fixture, geometry.surfaces, nominal(contacts, geometry.surfaces), access)
    free = free_of(touched, geometry.tolerance)  # step 3
    layouts = cylinder_layouts(touched.contacts, touched.surfaces, touched.sigmas)
    findings += contact_findings(touched, free, geometry.symmetries, source)
    findings += layout_findings(layouts, source)
    found = ContactCheck(None, None, (), False, unreachable, tuple(findings), layouts)
    if not free:
        accuracy = certainty(touched, at, geometry.tolerance, source)  # step 4
        found = _with_accuracy(fixture, geometry, touched, spread_touched, accuracy, max_sigma, nominal_locator, found)
    # Step 5.
    return replace(found, can_be_located=spread_touched is not None and _are_determined(spread_touched, geometry))


def _are_determined(touched: Touched, geometry: GeometryCheck) -> bool:
    """Whether these contacts leave no motion free and no direction undetermined."""
    if free_of(touched, geometry.tolerance):
        return False
    found = certainty(touched, np.zeros((0, 3)), geometry.tolerance, "spread")
    return found.turn_sigma <= UNDERDETERMINED_ANGLE


def _with_accuracy(
    fixture: Fixture,
    geometry: GeometryCheck,
    touched: Touched,
    spread: Touched | None,
    accuracy: Certainty,
    max_sigma: float | None,
    locator: Locator,
    so_far: ContactCheck,
) -> ContactCheck:
    """The check so far, with the accuracy, and with margins and blind spots if the rotation is determined.

    spread: well spread contacts, None if a feature cannot be touched.
    """
    findings = [*so_far.findings, *certainty_findings(accuracy, touched.rms_sigma, max_sigma, fixture.units)]
    if accuracy.turn_sigma > UNDERDETERMINED_ANGLE:
        # locate would call this underdetermined: there is no pose to compare others with.
        return replace(so_far, certainty=accuracy, findings=tuple(findings))
    tip = _forgotten_tip(fixture, touched)
    margin = margins(touched, locator, with_losses=accuracy.source != "spread")
    spots = blind_spots(_case(fixture, touched, tip, accuracy.worst.sigma, locator))
    # If the spread contacts are checked themselves, this is known.
    forgotten = next(spot for spot in spots if spot.error == "tip_radius")
    shows_tip = (
        spread is not None and (forgotten if accuracy.source == "spread" else forgotten_tip(spread, tip)).detectable
    )
    is_symmetric = any(symmetry.broken_by is None for symmetry in geometry.symmetries)
    findings += margin_findings(margin, accuracy.source, is_symmetric, fixture.units)
    findings += blind_spot_findings(spots, shows_tip, accuracy, accuracy.source, fixture.units)
    is_unique = accuracy.source != "spread" and margin.is_unique
    return replace(
        so_far, certainty=accuracy, margins=margin, blind_spots=spots, is_unique=is_unique, findings=tuple(findings)
    )


def _case(fixture: Fixture, touched: Touched, tip_radius: float, worst_sigma: float, locator: Locator) -> Case:
    size = size_of(touched.surfaces.values())
    ratio = min(_LOOSEST, max(_PLACES_EXCHANGED, ERROR_SIGMAS * touched.rms_sigma / (size or np.inf)))
    near = settled(symmetries(touched.surfaces, fixture.touch, ratio), fixture.placement, size)
    exchanges = tuple(s for s in near if s.confusable)
    return Case(touched, tip_radius, worst_sigma, exchanges, fixture, locator)


def _in_fixture_frame(
    fixture: Fixture, surfaces: Mapping[str, Surface], given: Contacts | None, spread: Contacts, locator: Locator
) -> tuple[Contacts, Source, list[Finding]]:
    """The contacts to check, in the fixture frame, and their source.

    Contacts that lie on the surfaces as they are given are a plan; others are measured and are located first.
    """
    if given is None:
        return spread, "spread", []
    if lies_on(surfaces, given, residual_sigmas(fixture, given)):
        return given, "plan", []
    result = locator(given)
    best = min((c for c in result.candidates if c.accepted), key=lambda c: c.chi2, default=None)
    if best is not None:
        return given.moved(inverse(best.base_from_fixture)), "contacts", []
    hint = "tactfix locate says why; well spread contacts are checked instead"
    message = f"the contacts are not a plan in the fixture frame and give no pose ({result.status})"
    return spread, "spread", [Finding("contacts_not_located", "error", message, hint)]


def _touched(fixture: Fixture, surfaces: Mapping[str, Surface], contacts: Contacts, access: Access) -> Touched:
    corners = extreme_points(surfaces, fixture.touch, least=access.radius)
    return Touched(surfaces, contacts, residual_sigmas(fixture, contacts), corners, fixture.placement)


def _forgotten_tip(fixture: Fixture, touched: Touched) -> float:
    """The tip radius that is forgotten: that of contacts or fixture, else the usual one if it fits the bores."""
    radius = touched.contacts.tip_radius or fixture.probe.tip_radius or 0.0
    if radius > 0:
        return radius
    curved = [surface for surface in touched.surfaces.values() if isinstance(surface, Sphere | Cylinder)]
    bores = [_BORE_SHARE * surface.radius for surface in curved if surface.side == "inner"]
    return min([_USUAL_TIP * factor("m", fixture.units), *bores])
