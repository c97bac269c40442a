"""A plane from three contacts or more: orthogonal least squares by singular values.

1. Contacts are centred and scaled (`unit_contacts`), and refused if fewer than three differ or all lie on one line.
2. The plane passes through their weighted mean.
3. Its normal is the right singular vector of the weighted arms with the smallest singular value.
4. Both sides are returned, each offset by tip_radius: only the approach shows which one is outward.

Three contacts: eqs. 1-2, n = v1 x v2.
"""

import numpy as np

from tactfix.geometry.arrays import Floats, Ints, basis_across, unit
from tactfix.geometry.surfaces import Plane
from tactfix.localizers.candidate import SurfaceCandidate
from tactfix.localizers.unit_contacts import refuse_coincident, refuse_collinear, unit_contacts
from tactfix.values import frozen_value

CONTACTS = 3
"""Contacts that determine a plane: it has three degrees of freedom."""


def localize_plane(
    points: Floats, sigmas: Floats | float | None = None, tip_radius: float = 0.0
) -> tuple[SurfaceCandidate, ...]:
    """The plane nearest to contacts, with each of its sides as the outward one.

    Minimises the weighted sum of ((x_i - p) . n - tip_radius)^2; through three contacts n = v1 x v2 (eq. 1).

    points (n, 3): n >= 3 tip centres or surface points; sigmas (n,) or one number, along the normal, or None for exact
    contacts; tip_radius: distance of the tip's centres from the plane on its outward side: all in one unit.
    Returns two candidates with opposite normals, 2 * tip_radius apart.
    Raises DegenerateContactsError if fewer than three contacts differ, or all lie on one line.
    Source: eqs. 1-2; orthogonal least squares by singular values beyond three contacts.
    """
    contacts = unit_contacts(points, sigmas)  # step 1
    refuse_coincident("plane", contacts, CONTACTS)
    refuse_collinear("plane", contacts)
    share = contacts.weights**2 / np.sum(contacts.weights**2)
    middle = share @ contacts.points  # step 2
    arms = (contacts.points - middle) * contacts.weights[:, None]
    _, spread, vh = np.linalg.svd(arms, full_matrices=False)
    normal = vh[-1]  # step 3
    residuals = (contacts.points - middle) @ normal
    center = contacts.origin + contacts.scale * middle
    chi2 = float(np.sum((contacts.weights * residuals / contacts.sigma) ** 2))
    rms = float(np.sqrt(np.mean(residuals**2)) * contacts.scale)
    # Step 4.
    return tuple(
        SurfaceCandidate(Plane(center - tip_radius * n, n), chi2, rms, float(1.0 / spread[1]), poorly_determined=False)
        for n in (normal, -normal)
    )


@frozen_value
class PlaneProblem:
    """Contacts (n, 3) of unit size and weights (n,); a state is (point (3,), normal (3,)).

    Parameters: a shift along the normal, and two tilts about the point.
    """

    points: Floats
    weights: Floats

    def evaluate(self, states: Floats, index: Ints) -> tuple[Floats, Floats]:
        """Residuals (B, n), weight * height over the plane, and Jacobians (B, n, 3)."""
        del index
        arms = self.points - states[:, None, :3]
        heights = np.einsum("bni,bi->bn", arms, states[:, 3:])
        tilts = arms @ np.swapaxes(basis_across(states[:, 3:]), -1, -2)
        jacobian = np.concatenate([np.full((*heights.shape, 1), -1.0), tilts], axis=-1) * self.weights[:, None]
        return self.weights * heights, jacobian

    def step(self, states: Floats, change: Floats) -> Floats:
        """The states after a shift and two tilts (B, 3)."""
        normal = states[:, 3:]
        tilt = np.einsum("bi,bij->bj", change[:, 1:], basis_across(normal))
        return np.concatenate([states[:, :3] + change[:, :1] * normal, unit(normal + tilt)], axis=-1)
