"""What to do where pose and tip together are not found: where to touch next and how, or which contact to doubt."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts, Unknown
from tactfix.diagnosis.messages import one_of
from tactfix.diagnosis.ranking import INDISTINCT
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Surface, moved
from tactfix.localization.missing_contacts import missing_contact, touch_in_words
from tactfix.localization.next_contact import next_contact
from tactfix.noise import chi_square_limit
from tactfix.poses.pose_fit import contact_residuals
from tactfix.results import Diagnosis, NextContact
from tactfix.unknowns.descent import descend
from tactfix.unknowns.equations import TipEquations
from tactfix.unknowns.solution import TipSolution

WRONG_CONTACTS_TOLD = 8
"""Contacts of which one may be wrong that are told."""


def telling_contact(fixture: Fixture, left: Sequence[TipSolution]) -> NextContact | None:
    """The contact that tells the poses that are left apart, as each has its own tip."""
    sigma = float(left[0].contacts.sigmas.max())
    return next_contact(fixture, [each.solution for each in left], sigma, left[0].contacts.tip_radius)


def turned_contact(fixture: Fixture, loosest: TipSolution) -> NextContact | None:
    """The contact to make next where a motion is free, with the tool turned where one of the tip is.

    In the fixture frame alone: where the fixture stands is not known.
    """
    found = missing_contact(fixture, loosest.contacts, loosest.solution)
    if found is None or loosest.tip_is_known:
        return found
    point, approach = found.point_in_fixture, found.approach_in_fixture
    assert point is not None
    assert approach is not None
    touch = touch_in_words(found.feature, point, approach, None, float(loosest.contacts.sigmas.min()))
    # A contact in an orientation that was there already tells of the tip what they all tell.
    words = f"{touch.message}, with the tool turned about another axis than so far, the farther the better"
    return replace(touch, message=words)


def suspects(
    contacts: Contacts,
    sigmas: Floats,
    unknown: frozenset[Unknown],
    fixture: Fixture,
    nearest: TipSolution,
    surfaces: Mapping[str, Surface],
) -> tuple[Diagnosis, ...]:
    """The contacts without one of which pose and tip explain the others; nothing where there is none.

    nearest: what explains them best; each set without one contact is fitted from there. sigmas (n,) of the residuals.
    """
    found = []
    for i in range(len(contacts)):
        rest = np.delete(np.arange(len(contacts)), i)
        equations = TipEquations.build(surfaces, contacts.subset(rest), sigmas[rest], unknown, fixture.placement)
        dof = len(equations) - len(equations.columns)
        pose, radius = nearest.solution.base_from_fixture, nearest.contacts.tip_radius
        trials, cost = descend(equations, equations.trials(pose[None], nearest.tip[None], radius))
        if dof > 0 and cost[0] <= chi_square_limit(dof):
            there = equations.poses(trials)[0]
            change, tip = equations.length * trials.tips[0], float(equations.length * trials.radii[0])
            in_base = {name: moved(there, surface) for name, surface in surfaces.items()}
            off = contact_residuals(in_base, contacts.subset([i]).with_tip(change, tip))[0]
            found.append(_outlier(contacts, i, float(off[0]), float(cost[0])))
    found.sort(key=lambda cause: cause.chi2 or 0.0)
    alike = [cause for cause in found if (cause.chi2 or 0.0) <= (found[0].chi2 or 0.0) + INDISTINCT]
    return (one_of(alike[:WRONG_CONTACTS_TOLD]), *found[len(alike) : WRONG_CONTACTS_TOLD]) if found else ()


def _outlier(contacts: Contacts, i: int, off: float, chi2: float) -> Diagnosis:
    message = f"without {contacts.label(i)} ({contacts.features[i]}) the others are consistent: touch it again"
    return Diagnosis("outlier", (contacts.rows[i],), (contacts.features[i],), off, chi2, message)
