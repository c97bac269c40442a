"""The lower bound of chi-square against random poses, and cases in which it must be positive."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from tactfix.diagnosis.feasibility import are_beyond_boxes, least_chi_square
from tactfix.fixture import TouchBox
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tests.support.plans import contacts_of

SURFACES = {
    "table": Plane(np.array([0, 0, -40.0]), np.array([0, 0, 1.0])),
    "ball": Sphere(np.array([60.0, 10.0, 30.0]), 12.0),
    "socket": Sphere(np.array([-50.0, 10.0, 0.0]), 15.0, "inner"),
    "pin": Cylinder(np.array([0.0, 50.0, 0.0]), np.array([0, 0, 1.0]), 9.0),
}
TIP = 2.0
INF = np.inf


def off(name, x):
    """Signed distances (n,) of tip centres from contact, written out."""
    if name == "table":
        return x[:, 2] + 40 - TIP
    if name == "pin":
        return np.hypot(x[:, 0], x[:, 1] - 50) - 11
    return (
        np.linalg.norm(x - [60, 10, 30], axis=1) - 14
        if name == "ball"
        else 13 - np.linalg.norm(x - [-50, 10, 0], axis=1)
    )


def random_pose(rng):
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return (q if np.linalg.det(q) > 0 else -q), 80 * rng.normal(size=3)


def touched_at(points, names):
    return contacts_of(names, np.array(points, dtype=float), np.full((len(names), 3), np.nan), 0.5, TIP)


def test_no_pose_falls_below_the_bound():
    rng = np.random.default_rng(3)
    positive = 0
    for _ in range(60):
        names = [str(name) for name in rng.choice(list(SURFACES), 5)]
        contacts = touched_at(rng.normal(size=(5, 3)) * rng.choice([1.0, 10, 40]), names)
        bound = least_chi_square(SURFACES, contacts, contacts.sigmas)
        positive += bound > 0
        for _ in range(40):
            rotation, shift = random_pose(rng)
            fixture = (contacts.points - shift) @ rotation
            chi2 = sum((off(n, x[None])[0] / 0.5) ** 2 for n, x in zip(names, fixture, strict=True))
            assert chi2 >= bound * (1 - 1e-12)
    assert 20 < positive < 60


@pytest.mark.parametrize(
    ("names", "apart", "excess"),
    [
        (("ball", "ball"), 40.0, 12.0),  # a ball of 12 and a tip of 2: 28 across
        (("ball", "ball"), 27.0, 0.0),
        (("socket", "socket"), 30.0, 4.0),  # a bore of 15 and a tip of 2: 26 across
        (("ball", "socket"), 200.0, 200 - np.hypot(110, 30) - 27),
        (("ball", "socket"), 10.0, np.hypot(110, 30) - 27 - 10),
        (("ball", "pin"), 10.0, np.hypot(60, 40) - 25 - 10),
        (("ball", "pin"), 1e4, 0.0),  # a pin has no ends
        (("ball", "table"), 10.0, 70 - TIP - 14 - 10),
        (("pin", "table"), 0.0, 0.0),
    ],
)
def test_two_contacts_by_hand(names, apart, excess):
    contacts = touched_at([[0, 0, 0], [apart, 0, 0]], list(names))
    assert least_chi_square(SURFACES, contacts, contacts.sigmas) == pytest.approx(excess**2 / (2 * 0.5**2), abs=1e-9)


def test_four_contacts_that_are_not_even_lie_on_no_plane():
    corners = [[0, 0, 0], [10, 0, 0], [0, 10, 0], [10, 10, 8.0]]
    contacts = touched_at(corners, ["table"] * 4)
    # The best plane through a square with one corner raised by h leaves a residual of h / 4 at each corner.
    tilt = np.arctan(np.hypot(0.4, 0.4))
    assert least_chi_square(SURFACES, contacts, contacts.sigmas) == pytest.approx(
        4 * (2 * np.cos(tilt) / 0.5) ** 2, rel=0.05
    )


@pytest.mark.parametrize(("turned", "least", "most"), [(0.0, 0.0, 1e-9), (0.1, 0.3, 1.0)])
def test_planes_whose_contacts_are_at_another_angle(turned, least, most):
    """Table and wall are perpendicular; the wall's contacts are rotated by 0.1 rad."""
    surfaces = {**SURFACES, "wall": Plane(np.zeros(3), np.array([1.0, 0, 0]))}
    table = [[0, 0, 0], [40, 0, 0], [0, 40, 0], [40, 40, 0]]
    wall = [[0, 0, 10], [0, 40, 10], [turned * 40, 0, 50], [turned * 40, 40, 50]]
    contacts = touched_at([*table, *wall], ["table"] * 4 + ["wall"] * 4)
    # The best fit shares the angle equally; the contacts are 20 mm from the middle of each plane.
    shared = 8 * (0.05 * 20 / 0.5) ** 2 if turned else 1.0
    assert least * shared <= least_chi_square(surfaces, contacts, contacts.sigmas) <= most * shared


def test_contacts_beyond_their_touch_boxes():
    box = TouchBox(np.array([-5.0, -5.0, -INF]), np.array([5.0, 5.0, INF]))
    near, far = (touched_at([[0, 0, 0], [apart, 0, 0]], ["table"] * 2) for apart in (20.0, 40.0))
    assert not are_beyond_boxes(SURFACES, {"table": box}, near)
    assert are_beyond_boxes(SURFACES, {"table": box}, far)
    assert not are_beyond_boxes(SURFACES, {}, far)


@pytest.mark.parametrize(("name", "radius"), [("ball", 14.0), ("socket", 13.0), ("pin", 11.0)])
def test_contacts_curved_more_than_the_radius_fit_no_surface(name, radius):
    """On a ball or bar of their own size the bound is 0; for a twentieth of the radius it is at most the fit's cost."""
    rng = np.random.default_rng(5)
    turns, heights = rng.uniform(0, 2 * np.pi, 8), rng.uniform(-0.9, 0.9, 8)
    across = np.sqrt(1 - heights**2) if name != "pin" else np.ones(8)
    points = radius * np.column_stack([across * np.cos(turns), across * np.sin(turns), heights])
    sigmas = np.full(8, 0.01)
    assert least_chi_square(SURFACES, touched_at(points, [name] * 8), sigmas) == 0
    shrunk = points / 20
    bound = least_chi_square(SURFACES, touched_at(shrunk, [name] * 8), sigmas)
    left = []
    for _ in range(12):
        fit = least_squares(_residuals, np.zeros(5), args=(rng.normal(size=3), shrunk, name, radius))
        left.append(2 * fit.cost / 0.01**2)
    assert 100 < bound <= min(left)


def _residuals(moves, start, points, name, radius):
    """Distances of points from a ball, or a bar in any direction, near them."""
    arms = points - radius * start / np.linalg.norm(start) - moves[:3]
    if name == "pin":
        axis = np.cross(start, [1.0, moves[3], moves[4]])
        axis /= np.linalg.norm(axis)
        arms = arms - np.outer(arms @ axis, axis)
    return np.linalg.norm(arms, axis=1) - radius
