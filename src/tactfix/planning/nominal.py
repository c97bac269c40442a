"""From touches to contacts and back: nominal contacts are what a perfect probe would report of a plan."""

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.geometry.surfaces import feet, outward_normals, standoff
from tactfix.planning.pool import Pool, Touches
from tactfix.probe import residual_sigmas


def nominal_contacts(pool: Pool, touches: Touches, sigma: float) -> Contacts:
    """The touches as contacts in the fixture frame: tip centres, approached square to the surface.

    A point says nothing of how the tip comes into it: no approach.
    """
    n = len(touches)
    off = [standoff(pool.access.surfaces[pool.names[i]], pool.access.tip_radius) for i in touches.which]
    return Contacts(
        features=tuple(pool.names[i] for i in touches.which),
        points=touches.points + np.array(off)[:, None] * touches.normals,
        approaches=np.where(pool.on_points(touches.which)[:, None], np.nan, -touches.normals),
        sigmas=np.full(n, sigma),
        tip_radius=pool.access.tip_radius,
        rows=tuple(range(1, n + 1)),
        ids=(None,) * n,
    )


def touches_made(pool: Pool, contacts: Contacts | None, fixture: Fixture) -> Touches:
    """Contacts already made, in the fixture frame, as touches with their own sigmas; none where None."""
    if contacts is None:
        return pool.touches.take(np.zeros(0, dtype=np.intp))
    surfaces = [pool.access.surfaces[name] for name in contacts.features]
    points = np.array([feet(surface, point) for surface, point in zip(surfaces, contacts.points, strict=True)])
    normals = np.array([outward_normals(surface, point) for surface, point in zip(surfaces, points, strict=True)])
    which = np.array([pool.names.index(name) for name in contacts.features], dtype=np.intp)
    sigmas = residual_sigmas(fixture, contacts)
    return pool.touches_at(which, points, normals, sigmas)


def joined_contacts(first: Contacts | None, second: Contacts) -> Contacts:
    """The contacts of both, in one frame, rows counted anew; the tip is that of the second."""
    if first is None:
        return second
    return Contacts(
        features=first.features + second.features,
        points=np.concatenate([first.points, second.points]),
        approaches=np.concatenate([first.approaches, second.approaches]),
        sigmas=np.concatenate([first.sigmas, second.sigmas]),
        tip_radius=second.tip_radius,
        rows=tuple(range(1, len(first) + len(second) + 1)),
        ids=first.ids + second.ids,
    )
