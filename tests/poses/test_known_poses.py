"""Poses searched with a placement: limits, a measured pose, constrained directions."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from tactfix.localization.locate import locate
from tactfix.placement import Placement
from tactfix.poses import search
from tactfix.poses.equations import evaluate
from tactfix.poses.pose_domain import MeasuredPose, PoseDomain
from tactfix.poses.search_frame import SearchFrame
from tests.support.problems import BALLS, CORNER, PLATE, placed, pose_error, pose_of, random_pose, touch_all

UNITS = np.array([1e-4] * 3 + [0.05] * 3)

FLAT = ("x", "y", "rz")
FREE = [
    (PLATE, {"pin": 2, "ball": 1}, "x y rz"),
    (PLATE, {"plate": 3}, "z rx ry"),
    (BALLS, {"a": 1, "b": 1, "c": 1}, "x y z"),
    (BALLS, {"b": 1}, "rz"),
    (BALLS, {"b": 2, "c": 1}, "rx ry rz"),
    (BALLS, {"a": 1, "b": 1, "c": 2}, "x rx ry rz"),
    (PLATE, {"plate": 3, "pin": 1, "ball": 1}, "y z rx ry rz"),
]


def away(near, free, rng, turn=2.0, shift=40.0):
    """A pose that differs from near only in the free directions: rotation vector and translation."""
    vector = np.array([rng.uniform(-turn, turn) * (f"r{axis}" in free) for axis in "xyz"])
    step = np.array([rng.uniform(-shift, shift) * (axis in free) for axis in "xyz"])
    return pose_of(Rotation.from_rotvec(vector).as_matrix() @ near[:3, :3], near[:3, 3] + step)


def held(pose, near, free):
    """The deviation of a pose from near in the constrained directions."""
    off = pose_error(near, pose)
    names = ["rx", "ry", "rz", "x", "y", "z"]
    return np.abs([value for name, value in zip(names, off, strict=True) if name not in free]).max(initial=0.0)


def domain(rng, turns, shifts):
    near = Rotation.random(random_state=rng).as_matrix()
    return PoseDomain(near, np.array(turns, bool), np.array(shifts, bool), rng.normal(size=3), rng.normal(size=3))


@pytest.mark.parametrize("turns", [(0, 0, 0), (0, 1, 0), (1, 0, 1), (1, 1, 1)])
@pytest.mark.parametrize("shifts", [(0, 0, 0), (1, 0, 0), (0, 1, 1), (1, 1, 1)])
def test_a_domain_is_reached_and_its_basis_stays_in_it(turns, shifts):
    rng = np.random.default_rng(5)
    reachable = domain(rng, turns, shifts)
    quaternions = rng.normal(size=(4, 6)) * np.array([1, *turns])[:, None]
    rotations = reachable.turned_from_near(quaternions / np.linalg.norm(quaternions, axis=0))
    rotations, offsets = reachable.onto(rotations, rng.normal(size=(3, 6)))
    turned = np.einsum("abN,ac->Nbc", rotations, reachable.near)
    origin = -np.einsum("abN,aN->bN", rotations, offsets - reachable.pivot[:, None]) - reachable.place[:, None]
    vectors = Rotation.from_matrix(turned).as_quat()[:, :3]
    assert np.abs(vectors[:, ~reachable.turns]).max(initial=0) < 1e-12
    assert np.abs(origin[~reachable.shifts]).max(initial=0) < 1e-12
    steps = reachable.basis(rotations, offsets)
    assert steps.shape[1] == reachable.dimension
    for step in np.moveaxis(1e-5 * steps, 1, 0):
        ahead = Rotation.from_rotvec(step[:3].T).as_matrix() @ np.moveaxis(rotations, -1, 0)
        ahead, moved = np.moveaxis(ahead, 0, -1), offsets + step[3:]
        if sum(turns) != 3 or sum(shifts) != 3:
            again, back = reachable.onto(ahead, moved)
            assert max(np.abs(again - ahead).max(), np.abs(back - moved).max()) < 1e-8


def test_the_derivatives_of_a_measured_pose_are_those_of_differences():
    rng = np.random.default_rng(6)
    near = Rotation.random(random_state=rng).as_matrix()
    measured = MeasuredPose(near, rng.normal(size=3), rng.normal(size=3), rng.normal(size=(6, 6)))
    for angle in (0.0, 1e-6, 0.4, 2.0, 3.1):
        axis = rng.normal(size=3)
        turn = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix()
        rotation, offset = near @ turn.T, rng.normal(size=3)
        _, jacobian = measured.evaluate(rotation[..., None], offset[:, None])
        for k, step in enumerate(np.eye(6)):

            def at(size, step=step, rotation=rotation, offset=offset):
                ahead = Rotation.from_rotvec(size * step[:3]).as_matrix() @ rotation
                return measured.evaluate(ahead[..., None], (offset + size * step[3:])[:, None])[0][:, 0]

            np.testing.assert_allclose((at(1e-6) - at(-1e-6)) / 2e-6, jacobian[k, :, 0], atol=2e-7 / (3.2 - angle))


@pytest.mark.parametrize(("patches", "counts", "free"), FREE)
def test_reduced_jacobians_are_those_of_differences_along_the_domain(patches, counts, free):
    rng = np.random.default_rng(7)
    near = random_pose(rng)
    contacts = touch_all(patches, counts, rng, pose=away(near, free.split(), rng)).contacts()
    surfaces = {name: patch.surface() for name, patch in patches.items()}
    placement = Placement(near, sigma=(1.0, 0.1), free=frozenset(free.split()))
    equations = SearchFrame.of(surfaces, contacts).equations(surfaces, contacts, np.ones(len(contacts)), placement, 0.1)
    start = equations.domain.onto(equations.domain.near[..., None], rng.normal(size=(3, 1)))
    steps = equations.domain.basis(*start)[..., 0]
    _, jacobian = evaluate(equations, *start, geometric=True)

    def at(size, step):
        ahead = Rotation.from_rotvec(size * step[:3]).as_matrix() @ start[0][..., 0]
        return evaluate(equations, ahead[..., None], start[1] + size * step[3:, None], geometric=True)[0][:, 0]

    for k, step in enumerate(steps.T):
        slope = (at(1e-6, step) - at(-1e-6, step)) / 2e-6
        np.testing.assert_allclose(slope, jacobian[k, :, 0], atol=1e-6 * max(1, np.abs(jacobian).max()))


FAR_TOO = ("x y rz", "rx ry rz")
"""Free rotations about one axis and about all axes: the fast tests also use fixtures far from their origin."""


@pytest.mark.parametrize(
    ("patches", "counts", "free", "far"),
    [
        pytest.param(*case, far, marks=pytest.mark.slow if far and case[2] not in FAR_TOO else ())
        for case in FREE
        for far in (False, True)
    ],
)
def test_as_many_contacts_as_free_directions_leave_the_truth(patches, counts, free, far):
    rng = np.random.default_rng(8)
    free = free.split()
    for _ in range(3):
        near = random_pose(rng)
        if far:
            # The rotations are about near's origin, which is ten sizes of the fixture away from its features.
            patches = {n: replace(p, at=tuple(np.add(p.at, (3000, -1000, 500)))) for n, p in patches.items()}
        truth = touch_all(patches, counts, rng, pose=away(near, free, rng))
        fixture = replace(placed(patches), placement=Placement(near, free=frozenset(free)))
        result = locate(fixture, truth.contacts(), explain=False)
        assert result.dof == len(truth.names) - len(free)
        errors = [np.abs(pose_error(c.base_from_fixture, truth.pose)) for c in result.candidates]
        best = min(errors, key=lambda error: error.max())
        assert best[:3].max() < 1e-8
        assert best[3:].max() < 1e-5
        for candidate in result.candidates:
            assert held(candidate.base_from_fixture, near, free) < 1e-8
        if result.status == "located" and len([n for n in free if n.startswith("r")]) != 2:
            fixed = [n not in free for n in ("rx", "ry", "rz", "x", "y", "z")]
            assert np.sqrt(np.diag(result.covariance))[fixed].max(initial=0) < 1e-9


def test_turns_about_one_axis_are_all_found():
    """A ball that moves on a circle: two rotations bring it into contact, known in closed form."""
    near, at = np.eye(4), np.array([100.0, 0.0, 0.0])
    patches = {"ball": replace(BALLS["b"], at=tuple(at))}
    angle = 0.8
    centre = 100 * np.array([np.cos(angle), np.sin(angle), 0.0])
    out = np.array([0.3, 0.4, np.sqrt(0.75)])
    point = centre + 12.7 * out
    truth = touch_all(patches, {"ball": 1}, np.random.default_rng(0), pose=near)
    contacts = truth.contacts(points=point[None], approaches=np.full((1, 3), np.nan))
    fixture = replace(placed(patches), placement=Placement(near, free=frozenset({"rz"})))
    result = locate(fixture, contacts)
    # |p - 100 e(a)| = r: both solutions have the same angle between e(a) and p's direction in the plane.
    flat = np.arctan2(point[1], point[0])
    half = np.arccos((point @ point + 100**2 - 12.7**2) / (200 * np.hypot(*point[:2])))
    found = sorted(np.arctan2(c.base_from_fixture[1, 0], c.base_from_fixture[0, 0]) for c in result.candidates)
    np.testing.assert_allclose(found, sorted([flat - half, flat + half]), atol=1e-9)
    assert result.status == "ambiguous"
    assert result.without_prior.status == "underdetermined"


def test_a_turn_that_leaves_the_touched_ball_in_place_is_free():
    rng = np.random.default_rng(9)
    truth = touch_all(BALLS, {"a": 3}, rng)
    fixture = replace(placed(BALLS), placement=Placement(truth.pose, free=frozenset({"rz"})))
    result = locate(fixture, truth.contacts())
    assert result.status == "underdetermined"
    assert len(result.free_motions) == 1


def test_constrained_directions_need_no_contact():
    rng = np.random.default_rng(22)
    near = pose_of(np.eye(3), (1200.0, -350.0, 400.0))
    truth = touch_all(PLATE, {"pin": 2}, rng, pose=away(near, FLAT, rng))
    fixture = replace(placed(PLATE), placement=Placement(near, free=frozenset(FLAT)))
    result = locate(fixture, truth.contacts())
    assert result.status == "underdetermined"
    assert result.next_contact.feature == "ball"  # the plate holds neither shifts along it nor turns about z
    assert result.next_contact.further == ()


@pytest.mark.parametrize("degrees", [0.0, 90.0, 180.0])
def test_a_placement_rotated_by_a_half_turn_is_not_singular(degrees):
    rng = np.random.default_rng(10)
    near = random_pose(rng)
    turn = Rotation.from_euler("z", degrees, degrees=True).as_matrix()
    truth = touch_all(PLATE, {"pin": 3, "ball": 3}, rng, pose=pose_of(turn @ near[:3, :3], near[:3, 3] + (5, -3, 0)))
    for free in ({"x", "y", "rz"}, {"x", "y", "rz", "rx"}):
        fixture = replace(placed(PLATE), placement=Placement(near, free=frozenset(free)))
        result = locate(fixture, truth.contacts())
        assert any(np.abs(pose_error(c.base_from_fixture, truth.pose)).max() < 1e-6 for c in result.candidates)


def test_a_measured_pose_is_six_observations():
    """Pose, chi-square and covariance are those of an independent least squares over contacts and measurement."""
    rng = np.random.default_rng(11)
    truth = touch_all(PLATE, {"plate": 2, "pin": 1, "ball": 1}, rng, sigma=0.05)
    sigmas = np.array([0.001] * 3 + [0.1] * 3)
    off = sigmas * rng.standard_normal(6)
    near = pose_of(Rotation.from_rotvec(off[:3]).as_matrix() @ truth.pose[:3, :3], truth.pose[:3, 3] + off[3:])
    contacts = truth.contacts(rng)
    result = locate(replace(placed(PLATE), placement=Placement(near, sigma=(0.1, 0.001))), contacts)

    def missing(step):
        pose = pose_of(Rotation.from_rotvec(step[:3]).as_matrix() @ near[:3, :3], near[:3, 3] + step[3:])
        points = (contacts.points - pose[:3, 3]) @ pose[:3, :3]
        pin, ball = np.linalg.norm(points[2, :2]) - 10, np.linalg.norm(points[3] - (300, 180, 60)) - 19.05
        return np.concatenate([np.array([*points[:2, 2], pin, ball]) / 0.05, step / sigmas])

    fit = least_squares(missing, np.zeros(6), xtol=1e-15, ftol=1e-15, gtol=1e-15, x_scale=sigmas)
    assert result.status == "located"
    assert result.dof == 4
    assert result.chi2 == pytest.approx(2 * fit.cost, rel=1e-6)
    expected = pose_of(Rotation.from_rotvec(fit.x[:3]).as_matrix() @ near[:3, :3], near[:3, 3] + fit.x[3:])
    assert np.abs(pose_error(result.base_from_fixture, expected)).max() < 1e-5
    covariance = np.linalg.inv(fit.jac.T @ fit.jac)
    np.testing.assert_allclose(np.sqrt(np.diag(result.covariance)), np.sqrt(np.diag(covariance)), rtol=0.05)
    assert result.without_prior.status == "underdetermined"


@pytest.mark.parametrize("turn", [1e-4, 0.05, 0.3])
def test_a_ball_and_a_badly_measured_pose_leave_the_nearest_pose(turn):
    """The free motion of the contacts is long compared with the noise, and curved except about the ball."""
    rng = np.random.default_rng(20)
    truth = touch_all(BALLS, {"b": 6}, rng, sigma=2e-5)
    off = rng.standard_normal(6) * ([turn] * 3 + [20.0] * 3)
    near = pose_of(Rotation.from_rotvec(off[:3]).as_matrix() @ truth.pose[:3, :3], truth.pose[:3, 3] + off[3:])
    result = locate(replace(placed(BALLS), placement=Placement(near, sigma=(20.0, turn))), truth.contacts(rng))
    assert len(result.candidates) == 1
    found = result.candidates[0].base_from_fixture
    center = truth.pose[:3, :3] @ BALLS["b"].at + truth.pose[:3, 3]
    np.testing.assert_allclose(found[:3, :3] @ BALLS["b"].at + found[:3, 3], center, atol=1e-3)

    def away_from_near(vector):
        rotation = Rotation.from_rotvec(vector).as_matrix() @ near[:3, :3]
        return np.concatenate([vector / turn, (center - rotation @ BALLS["b"].at - near[:3, 3]) / 20.0])

    expected = least_squares(away_from_near, np.zeros(3), xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    np.testing.assert_allclose(pose_error(near, found)[:3], expected, atol=1e-4)


@pytest.mark.parametrize("patches", [CORNER, PLATE, BALLS])
@pytest.mark.parametrize("offset", [0.0, 60.0])
def test_poses_left_by_contacts_alone_are_those_without_a_measurement(patches, offset):
    """Three faces leave four poses, in pairs of mirror images; a measurement 60 mm off contradicts all four."""
    rng = np.random.default_rng(21)
    truth = touch_all(patches, dict.fromkeys(patches, 4), rng, sigma=0.02)
    contacts = replace(truth.contacts(rng), approaches=np.full((4 * len(patches), 3), np.nan))
    bare = locate(placed(patches), contacts)
    near = pose_of(truth.pose[:3, :3], truth.pose[:3, 3] + offset)
    measured = locate(replace(placed(patches), placement=Placement(near, sigma=(0.5, 0.01))), contacts)
    assert measured.without_prior.status == bare.status
    assert measured.without_prior.poses == sum(candidate.accepted for candidate in bare.candidates)
    assert measured.status == ("inconsistent" if offset else "located")
    against = [candidate for candidate in measured.candidates if not candidate.accepted]
    left = [candidate for candidate in against if {reason.code for reason in candidate.reasons} == {"prior"}]
    assert len(left) == measured.without_prior.poses - (0 if offset else 1)


@pytest.mark.parametrize("with_approach", [("top",), ("top", "right"), ("right", "back", "top")])
def test_poses_left_by_contacts_alone_respect_approaches(with_approach):
    """Of the four poses of three faces those with possible approaches remain; other poses are not searched."""
    rng = np.random.default_rng(22)
    truth = touch_all(CORNER, dict.fromkeys(CORNER, 4), rng, sigma=0.02)
    contacts = truth.contacts(rng)
    has_approach = np.array([name in with_approach for name in contacts.features])
    contacts = replace(contacts, approaches=np.where(has_approach[:, None], contacts.approaches, np.nan))
    bare = locate(placed(CORNER), contacts)
    for how in ({"sigma": (0.5, 0.01)}, {"within": (1.0, 0.01)}):
        known = locate(replace(placed(CORNER), placement=Placement(truth.pose, **how)), contacts)
        assert known.status == "located"
        assert known.without_prior.status == bare.status
        assert known.without_prior.poses == sum(candidate.accepted for candidate in bare.candidates)
    assert len(known.candidates) == len(bare.candidates)


@pytest.mark.parametrize("how", [{"within": (5.0, 0.1)}, {"sigma": (0.5, 0.01)}])
def test_the_place_that_is_known_spares_descents_where_features_fix_the_place(monkeypatch, how):
    rng = np.random.default_rng(23)
    truth = touch_all(PLATE, {"plate": 4, "pin": 4, "ball": 5}, rng, sigma=0.02)
    contacts, begun = truth.contacts(rng), []
    original = search.descend

    def counted(equations, rotations, *more, **how):
        begun[-1] += rotations.shape[2]
        return original(equations, rotations, *more, **how)

    monkeypatch.setattr(search, "descend", counted)
    for placement in (None, Placement(truth.pose, **how)):
        begun.append(0)
        assert locate(replace(placed(PLATE), placement=placement), contacts).status == "located"
    assert begun[1] < begun[0] / 2


def test_a_constrained_direction_that_contradicts_contacts_is_named():
    rng = np.random.default_rng(12)
    near = random_pose(rng)
    true = pose_of(near[:3, :3], near[:3, 3] + (4.0, -2.0, 3.02))
    contacts = touch_all(PLATE, {"plate": 3, "pin": 3, "ball": 2}, rng, pose=true).contacts(rng)
    fixture = replace(placed(PLATE), placement=Placement(near, free=frozenset({"x", "y", "rz"})))
    result = locate(fixture, contacts)
    assert result.status == "inconsistent"
    assert "z, off by 3.02" in result.warnings[-1]


def test_limits_that_the_contacts_contradict_tell_the_component():
    rng = np.random.default_rng(13)
    truth = touch_all(PLATE, {"plate": 4, "pin": 3, "ball": 3}, rng)
    near = pose_of(truth.pose[:3, :3], truth.pose[:3, 3] - (0, 31.2, 0))
    result = locate(replace(placed(PLATE), placement=Placement(near, (20.0, 0.3))), truth.contacts(rng))
    assert result.status == "inconsistent"
    assert {reason.code for candidate in result.candidates for reason in candidate.reasons} >= {"prior"}
    assert "31.2 mm along y" in result.warnings[-1]
    assert result.without_prior.status == "located"


def test_limits_are_widened_by_the_sigma_of_the_pose():
    rng = np.random.default_rng(14)
    truth = touch_all(PLATE, {"plate": 4, "pin": 3, "ball": 3}, rng, sigma=0.1)
    contacts = truth.contacts(rng)
    found = locate(placed(PLATE), contacts)
    sigma = np.sqrt(found.covariance[5, 5])
    for times, status in ((4.9, "located"), (5.1, "inconsistent")):
        near = found.base_from_fixture.copy()
        near[2, 3] += 1.0 + times * sigma
        assert locate(replace(placed(PLATE), placement=Placement(near, (1.0, 0.3))), contacts).status == status


@pytest.mark.parametrize("scale", [1e-3, 1.0])
def test_limits_change_no_pose_but_only_what_is_left(scale):
    rng = np.random.default_rng(15)
    units = "mm" if scale == 1 else "m"
    for _ in range(3):
        truth = touch_all(BALLS, {"a": 2, "b": 2, "c": 2}, rng, scale=scale, pose=random_pose(rng, 100.0))
        contacts = replace(truth.contacts(rng), approaches=np.full((6, 3), np.nan))
        fixture = placed(BALLS, scale=scale, units=units)
        free = locate(fixture, contacts)
        limited = locate(replace(fixture, placement=Placement(truth.pose, (20.0 * scale, 0.3))), contacts)
        assert free.status == "ambiguous"
        assert limited.without_prior.status == "ambiguous"
        assert any(candidate.accepted for candidate in limited.candidates)
        for candidate in limited.candidates:
            gaps = [np.abs(candidate.base_from_fixture - other.base_from_fixture) for other in free.candidates]
            nearest = min(gaps, key=lambda gap: gap[:3, :3].max())
            assert nearest[:3, :3].max() < 1e-7
            assert nearest[:3, 3].max() < 1e-4 * scale
            if not candidate.accepted:
                off = pose_error(truth.pose, candidate.base_from_fixture)
                assert np.linalg.norm(off[:3]) > 0.3 or np.linalg.norm(off[3:]) > 20 * scale
        if limited.status == "located":
            assert any("depends on what is known" in warning for warning in limited.warnings)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("counts", "free", "sigma"),
    [
        ({"plate": 2, "pin": 3, "ball": 2}, "x y rz", None),
        ({"plate": 4, "pin": 2, "ball": 2}, "z rx ry", None),
        ({"plate": 2, "pin": 2, "ball": 1}, None, (0.1, 0.001)),
    ],
)
def test_covariances_cover_the_truth(counts, free, sigma):
    """Coverage of the 95 per cent ellipsoid over 2,000 draws, in the unconstrained directions."""
    from scipy.stats import chi2

    rng = np.random.default_rng(16)
    near = random_pose(rng)
    names = None if free is None else frozenset(free.split())
    inside = 0
    base = touch_all(PLATE, counts, rng, pose=away(near, free.split(), rng, 0.3) if free else near, sigma=0.05)
    for _ in range(2000):
        start = near
        if sigma is not None:
            off = np.repeat(sigma[::-1], 3) * rng.standard_normal(6)
            start = pose_of(Rotation.from_rotvec(off[:3]).as_matrix() @ near[:3, :3], near[:3, 3] + off[3:])
        fixture = replace(placed(PLATE), placement=Placement(start, sigma=sigma, free=names))
        result = locate(fixture, base.contacts(rng), explain=False)
        right = min(
            (c for c in result.candidates if c.accepted),
            key=lambda c: np.abs(pose_error(c.base_from_fixture, base.pose)).max(),
        )
        # In the free directions, with rotations and translations scaled to similar size.
        error, size = pose_error(right.base_from_fixture, base.pose) / UNITS, 6 if free is None else len(names)
        values, vectors = np.linalg.eigh(result.covariance / np.outer(UNITS, UNITS))
        free_error = vectors[:, -size:].T @ error
        inside += float((free_error**2 / values[-size:]).sum()) < chi2.ppf(0.95, size)
    print(f"{counts}, free {free}, sigma {sigma}: covered {inside / 20:.1f} per cent")
    assert 0.935 < inside / 2000 < 0.965


def test_a_half_turn_has_the_distance_of_a_half_turn_from_near():
    from tactfix.poses.prior import deviation

    for axis in np.eye(3):
        turned = pose_of(2 * np.outer(axis, axis) - np.eye(3), [0, 0, 0])
        assert np.abs(deviation(Placement(np.eye(4)), turned)[:3]) == pytest.approx(np.pi * axis)
