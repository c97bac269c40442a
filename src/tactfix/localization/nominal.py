"""Locating the contacts of a plan, which are in the fixture frame.

What is known beforehand is known in base. So contacts are transformed to base by the expected pose, located, and the
result is transformed back: the right pose is the identity, whether the fixture has a placement or not.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import inverse
from tactfix.geometry.surfaces import Surface, moved
from tactfix.localization.locate import locate
from tactfix.locate_result import LocateResult


def expected_pose(fixture: Fixture) -> Floats | None:
    """The expected pose base_from_fixture (4, 4); None if nothing is known."""
    return None if fixture.placement is None else fixture.placement.near


def locate_nominal(fixture: Fixture, contacts: Contacts, base_from_fixture: Floats | None) -> LocateResult:
    """The result of locate, without explanations, for contacts in the fixture frame and a fixture at base_from_fixture.

    The result is in the fixture frame, without free motions and next contact, whose messages are in base. None: any
    pose, which is only allowed if nothing is known beforehand.
    """
    if base_from_fixture is None:
        return locate(fixture, contacts, explain=False)
    found: LocateResult = locate(fixture, contacts.moved(base_from_fixture), explain=False)
    fixture_from_base = inverse(base_from_fixture)
    turn = np.kron(np.eye(2), fixture_from_base[:3, :3])
    pose, covariance = found.base_from_fixture, found.covariance
    candidates = tuple(
        replace(
            c, base_from_fixture=fixture_from_base @ c.base_from_fixture, surfaces=_seen(c.surfaces, fixture_from_base)
        )
        for c in found.candidates
    )
    return replace(
        found,
        base_from_fixture=None if pose is None else fixture_from_base @ pose,
        covariance=None if covariance is None else turn @ covariance @ turn.T,
        candidates=candidates,
        surfaces=_seen(found.surfaces, fixture_from_base),
        free_motions=(),
        next_contact=None,
    )


def _seen(surfaces: Mapping[str, Surface], fixture_from_base: Floats) -> Mapping[str, Surface]:
    return {name: moved(fixture_from_base, surface) for name, surface in surfaces.items()}
