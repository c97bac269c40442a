"""Results as JSON, as samples/README.md describes it field by field. Unknown values are null, never NaN."""

import json
import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from tactfix.acceptance import point_covariance, sigma_at
from tactfix.formats import LOCATE_SCHEMA
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface
from tactfix.locate_result import LocateResult
from tactfix.results import POSE_UNKNOWNS, Diagnosis, NextContact
from tactfix.version import VERSION

if TYPE_CHECKING:
    from tactfix.fitting.fit import FitResult

Json: TypeAlias = dict[str, Any]

FIT_SCHEMA: Final = "tactfix/fit/1"


def text_of(report: Json) -> str:
    """A report as text: one line for each key, and for each element of a list of objects."""
    lines = [f"  {json.dumps(key)}: {_value(value)}" for key, value in report.items()]
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _value(value: Any) -> str:
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return "[\n" + ",\n".join(f"    {json.dumps(item, allow_nan=False)}" for item in value) + "\n  ]"
    return json.dumps(value, allow_nan=False)


def document(schema: str, **parts: Any) -> Json:
    """The JSON of a command: its schema, the version, and these parts."""
    return {"schema": schema, "tactfix_version": VERSION, **plain(parts)}


def plain(value: Any) -> Any:
    """A value as JSON: the fields of a dataclass by name, arrays as lists, null for numbers that are not finite."""
    if is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return float(value) + 0.0 if math.isfinite(value) else None
    return value


def picked(value: object, *names: str) -> Json:
    """These fields of a value, by name."""
    return {name: getattr(value, name) for name in names}


def locate_json(result: LocateResult, at: Floats | None = None) -> Json:
    """The JSON of locate, all in base coordinates and the fixture's units.

    at: a point (3,) of the fixture frame; adds "at": its coordinates in base, and its sigma.
    """
    more: Json = {}
    if result.unknowns != POSE_UNKNOWNS:
        more = picked(result, "unknowns", "joint_covariance", "tip")
    if at is not None:
        more["at"] = _at(result, at)
    return document(
        LOCATE_SCHEMA,
        **picked(result, "fixture", "units", "status"),
        transform=result.base_from_fixture,
        **picked(result, "covariance", "dof", "chi2", "chi2_limit", "rms"),
        candidates=[
            {"transform": one.base_from_fixture, **picked(one, "chi2", "rms", "accepted", "reasons")}
            for one in result.candidates
        ],
        features={name: surface_json(surface) for name, surface in result.surfaces.items()},
        **picked(result, "contacts", "free_motions"),
        next_contact=_next_contact(result.next_contact),
        without_prior=result.without_prior,
        diagnosis=[_diagnosis(cause) for cause in result.diagnosis],
        warnings=result.warnings,
        **more,
    )


def fit_json(result: "FitResult") -> Json:
    """The JSON of fit, in base coordinates and the contacts' unit."""
    return document(
        FIT_SCHEMA,
        **picked(result, "kind", "units", "status"),
        surface=None if result.surface is None else surface_json(result.surface),
        candidates=[
            {
                "surface": surface_json(one.surface),
                **picked(one, "chi2", "rms", "accepted", "poorly_determined", "reasons"),
            }
            for one in result.candidates
        ],
        **picked(result, "dof", "chi2", "chi2_limit", "rms", "residuals"),
        sigma={name: values[0] if name == "radius" else values for name, values in result.sigma.items()},
        warnings=result.warnings,
    )


def surface_json(surface: Surface) -> Json:
    """A surface by its type, place and size."""
    match surface:
        case Plane():
            return {"type": "plane", **picked(surface, "point", "normal")}
        case Sphere():
            return {"type": "sphere", **picked(surface, "center", "radius")}
        case Point():
            return {"type": "point", **picked(surface, "point")}
        case Cylinder():
            return {"type": "cylinder", **picked(surface, "point", "direction", "radius")}


def _at(result: LocateResult, point_fixture: Floats) -> Json:
    pose, covariance = result.base_from_fixture, result.covariance
    return {
        "point_fixture": point_fixture,
        "point": None if pose is None else pose[:3, :3] @ point_fixture + pose[:3, 3],
        "covariance": None if pose is None or covariance is None else point_covariance(pose, covariance, point_fixture),
        "worst_sigma": sigma_at(result, point_fixture),
    }


def _diagnosis(cause: Diagnosis) -> Json:
    entry = picked(cause, "code", "rows", "features", "value", "chi2", "message", "one_of")
    return {**entry, "causes": [_diagnosis(each) for each in cause.causes]} if cause.one_of else entry


def _next_contact(contact: NextContact | None) -> Json | None:
    if contact is None:
        return None
    entry = picked(contact, "feature", "point", "approach", "point_in_fixture", "approach_in_fixture", "message")
    return {**entry, "further": [_next_contact(each) for each in contact.further]} if contact.further else entry
