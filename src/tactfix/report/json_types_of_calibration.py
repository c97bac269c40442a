"""The types of the JSON of calibrate and of calibrate --plan; see json_types."""

from typing import Literal, TypedDict

from tactfix.report.json_types import Covariance, Matrix, Number, Numbers


class ParameterJson(TypedDict):
    """A parameter of the robot: error of the nominal robot and its sigma; not identified: held as it was."""

    name: str
    joint: str | None
    unit: str
    nominal: float
    value: Number
    sigma: Number
    identified: bool


class PlaceJson(TypedDict):
    """Where the fixture at a place stands in base; covariance null where a motion of it is free."""

    transform: Matrix
    covariance: Covariance | None
    rms_before: Number
    rms_after: Number


class HeldOutJson(TypedDict):
    """The residuals at a place that the robot was not fitted to."""

    place: str
    rms_before: Number
    rms_after: Number
    by: Literal["hold-out", "leaving out"]


class BeforeAfterJson(TypedDict):
    """rms sigma of the tip's place, with the prior and with the touches."""

    before: Number
    after: Number


class TouchJson(TypedDict):
    """The residual of a touch with the nominal and with the calibrated robot."""

    row: int
    place: str
    feature: str
    before: Number
    after: Number


class CalibratedTipJson(TypedDict):
    """The tip's centre in the frame that carries it, with the covariance of its place, and its radius."""

    flange: str
    transform: Matrix
    covariance: list[Numbers]
    radius: Number
    radius_sigma: Number


class FactorJson(TypedDict):
    """The rms residual at the places left out, with so much of the prior believed."""

    factor: float
    rms: Number


class CalibrateJson(TypedDict):
    """The JSON of calibrate, in the cell's units; angles of parameters in degrees."""

    schema: Literal["tactfix/calibrate/1"]
    tactfix_version: str
    units: str
    status: Literal["calibrated", "underdetermined", "inconsistent"]
    reasons: list[str]
    parameters: list[ParameterJson]
    not_identified: list[str]
    tip: CalibratedTipJson
    places: dict[str, PlaceJson]
    held_out: list[HeldOutJson]
    shrinkage: float
    factors: list[FactorJson]
    prediction: BeforeAfterJson
    undetermined: Number
    observability: dict[str, Number]
    outliers: list[int]
    touches: list[TouchJson]
    warnings: list[str]


class AddedTouchJson(TypedDict):
    """A touch to add: joints in degrees, lengths of prismatic ones in the cell's units."""

    place: str
    feature: str
    joints: list[float]


class PlannedParameterJson(TypedDict):
    """Sigma of a parameter by the prior, after the touches planned, and with those added."""

    name: str
    unit: str
    prior: Number
    planned: Number
    with_added: Number
    identified: bool


class PlanStagesJson(TypedDict):
    """A sigma of the tip's place by the prior, after the touches planned, and with those added."""

    prior: Number
    planned: Number
    with_added: Number


class UndeterminedStagesJson(TypedDict):
    """What touches leave of the robot's errors, from 0 to 1: the touches planned, and with those added."""

    planned: Number
    with_added: Number


class CalibratePlanJson(TypedDict):
    """The JSON of calibrate --plan, in the cell's units; angles in degrees."""

    schema: Literal["tactfix/calibrate-plan/1"]
    tactfix_version: str
    units: str
    planned: int
    added: list[AddedTouchJson]
    parameters: list[PlannedParameterJson]
    not_identified: list[str]
    prediction: PlanStagesJson
    worst: PlanStagesJson
    undetermined: UndeterminedStagesJson
    observability: dict[str, Number]
    unplaced: list[str]
    out_of_reach: list[str]
