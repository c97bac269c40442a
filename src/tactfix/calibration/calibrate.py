"""Robot calibration from touches: the estimate, its accuracy, and its verification.

1. The robot is fitted to the touches at all places except those held out (`robot_fit`).
2. The linearised equations there give the covariance and the identified parameters (`accuracy`).
3. The result contains parameters, tip, places, residuals, outliers, and the sigma of the tip over the joint ranges.
4. The status says whether this robot may be written (`status`).
5. Each place held out is located with the nominal and with the calibrated robot.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactfix.calibration import accuracy, robust_start, shrinkage
from tactfix.calibration.cell import Cell, Touches
from tactfix.calibration.equations import distances, groups_of, place_pose
from tactfix.calibration.estimation import Eliminated, reduced
from tactfix.calibration.result import (
    Calibration,
    LeftOut,
    ParameterResult,
    PlaceResult,
    TipResult,
    TouchResidual,
    Workspace,
)
from tactfix.calibration.robot_fit import RobotFit, fitted
from tactfix.calibration.status import status_of, warnings_of
from tactfix.errors import UsageError
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import skew
from tactfix.wording import listed


def calibrate(cell: Cell, touches: Touches, hold_out: Sequence[str] = (), unchecked: bool = False) -> Calibration:
    """Calibrate the robot of a cell.

    hold_out: places that are not used for the fit, only located with the nominal and the calibrated robot. unchecked:
    accept touches at one place, with the full prior. Raises UsageError for places that are not touched.
    """
    _refuse(touches, hold_out)
    train = touches.at([name for name in touches.touched if name not in hold_out])
    fit = fitted(cell, train, unchecked)  # step 1
    # Step 2.
    parts = reduced(cell, fit.groups, fit.after)
    certainty = _certainty(fit, parts)
    spread = np.zeros((len(fit.free), len(fit.free)))
    spread[np.ix_(fit.free, fit.free)] = certainty.covariance
    result = _result(fit, parts, certainty, spread)  # step 3
    status, reasons = status_of(fit, certainty, result, unchecked)  # step 4
    return replace(
        result,
        status=status,
        reasons=reasons,
        # Step 5.
        left_out=(*result.left_out, *(_held_out(fit, touches.at([name]), name) for name in hold_out)),
        warnings=warnings_of(fit, unchecked),
    )


def _refuse(touches: Touches, hold_out: Sequence[str]) -> None:
    for name in hold_out:
        if name not in touches.touched:
            raise UsageError(f"no touch is at {name!r}; the places touched are {listed(touches.touched)}")
    if set(touches.touched) <= set(hold_out):
        raise UsageError("every place is held out; leave at least one to calibrate with")


def _certainty(fit: RobotFit, parts: tuple[Eliminated, ...]) -> accuracy.Certainty:
    names = tuple(parameter.name for parameter in fit.cell.parameters)
    believed = shrinkage.believed(fit.cell, fit.prior, fit.free, fit.choice.factor)
    return accuracy.certainty(
        accuracy.information(parts, fit.free),
        fit.prior[fit.free],
        believed[fit.free],
        fit.noise**2,
        tuple(name for name, free in zip(names, fit.free, strict=True) if free),
    )


def _undetermined(fit: RobotFit) -> float:
    """The share (0 to 1) that the touches leave of errors that would explain the nominal robot's residuals."""
    possible = shrinkage.believed(fit.cell, fit.prior, fit.free, fit.room)[fit.free]
    tip = robust_start.tips(fit.cell, fit.free)[fit.free]
    matrix = accuracy.information(reduced(fit.cell, fit.groups, fit.before), fit.free)
    _, moves = accuracy.workspace_points(fit.cell, fit.touches, fit.before.values)
    return accuracy.undetermined(matrix, possible, tip, moves[:, :, fit.free], fit.noise**2)


def _result(
    fit: RobotFit,
    parts: tuple[Eliminated, ...],
    certainty: accuracy.Certainty,
    spread: Floats,
) -> Calibration:
    """The result without its status and the places held out."""
    matrix, prior = accuracy.information(parts, fit.free), fit.prior[fit.free]
    points, moves = accuracy.workspace_points(fit.cell, fit.touches, fit.after.values)
    workspace = Workspace(points, accuracy.tip_sigmas(moves, _prior_spread(fit)), accuracy.tip_sigmas(moves, spread))
    return Calibration(
        units=fit.cell.units,
        status="underdetermined",
        values=fit.after.values,
        covariance=spread,
        parameters=_parameters(fit, certainty),
        not_identified=(*(held.message for held in fit.held), *certainty.unknown),
        tip=_tip(fit, spread),
        places=_places(fit, parts, spread),
        left_out=tuple(LeftOut(name, *rms, False) for name, rms in fit.choice.left_out.items()),
        shrinkage=fit.choice.factor,
        prediction=workspace.prediction,
        undetermined=_undetermined(fit),
        workspace=workspace,
        scores=fit.choice.scores,
        observability=accuracy.observability(matrix, prior, len(fit.touches)),
        touches=_touch_residuals(fit),
        outliers=fit.suspicious,
        reasons=(),
        warnings=(),
    )


def _parameters(fit: RobotFit, certainty: accuracy.Certainty) -> tuple[ParameterResult, ...]:
    """The parameters to calibrate, those held at nominal included, in the order of the chain."""
    sigmas = dict(zip(np.flatnonzero(fit.free).tolist(), np.sqrt(np.diag(certainty.covariance)).tolist(), strict=True))
    known = dict(zip(np.flatnonzero(fit.free).tolist(), certainty.identified.tolist(), strict=True))
    held = {item.index for item in fit.held}
    found = []
    for index, parameter in enumerate(fit.cell.parameters):
        if index in sigmas or index in held:
            scale = float(np.rad2deg(1.0)) if parameter.is_angle else 1.0
            found.append(
                ParameterResult(
                    name=parameter.name,
                    joint=_joint_name(fit.cell, parameter.name),
                    unit="deg" if parameter.is_angle else fit.cell.units,
                    nominal=0.0,
                    value=float(fit.after.values[index]) * scale,
                    sigma=sigmas.get(index, 0.0) * scale,
                    identified=known.get(index, False),
                )
            )
    return tuple(found)


def _joint_name(cell: Cell, name: str) -> str | None:
    joint, _, _ = name.partition(".")
    number = joint.removeprefix("joint_")
    return cell.chain.joints[int(number) - 1].name if number.isdecimal() else None


def _places(fit: RobotFit, parts: tuple[Eliminated, ...], spread: Floats) -> tuple[PlaceResult, ...]:
    rms = _rms_by_place(fit)
    by_root = {group.root: part for group, part in zip(fit.groups, parts, strict=True)}
    found = []
    for name in fit.touches.touched:
        pose = place_pose(fit.cell, fit.after.poses, name)
        part = by_root[fit.cell.root(name)[0]]
        found.append(PlaceResult(name, pose, _place_covariance(part, spread, fit.noise, pose), *rms[name]))
    return tuple(found)


def _place_covariance(part: Eliminated, spread: Floats, noise: float, pose: Floats) -> Floats | None:
    """Covariance (6, 6) of a pose about its origin, by noise and by the robot; None if a motion is free."""
    if not part.is_located:
        return None
    steps = part.block.motions @ part.steps
    by_robot = steps @ part.basis.T @ part.block.robot
    own = steps @ steps.T * noise**2 + by_robot @ spread @ by_robot.T
    shift = np.eye(6)
    shift[:3, :3] /= part.block.scale
    shift[3:, :3] = -skew(pose[:3, 3] - part.block.centre) / part.block.scale
    return np.asarray(shift @ own @ shift.T)


def _tip(fit: RobotFit, spread: Floats) -> TipResult:
    """The tip in its flange: its errors are lengths along the axes of its own frame."""
    index = [fit.cell.chain.names().index(f"tip.{axis}") for axis in "xyz"]
    errors = np.eye(4)
    errors[:3, 3] = fit.after.values[index]
    flange_from_tip = fit.cell.flange_from_tip @ errors
    rotation = flange_from_tip[:3, :3]
    covariance = rotation @ spread[np.ix_(index, index)] @ rotation.T
    radius = fit.cell.tip_radius + float(fit.after.values[-1])
    return TipResult(fit.cell.flange, flange_from_tip, covariance, radius, float(np.sqrt(spread[-1, -1])))


def _touch_residuals(fit: RobotFit) -> tuple[TouchResidual, ...]:
    before = distances(fit.cell, fit.groups, fit.before.poses, fit.before.values)
    after = distances(fit.cell, fit.groups, fit.after.poses, fit.after.values)
    touches = fit.touches
    return tuple(
        TouchResidual(row, place, feature, before[row], after[row])
        for row, place, feature in zip(touches.rows, touches.places, touches.features, strict=True)
    )


def _rms_by_place(fit: RobotFit) -> dict[str, tuple[float, float]]:
    by_place: dict[str, list[tuple[float, float]]] = {name: [] for name in fit.touches.touched}
    for touch in _touch_residuals(fit):
        by_place[touch.place].append((touch.before, touch.after))
    found = {name: np.sqrt((np.array(pairs) ** 2).mean(axis=0)) for name, pairs in by_place.items()}
    return {name: (float(rms[0]), float(rms[1])) for name, rms in found.items()}


def _held_out(fit: RobotFit, touches: Touches, name: str) -> LeftOut:
    (group,) = groups_of(fit.cell, touches)
    start = robust_start.placed(fit.cell, (group,), fit.after.values, np.sqrt(np.diag(_prior_spread(fit))))
    rms = [shrinkage.left_out(fit.cell, group, start, state.values)[1] for state in (fit.before, fit.after)]
    return LeftOut(name, rms[0], rms[1], True)


def _prior_spread(fit: RobotFit) -> Floats:
    return np.diag(np.where(fit.free, fit.prior, 0.0) ** 2)
