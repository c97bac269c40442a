"""The types of the JSON of calibrate and of calibrate --plan; see json_types."""

from typing import Literal, TypedDict

from tactfix.report.json_types import Covariance, Matrix, Number, Numbers


class ParameterJson(TypedDict):
    """A parameter of the robot: nominal and calibrated error, and its sigma; if not identified, it is near nominal."""

    name: str
    joint: str | None
    unit: str
    nominal: float
    value: Number
    sigma: Number
    identified: bool


class PlaceJson(TypedDict):
    """The pose in base of the fixture at a place; covariance is null if a motion of it is free."""

    transform: Matrix
    covariance: Covariance | None
    rms_before: Number
    rms_after: Number


class HeldOutJson(TypedDict):
    """The residuals at a place whose touches were not used in the fit of the robot."""

    place: str
    rms_before: Number
    rms_after: Number
    by: Literal["hold-out", "leaving out"]


class BeforeAfterJson(TypedDict):
    """rms sigma of the tip's position, with the prior (before) and with the touches (after)."""

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
    """The tip's centre in the frame that carries it, with the covariance of its position, and its radius."""

    flange: str
    transform: Matrix
    covariance: list[Numbers]
    radius: Number
    radius_sigma: Number


class FactorJson(TypedDict):
    """A factor on the prior, and the rms residual at the places left out with it."""

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
    """Sigma of a parameter with the prior, with the planned touches, and with the added ones too."""

    name: str
    unit: str
    prior: Number
    planned: Number
    with_added: Number
    identified: bool


class PlanStagesJson(TypedDict):
    """A sigma of the tip's position with the prior, with the planned touches, and with the added ones too."""

    prior: Number
    planned: Number
    with_added: Number


class UndeterminedStagesJson(TypedDict):
    """Share of the robot's errors, from 0 to 1, that stays undetermined: with planned touches, and with added ones."""

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
