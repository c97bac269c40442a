"""Whether a fitted robot may be written, and the warnings of a fit.

1. The touches are inconsistent if one touch is explained by no robot, residuals are gross, or a place contradicts its
   placement.
2. No robot is written if no factor on the prior is better than the nominal robot at the places left out.
3. That is not enough, because a place left out tests only what its features measure. Tables measure heights alone; two
   parallel tables have similar form errors, and the robot deforms alike on both. A robot with many parameters can fit
   that and be worse elsewhere. So the touches must also determine the robot: of errors that would explain the nominal
   robot's residuals they must leave less than half over its joint ranges (`accuracy.undetermined`, `IDENTIFIED`), the
   limit for a single parameter. Errors that the tip's offset or the base compensate are not counted. The result does
   not depend on the width of the prior, only on the ratios between its kinds.
4. Parameters that the file names must be identified.
"""

from typing import Final

import numpy as np

from tactfix.calibration import accuracy
from tactfix.calibration.cell import Cell
from tactfix.calibration.result import Calibration, CalibrationStatus, PlaceResult
from tactfix.calibration.robot_fit import RobotFit
from tactfix.geometry.arrays import Floats
from tactfix.noise import SUSPICIOUS, chi_square_limit
from tactfix.poses.prior import contradiction
from tactfix.values import frozen_value
from tactfix.wording import listed

GROSS_RESIDUAL: Final = 50.0
"""Ratio of the residuals to sigma above which they are neither noise nor form error: something else was touched."""

_NOTHING_CHECKS: Final = "touches at one place cannot check a calibration: touch the fixture at another place too"
"""The reason not to write a robot calibrated at one place, or the warning if the user accepts that."""


def status_of(
    fit: RobotFit, certainty: accuracy.Certainty, result: Calibration, unchecked: bool
) -> tuple[CalibrationStatus, tuple[str, ...]]:
    """The status, and why it is not "calibrated"; unchecked: accept touches at one place."""
    # Step 1.
    rows = sum(len(group.touches) for group in fit.groups)
    if fit.suspicious and fit.noise**2 * rows <= chi_square_limit(rows, SUSPICIOUS):
        named = listed([str(row) for row in fit.suspicious])
        return "inconsistent", (f"row {named}: no robot explains them together with all others; repeat these touches",)
    reasons = [reason for place in result.places if (reason := _against_placement(fit.cell, place))]
    if fit.noise > GROSS_RESIDUAL:
        message = f"the residuals are {fit.noise:.0f} times sigma after calibration"
        reasons.append(f"{message}: check units, labels, the fixtures' files and the robot's model")
    if reasons:
        return "inconsistent", tuple(reasons)
    # Step 2.
    if _is_one_place(fit):
        reasons += () if unchecked else (_NOTHING_CHECKS,)
    elif fit.choice.factor == 0:
        reasons.append("no calibrated robot is better than the nominal one at the places left out")
    # Step 3.
    if result.undetermined >= accuracy.IDENTIFIED:
        left = f"the touches leave {100 * result.undetermined:.0f} per cent of the robot's errors over its joint ranges"
        remedy = "touch at more places and features that face other ways, or reduce the unknown parameters"
        reasons.append(f"{left}, {100 * accuracy.IDENTIFIED:.0f} or more is too much: {remedy}")
    # Step 4.
    names = [parameter.name for parameter, free in zip(fit.cell.parameters, fit.free, strict=True) if free]
    unknown = [name for name, known in zip(names, certainty.identified, strict=True) if not known]
    asked = [name for name in unknown if name in fit.cell.unknown and "." in name]
    if asked:
        reasons.append(f"the touches do not determine {listed(asked)}, asked for by name")
    return ("underdetermined" if reasons else "calibrated"), tuple(reasons)


def _is_one_place(fit: RobotFit) -> bool:
    return len(fit.touches.touched) < 2


@frozen_value
class _PlacePose:
    """The pose of a place; infinite variances if its touches leave motions free."""

    base_from_fixture: Floats
    covariance: Floats
    free_twists: Floats


def _against_placement(cell: Cell, place: PlaceResult) -> str | None:
    """The contradiction between a place and its placement, in words, if there is one."""
    placement = cell.places[place.name].placement
    if placement is None:
        return None
    covariance = np.full((6, 6), np.inf) if place.covariance is None else place.covariance
    found = contradiction(
        placement, _PlacePose(place.base_from_fixture, covariance, np.zeros((0, 6))), cell.units, fitted=True
    )
    remedy = "check its placement in the cell file, and that the touches are of this place"
    return (
        None if found is None else f"what is known of {place.name!r} contradicts the touches: {found.message}; {remedy}"
    )


def warnings_of(fit: RobotFit, unchecked: bool) -> tuple[str, ...]:
    """The warnings of a fit."""
    found = [_NOTHING_CHECKS] if unchecked and _is_one_place(fit) else []
    if fit.noise > 1.5:
        message = f"the residuals are {fit.noise:.2g} times as large as sigma"
        wider = "" if "all" in fit.cell.unknown else "parameters that are not unknown are wrong, "
        causes = f"{wider}surfaces are not as the file says, or the robot bends"
        found.append(f"{message}: {causes}; sigmas are scaled up by it")
    if fit.suspicious:
        named = listed([f"row {row}" for row in fit.suspicious[:10]])
        found.append(f"larger than noise: {named} (data snooping): repeat these touches")
    if fit.choice.left_out and fit.choice.factor > 0:
        worse = [name for name, (before, after) in fit.choice.left_out.items() if after > 1.05 * before]
        if worse:
            found.append(f"left out, {listed(worse)} is worse with the calibrated robot than with the nominal one")
    return tuple(found)
