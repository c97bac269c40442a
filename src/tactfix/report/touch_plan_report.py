"""What calibrate --plan prints: the touches to add as a touch file, its JSON, and a summary for people."""

import csv
import io
from collections.abc import Iterator
from typing import IO, Final

import numpy as np
from rich.console import Console
from rich.table import Table

from tactfix.calibration.accuracy import IDENTIFIED
from tactfix.calibration.touch_plan import EXPECTED_ERRORS, TouchPlan
from tactfix.report.json_report import Json, number
from tactfix.version import VERSION
from tactfix.wording import listed, spreadsheet_cell

CALIBRATE_PLAN_SCHEMA: Final = "tactfix/calibrate-plan/1"
_DIGITS: Final = 4
"""Of a degree: a ten thousandth is 2 um at a metre, less than any robot repeats."""


def plan_csv(plan: TouchPlan) -> str:
    """The touches to add as a touch file: joints in degrees, lengths of prismatic ones in the cell's units."""
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
    return {
        "schema": CALIBRATE_PLAN_SCHEMA,
        "tactfix_version": VERSION,
        "units": plan.units,
        "planned": plan.planned,
        "added": [
            {"place": place, "feature": feature, "joints": joints}
            for place, feature, joints in zip(plan.added.places, plan.added.features, _joints(plan), strict=True)
        ],
        "parameters": [
            {
                "name": item.name,
                "unit": item.unit,
                "prior": number(item.prior),
                "planned": number(item.planned),
                "with_added": number(item.with_added),
                "identified": item.identified,
            }
            for item in plan.parameters
        ],
        "not_identified": list(plan.not_identified),
        "prediction": dict(zip(stages, map(number, plan.prediction), strict=True)),
        "worst": dict(zip(stages, map(number, plan.worst), strict=True)),
        "undetermined": dict(zip(stages[1:], map(number, plan.undetermined), strict=True)),
        "observability": {name: number(value) for name, value in plan.observability.items()},
        "unplaced": list(plan.unplaced),
        "out_of_reach": list(plan.out_of_reach),
    }


def touch_plan_lines(plan: TouchPlan) -> Iterator[str]:
    """What there is to say of a plan, a sentence a line."""
    before, planned, after = (f"{value:.3g} {plan.units}" for value in plan.prediction)
    yield f"the tip's place over the joint ranges is known to {before} (rms) of the nominal robot"
    if plan.planned:
        yield f"{plan.planned} touches planned: {planned}"
    if len(plan.added):
        yield f"with {len(plan.added)} added: {after}, {plan.worst[2]:.3g} {plan.units} where it is worst"
    yield _left(plan)
    told = [item.name for item in plan.parameters if item.identified]
    yield f"{len(told)} of {len(plan.parameters)} parameters told to less than half of their prior"
    for words in plan.not_identified:
        if "held at" not in words:
            yield f"not known: {words}"
    if plan.unplaced:
        yield f"none is added at {listed(plan.unplaced)}: write placement: {{near: ...}} or plan touches there"
    if plan.out_of_reach:
        yield f"no posture found that reaches {listed(plan.out_of_reach)}"


def _left(plan: TouchPlan) -> str:
    """What would be left of the robot's errors, and whether calibrate would refuse that."""
    planned, after = (f"{100 * share:.0f} per cent" for share in plan.undetermined)
    stages = [f"planned leave {planned}"] if plan.planned else []
    stages += [f"added {after}" if stages else f"added leave {after}"] if len(plan.added) else []
    limit = f"calibrate writes no robot at {100 * IDENTIFIED:.0f} or more"
    remedy = "; plan other features or places, or let fewer parameters be unknown"
    size = f"if they are {100 * EXPECTED_ERRORS:.0f} per cent of the prior"
    what = f"the touches {', with those '.join(stages)} of the robot's errors undetermined, {size}"
    return f"{what}; {limit}{remedy if plan.undetermined[1] >= IDENTIFIED else ''}"


def print_touch_plan(plan: TouchPlan, file: IO[str]) -> None:
    """The sigma of each parameter: by the prior, after the touches planned, and with those added."""
    table = Table("parameter", "prior", "planned", "with added", "unit", "", box=None, header_style="dim")
    for item in plan.parameters:
        sigmas = (f"{value:.3g}" for value in (item.prior, item.planned, item.with_added))
        table.add_row(item.name, *sigmas, item.unit, "" if item.identified else "hardly told")
    Console(file=file, highlight=False).print(table)
