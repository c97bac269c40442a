"""Reads results back from the JSON of locate, fit and qualify; the JSON of other commands is not complete."""

import json
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from tactfix.errors import UsageError
from tactfix.fitting.result import FitCandidate, FitResult
from tactfix.formats import LOCATE_SCHEMA
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Cylinder, Plane, Point, SidedSurface, Sphere, Surface
from tactfix.locate_result import LocateResult
from tactfix.qualification.result import DirectionMean, Drift, QualifyResult, Step
from tactfix.report.json_report import FIT_SCHEMA, Json
from tactfix.report.qualify_report import QUALIFY_SCHEMA
from tactfix.results import (
    POSE_UNKNOWNS,
    Candidate,
    ContactResidual,
    Diagnosis,
    FreeMotion,
    NextContact,
    Reason,
    TipEstimate,
    WithoutPrior,
)

T = TypeVar("T")

_RESULT_REMEDY = "write it with result.to_json()"


def locate_result(text: str | bytes) -> LocateResult:
    """The result of locate from its JSON text; raises UsageError as `_read` does."""
    return _read(text, LOCATE_SCHEMA, _located)


def fit_result(text: str | bytes) -> FitResult:
    """The result of fit from its JSON text; raises UsageError as `_read` does."""
    return _read(text, FIT_SCHEMA, _fitted)


def qualify_result(text: str | bytes) -> QualifyResult:
    """The result of qualify from its JSON text; raises UsageError as `_read` does."""
    return _read(text, QUALIFY_SCHEMA, _qualified)


def _read(text: str | bytes, schema: str, result: Callable[[Json], T]) -> T:
    """The result from a JSON text of this schema.

    Raises UsageError for invalid JSON, another schema, or missing parts.
    """
    try:
        report = json.loads(text)
    except ValueError as error:
        raise UsageError(f"this is no JSON ({error}); {_RESULT_REMEDY}") from None
    if not isinstance(report, dict) or report.get("schema") != schema:
        raise UsageError(f"this is no JSON of the schema {schema}; {_RESULT_REMEDY}")
    try:
        return result(report)
    except (KeyError, TypeError, ValueError) as error:
        raise UsageError(f"this JSON is not whole: {error!r}; {_RESULT_REMEDY}") from None


def _fitted(report: Json) -> FitResult:
    return FitResult(
        kind=report["kind"],
        status=report["status"],
        dof=report["dof"],
        surface=None if report["surface"] is None else _sided(report["surface"]),
        candidates=tuple(_fit_candidate(one) for one in report["candidates"]),
        chi2=report["chi2"],
        chi2_limit=report["chi2_limit"],
        rms=report["rms"],
        residuals=np.asarray(report["residuals"], dtype=np.float64),
        sigma={name: np.atleast_1d(np.asarray(each, np.float64)) for name, each in report["sigma"].items()},
        warnings=tuple(report["warnings"]),
        units=report["units"],
    )


def _fit_candidate(one: Json) -> FitCandidate:
    reasons = tuple(Reason(**reason) for reason in one["reasons"])
    return FitCandidate(_sided(one["surface"]), one["chi2"], one["rms"], one["poorly_determined"], reasons)


def _sided(one: Json) -> SidedSurface:
    surface = _surface(one)
    if isinstance(surface, Point):
        raise ValueError("a point is no surface that is fitted")
    return surface


def _qualified(report: Json) -> QualifyResult:
    low, high = report["sigma_interval"]
    return QualifyResult(
        units=report["units"],
        touches=report["touches"],
        places=report["places"],
        dof=report["dof"],
        sigma=report["sigma"],
        sigma_interval=(low, high),
        range=report["range"],
        drift=None if report["drift"] is None else Drift(**report["drift"]),
        steps=tuple(Step(**step) for step in report["steps"]),
        outliers=tuple(report["outliers"]),
        tip_radius=report["tip_radius"],
        tip_radius_sigma=report["tip_radius_sigma"],
        directions=tuple(
            DirectionMean(**{**mean, "direction": _array(mean["direction"], (3,))}) for mean in report["directions"]
        ),
        direction_frame=report["direction_frame"],
        warnings=tuple(report["warnings"]),
    )


def _located(report: Json) -> LocateResult:
    return LocateResult(
        fixture=report["fixture"],
        units=report["units"],
        status=report["status"],
        base_from_fixture=_optional(report["transform"], (4, 4)),
        covariance=_optional(report["covariance"], (6, 6)),
        dof=report["dof"],
        chi2=report["chi2"],
        chi2_limit=report.get("chi2_limit"),
        rms=report["rms"],
        candidates=tuple(_candidate(one) for one in report["candidates"]),
        surfaces={name: _surface(one) for name, one in report["features"].items()},
        contacts=tuple(ContactResidual(**one) for one in report["contacts"]),
        free_motions=tuple(_free_motion(one) for one in report["free_motions"]),
        next_contact=_next_contact(report["next_contact"]),
        warnings=tuple(report["warnings"]),
        diagnosis=tuple(_diagnosis(one) for one in report.get("diagnosis", ())),
        unknowns=tuple(report.get("unknowns", POSE_UNKNOWNS)),
        joint_covariance=_optional(report.get("joint_covariance"), (len(report.get("unknowns", POSE_UNKNOWNS)),) * 2),
        tip=_tip(report.get("tip")),
        without_prior=WithoutPrior(**without) if (without := report.get("without_prior")) else None,
    )


def _tip(one: Json | None) -> TipEstimate | None:
    if one is None:
        return None
    covariance = np.asarray(one["covariance"], dtype=np.float64)
    return TipEstimate(_optional(one["offset"], (3,)), one["radius"], covariance, one["message"])


def _optional(values: Any, shape: tuple[int, ...]) -> Floats | None:
    return None if values is None else _array(values, shape)


def _array(values: Any, shape: tuple[int, ...]) -> Floats:
    array = np.asarray(values, dtype=np.float64)
    if array.shape != shape:
        raise ValueError(f"an array has the shape {array.shape} instead of {shape}")
    return array


def _candidate(one: Json) -> Candidate:
    reasons = tuple(Reason(**reason) for reason in one["reasons"])
    return Candidate(_array(one["transform"], (4, 4)), {}, one["chi2"], one["rms"], reasons)


def _surface(one: Json) -> Surface:
    match one["type"]:
        case "plane":
            return Plane(_array(one["point"], (3,)), _array(one["normal"], (3,)))
        case "sphere":
            return Sphere(_array(one["center"], (3,)), one["radius"])
        case "cylinder":
            return Cylinder(_array(one["point"], (3,)), _array(one["direction"], (3,)), one["radius"])
        case "point":
            return Point(_array(one["point"], (3,)))
        case other:
            raise ValueError(f"no surface is a {other!r}")


def _free_motion(one: Json) -> FreeMotion:
    return FreeMotion(_array(one["rotation"], (3,)), _array(one["translation"], (3,)), one["message"])


def _diagnosis(one: Json) -> Diagnosis:
    return Diagnosis(
        one["code"],
        tuple(one["rows"]),
        tuple(one["features"]),
        tuple(one["value"]) if isinstance(one["value"], list) else one["value"],
        one["chi2"],
        one["message"],
        one["one_of"],
        tuple(_diagnosis(cause) for cause in one.get("causes", ())),
    )


def _next_contact(one: Json | None) -> NextContact | None:
    if one is None:
        return None
    return NextContact(
        one["feature"],
        _optional(one["point"], (3,)),
        _optional(one["approach"], (3,)),
        one["message"],
        _optional(one.get("point_in_fixture"), (3,)),
        _optional(one.get("approach_in_fixture"), (3,)),
        tuple(contact for each in one.get("further", ()) if (contact := _next_contact(each)) is not None),
    )
