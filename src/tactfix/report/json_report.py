"""Results as JSON, as samples/README.md describes it field by field. What does not exist is null, never NaN."""

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from tactfix.acceptance import point_covariance, sigma_at
from tactfix.formats import LOCATE_SCHEMA
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface
from tactfix.locate_result import LocateResult
from tactfix.results import POSE_UNKNOWNS, Candidate, Diagnosis, NextContact, Reason, TipEstimate
from tactfix.version import VERSION

if TYPE_CHECKING:
    from tactfix.fitting.fit import FitCandidate, FitResult

Json: TypeAlias = dict[str, Any]

FIT_SCHEMA: Final = "tactfix/fit/1"


def text_of(report: Json) -> str:
    """A report as text: one key a line, and one line for each element of a list of objects."""
    lines = [f"  {json.dumps(key)}: {_value(value)}" for key, value in report.items()]
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _value(value: Any) -> str:
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return "[\n" + ",\n".join(f"    {json.dumps(item, allow_nan=False)}" for item in value) + "\n  ]"
    return json.dumps(value, allow_nan=False)


def locate_json(result: LocateResult, at: Floats | None = None) -> Json:
    """The JSON of locate, all in base coordinates and the fixture's units.

    at: a point (3,) of the fixture frame; with it the JSON says "at": where it is in base, and its sigma.
    """
    report = _locate_json(result)
    if result.unknowns != POSE_UNKNOWNS:
        report["unknowns"] = list(result.unknowns)
        report["joint_covariance"] = array(result.joint_covariance)
        report["tip"] = None if result.tip is None else _tip(result.tip)
    if at is not None:
        report["at"] = _at(result, at)
    return report


def _locate_json(result: LocateResult) -> Json:
    return {
        "schema": LOCATE_SCHEMA,
        "tactfix_version": VERSION,
        "fixture": result.fixture,
        "units": result.units,
        "status": result.status,
        "transform": array(result.base_from_fixture),
        "covariance": array(result.covariance),
        "dof": result.dof,
        "chi2": number(result.chi2),
        "chi2_limit": number(result.chi2_limit),
        "rms": number(result.rms),
        "candidates": [_candidate(candidate) for candidate in result.candidates],
        "features": {name: surface_json(surface) for name, surface in result.surfaces.items()},
        "contacts": [
            {
                "row": contact.row,
                "feature": contact.feature,
                "residual": number(contact.residual),
                "approach_angle_deg": number(contact.approach_angle_deg),
            }
            for contact in result.contacts
        ],
        "free_motions": [
            {"rotation": array(motion.rotation), "translation": array(motion.translation), "message": motion.message}
            for motion in result.free_motions
        ],
        "next_contact": _next_contact(result.next_contact),
        "without_prior": None if result.without_prior is None else asdict(result.without_prior),
        "diagnosis": [_diagnosis(cause) for cause in result.diagnosis],
        "warnings": list(result.warnings),
    }


def fit_json(result: "FitResult") -> Json:
    """The JSON of fit, in base coordinates and the contacts' unit."""
    return {
        "schema": FIT_SCHEMA,
        "tactfix_version": VERSION,
        "kind": result.kind,
        "units": result.units,
        "status": result.status,
        "surface": None if result.surface is None else surface_json(result.surface),
        "candidates": [_fit_candidate(candidate) for candidate in result.candidates],
        "dof": result.dof,
        "chi2": number(result.chi2),
        "chi2_limit": number(result.chi2_limit),
        "rms": number(result.rms),
        "residuals": array(result.residuals),
        "sigma": sigma_json(result.sigma),
        "warnings": list(result.warnings),
    }


def surface_json(surface: Surface) -> Json:
    """A surface by its type, place and size."""
    match surface:
        case Plane():
            return {"type": "plane", "point": array(surface.point), "normal": array(surface.normal)}
        case Sphere():
            return {"type": "sphere", "center": array(surface.center), "radius": number(surface.radius)}
        case Point():
            return {"type": "point", "point": array(surface.point)}
        case Cylinder():
            place = {"point": array(surface.point), "direction": array(surface.direction)}
            return {"type": "cylinder", **place, "radius": number(surface.radius)}


def sigma_json(sigma: Mapping[str, Floats]) -> Json:
    """One standard deviation of each number of a surface, under the names that the surface has."""
    return {name: number(values[0]) if name == "radius" else array(values) for name, values in sigma.items()}


def number(value: float | None) -> float | None:
    """A finite number without the sign of zero, or None."""
    return float(value) + 0.0 if value is not None and math.isfinite(value) else None


def array(values: Floats | None) -> list[Any] | None:
    """An array as lists of numbers, None for what is not finite."""
    if values is None:
        return None
    if np.isfinite(values).all():
        return list((np.asarray(values) + 0.0).tolist())
    return [array(row) if np.ndim(row) else number(row) for row in values]


def _candidate(candidate: Candidate) -> Json:
    return {
        "transform": array(candidate.base_from_fixture),
        "chi2": number(candidate.chi2),
        "rms": number(candidate.rms),
        "accepted": candidate.accepted,
        "reasons": _reasons(candidate.reasons),
    }


def _fit_candidate(candidate: "FitCandidate") -> Json:
    return {
        "surface": surface_json(candidate.surface),
        "chi2": number(candidate.chi2),
        "rms": number(candidate.rms),
        "accepted": candidate.accepted,
        "poorly_determined": candidate.poorly_determined,
        "reasons": _reasons(candidate.reasons),
    }


def _reasons(reasons: Iterable[Reason]) -> list[Json]:
    return [
        {"code": reason.code, "feature": reason.feature, "row": reason.row, "message": reason.message}
        for reason in reasons
    ]


def _at(result: LocateResult, point_fixture: Floats) -> Json:
    pose, covariance = result.base_from_fixture, result.covariance
    spread = None if pose is None or covariance is None else point_covariance(pose, covariance, point_fixture)
    return {
        "point_fixture": array(point_fixture),
        "point": None if pose is None else array(pose[:3, :3] @ point_fixture + pose[:3, 3]),
        "covariance": array(spread),
        "worst_sigma": number(sigma_at(result, point_fixture)),
    }


def _tip(tip: TipEstimate) -> Json:
    return {
        "offset": array(tip.offset),
        "radius": number(tip.radius),
        "covariance": array(tip.covariance),
        "message": tip.message,
    }


def _diagnosis(cause: Diagnosis) -> Json:
    told: Json = {
        "code": cause.code,
        "rows": list(cause.rows),
        "features": list(cause.features),
        "value": list(cause.value) if isinstance(cause.value, tuple) else number(cause.value),
        "chi2": number(cause.chi2),
        "message": cause.message,
        "one_of": cause.one_of,
    }
    return {**told, "causes": [_diagnosis(each) for each in cause.causes]} if cause.one_of else told


def _next_contact(contact: NextContact | None) -> Json | None:
    if contact is None:
        return None
    told: Json = {
        "feature": contact.feature,
        "point": array(contact.point),
        "approach": array(contact.approach),
        "point_in_fixture": array(contact.point_in_fixture),
        "approach_in_fixture": array(contact.approach_in_fixture),
        "message": contact.message,
    }
    return {**told, "further": [_next_contact(each) for each in contact.further]} if contact.further else told
