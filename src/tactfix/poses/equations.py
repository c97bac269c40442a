"""The equations that a pose must satisfy, one per contact, evaluated for many trial poses at once.

1. Every contact gets an equation. In the fixture frame a contact at y = A x + b (A, b: fixture_from_base) lies on its
   feature when

    plane              n . (y - p) - t                = 0
    sphere, cylinder   (|P (y - p)|^2 - rho^2) / 2rho = 0,   P = I (sphere) or I - s s^T (cylinder), rho = r +- t,

   All have the form  y'Q y'/2 + n . y' + k = 0  with y' = y - p.

2. This polynomial form has no kink at a centre or axis, so Newton's method may start anywhere. Near a surface it equals
   the distance to second order. The geometric form |P y'| - rho is exact; least squares use it once a pose is close.
3. A measured pose adds six equations; constrained directions remove unknowns (`pose_domain`).

The trial poses are the last axis of all arrays: long inner loops, few numpy calls. Lengths are scaled by the caller.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactfix.geometry.arrays import Bools, Floats, Ints
from tactfix.geometry.surfaces import Plane, SidedSurface, Sphere, offset_radius
from tactfix.poses.pose_domain import ALL_POSES, MeasuredPose, PoseDomain
from tactfix.values import frozen_value

OFF_CENTRE = np.array([[1e-3], [2e-3], [3e-3]])
"""Added to the best offsets (scaled lengths): at a centre or on an axis the gradient is zero and Newton's method would
stay. The components differ so that no feature in special position is hit again."""


@frozen_value
class PoseEquations:
    """n contacts as quadratic forms; lengths in one unit chosen by the caller.

    points (3, n) in base; anchors (3, n): p, quadrics (3, 3, n): Q, normals (3, n): n, constants (n,): k in the fixture
    frame; radii (n,): rho, 0 for a plane; weights (n,): of the residuals. domain: of the poses; measured: a prior
    measurement of the pose. targets (r, N): target values of the r residuals at each of N trial poses; zero if None.
    """

    points: Floats
    anchors: Floats
    quadrics: Floats
    normals: Floats
    constants: Floats
    radii: Floats
    weights: Floats
    domain: PoseDomain = ALL_POSES
    measured: MeasuredPose | None = None
    targets: Floats | None = None

    def __len__(self) -> int:
        """The number of contacts."""
        return int(self.points.shape[1])

    @property
    def dof(self) -> int:
        """The number of equations less the number of unknowns."""
        return len(self) + (6 if self.measured else 0) - self.domain.dimension

    @property
    def turns(self) -> int:
        """The number of rotations among the unknowns; they come first."""
        return int(self.domain.turns.sum())

    def without_measured(self) -> "PoseEquations":
        """The equations of the contacts alone, over all poses; those near the measured one are searched thoroughly."""
        return replace(self, measured=None, domain=replace(self.domain, looks_beyond=True))

    def of_trials(self, which: Bools | Ints) -> "PoseEquations":
        """The equations of some of the trial poses: those with their targets."""
        return self if self.targets is None else replace(self, targets=self.targets[:, which])

    def subset(self, index: Sequence[int]) -> "PoseEquations":
        """The equations of some of the contacts."""
        arrays = (self.points, self.anchors, self.quadrics, self.normals, self.constants, self.radii, self.weights)
        points, anchors, quadrics, normals, constants, radii, weights = (
            np.ascontiguousarray(array[..., index]) for array in arrays
        )
        return PoseEquations(points, anchors, quadrics, normals, constants, radii, weights, self.domain, self.measured)


def pose_equations(
    surfaces: Sequence[SidedSurface], feature_index: Sequence[int], points: Floats, weights: Floats, tip_radius: float
) -> PoseEquations:
    """The equations of contacts points (n, 3) on surfaces[feature_index[i]], in the units in which they come.

    Raises TipDoesNotFitError when the tip is larger than a touched bore.
    """
    columns = zip(*(_quadric(surface, tip_radius) for surface in surfaces), strict=True)
    anchors, quadrics, normals, constants, radii = (
        np.take(np.stack([np.asarray(value, dtype=np.float64) for value in column], axis=-1), feature_index, axis=-1)
        for column in columns
    )
    return PoseEquations(np.ascontiguousarray(points.T), anchors, quadrics, normals, constants, radii, weights)


def _quadric(surface: SidedSurface, tip_radius: float) -> tuple[Floats, Floats, Floats, float, float]:
    """p, Q, n, k and rho of one surface."""
    if isinstance(surface, Plane):
        return surface.point, np.zeros((3, 3)), surface.normal, -tip_radius, 0.0
    rho = offset_radius(type(surface).__name__.lower(), surface.radius, surface.side, tip_radius)
    if isinstance(surface, Sphere):
        return surface.center, np.eye(3) / rho, np.zeros(3), -rho / 2, rho
    projector = np.eye(3) - np.outer(surface.direction, surface.direction)
    return surface.point, projector / rho, np.zeros(3), -rho / 2, rho


def evaluate(equations: PoseEquations, rotations: Floats, offsets: Floats, geometric: bool) -> tuple[Floats, Floats]:
    """Residuals (r, N) and Jacobian (u, r, N) at fixture_from_base poses rotations (3, 3, N), offsets (3, N).

    The u unknowns are a rotation about the fixture axes (acting after A, before b) and a translation along them,
    reduced to the tangent space of the domain (`PoseDomain.basis`). The r residuals are those of the contacts, then
    those of a measured pose, minus their targets.
    """
    residual, jacobian = _contact_residuals(equations, rotations, offsets, geometric)
    if equations.measured is not None:
        more, their = equations.measured.evaluate(rotations, offsets)
        residual, jacobian = np.concatenate([residual, more]), np.concatenate([jacobian, their], axis=1)
    if equations.targets is not None:
        residual = residual - equations.targets
    if not equations.domain.is_free:
        basis = equations.domain.basis(rotations, offsets)
        jacobian = np.einsum("iuN,irN->urN", basis, jacobian)
    return residual, jacobian


def _contact_residuals(
    equations: PoseEquations, rotations: Floats, offsets: Floats, geometric: bool
) -> tuple[Floats, Floats]:
    """Residuals (n, N) of the contacts and their Jacobian (6, n, N)."""
    turned, y, gradient = _placed(equations, rotations, offsets)
    residual = np.einsum("anN,anN->nN", gradient / 2 + equations.normals[:, :, None], y) + equations.constants[:, None]
    round_ = equations.radii > 0
    if geometric and round_.any():
        # gradient = P y'/rho, so |P y'| = rho |gradient|; at the centre the gradient is zero.
        length = np.sqrt((gradient**2).sum(axis=0))
        distance = equations.radii[:, None] * (length - 1)
        residual = np.where(round_[:, None], distance, residual)
        gradient = gradient / np.where(length > 0, length, 1.0)
    residual *= equations.weights[:, None]
    jacobian = np.empty((6, *residual.shape))
    np.add(gradient, equations.normals[:, :, None], out=jacobian[3:])
    jacobian[3:] *= equations.weights[:, None]
    _cross(turned, jacobian[3:], jacobian[:3])
    return residual, jacobian


def curvature(
    equations: PoseEquations, rotations: Floats, offsets: Floats, residual: Floats, geometric: bool
) -> Floats:
    """The sum (u, u, N) of residuals (r, N) times their second derivatives: the term that Gauss-Newton neglects.

    Contacts only: a measured pose is nearly linear, and the domain nearly flat, within noise.

    A turn by v moves y by v x u + v x (v x u) / 2 to second order, u = A x: with gradient g and Hessian H of the
    residual in y the second derivatives are [u] H [u]^T + (g u^T + u g^T) / 2 - g.u I for the turn, [u] H for turn and
    shift, and H for the shift, [u] the matrix of u x.
    """
    turned, _, gradient = _placed(equations, rotations, offsets)
    pull = residual[: len(equations)] * equations.weights[:, None]
    bends = equations.quadrics[..., None]
    if geometric:
        # Of |P y'|: (P - e e^T) / |P y'| with e along P y'.
        length = np.sqrt((gradient**2).sum(axis=0))
        gradient = gradient / np.where(length > 0, length, 1.0)
        across = bends * equations.radii[:, None] - gradient[:, None] * gradient
        bends = across / np.where(length > 0, equations.radii[:, None] * length, 1.0)
    bends = pull * bends
    mixed = _cross(turned[:, None], bends, np.empty_like(bends))
    moment = np.einsum("anN,bnN->abN", pull * (gradient + equations.normals[:, :, None]), turned)
    second = np.empty((6, 6, residual.shape[1]))
    second[:3, :3] = _cross(turned[:, None], np.swapaxes(mixed, 0, 1), np.empty_like(mixed)).sum(axis=2)
    second[:3, :3] += (moment + np.swapaxes(moment, 0, 1)) / 2 - np.eye(3)[..., None] * np.einsum("aaN->N", moment)
    second[:3, 3:] = mixed.sum(axis=2)
    second[3:, :3] = np.swapaxes(second[:3, 3:], 0, 1)
    second[3:, 3:] = bends.sum(axis=2)
    if equations.domain.is_free:
        return second
    basis = equations.domain.basis(rotations, offsets)
    return np.asarray(np.einsum("iuN,ijN,jvN->uvN", basis, second, basis))


def _placed(equations: PoseEquations, rotations: Floats, offsets: Floats) -> tuple[Floats, Floats, Floats]:
    """Contacts turned (3, n, N), their y' = turned + b - p (3, n, N), and Q y' (3, n, N)."""
    turned = np.einsum("abN,bn->anN", rotations, equations.points)
    y = turned + (offsets[:, None, :] - equations.anchors[:, :, None])
    return turned, y, np.einsum("abn,bnN->anN", equations.quadrics, y)


def _cross(a: Floats, b: Floats, out: Floats) -> Floats:
    """`cross_columns` written to out, without temporary arrays: the innermost loop of every search."""
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(a[j], b[k], out=out[i])
        out[i] -= a[k] * b[j]
    return out


def centred_offsets(equations: PoseEquations, rotations: Floats) -> Floats:
    """Offsets b (3, N) that bring the contacts closest to the planes, axes and centres, for rotations (3, 3, N).

    A linear least-squares problem with the same 3x3 matrix for every rotation; offsets along free translations are 0.
    """
    n = len(equations)
    projectors = _projectors(equations)
    turned = np.einsum("abN,bn->anN", rotations, equations.points)
    rhs = np.einsum("abn,bnN->aN", projectors, equations.anchors[:, :, None] - turned)
    if equations.domain.is_free:
        offsets = np.linalg.pinv(projectors.sum(axis=2), rcond=1e-6 / n) @ rhs
    else:
        offsets = _centred_in_domain(equations.domain, rotations, projectors.sum(axis=2), rhs, 1e-6 / n)
    return equations.domain.onto(rotations, np.asarray(offsets + OFF_CENTRE))[1]


def translation_matrix(equations: PoseEquations) -> Floats:
    """The normal matrix (3, 3) of translations in the frame of y: singular if a translation is free."""
    return np.asarray(_projectors(equations).sum(axis=2))


def _projectors(equations: PoseEquations) -> Floats:
    """Projectors (3, 3, n) on the directions in which a shift leaves each feature."""
    normals = equations.normals
    return np.asarray(equations.quadrics * equations.radii + np.einsum("an,bn->abn", normals, normals))


def _centred_in_domain(domain: PoseDomain, rotations: Floats, matrix: Floats, rhs: Floats, rcond: float) -> Floats:
    """The same with some translations constrained: matrix (3, 3), rhs (3, N) of the normal equations."""
    _, constrained = domain.onto(rotations, np.repeat(domain.pivot[:, None], rotations.shape[2], axis=1))
    free = rotations[:, domain.shifts]
    matrices = np.einsum("auN,ab,bvN->Nuv", free, matrix, free)
    right = np.einsum("auN,aN->Nu", free, rhs - matrix @ constrained)
    shifts = np.linalg.pinv(matrices, rcond=rcond, hermitian=True) @ right[..., None]
    return np.asarray(constrained + np.einsum("auN,Nu->aN", free, shifts[..., 0]))
