"""The best pose near a given one: weighted geometric least squares over all contacts, and its sensitivity.

1. The residual of a contact is the distance of the tip's centre from the offset surface along the outward normal n.
2. A small motion of the fixture, a rotation w about c and a translation v, changes it by  -n . v - ((x - c) x n) . w.
   Rotations are taken about the contacts' centroid c and in units of their spread. So the six columns of the Jacobian
   have similar sizes in any unit of length and at any distance from the origin.
3. Its singular values, over sigma, give the motions that the contacts determine, and those that are free.
4. A refit (`refine`) takes Gauss-Newton steps, halved until chi-square falls.
"""

from collections.abc import Mapping

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import TINY, Bools, Floats, cross
from tactfix.geometry.rigid import homogeneous, inverse, moved_about, orthonormalized, skew
from tactfix.geometry.surfaces import SidedSurface, Surface, moved, rescaled, residuals_and_normals
from tactfix.placement import Placement
from tactfix.poses.equations import PoseEquations, pose_equations
from tactfix.poses.placement_terms import onto_placement, terms_at, with_placement
from tactfix.values import frozen_value

MOST_REFIT_STEPS = 50
"""Most Gauss-Newton steps of a refit. It converges in a few, except from contacts far off the surfaces."""
SMALLEST_RATIO = 1e-9
"""Ratio of singular values below which a motion is free: rounding gives about 1e-15 of the largest; a fixture with a
smaller ratio would have its worst sigma a billion times its best."""


@frozen_value
class Sensitivity:
    """The sensitivity of n contacts to a motion: the Jacobian of residual / sigma (n, 6), and its frame.

    Columns: rotation (units of 1 / scale) and translation along the base axes, about centre (3,) in base, scale a
    length. basis (6, u): the unconstrained motions, None if all are. A measured pose counts as six
    contacts.
    """

    jacobian: Floats
    centre: Floats
    scale: float
    basis: Floats | None = None

    @property
    def reduced(self) -> Floats:
        """The Jacobian (r, u) of the unconstrained motions."""
        return self.jacobian if self.basis is None else self.jacobian @ self.basis

    def svd(self) -> tuple[Floats, Floats]:
        """Singular values (u,), largest first, and the motions (u, 6), a row each, that belong to them."""
        rows = self.reduced
        unknowns = rows.shape[1]
        rows = rows if len(rows) >= unknowns else np.vstack([rows, np.zeros((unknowns, unknowns))])
        _, values, motions = np.linalg.svd(rows, full_matrices=False)
        return values, motions if self.basis is None else motions @ self.basis.T

    def free(self, values: Floats) -> Bools:
        """Which of the singular values (u,) are zero to rounding: those of free motions."""
        # With constraints the largest value is that of the whole Jacobian: one motion alone has no ratio.
        largest = values[0] if self.basis is None else np.linalg.norm(self.jacobian, 2)
        return np.asarray(values <= SMALLEST_RATIO * max(float(largest), TINY))

    def twists(self, motions: Floats, at: Floats) -> Floats:
        """Motions (k, 6) of the Jacobian's columns as twists (k, 6) at the point at (3,): rotation rad, translation."""
        rotation = motions[:, :3] / self.scale
        return np.hstack([rotation, motions[:, 3:] + cross(rotation, at - self.centre)])

    def covariance(self, at: Floats) -> Floats:
        """Covariance (6, 6) of rotation (rad) and translation of the point at (3,); infinite where a motion is free."""
        values, motions = self.svd()
        with np.errstate(divide="ignore", over="ignore"):
            spread = self.twists(motions / np.maximum(values, TINY)[:, None], at)
            return np.asarray(spread.T @ spread)

    def free_motions(self, at: Floats) -> Floats:
        """Twists (k, 6) at the point at (3,) that change no residual, by the ratio of singular values."""
        values, motions = self.svd()
        return self.twists(motions[self.free(values)], at)


@frozen_value
class PoseFit:
    """A refined pose: surfaces in base, residuals (n,) along the outward normals (n, 3), chi2, and its sensitivity.

    off (m,): residuals over sigma of a measured pose, m = 0 or 6; chi2 includes them.
    """

    base_from_fixture: Floats
    surfaces: Mapping[str, SidedSurface]
    residuals: Floats
    normals: Floats
    chi2: float
    sensitivity: Sensitivity
    off: Floats


def contact_residuals(surfaces: Mapping[str, Surface], contacts: Contacts) -> tuple[Floats, Floats]:
    """Residuals (n,) and outward normals (n, 3) of contacts on surfaces in base."""
    values, normals = np.empty(len(contacts)), np.empty((len(contacts), 3))
    for name, index in contacts.by_feature.items():
        on_surface = residuals_and_normals(surfaces[name], contacts.points[index], contacts.tip_radius)
        values[index], normals[index] = on_surface
    return values, normals


def sensitivity(contacts: Contacts, normals: Floats, sigmas: Floats) -> Sensitivity:
    """The Jacobian of residuals over sigma at contacts with outward normals (n, 3)."""
    arms = (contacts.points - contacts.centre) / contacts.spread
    rows = np.concatenate([cross(arms, normals), normals], axis=1) / -sigmas[:, None]
    return Sensitivity(rows, contacts.centre, contacts.spread)


def refine(
    surfaces: Mapping[str, SidedSurface],
    contacts: Contacts,
    sigmas: Floats,
    base_from_fixture: Floats,
    placement: Placement | None = None,
) -> PoseFit:
    """A pose of low chi-square near base_from_fixture (4, 4); surfaces in the fixture frame, sigmas (n,).

    placement: prior knowledge of the pose. There is no step along a free motion.

    Gauss-Newton with step halving, and not `descent`: design checks refit contacts with tip radii that do not fit a
    feature; these have residuals but no pose equations. From residuals of thousands of sigma it ends in some local
    minimum, and not always that of `descent`.
    """
    start = base_from_fixture if placement is None else onto_placement(placement, base_from_fixture)
    fit = fit_at(surfaces, contacts, sigmas, start, placement)
    for _ in range(MOST_REFIT_STEPS):
        step = _gauss_newton_step(fit, sigmas)
        better = _line_search(surfaces, contacts, sigmas, fit, step, placement)
        if better is None:
            break
        gain, fit = fit.chi2 - better.chi2, better
        if gain <= 1e-12 * better.chi2 and np.abs(step).max() < 1e-6 * fit.sensitivity.scale:
            break
    return fit


def equations_near(
    fit: PoseFit, contacts: Contacts, sigmas: Floats, placement: Placement | None = None
) -> PoseEquations:
    """The residuals over sigma as functions of a motion of the contacts about their centroid, in units of their spread.

    The surfaces in base are the fixture of these equations: at no motion the residuals are those of the fit.
    """
    centre, scale = fit.sensitivity.centre, fit.sensitivity.scale
    names = list(contacts.by_feature)
    surfaces = [rescaled(fit.surfaces[name], centre, scale) for name in names]
    index = [names.index(name) for name in contacts.features]
    points = (contacts.points - centre) / scale
    equations = pose_equations(surfaces, index, points, scale / sigmas, contacts.tip_radius / scale)
    if placement is None:
        return equations
    frame_from_fixture = fit.base_from_fixture.copy()
    frame_from_fixture[:3, 3] -= centre
    return with_placement(equations, placement, centre, frame_from_fixture, scale, scale)


def no_motion(count: int) -> tuple[Floats, Floats]:
    """Rotations (3, 3, count) and offsets (3, count) of `equations_near` at the fit itself."""
    return np.repeat(np.eye(3)[:, :, None], count, axis=2), np.zeros((3, count))


def moved_poses(fit: PoseFit, rotations: Floats, offsets: Floats) -> Floats:
    """The poses (m, 4, 4) of the fixture that have the residuals of the fit after these motions of the contacts.

    rotations (3, 3, m), offsets (3, m): as in `equations_near`.
    """
    to_centre = homogeneous(np.eye(3), -fit.sensitivity.centre)
    turns = orthonormalized(np.moveaxis(rotations, -1, 0))
    contacts_moved = homogeneous(turns, fit.sensitivity.scale * offsets.T)
    return np.asarray(inverse(to_centre) @ inverse(contacts_moved) @ to_centre @ fit.base_from_fixture)


def fit_at(
    surfaces: Mapping[str, SidedSurface],
    contacts: Contacts,
    sigmas: Floats,
    base_from_fixture: Floats,
    placement: Placement | None = None,
) -> PoseFit:
    """The residuals and sensitivity at a pose (4, 4), without refinement; placement: prior knowledge of the pose."""
    in_base = {name: moved(base_from_fixture, surface) for name, surface in surfaces.items()}
    values, normals = contact_residuals(in_base, contacts)
    seen, more = with_known(sensitivity(contacts, normals, sigmas), placement, base_from_fixture)
    chi2 = float(((values / sigmas) ** 2).sum() + (more**2).sum())
    return PoseFit(base_from_fixture, in_base, values, normals, chi2, seen, more)


def with_known(seen: Sensitivity, placement: Placement | None, base_from_fixture: Floats) -> tuple[Sensitivity, Floats]:
    """The sensitivity with the rows of a placement, and the residuals (m,) over sigma of its measured pose."""
    if placement is None or not placement.is_in_fit:
        return seen, np.zeros(0)
    basis, more, rows = terms_at(placement, base_from_fixture, seen.centre, seen.scale)
    free = None if basis.shape[1] == 6 else basis
    return Sensitivity(np.concatenate([seen.jacobian, rows]), seen.centre, seen.scale, free), more


def _gauss_newton_step(fit: PoseFit, sigmas: Floats) -> Floats:
    """The Gauss-Newton step (6,) in the sensitivity's columns."""
    misses = np.concatenate([fit.residuals / sigmas, fit.off])
    step, *_ = np.linalg.lstsq(fit.sensitivity.reduced, -misses, rcond=SMALLEST_RATIO)
    step = step if fit.sensitivity.basis is None else fit.sensitivity.basis @ step
    # At most one spread of the contacts: beyond that the linear model is wrong.
    return np.asarray(step * (fit.sensitivity.scale / max(fit.sensitivity.scale, float(np.linalg.norm(step)))))


def _line_search(
    surfaces: Mapping[str, SidedSurface],
    contacts: Contacts,
    sigmas: Floats,
    fit: PoseFit,
    step: Floats,
    placement: Placement | None,
) -> PoseFit | None:
    """The first of the halved steps that lowers chi-square; None if none does."""
    for halvings in range(20):
        half = step * 0.5**halvings
        pose = moved_about(fit.base_from_fixture, half, fit.sensitivity.centre, fit.sensitivity.scale)
        pose = pose if placement is None else onto_placement(placement, pose)
        new = fit_at(surfaces, contacts, sigmas, pose, placement)
        if new.chi2 < fit.chi2:
            return new
    return None


def covariance_at(covariance: Floats, arm: Floats) -> Floats:
    """Covariance (6, 6) of the twist at a point, from that at another point; arm (3,): from that one to this one."""
    shift = np.eye(6)
    shift[3:, :3] = -skew(arm)
    return np.asarray(shift @ covariance @ shift.T)
