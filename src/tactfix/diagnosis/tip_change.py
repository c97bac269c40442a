"""How far the tip stands from where it is taken to be, to first order at a pose that is left.

A tip that stands q elsewhere in the flange moves the contact i by R_i q, R_i how the flange stood, and its residual by
n_i . R_i q. Where the flange turned, no motion of the fixture makes up for that: three columns more in the least
squares.

1. Residuals over sigma and what motions of the fixture do to them are taken at the pose.
2. From residuals and the columns n_i . R_i is taken away what these motions make up for.
3. Where of a direction of q nothing is left, the contacts cannot tell it; else least squares give q.
4. It is as likely as one wrong contact if the Bayesian information criterion (Schwarz 1978) says so.
"""

import math

import numpy as np

from tactfix.contacts import Contacts
from tactfix.diagnosis.deletion import Doubts, span_of
from tactfix.fixture import Placement
from tactfix.geometry.arrays import Floats
from tactfix.poses.points_as_planes import one_equation_each
from tactfix.poses.pose_fit import SMALLEST_RATIO, contact_residuals, sensitivity, with_known
from tactfix.poses.solution import Solution
from tactfix.values import frozen_value


@frozen_value
class TipChange:
    """change (3,) in the flange frame, units; what is left of chi-square with it, and whether it is the likelier cause.

    is_plausible: that it explains the residuals no worse than the one contact that stands out most, by the Bayesian
    information criterion: log n for each number that is free, and twice log n for the choice of one contact.
    """

    change: Floats
    chi2: float
    is_plausible: bool


def tip_change(
    contacts: Contacts, sigmas: Floats, solution: Solution, placement: Placement | None = None
) -> TipChange | None:
    """The change of the tip that fits best, None where the contacts cannot tell it; sigmas (n,) of the residuals."""
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
    worst = float(Doubts(scaled, span).normalized[: len(single.of)].max())
    count = len(single.of)
    chi2, before = float(rest @ rest), float(left @ left)
    as_one = before - worst**2 + 3 * math.log(count)  # step 4
    return TipChange(change, chi2, chi2 + 3 * math.log(count) <= as_one)
