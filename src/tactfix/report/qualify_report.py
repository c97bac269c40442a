"""The result of qualify as JSON, and as lines for people."""

from collections.abc import Iterator
from typing import Final

from tactfix.qualification.result import QualifyResult
from tactfix.report.json_report import Json, document, picked
from tactfix.wording import borne

QUALIFY_SCHEMA: Final = "tactfix/qualify/1"


def qualify_json(result: QualifyResult) -> Json:
    """The JSON of qualify; lengths in the contact file's unit."""
    return document(
        QUALIFY_SCHEMA,
        **picked(result, "units", "touches", "places", "dof", "sigma", "sigma_interval", "range", "drift", "steps"),
        **picked(result, "outliers", "tip_radius", "tip_radius_sigma", "direction_frame", "directions", "warnings"),
    )


def qualify_lines(result: QualifyResult) -> Iterator[str]:
    """Name and values of each quantity, as lines."""
    low, high = result.sigma_interval
    yield f"sigma {result.sigma:.3g} {result.units}, 95 % between {low:.3g} and {high:.3g}"
    places = "one place" if result.places == 1 else f"{result.places} places"
    yield f"range {result.range:.3g} {result.units} in {result.touches} touches of {places}"
    if result.drift is not None:
        yield f"drift {result.drift.per_touch:.3g} {result.units} a touch, sigma {result.drift.sigma:.2g}"
    tip, sigma = result.tip_radius, result.tip_radius_sigma
    if tip is not None and sigma is not None:
        yield f"tip radius {borne(tip, sigma)} {result.units}, sigma {sigma:.2g}"
    for mean in result.directions:
        direction = " ".join(f"{value + 0.0:+.3f}" for value in mean.direction)
        shown = borne(mean.mean, mean.sigma, "+")
        yield f"direction {direction} {result.direction_frame}: mean {shown}, sigma {mean.sigma:.2g}"
