"""Forty touches of a cast part on a measuring machine, and the published pose by another program."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.files.contact_source import load_contacts
from tactfix.files.fixture_file import load_fixture
from tactfix.localization.locate import locate
from tactfix.placement import Placement
from tests.support.shared_data import shared_data


@pytest.fixture(scope="module")
def part():
    fixture = load_fixture(shared_data("reference", "real", "cmm_part", "fixture.yaml"))
    contacts = load_contacts(str(shared_data("reference", "real", "cmm_part", "contacts.csv")), fixture)
    published = json.loads(shared_data("reference", "real", "cmm_part", "published.json").read_text())
    return fixture, contacts, np.array(published["base_from_fixture"])


def test_the_published_pose_is_found(part):
    fixture, contacts, published = part
    result = locate(fixture, contacts)
    assert result.status == "located"
    assert np.abs(result.base_from_fixture - published).max() < 1e-6


def rough(pose, rng, degrees=20.0, length=20.0):
    """A random pose within the limits of another."""
    axis, way = rng.normal(size=3), rng.normal(size=3)
    turn = Rotation.from_rotvec(np.radians(rng.uniform(0, degrees)) * axis / np.linalg.norm(axis)).as_matrix()
    near = pose.copy()
    near[:3, :3] = turn @ pose[:3, :3]
    near[:3, 3] += rng.uniform(0, length) * way / np.linalg.norm(way)
    return near


def drawn(contacts, count, rng):
    """A random choice of count contacts, at least one on each feature, without their approaches."""
    while True:
        few = contacts.subset(np.sort(rng.choice(len(contacts), count, replace=False)))
        if len(few.by_feature) == len(contacts.by_feature):
            return few


@pytest.mark.parametrize("count", [8, 11])
def test_limits_keep_the_true_pose(part, count):
    fixture, contacts, published = part
    rng = np.random.default_rng(count)
    for _ in range(4):
        few = drawn(contacts, count, rng)
        result = locate(replace(fixture, placement=Placement(rough(published, rng), (20.0, np.radians(20)))), few)
        assert result.status != "inconsistent"
        assert result.without_prior is not None
        assert result.without_prior.status != "inconsistent"
        if result.status == "located":
            error = result.base_from_fixture[:3, 3] - published[:3, 3]
            assert error @ np.linalg.solve(result.covariance[3:, 3:], error) < 35


@pytest.mark.slow
@pytest.mark.parametrize("count", [6, 7, 8, 9, 11])
def test_limits_leave_one_pose_more_often_and_never_none(part, count):
    fixture, contacts, published = part
    rng = np.random.default_rng(100 + count)
    with_limits = without = 0
    for _ in range(100):
        few = drawn(contacts, count, rng)
        result = locate(replace(fixture, placement=Placement(rough(published, rng), (20.0, np.radians(20)))), few)
        assert result.status != "inconsistent"
        assert result.without_prior is not None
        with_limits += result.status == "located"
        without += result.without_prior.status == "located"
    print(f"{count} contacts: one pose in {with_limits} of 100 draws with limits, in {without} without")
    assert with_limits > without
