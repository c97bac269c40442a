"""Placements optimized in parallel: they end where contacts and relations place the features, for every kind."""

import numpy as np
import pytest

import tactfix
from tactfix.geometry.charts import dimension, displaced
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tactfix.probe import residual_sigmas
from tactfix.relations import samples
from tactfix.relations.joint_problem import JointProblem
from tactfix.relations.placements import settled
from tactfix.relations.realization import fixture_scale
from tests.relations.touched_parts import turned_part
from tests.validation import relation_touches
from tests.validation.relation_geometry import KINDS, Angle
from tests.validation.relation_touches import by_geometry, by_relations
from tests.validation.relations_study import Cell, drawn, loaded, located

ANGLE = {"slab with hole": 20.0, "pins of equal lean": 20.0}


def touched_part(kind, folder, seed, noise=0.0, most=99):
    """Fixture files, the touches, and the objects read from them; most: contacts on each feature."""
    rng = np.random.default_rng([seed, *kind.encode()])
    degrees = ANGLE.get(kind, 60.0)
    part, touched = turned_part(kind, rng, Angle(degrees, 0.0, degrees, 0.0), most)
    (folder / "relations.yaml").write_text(by_relations(part))
    (folder / "geometry.yaml").write_text(by_geometry(part))
    (folder / "contacts.csv").write_text(touched.csv(0.01, noise * rng.standard_normal(len(touched.names))))
    fixture = tactfix.load_fixture(folder / "relations.yaml")
    return part, touched, fixture, tactfix.load_contacts(folder / "contacts.csv", fixture)


def in_base(thing, base):
    at, along = base[:3, :3] @ thing.at + base[:3, 3], base[:3, :3] @ thing.along
    if thing.kind == "sphere":
        return Sphere(at, thing.radius, thing.side)
    return Plane(at, along) if thing.kind == "plane" else Cylinder(at, along, thing.radius, thing.side)


@pytest.mark.parametrize("kind", KINDS)
def test_a_placement_near_the_truth_ends_there(kind, tmp_path):
    """All residuals vanish there and nowhere nearby; the parts are built without the package."""
    part, touched, fixture, contacts = touched_part(kind, tmp_path, seed=1)
    problem = JointProblem(contacts, residual_sigmas(fixture, contacts), fixture.relations, fixture_scale(fixture))
    truth = {name: in_base(thing, touched.base_from_part) for name, thing in part.things.items()}
    rng = np.random.default_rng(4)

    def off(surface):
        step = rng.normal(size=dimension(surface))
        tilts = 0 if isinstance(surface, Sphere) else 2
        return displaced(surface, np.concatenate([0.02 * step[:tilts], step[tilts:]]))

    ends, chi2 = settled(fixture, problem, [{name: off(s) for name, s in truth.items()} for _ in range(3)])
    assert len(ends) == len(chi2) == 3
    assert chi2 == pytest.approx(0, abs=1e-3)
    for name, surface in ends[0].items():
        expected = truth[name]
        if isinstance(expected, Sphere):
            assert surface.center == pytest.approx(expected.center, abs=1e-3)
        else:
            along = surface.normal if isinstance(expected, Plane) else surface.direction
            other = expected.normal if isinstance(expected, Plane) else expected.direction
            assert along == pytest.approx(other, abs=1e-4)


@pytest.mark.parametrize("kind", ["slab with hole", "bar beside ball on plate", "pins of equal lean"])
@pytest.mark.parametrize("seed", [1, 2])
def test_with_few_contacts_a_feature_the_pose_is_still_found(kind, seed, tmp_path):
    """Three contacts do not locate a bar alone; the place that agrees with contacts and relations is found."""
    _, touched, fixture, contacts = touched_part(
        kind, tmp_path, seed, noise=1.0, most=4 if kind != "slab with hole" else 3
    )
    by_relation = tactfix.locate(fixture, contacts)
    assert by_relation.status in ("located", "ambiguous")
    left = [c.base_from_fixture for c in by_relation.candidates if c.accepted]
    apart = [np.abs(pose[:3, :3] - touched.base_from_fixture[:3, :3]).max() for pose in left]
    assert min(apart) < 0.02


def test_a_scan_is_placed_by_some_contacts_and_fitted_by_all(tmp_path, monkeypatch):
    """128 placements need a row of numbers for each contact, so only a part of the contacts is used."""
    _, touched, fixture, contacts = touched_part("bar beside ball on plate", tmp_path, seed=1, noise=1.0, most=3)
    first = contacts.by_feature["plate"]
    rng, count = np.random.default_rng(5), 3000
    across = np.diff(touched.points[first], axis=0)
    scan = touched.points[first[0]] + rng.uniform(-1, 1, (count, 2)) @ across
    scan += 0.01 * rng.standard_normal((count, 1)) * touched.normals[first[0]]
    others = np.setdiff1d(np.arange(len(contacts)), first)
    names = ["plate"] * count + [contacts.features[i] for i in others]
    points = np.vstack([scan, contacts.points[others]])
    approaches = np.vstack([np.repeat(contacts.approaches[first[:1]], count, axis=0), contacts.approaches[others]])
    many = tactfix.contacts_from_arrays(names, points, approaches=approaches, sigma=0.01, tip_radius=0.0)
    counts, settle = [], samples.settled
    monkeypatch.setattr(samples, "settled", lambda *given: counts.append(len(given[1].contacts)) or settle(*given))
    result = tactfix.locate(fixture, many)
    assert counts == [samples.PLACED_CONTACTS + len(others)]
    left = [c.base_from_fixture for c in result.candidates if c.accepted]
    assert min(np.abs(pose[:3, :3] - touched.base_from_fixture[:3, :3]).max() for pose in left) < 0.02
    assert len(result.contacts) == len(many)


@pytest.mark.parametrize("seed", [5000, 5001, 5002])
def test_relations_that_are_tightened_later_lead_more_placements_to_solutions(seed, tmp_path, monkeypatch):
    """With tight relations from the start 1 to 3 of 128 placements of two bars with three contacts each do."""
    monkeypatch.setattr(relation_touches, "COUNTS", {"plane": 3, "cylinder": 3})
    part, touched, noise, _ = drawn(Cell("pins of equal lean", 45.0, 0.0, turned=True, noisy=True), seed)
    shares, settle = [], samples.settled

    def counted(*given):
        ends, chi2 = settle(*given)
        shares.append(np.mean(chi2 < 100.0))
        return ends, chi2

    monkeypatch.setattr(samples, "settled", counted)
    located(loaded(by_relations(part), tmp_path), touched, noise, tmp_path, explain=False)
    assert shares[0] > 0.08
