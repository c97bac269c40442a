"""The output of calibrate and calibrate --plan: a summary sentence, the JSON, touches to add as a touch file."""

import csv
import io
from collections.abc import Iterator
from typing import Final

import numpy as np

from tactfix.calibration.accuracy import IDENTIFIED
from tactfix.calibration.result import Calibration
from tactfix.calibration.touch_plan import EXPECTED_ERRORS, TouchPlan
from tactfix.report.json_report import Json, document, picked
from tactfix.wording import listed, spreadsheet_cell

_DIGITS: Final = 4
"""Decimals of a degree: 1e-4 deg is 2 um at a metre, less than the repeatability of any robot."""


def calibration_sentence(result: Calibration) -> str:
    """The answer in one sentence: the sigma of the tip's place over the joint ranges, after and before."""
    if result.status == "inconsistent":
        return "inconsistent; no calibrated robot explains the touches"
    before, after = result.prediction
    accuracy = f"known to {after:.2g} {result.units} (rms sigma over the joint ranges; {before:.2g} before)"
    return f"{result.status}; the robot's parameters leave the place of its tip {accuracy}"


def calibration_json(result: Calibration) -> Json:
    """The JSON of a calibration, in base and the cell's units; angles of parameters in degrees."""
    before, after = result.prediction
    return document(
        "tactfix/calibrate/1",
        **picked(result, "units", "status", "reasons", "parameters", "not_identified"),
        tip={
            "flange": result.tip.flange,
            "transform": result.tip.flange_from_tip,
            **picked(result.tip, "covariance", "radius", "radius_sigma"),
        },
        places={
            place.name: {
                "transform": place.base_from_fixture,
                **picked(place, "covariance", "rms_before", "rms_after"),
            }
            for place in result.places
        },
        held_out=[
            {
                **picked(item, "place", "rms_before", "rms_after"),
                "by": "hold-out" if item.held_out else "leaving out",
            }
            for item in result.left_out
        ],
        shrinkage=result.shrinkage,
        factors=result.scores,
        prediction={"before": before, "after": after},
        **picked(result, "undetermined", "observability", "outliers", "touches", "warnings"),
    )


def plan_csv(plan: TouchPlan) -> str:
    """The touches to add as a touch file: joints in degrees, prismatic joints in the cell's units."""
    text = io.StringIO()
    text.write(f"# units: {plan.units}\n# joints: deg\n")
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(["place", "feature", *(f"q{k + 1}" for k in range(len(plan.joints)))])
    for place, feature, joints in zip(plan.added.places, plan.added.features, _joints(plan), strict=True):
        rows.writerow([spreadsheet_cell(place), spreadsheet_cell(feature), *joints])
    return text.getvalue()


def _joints(plan: TouchPlan) -> list[list[float]]:
    scale = np.where(plan.joints, 1.0, np.rad2deg(1.0))
    return [[round(value, _DIGITS) for value in row] for row in (plan.added.joints * scale).tolist()]


def touch_plan_json(plan: TouchPlan) -> Json:
    """The JSON of calibrate --plan, in the cell's units; angles in degrees."""
    stages = ("prior", "planned", "with_added")
    return document(
        "tactfix/calibrate-plan/1",
        **picked(plan, "units", "planned"),
        added=[
            {"place": place, "feature": feature, "joints": joints}
            for place, feature, joints in zip(plan.added.places, plan.added.features, _joints(plan), strict=True)
        ],
        **picked(plan, "parameters", "not_identified"),
        prediction=dict(zip(stages, plan.prediction, strict=True)),
        worst=dict(zip(stages, plan.worst, strict=True)),
        undetermined=dict(zip(stages[1:], plan.undetermined, strict=True)),
        **picked(plan, "observability", "unplaced", "out_of_reach"),
    )


def touch_plan_lines(plan: TouchPlan) -> Iterator[str]:
    """The summary of a plan, one sentence per line."""
    before, planned, after = (f"{value:.3g} {plan.units}" for value in plan.prediction)
    yield f"the tip's place over the joint ranges is known to {before} (rms) of the nominal robot"
    if plan.planned:
        yield f"{plan.planned} touches planned: {planned}"
    if len(plan.added):
        yield f"with {len(plan.added)} added: {after}, {plan.worst[2]:.3g} {plan.units} where it is worst"
    yield _left(plan)
    identified = [item.name for item in plan.parameters if item.identified]
    yield f"{len(identified)} of {len(plan.parameters)} parameters determined to less than half of their prior"
    for words in plan.not_identified:
        if "held at" not in words:
            yield f"not known: {words}"
    if plan.unplaced:
        yield f"none is added at {listed(plan.unplaced)}: write placement: {{near: ...}} or plan touches there"
    if plan.out_of_reach:
        yield f"no posture found that reaches {listed(plan.out_of_reach)}"


def _left(plan: TouchPlan) -> str:
    """The share of the robot's errors left undetermined, and whether calibrate would reject it."""
    planned, after = (f"{100 * share:.0f} per cent" for share in plan.undetermined)
    stages = [f"planned leave {planned}"] if plan.planned else []
    stages += [f"added {after}" if stages else f"added leave {after}"] if len(plan.added) else []
    limit = f"calibrate writes no robot at {100 * IDENTIFIED:.0f} or more"
    remedy = "; plan other features or places, or reduce the unknown parameters"
    size = f"if they are {100 * EXPECTED_ERRORS:.0f} per cent of the prior"
    message = f"the touches {', with those '.join(stages)} of the robot's errors undetermined, {size}"
    return f"{message}; {limit}{remedy if plan.undetermined[1] >= IDENTIFIED else ''}"
