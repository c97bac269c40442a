"""Plans leave one pose: checked by a search without code of locate; approaches are turned where this is necessary."""

import numpy as np
import pytest

from tactfix.accessibility.access import access_of
from tactfix.contacts import Contacts
from tactfix.files.fixture_file import load_fixture
from tactfix.planning.plan import plan
from tactfix.planning.uniqueness import separating_approaches, uniqueness_of
from tactfix.relations.realization import realize
from tests.support.placed_cells import all_cells
from tests.support.rival_search import poses_within, survives
from tests.validation.plan_against_random import SHIPPED


@pytest.mark.slow
@pytest.mark.parametrize(
    "fixture", [*all_cells(), *map(load_fixture, SHIPPED)], ids=lambda fixture: f"{fixture.name}-{fixture.units}"
)
@pytest.mark.parametrize("count", [6, 7])
def test_no_second_pose_is_within_ten_sigma(fixture, count):
    found = plan(fixture, count)
    assert found.unique
    contacts = found.contacts
    sigmas = np.hypot(contacts.sigmas, [fixture.features[name].sigma for name in contacts.features])
    poses = poses_within(realize(fixture)[0], contacts, sigmas)
    left = [chi2 for rotation, points, normals, chi2 in poses if survives(fixture, contacts, rotation, points, normals)]
    assert len(left) == 1
    assert left[0] < 1e-6


PAPER_BAR = np.array(
    [
        [2.927025, 2.0, 1.625],
        [1.775, 2.8, 1.443785],
        [1.372975, 2.6, 3.11662],
        [2.075, 3.4, 2.185405],
        [3.527025, 3.2, 3.10824],
    ]
)
PAPER_BALL = np.array([[5.456074, 4.6, 2.543645], [5.981074, 4.4, 3.841479]])


def paper_contacts():
    """Section 6 of the paper in the fixture frame of its solution, approached along the normals: ambiguous."""
    y, x = np.array([-0.3, -0.6, -0.74162]), np.array([0.927025, 0, -0.375])
    y /= np.linalg.norm(y)
    x -= (x @ y) * y
    x /= np.linalg.norm(x)
    rotation = np.stack([x, y, np.cross(x, y)])
    points = (np.vstack([PAPER_BAR, PAPER_BALL]) - [2.9, 3.8, 4.224859]) @ rotation.T
    normals = points.copy()
    normals[:5, 1] = 0
    normals[5:] -= [3.0, 0, 0]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    names = ("bar",) * 5 + ("ball",) * 2
    contacts = Contacts(names, points, -normals, np.full(7, 2e-6), 0.0, tuple(range(1, 8)), (None,) * 7)
    return contacts, normals


def test_an_approach_is_tilted_if_normal_ones_leave_two_poses():
    fixture = load_fixture(next(path for path in SHIPPED if path.stem == "cylinder-sphere"))
    contacts, normals = paper_contacts()
    square = uniqueness_of(fixture, contacts)
    assert square.located
    assert len(square.rivals) == 1
    access = access_of(fixture, realize(fixture)[0], 0.0)
    turned = separating_approaches(access, contacts, normals, square.rivals)
    cosine = -(turned.approaches * normals).sum(axis=1)
    assert np.allclose(np.linalg.norm(turned.approaches, axis=1), 1)
    assert (cosine < 1 - 1e-9).sum() == 1
    assert cosine.min() >= np.cos(np.radians(45)) - 1e-9
    assert uniqueness_of(fixture, turned).unique


def test_contacts_that_leave_a_motion_free_are_not_called_unique():
    contacts, _ = paper_contacts()
    fixture = load_fixture(next(path for path in SHIPPED if path.stem == "cylinder-sphere"))
    verdict = uniqueness_of(fixture, contacts.on("bar"))
    assert not verdict.located
    assert not verdict.unique
