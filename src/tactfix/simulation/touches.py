"""The touches of a simulation in the fixture frame: those of a plan, or random ones that the probe can make."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from tactfix.accessibility.access import Access
from tactfix.contacts import Contacts
from tactfix.errors import Problem, UsageError
from tactfix.geometry.arrays import Floats, circle_axes, lengths
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Surface, feet, outward_normals
from tactfix.simulation.fixture_faults import Touches
from tactfix.wording import borne, with_unit

CONE_DEG = 20.0
"""Half angle (degrees) of the cone around the inward normal in which a random touch comes: as square as a hand or a
program usually keeps it, and far from grazing (`contacts.GRAZING`)."""
_ENOUGH_ALONE: dict[type[Surface], int] = {Plane: 4, Cylinder: 6, Point: 1}
"""Contacts on one feature of a random plan: enough to locate it alone with unknown size, and one more."""
_ENOUGH_ON_A_BALL = 4
"""The same for a sphere, whose radius is known."""
MOST_SIMULATED: Final = 100_000
"""More than are made in practice; each takes the memory of 64 candidate points."""
_PLAN_OFF: Final = 0.1
"""Share of the plan's spread that a planned touch may be off its surface, since plans are written by hand."""
_PLACES_PER_TOUCH = 64
"""Candidate points for each random touch, enough for a choice among those that the probe can reach."""

_PLAN_REMEDY: Final = (
    "a plan is in the fixture frame, while contacts that were made are in base; "
    "tactfix plan makes one, and without a plan the touches are random"
)


class NoPlanError(UsageError):
    """Contacts that are not on the fixture in its own frame; a caller that knows their file raises a FileError."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        super().__init__(problem.text)


def planned_touches(access: Access, plan: Contacts) -> Touches:
    """The touches of a plan; contacts without an approach are approached along the normal.

    Raises NoPlanError for a touch that is far from its surface.
    """
    surfaces = access.surfaces
    points = np.array([feet(surfaces[f], p) for f, p in zip(plan.features, plan.points, strict=True)])
    off = lengths(points - plan.points) - plan.tip_radius
    if off.max() > _PLAN_OFF * plan.spread:
        worst = int(off.argmax())
        far = with_unit(borne(float(f"{off[worst]:.3g}"), None), plan.units)
        message = f"this touch is {far} off {plan.features[worst]} in the fixture frame, so the contacts are not a plan"
        raise NoPlanError(Problem(message, _PLAN_REMEDY, row=plan.rows[worst]))
    normals = np.array([outward_normals(surfaces[f], p) for f, p in zip(plan.features, points, strict=True)])
    approaches = np.where(plan.has_approach[:, None], plan.approaches, -normals)
    return Touches(plan.features, points.reshape(-1, 3), normals.reshape(-1, 3), approaches, access.tip_radius)


def shares(surfaces: Mapping[str, Surface], count: int | None) -> dict[str, int]:
    """The number of contacts on each feature: in proportion to what each needs alone, and exactly that for None.

    Raises UsageError for fewer contacts than one.
    """
    wanted = {name: _ENOUGH_ALONE.get(type(surface), _ENOUGH_ON_A_BALL) for name, surface in surfaces.items()}
    if count is None:
        return wanted
    if not 1 <= count <= MOST_SIMULATED:
        raise UsageError(f"{count} contacts cannot be simulated; ask for one or more, {MOST_SIMULATED} at most")
    share = dict.fromkeys(wanted, 0)
    for _ in range(count):
        share[min(wanted, key=lambda name: (share[name] + 0.5) / wanted[name])] += 1
    return share


def random_touches(access: Access, count: int | None, rng: np.random.Generator) -> Touches:
    """Random touches with approaches in a cone about the normals, distributed by `shares`."""
    names: list[str] = []
    chosen: list[tuple[Floats, Floats, Floats]] = []
    for name, wanted in shares(access.surfaces, count).items():
        start = rng.uniform(size=2)
        points, normals = access.spread(name, _PLACES_PER_TOUCH * max(wanted, 1), (float(start[0]), float(start[1])))
        tilted = _tilted(-normals, rng)
        # If only the approach along the normal is clear, it is taken.
        clear = access.can_touch(name, points, normals, tilted)
        approaches = np.where(clear[:, None], tilted, -normals)
        if isinstance(access.surfaces[name], Point):
            points, normals, approaches = (np.repeat(part, wanted, axis=0) for part in (points, normals, approaches))
        if len(points) < wanted:
            raise UsageError(
                f"{name} cannot be touched {wanted} times: its touch box leaves too little of it, or other features "
                "block every straight approach; enlarge the box, or shorten probe: approach_distance"
            )
        pick = rng.permutation(len(points))[:wanted]
        names += [name] * wanted
        chosen.append((points[pick], normals[pick], approaches[pick]))
    points, normals, approaches = (np.concatenate(part) for part in zip(*chosen, strict=True))
    return Touches(tuple(names), points, normals, approaches, access.tip_radius)


def _tilted(directions: Floats, rng: np.random.Generator) -> Floats:
    """Unit directions (n, 3) turned by up to CONE_DEG, uniform over the cone's solid angle."""
    cosine = rng.uniform(np.cos(np.radians(CONE_DEG)), 1.0, len(directions))[:, None]
    around = rng.uniform(0.0, 2 * np.pi, len(directions))[:, None]
    u, v = circle_axes(directions)
    return np.asarray(cosine * directions + np.sqrt(1 - cosine**2) * (np.cos(around) * u + np.sin(around) * v))
