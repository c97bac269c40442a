"""A placement (prior knowledge of a pose) in the frames of the pose equations.

base_origin (3,): origin of the frame of x, in base. frame_from_fixture (4, 4): pose of the fixture in the frame of y.
Both are in the fixture's unit; length is the unit of the equations. sigma: the standard deviation (fixture units) of a
residual of weight 1.
"""

from dataclasses import replace

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import homogeneous, transform_points
from tactfix.noise import chi_square_limit
from tactfix.placement import Placement
from tactfix.poses.equations import PoseEquations
from tactfix.poses.pose_domain import MeasuredPose, PoseDomain


def with_placement(
    equations: PoseEquations,
    placement: Placement,
    base_origin: Floats,
    frame_from_fixture: Floats,
    length: float,
    sigma: float,
) -> PoseEquations:
    """The equations with the domain and the measured pose of a placement."""
    domain, measured = _terms(placement, base_origin, frame_from_fixture, length, sigma)
    equations = replace(equations, domain=domain, measured=measured)
    turn, shift = search_limits(placement, equations.dof)
    is_limited = placement.within is not None
    domain = replace(domain, angle=turn, distance=shift / length, looks_beyond=is_limited)
    return replace(equations, domain=domain)


def terms_at(
    placement: Placement, base_from_fixture: Floats, centre: Floats, scale: float
) -> tuple[Floats, Floats, Floats]:
    """The terms of a placement at a pose (4, 4), for motions of the fixture about centre (3,) in base, a length scale.

    A motion is a rotation (units of 1 / scale) and a translation along base axes. Returns an orthonormal basis (6, u)
    of the free motions, and residuals (m,) over sigma of the measured pose with their derivatives (m, 6), m = 0 or 6.
    """
    frame_from_fixture = base_from_fixture.copy()
    frame_from_fixture[:3, 3] -= centre
    domain, measured = _terms(placement, centre, frame_from_fixture, scale, scale)
    still = np.eye(3)[:, :, None], np.zeros((3, 1))
    basis = np.eye(6) if domain.is_free else np.linalg.qr(domain.basis(*still)[:, :, 0])[0]
    if measured is None:
        return basis, np.zeros(0), np.zeros((0, 6))
    values, jacobian = measured.evaluate(*still)
    # The unknowns of the equations are motions of the contacts, opposite to those of the fixture.
    return basis, values[:, 0], jacobian[:, :, 0].T / -scale


def onto_placement(placement: Placement, base_from_fixture: Floats) -> Floats:
    """The nearest pose (4, 4) that satisfies the constrained directions."""
    domain, _ = _terms(placement, np.zeros(3), base_from_fixture, 1.0, 1.0)
    if domain.is_free:
        return base_from_fixture
    rotation, offset = (part[..., 0] for part in domain.onto(np.eye(3)[:, :, None], np.zeros((3, 1))))
    return np.asarray(homogeneous(rotation.T, -rotation.T @ offset) @ base_from_fixture)


def terms_in_fixture(
    placement: Placement, base_from_fixture: Floats, centre: Floats, scale: float
) -> tuple[Floats, Floats]:
    """Basis (6, u) and rows (m, 6) of `terms_at` for motions along the fixture's axes, centre (3,) in its frame."""
    in_base = transform_points(base_from_fixture, centre[None])[0]
    basis, _, rows = terms_at(placement, base_from_fixture, in_base, scale)
    base_from_fixture_axes = np.kron(np.eye(2), base_from_fixture[:3, :3])
    return base_from_fixture_axes.T @ basis, rows @ base_from_fixture_axes


def search_limits(placement: Placement, dof: int) -> tuple[float, float]:
    """The largest rotation (rad) and translation of the fixture's origin from near that a pose may have."""
    if placement.within is not None:
        translation, rotation = placement.within
        return rotation, translation
    if (covariance := placement.covariance) is not None:
        farthest = np.sqrt(chi_square_limit(dof))
        rotation, translation = (_largest_sigma(part) for part in (covariance[:3, :3], covariance[3:, 3:]))
        return farthest * rotation, farthest * translation
    return np.pi, np.inf


def _largest_sigma(covariance: Floats) -> float:
    return float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]))


def _terms(
    placement: Placement, base_origin: Floats, frame_from_fixture: Floats, length: float, sigma: float
) -> tuple[PoseDomain, MeasuredPose | None]:
    near = frame_from_fixture[:3, :3] @ placement.near[:3, :3].T
    pivot = frame_from_fixture[:3, 3] / length
    place = (placement.near[:3, 3] - base_origin) / length
    domain = PoseDomain(near, placement.turns, placement.shifts, pivot, place)
    if placement.whitening is None:
        return domain, None
    whitening = placement.whitening * np.array([1.0] * 3 + [length] * 3)
    return domain, MeasuredPose(near, pivot, place, whitening * (sigma / length))
