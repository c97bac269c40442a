"""Predicted accuracy against finite differences, information matrices without a contact, and definitions."""

import numpy as np
import pytest

from tactfix.design.accuracy import certainty, free_of
from tactfix.design.nominal_contacts import Touched
from tactfix.geometry.scale import tolerance_for
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tests.support.plans import contacts_of

SURFACES = {
    "table": Plane(np.zeros(3), np.array([0.0, 0.0, 1.0])),
    "ball": Sphere(np.array([60.0, 10.0, 30.0]), 12.0),
    "bore": Cylinder(np.array([-20.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]), 9.0, "inner"),
}
TIP = 2.0
CORNERS = np.array([[80.0, 40.0, 40.0], [-30.0, -30.0, 0.0], [80.0, -30.0, 40.0]])


def distance(name, x):
    """Signed distance of a tip centre from contact with a feature, written out."""
    if name == "table":
        return x[2] - TIP
    if name == "ball":
        return np.linalg.norm(x - [60, 10, 30]) - 12 - TIP
    return 9 - np.hypot(x[0] + 20, x[1]) - TIP


def touches():
    rng = np.random.default_rng(8)
    names = ["table"] * 4 + ["ball"] * 4 + ["bore"] * 4
    points = []
    for name in names:
        v = rng.normal(size=3)
        v /= np.linalg.norm(v)
        if name == "table":
            points.append([60 * v[0], 40 * v[1], TIP])
        elif name == "ball":
            points.append(np.array([60, 10, 30]) + 14 * v)
        else:
            u = v[:2] / np.linalg.norm(v[:2])
            points.append([-20 + 7 * u[0], 7 * u[1], -15 * abs(v[2])])
    sigmas = rng.uniform(0.005, 0.02, len(names))
    return contacts_of(names, np.array(points), np.full((len(names), 3), np.nan), 0.01, TIP), sigmas


def jacobian(contacts, sigmas):
    """Central differences of distance / sigma over small motions of the fixture."""
    step, rows = 1e-5, []
    for name, p, sigma in zip(contacts.features, contacts.points, sigmas, strict=True):
        row = []
        for k in range(6):
            w, v = np.zeros(3), np.zeros(3)
            (w if k < 3 else v)[k % 3] = step
            distances = [distance(name, p - s * (v + np.cross(w, p))) for s in (1, -1)]
            row.append((distances[0] - distances[1]) / (2 * step) / sigma)
        rows.append(row)
    return np.array(rows)


def sigma_at(covariance, x):
    m = np.array([[0, x[2], -x[1]], [-x[2], 0, x[0]], [x[1], -x[0], 0]])
    j = np.hstack([m, np.eye(3)])
    return np.sqrt(np.linalg.eigvalsh(j @ covariance @ j.T)[-1])


@pytest.fixture(scope="module")
def judged():
    contacts, sigmas = touches()
    at = np.array([[1.0, 2.0, 3.0]])
    found = certainty(Touched(SURFACES, contacts, sigmas, CORNERS), at, tolerance_for(SURFACES), "plan")
    return contacts, sigmas, jacobian(contacts, sigmas), found


def test_covariance_is_the_inverse_of_the_information(judged):
    _, _, j, found = judged
    np.testing.assert_allclose(found.covariance, np.linalg.inv(j.T @ j), rtol=1e-5, atol=1e-12)


def test_worst_point_and_requested_points(judged):
    _, _, j, found = judged
    covariance = np.linalg.inv(j.T @ j)
    assert found.worst.sigma == pytest.approx(max(sigma_at(covariance, c) for c in CORNERS), rel=1e-5)
    assert [p.sigma for p in found.extreme] == pytest.approx([sigma_at(covariance, c) for c in CORNERS], rel=1e-5)
    assert found.at[0].sigma == pytest.approx(sigma_at(covariance, np.array([1.0, 2.0, 3.0])), rel=1e-5)


def test_the_direction_known_worst_at_a_point(judged):
    """The variance along it is the largest of those along a thousand random directions."""
    _, _, j, found = judged
    covariance, (x, y, z) = np.linalg.inv(j.T @ j), found.worst.point
    at = np.hstack([[[0, z, -y], [-z, 0, x], [y, -x, 0]], np.eye(3)])
    local = at @ covariance @ at.T
    others = np.random.default_rng(4).normal(size=(1000, 3))
    others /= np.linalg.norm(others, axis=1)[:, None]
    along = found.worst.direction @ local @ found.worst.direction
    assert along == pytest.approx(found.worst.sigma**2, rel=1e-5)
    assert max(o @ local @ o for o in others) <= along * (1 + 1e-5)


def test_the_worst_known_rotation(judged):
    covariance = np.linalg.inv(judged[2].T @ judged[2])
    assert judged[3].turn_sigma == pytest.approx(np.sqrt(np.linalg.norm(covariance[:3, :3], 2)), rel=1e-5)


def test_the_contact_that_matters_most_and_least(judged):
    contacts, _, j, found = judged
    without = []
    for i in range(len(contacts)):
        rest = np.delete(j, i, axis=0)
        without.append(max(sigma_at(np.linalg.inv(rest.T @ rest), c) for c in CORNERS))
    assert found.most.label == f"row {np.argmax(without) + 1}"
    assert found.most.sigma_without == pytest.approx(max(without), rel=1e-4)
    assert found.least.label == f"row {np.argmin(without) + 1}"
    assert found.least.sigma_without == pytest.approx(min(without), rel=1e-4)


def test_a_contact_that_alone_constrains_a_motion_matters_most():
    contacts, sigmas = touches()
    six = contacts.subset([0, 1, 2, 4, 8, 9])
    found = certainty(Touched(SURFACES, six, sigmas[:6], CORNERS), np.zeros((0, 3)), tolerance_for(SURFACES), "plan")
    assert found.most.sigma_without is None


def test_observability_indices_by_definition(judged):
    contacts, sigmas, j, found = judged
    centre = contacts.points.mean(axis=0)
    length = np.sqrt(((contacts.points - centre) ** 2).sum(axis=1).mean())
    rows = j * sigmas[:, None]
    rows[:, :3] -= np.cross(centre, rows[:, 3:])
    rows[:, :3] /= length
    s = np.sqrt(np.linalg.eigvalsh(rows.T @ rows))[::-1]
    assert found.observability.length == pytest.approx(length)
    expected = {
        "O1": np.prod(s) ** (1 / 6) / np.sqrt(len(contacts)),
        "O2": s[-1] / s[0],
        "O3": s[-1],
        "O4": s[-1] ** 2 / s[0],
        "O5": 1 / np.sum(1 / s),
    }
    assert found.observability.indices == pytest.approx(expected, rel=1e-5)


def test_the_weakest_motion_is_one_sigma_of_itself(judged):
    """One standard deviation along the weakest direction raises chi-square by one."""
    _, _, j, found = judged
    motion = np.concatenate([found.weakest.rotation, found.weakest.translation])
    assert np.sum((j @ motion) ** 2) == pytest.approx(1.0, rel=1e-4)
    others = np.random.default_rng(1).normal(size=(1000, 6)) * np.sqrt(np.diag(found.covariance))
    length = found.observability.length
    centre = judged[0].points.mean(axis=0)

    def size(m):
        v = m[3:] + np.cross(m[:3], centre)
        return np.hypot(np.linalg.norm(m[:3]) * length, np.linalg.norm(v)) / np.sqrt(np.sum((j @ m) ** 2))

    assert max(size(m) for m in others) <= size(motion) * (1 + 1e-6)


def test_contacts_that_miss_a_motion_name_it():
    contacts, _ = touches()
    few = contacts.subset(list(range(8)))
    free = free_of(Touched(SURFACES, few, few.sigmas, CORNERS), tolerance_for(SURFACES))
    assert [m.message for m in free] == ["rotates about the normal of table through the centre of ball"]
    assert not free_of(Touched(SURFACES, contacts, contacts.sigmas, CORNERS), tolerance_for(SURFACES))
