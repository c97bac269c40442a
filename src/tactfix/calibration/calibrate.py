"""Robot calibration from touches: which parameters, how much of the prior, how sure, and what checks it.

start (places, tip) -> the estimate with the full prior -> the factor by places left out -> the estimate with it ->
outliers, covariance, prediction, and a status that says whether this robot may be written.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from tactfix.calibration import accuracy, robust_start, shrinkage
from tactfix.calibration.cell import Cell, Touches
from tactfix.calibration.equations import Group, distances, groups_of, place_pose
from tactfix.calibration.estimation import Eliminated, State, reduced
from tactfix.calibration.independence import Held, independent
from tactfix.calibration.result import (
    Calibration,
    CalibrationStatus,
    LeftOut,
    ParameterResult,
    PlaceResult,
    TipResult,
    TouchResidual,
    Workspace,
)
from tactfix.calibration.snooping import outliers
from tactfix.errors import UsageError
from tactfix.geometry.arrays import Bools, Floats
from tactfix.geometry.rigid import skew
from tactfix.noise import SUSPICIOUS, chi_square_limit
from tactfix.poses.prior import contradiction
from tactfix.values import frozen_value
from tactfix.wording import listed

GROSS_RESIDUAL: Final = 50.0
"""Times sigma, above which residuals after calibration are neither noise nor form: something else was touched."""


@frozen_value
class _Fit:
    """The work so far: free parameters, groups, the nominal robot, the estimate, and how noisy it is."""

    cell: Cell
    touches: Touches
    free: Bools
    held: tuple[Held, ...]
    prior: Floats
    groups: tuple[Group, ...]
    before: State
    after: State
    noise: float
    suspicious: tuple[int, ...]
    choice: shrinkage.Choice


def calibrate(cell: Cell, touches: Touches, hold_out: Sequence[str] = (), unchecked: bool = False) -> Calibration:
    """Calibrate the robot of a cell.

    hold_out: places that are kept out of all of it, and only located with the robots before and after. unchecked: let
    one place do, with the full prior. Raises UsageError for places that are not there or not touched.
    """
    _refuse(touches, hold_out)
    train = touches.at([name for name in touches.touched if name not in hold_out])
    fit = _fitted(cell, train, unchecked)
    parts = reduced(cell, fit.groups, fit.after)
    told = _certainty(fit, parts)
    spread = np.zeros((len(fit.free), len(fit.free)))
    spread[np.ix_(fit.free, fit.free)] = told.covariance
    places = _places(fit, parts, spread)
    status, reasons = _status(fit, told, places, unchecked)
    result = _result(fit, parts, told, places, spread, status, reasons)
    left = [LeftOut(name, *rms, False) for name, rms in fit.choice.left_out.items()]
    left += [_held_out(fit, touches.at([name]), name) for name in hold_out]
    warnings = (*_warnings(fit), *(reasons if unchecked else ()))
    return replace(result, left_out=tuple(left), outliers=fit.suspicious, warnings=warnings)


def _refuse(touches: Touches, hold_out: Sequence[str]) -> None:
    for name in hold_out:
        if name not in touches.touched:
            raise UsageError(f"no touch is at {name!r}; the places touched are {listed(touches.touched)}")
    if set(touches.touched) <= set(hold_out):
        raise UsageError("every place is held out; leave at least one to calibrate with")


def _fitted(cell: Cell, touches: Touches, unchecked: bool) -> _Fit:
    """Nominal robot, full prior, factor, estimate."""
    free, held = independent(cell, touches)
    prior = np.array([cell.prior.sigma(parameter) for parameter in cell.parameters])
    groups = groups_of(cell, touches)
    weights = np.divide(1.0, prior, out=np.zeros_like(prior), where=prior > 0)
    before = robust_start.nominal(cell, groups, weights, free, prior)
    full = robust_start.full(cell, groups, before, weights, free)
    suspicious, variance = outliers(groups, reduced(cell, groups, full), full.values, prior, free)
    noise = float(np.sqrt(max(1.0, variance)))
    full = shrinkage.shrunk(cell, groups, full, prior, free, noise, 1.0)
    before = shrinkage.shrunk(cell, groups, before, prior, free, noise, 0.0)
    if len(touches.touched) > 1:
        most = shrinkage.room(cell, groups, before, prior, free)
        choice = shrinkage.chosen_factor(cell, touches, full, prior, free, noise, most)
    else:
        choice = shrinkage.Choice(1.0 if unchecked else 0.0, {}, ())
    near = full if choice.factor > 0 else before
    after = shrinkage.shrunk(cell, groups, near, prior, free, noise, choice.factor)
    after = shrinkage.shrunk(cell, groups, after, prior, free, noise, choice.factor)
    return _Fit(cell, touches, free, held, prior, groups, before, after, noise, suspicious, choice)


def _certainty(fit: _Fit, parts: tuple[Eliminated, ...]) -> accuracy.Certainty:
    names = tuple(parameter.name for parameter in fit.cell.parameters)
    matrix = accuracy.information(parts, fit.free)
    chosen = tuple(name for name, free in zip(names, fit.free, strict=True) if free)
    return accuracy.certainty(matrix, fit.prior[fit.free], fit.choice.factor, fit.noise**2, chosen)


def _status(
    fit: _Fit, told: accuracy.Certainty, places: tuple[PlaceResult, ...], unchecked: bool
) -> tuple[CalibrationStatus, tuple[str, ...]]:
    """The status, and why it is not "calibrated"."""
    rows = sum(len(group.touches) for group in fit.groups)
    if fit.suspicious and fit.noise**2 * rows <= chi_square_limit(rows, SUSPICIOUS):
        named = listed([str(row) for row in fit.suspicious])
        return "inconsistent", (f"row {named}: no robot explains them beside all others; touch there anew",)
    reasons = [reason for place in places if (reason := _against_placement(fit.cell, place))]
    if fit.noise > GROSS_RESIDUAL:
        what = f"the residuals are {fit.noise:.0f} times sigma after calibration"
        reasons.append(f"{what}: check units, labels, the fixtures' files and the robot's model")
    if reasons:
        return "inconsistent", tuple(reasons)
    if len(fit.touches.touched) < 2:
        reasons.append("touches at one place cannot check a calibration: touch the fixture at another place too")
    elif fit.choice.factor == 0:
        reasons.append("no calibrated robot is better than the nominal one at the places left out")
    names = [parameter.name for parameter, free in zip(fit.cell.parameters, fit.free, strict=True) if free]
    unknown = [name for name, known in zip(names, told.identified, strict=True) if not known]
    asked = [name for name in unknown if name in fit.cell.unknown and "." in name]
    if asked:
        reasons.append(f"the touches do not tell {listed(asked)}, asked for by name")
    only_checked = unchecked and len(fit.touches.touched) < 2 and not asked
    return ("calibrated" if not reasons or only_checked else "underdetermined"), tuple(reasons)


def _result(
    fit: _Fit,
    parts: tuple[Eliminated, ...],
    told: accuracy.Certainty,
    places: tuple[PlaceResult, ...],
    spread: Floats,
    status: CalibrationStatus,
    reasons: tuple[str, ...],
) -> Calibration:
    matrix, prior = accuracy.information(parts, fit.free), fit.prior[fit.free]
    points, moves = accuracy.workspace_points(fit.cell, fit.touches, fit.after.values)
    workspace = Workspace(points, accuracy.tip_sigmas(moves, _prior_spread(fit)), accuracy.tip_sigmas(moves, spread))
    return Calibration(
        units=fit.cell.units,
        status=status,
        values=fit.after.values,
        covariance=spread,
        parameters=_parameters(fit, told),
        not_identified=(*(held.message for held in fit.held), *told.unknown),
        tip=_tip(fit, spread),
        places=places,
        left_out=(),
        shrinkage=fit.choice.factor,
        prediction=workspace.prediction,
        workspace=workspace,
        scores=fit.choice.scores,
        observability=accuracy.observability(matrix, prior, len(fit.touches)),
        touches=_touch_residuals(fit),
        outliers=(),
        reasons=reasons,
        warnings=(),
    )


def _parameters(fit: _Fit, told: accuracy.Certainty) -> tuple[ParameterResult, ...]:
    """Every parameter asked for, those held at nominal included, in the order of the chain."""
    sigmas = dict(zip(np.flatnonzero(fit.free).tolist(), np.sqrt(np.diag(told.covariance)).tolist(), strict=True))
    known = dict(zip(np.flatnonzero(fit.free).tolist(), told.identified.tolist(), strict=True))
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


def _places(fit: _Fit, parts: tuple[Eliminated, ...], spread: Floats) -> tuple[PlaceResult, ...]:
    rms = _rms_by_place(fit)
    by_root = {group.root: part for group, part in zip(fit.groups, parts, strict=True)}
    found = []
    for name in fit.touches.touched:
        pose = place_pose(fit.cell, fit.after.poses, name)
        part = by_root[fit.cell.root(name)[0]]
        found.append(PlaceResult(name, pose, _place_covariance(part, spread, fit.noise, pose), *rms[name]))
    return tuple(found)


@frozen_value
class _Standing:
    """A place as it was found; infinite variances where its touches leave motions free."""

    base_from_fixture: Floats
    covariance: Floats
    free_twists: Floats


def _against_placement(cell: Cell, place: PlaceResult) -> str | None:
    """What is known of a place beforehand, where it contradicts where the place was found."""
    placement = cell.places[place.name].placement
    if placement is None:
        return None
    covariance = np.full((6, 6), np.inf) if place.covariance is None else place.covariance
    found = contradiction(
        placement, _Standing(place.base_from_fixture, covariance, np.zeros((0, 6))), cell.units, fitted=True
    )
    remedy = "check its placement in the cell file, and that the touches are of this place"
    return (
        None if found is None else f"what is known of {place.name!r} contradicts the touches: {found.message}; {remedy}"
    )


def _place_covariance(part: Eliminated, spread: Floats, noise: float, pose: Floats) -> Floats | None:
    """Covariance (6, 6) of a pose about its origin, noise and robot together; None where a motion is free."""
    if not part.is_located:
        return None
    steps = part.block.motions @ part.steps
    by_robot = steps @ part.basis.T @ part.block.robot
    own = steps @ steps.T * noise**2 + by_robot @ spread @ by_robot.T
    shift = np.eye(6)
    shift[:3, :3] /= part.block.scale
    shift[3:, :3] = -skew(pose[:3, 3] - part.block.centre) / part.block.scale
    return np.asarray(shift @ own @ shift.T)


def _tip(fit: _Fit, spread: Floats) -> TipResult:
    """The tip in its flange: its errors are lengths along the axes of its own frame."""
    index = [fit.cell.chain.names().index(f"tip.{axis}") for axis in "xyz"]
    errors = np.eye(4)
    errors[:3, 3] = fit.after.values[index]
    flange_from_tip = fit.cell.flange_from_tip @ errors
    rotation = flange_from_tip[:3, :3]
    covariance = rotation @ spread[np.ix_(index, index)] @ rotation.T
    radius = fit.cell.tip_radius + float(fit.after.values[-1])
    return TipResult(fit.cell.flange, flange_from_tip, covariance, radius, float(np.sqrt(spread[-1, -1])))


def _touch_residuals(fit: _Fit) -> tuple[TouchResidual, ...]:
    before = distances(fit.cell, fit.groups, fit.before.poses, fit.before.values)
    after = distances(fit.cell, fit.groups, fit.after.poses, fit.after.values)
    touches = fit.touches
    return tuple(
        TouchResidual(row, place, feature, before[row], after[row])
        for row, place, feature in zip(touches.rows, touches.places, touches.features, strict=True)
    )


def _rms_by_place(fit: _Fit) -> dict[str, tuple[float, float]]:
    by_place: dict[str, list[tuple[float, float]]] = {name: [] for name in fit.touches.touched}
    for touch in _touch_residuals(fit):
        by_place[touch.place].append((touch.before, touch.after))
    found = {name: np.sqrt((np.array(pairs) ** 2).mean(axis=0)) for name, pairs in by_place.items()}
    return {name: (float(rms[0]), float(rms[1])) for name, rms in found.items()}


def _held_out(fit: _Fit, touches: Touches, name: str) -> LeftOut:
    (group,) = groups_of(fit.cell, touches)
    start = robust_start.placed(fit.cell, (group,), fit.after.values, np.sqrt(np.diag(_prior_spread(fit))))
    rms = [shrinkage.left_out(fit.cell, group, start, state.values)[1] for state in (fit.before, fit.after)]
    return LeftOut(name, rms[0], rms[1], True)


def _prior_spread(fit: _Fit) -> Floats:
    return np.diag(np.where(fit.free, fit.prior, 0.0) ** 2)


def _warnings(fit: _Fit) -> tuple[str, ...]:
    found = []
    if fit.noise > 1.5:
        what = f"the residuals are {fit.noise:.2g} times what sigma allows for"
        found.append(f"{what}: surfaces are not as the file says, or the robot bends; sigmas are scaled up by it")
    if fit.suspicious:
        named = listed([f"row {row}" for row in fit.suspicious[:10]])
        found.append(f"beyond noise: {named} (data snooping): touch there anew")
    if fit.choice.left_out and fit.choice.factor > 0:
        worse = [name for name, (before, after) in fit.choice.left_out.items() if after > 1.05 * before]
        if worse:
            found.append(f"left out, {listed(worse)} is worse with the calibrated robot than with the nominal one")
    return tuple(found)
