"""The JSON of calibrate."""

from typing import Final

from tactfix.calibration.result import Calibration
from tactfix.report.json_report import Json, array, number
from tactfix.version import VERSION

CALIBRATE_SCHEMA: Final = "tactfix/calibrate/1"


def calibration_sentence(result: Calibration) -> str:
    """The answer in one sentence: the sigma of the tip's place over the joint ranges, after and before."""
    if result.status == "inconsistent":
        return "inconsistent; no calibrated robot explains the touches"
    before, after = result.prediction
    sure = f"known to {after:.2g} {result.units} (rms sigma over the joint ranges; {before:.2g} before)"
    return f"{result.status}; the robot's parameters leave the place of its tip {sure}"


def calibration_json(result: Calibration) -> Json:
    """Everything that a calibration says, in base and the cell's units; angles of parameters in degrees."""
    return {
        "schema": CALIBRATE_SCHEMA,
        "tactfix_version": VERSION,
        "units": result.units,
        "status": result.status,
        "reasons": list(result.reasons),
        "parameters": [
            {
                "name": item.name,
                "joint": item.joint,
                "unit": item.unit,
                "nominal": item.nominal,
                "value": number(item.value),
                "sigma": number(item.sigma),
                "identified": item.identified,
            }
            for item in result.parameters
        ],
        "not_identified": list(result.not_identified),
        "tip": {
            "flange": result.tip.flange,
            "transform": array(result.tip.flange_from_tip),
            "covariance": array(result.tip.covariance),
            "radius": number(result.tip.radius),
            "radius_sigma": number(result.tip.radius_sigma),
        },
        "places": {
            place.name: {
                "transform": array(place.base_from_fixture),
                "covariance": array(place.covariance),
                "rms_before": number(place.rms_before),
                "rms_after": number(place.rms_after),
            }
            for place in result.places
        },
        "held_out": [
            {
                "place": item.place,
                "rms_before": number(item.rms_before),
                "rms_after": number(item.rms_after),
                "by": "hold-out" if item.held_out else "leaving out",
            }
            for item in result.left_out
        ],
        "shrinkage": result.shrinkage,
        "factors": [{"factor": score.factor, "rms": number(score.rms)} for score in result.scores],
        "prediction": {"before": number(result.prediction[0]), "after": number(result.prediction[1])},
        "undetermined": number(result.undetermined),
        "observability": {name: number(value) for name, value in result.observability.items()},
        "outliers": list(result.outliers),
        "touches": [
            {
                "row": item.row,
                "place": item.place,
                "feature": item.feature,
                "before": number(item.before),
                "after": number(item.after),
            }
            for item in result.touches
        ],
        "warnings": list(result.warnings),
    }
