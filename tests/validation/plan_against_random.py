"""The worst sigma of plans against that of 10,000 random plans with as many contacts, on the shipped fixtures.

    python -m tests.validation.plan_against_random

Random plans distribute their contacts over all features and touch boxes. Unlike the plan they need not give a unique
pose, be reachable, or keep clear of edges. Shares no code with the planner except the fixture's surfaces: points, rows
and covariances are computed here.
"""

import time

import numpy as np

from tactfix.accessibility.touchable import extreme_points
from tactfix.files.fixture_file import load_fixture
from tactfix.fixture import Fixture
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tactfix.planning.plan import plan
from tactfix.relations.realization import realize
from tests.support.project import FIXTURES

SHIPPED = sorted(FIXTURES.glob("*.yaml"))
RANDOM_PLANS = 10_000


def random_points(surface, box, count, middle, reach, rng):
    """Random points (count, 3) of the surface in its box; open sides of the box are closed at reach from its middle."""
    kept = np.zeros((0, 3))
    while len(kept) < count:
        n = 4 * count
        if isinstance(surface, Sphere):
            v = rng.standard_normal((n, 3))
            points = surface.center + surface.radius * v / np.linalg.norm(v, axis=1, keepdims=True)
        elif isinstance(surface, Cylinder):
            v = np.cross(surface.direction, rng.standard_normal((n, 3)))
            foot = surface.point + ((middle - surface.point) @ surface.direction) * surface.direction
            along = rng.uniform(-reach, reach, (n, 1)) * surface.direction
            points = foot + along + surface.radius * v / np.linalg.norm(v, axis=1, keepdims=True)
        else:
            points = middle + rng.uniform(-reach, reach, (n, 3))
            points -= ((points - surface.point) @ surface.normal)[:, None] * surface.normal
        if box is not None:
            slack = 1e-9 * reach
            points = points[((points >= box.low - slack) & (points <= box.high + slack)).all(axis=1)]
        kept = np.concatenate([kept, points])
    return kept[:count]


def outward(surface, points):
    if isinstance(surface, Plane):
        return np.broadcast_to(surface.normal, points.shape)
    arms = points - (surface.center if isinstance(surface, Sphere) else surface.point)
    if isinstance(surface, Cylinder):
        arms = arms - (arms @ surface.direction)[:, None] * surface.direction
    return arms / np.linalg.norm(arms, axis=1, keepdims=True)  # the side has no effect on the information


def worst_sigmas(points, normals, sigmas, corners):
    """Worst sigma (k,) over corners (c, 3) for k sets of contacts: points and normals (k, n, 3), sigmas (k, n)."""
    middle, size = corners.mean(axis=0), np.ptp(corners, axis=0).max()
    arms = (points - middle) / size
    rows = np.concatenate([np.cross(arms, normals), normals], axis=2) / sigmas[..., None]
    values, vectors = np.linalg.eigh(np.swapaxes(rows, 1, 2) @ rows)
    values = np.maximum(values, 1e-12 * values[:, -1:])
    covariances = (vectors / values[:, None, :]) @ np.swapaxes(vectors, 1, 2)
    worst = np.zeros(len(points))
    for x, y, z in (corners - middle) / size:
        jacobian = np.array([[0, z, -y, 1, 0, 0], [-z, 0, x, 0, 1, 0], [y, -x, 0, 0, 0, 1]])
        worst = np.maximum(worst, np.linalg.eigvalsh(jacobian @ covariances @ jacobian.T)[:, -1])
    return np.sqrt(worst)


def random_worst_sigmas(fixture: Fixture, count: int, seed: int = 0, plans: int = RANDOM_PLANS):
    """The worst sigmas (plans,) of random plans with count contacts."""
    rng = np.random.default_rng(seed)
    surfaces = realize(fixture)[0]
    corners = extreme_points(surfaces, fixture.touch)
    middle, reach = corners.mean(axis=0), np.linalg.norm(np.ptp(corners, axis=0)) / 2
    names = list(surfaces)
    stock = 4000
    points = np.array([random_points(surfaces[n], fixture.touch.get(n), stock, middle, reach, rng) for n in names])
    normals = np.array([outward(surfaces[n], p) for n, p in zip(names, points, strict=True)])
    sigma = np.array([np.hypot(fixture.probe.sigma, fixture.features[n].sigma) for n in names])
    which = rng.integers(len(names), size=(plans, count))
    pick = rng.integers(stock, size=(plans, count))
    return worst_sigmas(points[which, pick], normals[which, pick], sigma[which], corners)


def plan_worst_sigma(fixture: Fixture, found) -> float:
    """The worst sigma of a plan, computed from its contacts."""
    surfaces = realize(fixture)[0]
    contacts = found.contacts
    touched = [surfaces[name] for name in contacts.features]
    normals = np.array([outward(s, p[None])[0] for s, p in zip(touched, contacts.points, strict=True)])
    sigma = np.hypot(contacts.sigmas, [fixture.features[name].sigma for name in contacts.features])
    inner = np.array([getattr(surface, "side", "outer") == "inner" for surface in touched])
    on_surface = contacts.points - contacts.tip_radius * np.where(inner[:, None], -normals, normals)
    return float(worst_sigmas(on_surface[None], normals[None], sigma[None], extreme_points(surfaces, fixture.touch))[0])


def main() -> None:
    print(f"{'fixture':24} {'contacts':>8} {'plan':>10} {'best of random':>14} {'median':>10} {'cpu s':>8}")
    for path in SHIPPED:
        fixture = load_fixture(path)
        for count in (None, 9, 12):
            began = time.process_time()
            found = plan(fixture, count)
            took = time.process_time() - began
            random = random_worst_sigmas(fixture, len(found.contacts))
            worst = plan_worst_sigma(fixture, found)
            best, median = random.min(), np.median(random)
            row = f"{fixture.name:24} {len(found.contacts):8} {worst:10.3g} {best:14.3g} {median:10.3g}"
            print(f"{row} {took:8.2f}{'' if found.unique else '  not unique'}{'  with table' if count is None else ''}")


if __name__ == "__main__":
    main()
