"""Contacts already made, in the fixture frame: by the pose that they give, or by one that they allow.

1. The poses that explain them are located; if there is none and the tip is unknown, those with another tip.
2. If no motion is free, or one is weakly determined, the best pose is taken.
3. If a motion is free, the contacts have nearly the same information at all poses that it leads through. From each
   pose, turned by each of _FIRST_TURNS, a descent (Levenberg-Marquardt) leads to a pose at which every contact lies in
   the touch box of its feature and its approach leads into the material, as at the true pose.
4. The first pose with a cost below the number of contacts is taken, else the one with the least cost.
"""

from collections.abc import Callable

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import UsageError
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import TINY, Floats
from tactfix.geometry.rigid import homogeneous, inverse, rotation_from_vector, transform_points
from tactfix.geometry.surfaces import moved, outward_normals, residuals
from tactfix.localization.locate import locate
from tactfix.locate_result import LocateResult
from tactfix.results import Candidate
from tactfix.values import frozen_value

_AS_BAD_AS_SIGMA = 1e-3
"""Share of the contacts' extent outside a box, and cosine of an approach, that cost as much as one sigma."""
_SHALLOWEST_APPROACH = -0.5
"""Cosine of approach and outward normal that usual approaches do not exceed: 60 degrees from the inward normal."""
_TOUCH_STEPS = 40
"""Levenberg-Marquardt steps at most."""
_TOUCH_DIFFERENCE = 1e-7
"""Step of the forward differences: rad, and shares of the contacts' extent; above the root of doubles' rounding."""
_TOUCH_SETTLED = 1e-6
"""A step that lowers the sum of squares by less than this share of it, and of one, is the last."""
_FIRST_TURNS = np.vstack([np.zeros(3), *(np.pi * f * axis for f in (1.0, 0.5, -0.5) for axis in np.eye(3))])
"""Rotation vectors of the start poses relative to the located one: a descent does not turn the fixture over."""
_MARGIN = 0.05
"""Share of a box's width that contacts keep from its edges without cost: planned contacts keep away from edges."""


@frozen_value
class Made:
    """Contacts already made, in the fixture frame, and the pose of the fixture; None if they leave a motion free."""

    contacts: Contacts
    base_from_fixture: Floats | None


def contacts_made(fixture: Fixture, existing: Contacts, tip_unknown: bool = False) -> Made:
    """The contacts in the fixture frame; tip_unknown: if no pose explains them, one with another tip is used.

    Raises UsageError if no pose explains them.
    """
    result = locate(fixture, existing, explain=False)  # step 1
    accepted = _accepted(result)
    if not accepted and tip_unknown and existing.flange_rotations is not None:
        with_tip = _accepted(locate(fixture, existing, unknown=["tip"]))
        if with_tip:
            # Motions that too few orientations leave free move fixture and tip together, by little.
            pose = with_tip[0].base_from_fixture
            return Made(existing.moved(inverse(pose)), pose)
    if not accepted:
        raise UsageError(
            f"the contacts already made do not give a pose to plan from ({result.status}); locate says why"
        )
    touch = result.next_contact
    # Step 2.
    if result.status != "underdetermined" or (touch is not None and touch.point is not None):
        pose = accepted[0].base_from_fixture
        return Made(existing.moved(inverse(pose)), pose)
    best = (np.inf, accepted[0].base_from_fixture)
    for candidate in accepted:
        for turn in _FIRST_TURNS:
            # Step 3.
            best = min(best, _possible(fixture, existing, candidate, turn), key=lambda one: one[0])
            if best[0] < len(existing):  # step 4
                return Made(existing.moved(inverse(best[1])), None)
    return Made(existing.moved(inverse(best[1])), None)


def _accepted(result: LocateResult) -> list[Candidate]:
    """The poses that are left, the one with the least chi-square first."""
    return sorted((c for c in result.candidates if c.accepted), key=lambda candidate: candidate.chi2)


def _possible(fixture: Fixture, contacts: Contacts, candidate: Candidate, turn: Floats) -> tuple[float, Floats]:
    """The pose of least cost near the candidate's, which is first turned by a rotation vector (3,).

    The cost, half the sum of squares of residuals, sides and boxes, and the pose.
    """
    start = inverse(candidate.base_from_fixture)
    surfaces = {name: moved(start, surface) for name, surface in candidate.surfaces.items()}
    local = contacts.moved(start)
    first = np.concatenate([turn, np.zeros(3)])
    size = float(np.linalg.norm(np.ptp(local.points, axis=0))) or 1.0

    def off(step: Floats) -> Floats:
        motion = _pose(first + step, size, local.centre)
        points, ways = transform_points(motion, local.points), local.approaches @ motion[:3, :3].T
        parts = []
        for name, index in contacts.by_feature.items():
            parts.append(residuals(surfaces[name], points[index], contacts.tip_radius) / contacts.sigmas[index])
            into = np.einsum("ij,ij->i", ways[index], outward_normals(surfaces[name], points[index]))
            parts.append(
                np.where(np.isfinite(into), np.maximum(into - _SHALLOWEST_APPROACH, 0.0), 0.0) / _AS_BAD_AS_SIGMA
            )
            box = fixture.touch.get(name)
            if box is not None:
                width = np.where(np.isfinite(box.high - box.low), box.high - box.low, 0.0)
                low, high = box.low + _MARGIN * width, box.high - _MARGIN * width
                outside = np.maximum(np.maximum(low - points[index], points[index] - high) - contacts.tip_radius, 0.0)
                parts.append(outside.ravel() / (_AS_BAD_AS_SIGMA * size))
        return np.concatenate(parts)

    step, cost = _least(off)
    return cost, inverse(_pose(first + step, size, local.centre) @ start)


def _least(off: Callable[[Floats], Floats]) -> tuple[Floats, float]:
    """The minimum from zero (6,), and half the sum of squares there: Levenberg-Marquardt, forward differences."""
    step, damping = np.zeros(6), 1e-3
    values = off(step)
    for _ in range(_TOUCH_STEPS):
        slopes = np.array([(off(step + _TOUCH_DIFFERENCE * unit) - values) / _TOUCH_DIFFERENCE for unit in np.eye(6)]).T
        curvature = slopes.T @ slopes
        damped = curvature + damping * np.diag(np.diag(curvature) + TINY)
        ahead = step - np.linalg.lstsq(damped, slopes.T @ values, rcond=None)[0]
        gain = float(values @ values) - float(off(ahead) @ off(ahead))
        if gain > 0:
            step, values, damping = ahead, off(ahead), 0.2 * damping
            if gain < _TOUCH_SETTLED * (1 + float(values @ values)):
                break
        else:
            damping *= 5
    return step, float(values @ values) / 2


def _pose(step: Floats, size: float, centre: Floats) -> Floats:
    """The motion (4, 4) by a turn (3,) about the centre and a shift (3,) in units of size."""
    turn = rotation_from_vector(step[:3])
    return homogeneous(turn, centre + size * step[3:] - turn @ centre)
