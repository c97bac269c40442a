"""The tool orientation of each planned contact, optimal for the tip's place in the flange found with the pose.

A tip that is displaced by q in the flange frame changes the residual of contact i by n_i . F_i q, with the rotation F_i
of the flange: three columns more than those of the pose. Orientations are assigned to contacts so that the largest
standard deviation of the tip's place, with pose and tip unknown, is smallest.

1. The contacts take the orientations in turn.
2. Contacts already made count with their orientations.
3. Contact by contact, another orientation is taken if it lowers that standard deviation by more than rounding.
4. Passes over all contacts are repeated until one changes nothing.
"""

from dataclasses import replace
from typing import Final

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import UsageError
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats, Ints
from tactfix.geometry.rigid import inverse
from tactfix.planning.exchange import WORTH_A_STEP
from tactfix.planning.pool import joined_contacts
from tactfix.planning.result import Plan
from tactfix.poses.placement_terms import terms_in_fixture
from tactfix.poses.points_as_planes import one_equation_each
from tactfix.poses.pose_fit import contact_residuals, sensitivity
from tactfix.probe import residual_sigmas
from tactfix.simulation.poses import in_turn, tool_orientations
from tactfix.simulation.simulate import nominal_surfaces

USUAL_CONTACTS: Final = 12
"""Default number of contacts: nine unknowns of pose and tip, and three contacts of redundancy."""
ORIENTATION_PASSES: Final = 10
"""Passes over all contacts at most; the last one changes nothing."""
TIP_UNDETERMINED: Final = 1e-9
"""Ratio of singular values below which the tip is not determined."""


def with_orientations(plan: Plan, fixture: Fixture, count: int, made: Contacts | None = None) -> Plan:
    """The plan in count tool orientations, assigned to its contacts.

    made: contacts already made, in the fixture frame. Raises UsageError for a count below one, and if contacts already
    made have no flange rotations.
    """
    if count < 1:
        raise UsageError(f"{count} tool orientations cannot be planned; ask for one or more")
    if made is not None and made.flange_rotations is None:
        raise UsageError(
            "the contacts already made have no flange orientations, and the tip is determined from all contacts; "
            "give columns such as qw,qx,qy,qz, or plan without those contacts"
        )
    base_from_fixture = plan.base_from_fixture if plan.frame == "base" else None
    new = plan.contacts if base_from_fixture is None else plan.contacts.moved(inverse(base_from_fixture))
    rotations = tool_orientations(count, new.approaches)
    chosen = in_turn(new.features, count)  # step 1
    # Step 2.
    seen = _TipSensitivity(fixture, new if made is None else joined_contacts(made, new))
    fixed = np.zeros((0, 3, 3)) if made is None or made.flange_rotations is None else made.flange_rotations

    def tip_sigma(which: Ints) -> float:
        return seen.tip_sigma(np.concatenate([fixed, rotations[which]]))

    best = tip_sigma(chosen)
    for _ in range(ORIENTATION_PASSES):
        before = best
        for i in range(len(chosen)):
            for other in range(count):
                tried = chosen.copy()
                tried[i] = other
                # Step 3.
                if (sigma := tip_sigma(tried)) < (1 - WORTH_A_STEP) * best:
                    chosen, best = tried, sigma
        if best == before:  # step 4
            break
    offset = np.array(fixture.probe.tip_offset or (0.0, 0.0, 0.0))
    turned = rotations[chosen] if base_from_fixture is None else base_from_fixture[:3, :3] @ rotations[chosen]
    contacts = replace(plan.contacts, flange_rotations=turned, tip_offset=offset)
    return replace(plan, contacts=contacts, tip_sigma=float(best))


class _TipSensitivity:
    """The Jacobian of nominal contacts in the fixture frame for the pose, and for a tip in given orientations."""

    def __init__(self, fixture: Fixture, contacts: Contacts) -> None:
        single = one_equation_each(nominal_surfaces(fixture), contacts, residual_sigmas(fixture, contacts))
        _, self.normals = contact_residuals(single.surfaces, single.contacts)
        self.sigmas, self.of = single.sigmas, single.of
        seen = sensitivity(single.contacts, self.normals, single.sigmas)
        self.pose = seen.jacobian
        self.known = np.zeros((0, self.pose.shape[1]))
        if fixture.placement is not None:
            basis, rows = terms_in_fixture(fixture.placement, fixture.placement.near, seen.centre, seen.scale)
            self.pose, self.known = self.pose @ basis, rows @ basis

    def tip_sigma(self, rotations: Floats) -> float:
        """The largest standard deviation of the tip's place (units); inf if it is not determined."""
        tip = np.einsum("ni,nij->nj", self.normals, rotations[self.of]) / self.sigmas[:, None]
        below = np.hstack([self.known, np.zeros((len(self.known), 3))])
        joint = np.vstack([np.hstack([self.pose, tip]), below])
        if len(joint) < joint.shape[1]:
            return float("inf")
        _, values, motions = np.linalg.svd(joint, full_matrices=False)
        if values[-1] <= TIP_UNDETERMINED * values[0]:
            return float("inf")
        spread = motions[:, -3:] / values[:, None]
        return float(np.linalg.norm(spread, 2))
