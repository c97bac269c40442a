"""The error of the tip's place in the flange frame, to first order at a pose that fits.

A tip that is displaced by q in the flange frame moves contact i by R_i q, where R_i is the rotation of the flange, and
changes its residual by n_i . R_i q. If the flange had different orientations, no motion of the fixture has the same
effect. So the least squares get three more columns.

1. Residuals over sigma and the Jacobian of the motions of the fixture are taken at the pose.
2. Residuals and the columns n_i . R_i are projected onto the complement of that Jacobian's columns.
3. If the projected columns are dependent, q is not determined; otherwise least squares give q.
4. q is compared with one wrong contact by the Bayesian information criterion (Schwarz 1978).
"""

import math

import numpy as np

from tactfix.contacts import Contacts
from tactfix.diagnosis.deletion import CaseDeletion, span_of
from tactfix.geometry.arrays import Floats
from tactfix.placement import Placement
from tactfix.poses.points_as_planes import one_equation_each
from tactfix.poses.pose_fit import SMALLEST_RATIO, contact_residuals, sensitivity, with_known
from tactfix.poses.solution import Solution
from tactfix.values import frozen_value


@frozen_value
class TipChange:
    """change (3,): of the tip, in the flange frame and fixture units; chi2: after the change.

    is_plausible: whether it explains the residuals no worse than deleting the worst contact does, by the Bayesian
    information criterion: log n for each free number, and twice log n for the choice of one contact.
    """

    change: Floats
    chi2: float
    is_plausible: bool


def tip_change(
    contacts: Contacts, sigmas: Floats, solution: Solution, placement: Placement | None = None
) -> TipChange | None:
    """The change of the tip that fits best; None if the contacts do not determine it. sigmas (n,) of the residuals."""
    assert contacts.flange_rotations is not None
    single = one_equation_each(solution.surfaces, contacts, sigmas)
    values, normals = contact_residuals(single.surfaces, single.contacts)  # step 1
    seen = sensitivity(single.contacts, normals, single.sigmas)
    seen, more = with_known(seen, placement, solution.base_from_fixture)
    scaled = np.concatenate([values / single.sigmas, more])
    span = span_of(seen.reduced)
    columns = np.einsum("ni,nij->nj", normals, contacts.flange_rotations[single.of]) / single.sigmas[:, None]
    columns = np.vstack([columns, np.zeros((len(more), 3))])
    # Step 2.
    own, left = columns - span @ (span.T @ columns), scaled - span @ (span.T @ scaled)
    sizes = np.linalg.svd(own, compute_uv=False)  # step 3
    if sizes[-1] <= SMALLEST_RATIO * np.linalg.norm(columns):
        return None
    change = -np.linalg.lstsq(own, left, rcond=None)[0]
    rest = left + own @ change
    worst = float(CaseDeletion(scaled, span).normalized[: len(single.of)].max())
    count = len(single.of)
    chi2, before = float(rest @ rest), float(left @ left)
    as_one = before - worst**2 + 3 * math.log(count)  # step 4
    return TipChange(change, chi2, chi2 + 3 * math.log(count) <= as_one)
