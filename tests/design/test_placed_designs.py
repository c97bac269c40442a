"""Design checks with a known placement: symmetries, contact counts, free motions, mistakes."""

import json
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from tactfix.cli.app import run
from tactfix.design.contact_counts import minimal_sets
from tactfix.design.design_check import design_check
from tactfix.design.design_report import Wishes
from tactfix.files.fixture_file import load_fixture
from tactfix.fixture import Probe
from tactfix.geometry.scale import tolerance_for
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tactfix.placement import Placement
from tactfix.poses.pose_fit import refine
from tactfix.simulation.simulate import simulate
from tests.support.placed_cells import ball_and_bar, cube_corner, placed, plate_with_all, surfaces_of
from tests.support.project import ROOT

UPRIGHT = np.eye(4)
UPRIGHT[:3, :3] = Rotation.from_euler("z", -64, degrees=True).as_matrix()
UPRIGHT[:3, 3] = [1200.0, -350.0, 400.0]
TILTED = UPRIGHT.copy()
TILTED[:3, :3] = Rotation.from_euler("zyx", [-64, 30, 100], degrees=True).as_matrix()
FLAT = frozenset(("x", "y", "rz"))
QUICK = Wishes(layouts=0)


def codes(report):
    return {finding.code: finding.status for finding in report.findings if finding.status != "ok"}


HALF_TURN_ABOUT_X = replace(ball_and_bar(), touch={})
"""A bar along y and a ball next to it on x: a half-turn about x maps both onto themselves and keeps the origin."""


@pytest.mark.parametrize(
    ("placement", "settles"),
    [
        (None, False),
        (Placement(TILTED), False),
        (Placement(TILTED, (20.0, np.radians(10))), True),
        (Placement(TILTED, (20.0, np.radians(89))), True),
        # Limits above 90 degrees can contain both of two poses that are a half-turn apart.
        (Placement(TILTED, (20.0, np.radians(91))), False),
        (Placement(TILTED, sigma=(1.0, 0.01)), True),
        (Placement(UPRIGHT, free=FLAT), True),
        (Placement(UPRIGHT, free=frozenset(("rx", "ry", "rz"))), False),
    ],
)
def test_a_symmetry_is_resolved_by_limits_that_keep_one_pose(placement, settles):
    # Without sigma only the geometry is checked: these tests are not about contacts.
    report = design_check(replace(HALF_TURN_ABOUT_X, placement=placement, probe=Probe(1.0)), wishes=QUICK)
    (symmetry,) = report.symmetries
    assert symmetry.broken_by == ("placement" if settles else None)
    assert ("symmetry_placement" in codes(report)) == settles
    assert ("symmetry" in codes(report)) == (not settles)


def test_a_half_turn_about_a_vertical_axis_is_not_settled_by_lying_flat():
    up = UPRIGHT.copy()
    # The fixture's x axis, the axis of the half-turn, points up.
    up[:3, :3] = Rotation.from_euler("y", -90, degrees=True).as_matrix()
    report = design_check(replace(HALF_TURN_ABOUT_X, placement=Placement(up, free=FLAT)), wishes=QUICK)
    assert report.symmetries[0].broken_by is None


def random_rank(surfaces, chosen, free_axes):
    """The rank of random contacts with these counts, for motions along these base axes (columns, in fixture axes)."""
    rng = np.random.default_rng(1)
    rows = []
    for name, count in chosen.items():
        surface = surfaces[name]
        for _ in range(count):
            if isinstance(surface, Plane):
                aside = rng.normal(size=3) * 50
                point, normal = surface.point + aside - (aside @ surface.normal) * surface.normal, surface.normal
            elif isinstance(surface, Sphere):
                normal = rng.normal(size=3)
                normal /= np.linalg.norm(normal)
                point = surface.center + surface.radius * normal
            else:
                normal = np.cross(surface.direction, rng.normal(size=3))
                normal /= np.linalg.norm(normal)
                point = surface.point + rng.normal() * 50 * surface.direction + surface.radius * normal
            rows.append(np.concatenate([np.cross(point, normal) / 100, normal]))
    return np.linalg.matrix_rank(np.array(rows).reshape(-1, 6) @ free_axes, tol=1e-6)


@pytest.mark.parametrize("free", [FLAT, frozenset(("x", "y", "z")), frozenset(("z", "rx", "ry")), frozenset(("rz",))])
@pytest.mark.parametrize("cell", [plate_with_all(), cube_corner(), ball_and_bar()], ids=lambda cell: cell.name)
def test_minimal_sets_constrain_the_free_directions(free, cell):
    surfaces = surfaces_of(cell)
    placement = Placement(UPRIGHT, free=free)
    axes = np.kron(np.eye(2), UPRIGHT[:3, :3].T)
    free_axes = axes[:, [name in free for name in ("rx", "ry", "rz", "x", "y", "z")]]
    total = random_rank(surfaces, dict.fromkeys(surfaces, 6), free_axes)
    every = [
        dict(zip(surfaces, counts, strict=True))
        for counts in product(range(total + 1), repeat=len(surfaces))
        if sum(counts) == total
    ]
    expected = [chosen for chosen in every if random_rank(surfaces, chosen, free_axes) == total]
    found = minimal_sets(surfaces, tolerance_for(surfaces), 500, placement)
    assert sorted(map(sorted, (c.items() for c in found))) == sorted(map(sorted, (c.items() for c in expected)))


PIN_ON_PLATE = placed(
    "pin-on-plate", {"plate": Plane([0, 0, 0], [0, 0, 1]), "pin": Cylinder([0, 0, 0], [0, 0, 1], 8.0)}, {}, 1.0, 0.02
)


def test_constrained_and_measured_motions_are_not_free():
    for placement in (None, Placement(TILTED, (20.0, 0.1)), Placement(UPRIGHT, free=FLAT)):
        report = design_check(replace(PIN_ON_PLATE, placement=placement), wishes=QUICK)
        assert [motion.message for motion in report.free_motions] == ["rotates about the axis of pin"]
        assert report.certainty is None
    held, measured = (
        design_check(replace(PIN_ON_PLATE, placement=placement), wishes=QUICK)
        for placement in (Placement(UPRIGHT, free=frozenset(("x", "y", "z"))), Placement(TILTED, sigma=(0.5, 0.01)))
    )
    assert held.free_motions == measured.free_motions == ()
    assert held.counts.minimum_total == 3
    # A constrained direction has sigma 0; a rotation determined by the measurement alone has its sigma.
    assert np.abs(held.certainty.covariance[:3]).max() < 1e-15
    assert np.sqrt(measured.certainty.covariance[2, 2]) == pytest.approx(0.01, rel=1e-6)


@pytest.mark.parametrize(
    "placement",
    [
        Placement(TILTED, free=frozenset(("rx", "rz", "x", "z"))),
        Placement(TILTED, free=FLAT),
        Placement(TILTED, sigma=(0.3, 2e-3)),
        Placement(TILTED, sigma=(0.3, 2e-3), free=frozenset(("x", "ry"))),
    ],
    ids=["two turns", "flat", "measured", "measured and held"],
)
def test_the_refined_pose_is_that_of_an_optimizer_over_the_free_directions(placement):
    fixture = plate_with_all()
    surfaces = surfaces_of(fixture)
    off = TILTED.copy()
    off[:3, :3] = Rotation.from_rotvec([0.004, -0.003, 0.006]).as_matrix() @ TILTED[:3, :3]
    off[:3, 3] += [0.4, -0.6, 0.5]
    contacts = simulate(fixture, base_from_fixture=off, seed=2).contacts
    free = np.flatnonzero(np.concatenate([placement.turns, placement.shifts]))
    weight = None if placement.covariance is None else np.linalg.inv(np.linalg.cholesky(placement.covariance))

    def misses(unknown):
        motion = np.zeros(6)
        motion[free] = unknown
        rotation = Rotation.from_rotvec(motion[:3]).as_matrix() @ TILTED[:3, :3]
        points = (contacts.points - TILTED[:3, 3] - motion[3:]) @ rotation
        found = []
        for name, point in zip(contacts.features, points, strict=True):
            surface = surfaces[name]
            if isinstance(surface, Plane):
                gap = (point - surface.point) @ surface.normal
            elif isinstance(surface, Sphere):
                gap = np.linalg.norm(point - surface.center) - surface.radius
            else:
                gap = np.linalg.norm(np.cross(point - surface.point, surface.direction)) - surface.radius
                gap = gap if surface.side == "outer" else -gap
            found.append((gap - contacts.tip_radius) / fixture.probe.sigma)
        return np.array(found) if weight is None else np.concatenate([found, weight @ motion])

    best = least_squares(misses, np.zeros(len(free)), x_scale="jac", xtol=1e-15, ftol=1e-15, gtol=1e-15)
    fit = refine(surfaces, contacts, contacts.sigmas, TILTED, placement)
    motion = np.zeros(6)
    motion[free] = best.x
    assert fit.chi2 == pytest.approx(2 * best.cost, rel=1e-6)
    turned = Rotation.from_matrix(fit.base_from_fixture[:3, :3] @ TILTED[:3, :3].T).as_rotvec()
    assert np.allclose(turned, motion[:3], atol=1e-6)
    assert np.allclose(fit.base_from_fixture[:3, 3] - TILTED[:3, 3], motion[3:], atol=1e-5)


def test_a_constrained_height_reveals_a_wrong_tip_radius():
    cell = cube_corner()
    assert codes(design_check(cell, wishes=QUICK))["blind_tip_radius"] == "error"
    held = replace(cell, placement=Placement(UPRIGHT, free=frozenset(("x", "y", "rx", "ry", "rz"))))
    report = design_check(held, wishes=QUICK)
    assert "blind_tip_radius" not in codes(report)
    (spot,) = (spot for spot in report.blind_spots if spot.error == "tip_radius")
    assert spot.detectable
    known = design_check(replace(cell, placement=Placement(UPRIGHT, sigma=(0.05, 1e-3))), wishes=QUICK)
    assert "blind_tip_radius" not in codes(known)


def test_a_known_placement_reveals_a_wrong_unit():
    def unit_of(fixture):
        return next(spot for spot in design_check(fixture, wishes=QUICK).blind_spots if spot.error == "unit")

    bare = replace(cube_corner(), touch={})
    assert not unit_of(bare).detectable
    assert unit_of(replace(bare, placement=Placement(UPRIGHT, (20.0, 0.1)))).detectable


def test_random_layouts_begin_with_as_few_contacts_as_are_needed():
    fixture = replace(plate_with_all(), placement=Placement(UPRIGHT, (20.0, 0.1), free=FLAT))
    report = design_check(fixture)
    assert report.counts.minimum_total == 3
    assert report.study.shares[0].contacts == 3
    assert report.study.shares[-1].ambiguous + report.study.shares[-1].underdetermined < 0.3


def test_contacts_at_another_pose_within_the_limits_are_accepted():
    fixture = replace(plate_with_all(), placement=Placement(UPRIGHT, (20.0, 0.1)))
    report = design_check(fixture, simulate(fixture, seed=5).contacts, QUICK)
    assert report.certainty.source == "contacts"
    assert report.margins.is_unique


def test_design_check_follows_placement_options(tmp_path, capsys):
    np.savetxt(tmp_path / "near.txt", UPRIGHT, fmt="%.17g")
    text = (ROOT / "fixtures" / "cylinder-sphere.yaml").read_text().partition("touch:")[0]
    (tmp_path / "f.yaml").write_text(text)
    words = ["design-check", str(tmp_path / "f.yaml"), "--sigma", "0.001", "--study", "0", "--json"]
    assert run(words) == 1
    assert json.loads(capsys.readouterr().out)["symmetries"][0]["broken_by"] is None
    assert run([*words, "--near", str(tmp_path / "near.txt"), "--within", "2,10"]) == 0
    assert json.loads(capsys.readouterr().out)["symmetries"][0]["broken_by"] == "placement"
    assert run(["design-check", "--explain", "symmetry_placement"]) == 0
    assert "placement" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("translation", "free", "left"), [(40.0, None, True), (2.0, None, False), (40.0, FLAT, True), (0.1, FLAT, False)]
)
def test_a_wrong_file_whose_pose_is_beyond_the_limits_would_show(translation, free, left):
    """Exchanged coordinates of the pin move the plate by 22 mm, more than two poses within limits of 2 mm can differ.

    If the plate lies flat, it moves by 2 to 4 mm.
    """
    cell = load_fixture(ROOT / "fixtures" / "robot-cell-plate.yaml")
    contacts = simulate(cell, base_from_fixture=np.eye(4), seed=2, count=12).contacts
    cell = replace(cell, placement=Placement(UPRIGHT, (translation, np.radians(translation)), free=free))
    spots = design_check(cell, contacts, wishes=QUICK).blind_spots
    (axes,) = (spot for spot in spots if spot.error == "axes")
    assert axes.detectable
    assert (axes.pose_shift is not None) == left
