"""What the JSON of the other commands holds; see json_types."""

from typing import Annotated, Literal, TypedDict

from tactfix.mistakes import FaultKind
from tactfix.report.json_types import Covariance, LocateJson, Matrix, Number, Numbers, Vector


class MovedJson(TypedDict):
    """A motion in the axes of one frame."""

    translation: Vector
    rotation_deg: Vector


class CompareJson(TypedDict):
    """The JSON of compare. chance: how probable so much or more is of a fixture that stood still."""

    schema: Literal["tactfix/compare/1"]
    tactfix_version: str
    units: str | None
    status: Literal["ok", "exceeded"]
    distance: Number
    distance_sigma: Number
    angle_deg: Number
    angle_sigma_deg: Number
    base: MovedJson
    fixture: MovedJson
    covariance: Covariance | None
    chance: Number
    limit_translation: Number
    limit_rotation_deg: Number


class MovedPointJson(TypedDict):
    """The point of the fixture frame that moved farthest."""

    point: Vector
    displacement: Number
    sigma: Number


class DriftJson(TypedDict):
    """The drift over the history, a check."""

    checks: int
    detected: bool
    chance: Number
    translation_per_check: Vector
    rotation_per_check_deg: Vector
    covariance: list[list[float | None]] | None


class CheckJson(TypedDict):
    """The JSON of check; base and fixture: how it moved in the axes of each. locate: today's contacts."""

    schema: Literal["tactfix/check/1"]
    tactfix_version: str
    units: str
    status: Literal["moved", "not_moved", "underdetermined", "ambiguous", "inconsistent"]
    verdict: str
    distance: Number
    distance_sigma: Number
    angle_deg: Number
    angle_sigma_deg: Number
    base: MovedJson | None
    fixture: MovedJson | None
    covariance: Covariance | None
    chance: Number
    limit_translation: Number
    limit_rotation_deg: Number
    bound_95: Number
    worst_point: MovedPointJson | None
    drift: DriftJson | None
    locate: LocateJson
    warnings: list[str]


class ToolContactJson(TypedDict):
    """A contact of a simulation."""

    row: int
    feature: str
    point: Vector
    approach: Vector | None
    sigma: float


class PlannedContactJson(ToolContactJson):
    """A contact of a plan; in base too where it is known where the fixture stands."""

    point_in_base: Vector | None
    approach_in_base: Vector | None
    flange_in_fixture: list[Vector] | None


class StepJson(TypedDict):
    """How sure the pose is after so many contacts of a plan."""

    contacts: int
    worst_sigma: Number
    gain: Number
    unique: bool | None


class PlanJson(TypedDict):
    """The JSON of plan: contacts in the frame that frame names; transform: where the fixture stands, in base."""

    schema: Literal["tactfix/plan/1"]
    tactfix_version: str
    fixture: str
    units: str
    frame: Literal["fixture", "base"]
    transform: Matrix | None
    criterion: str
    unique: bool | None
    located: bool
    rivals: int
    starts: int
    agreeing: int
    worst_sigma: Number
    worst_point: Vector | None
    covariance: Covariance | None
    tip_radius: float
    tip_sigma: Number
    contacts: list[PlannedContactJson]
    steps: list[StepJson]


class SimulateJson(TypedDict):
    """The JSON of simulate: contacts in base, and the truth. mistake: what the fault did, in words."""

    schema: Literal["tactfix/simulate/1"]
    tactfix_version: str
    fixture: str
    units: str
    transform: Matrix
    seed: int
    fault: FaultKind | None
    mistake: str | None
    tip_radius: float
    contacts: list[ToolContactJson]


class ProbeDriftJson(TypedDict):
    """A straight line through the touches in their order."""

    per_touch: Number
    sigma: Number


class ProbeStepJson(TypedDict):
    """From this row on the touches are off by size."""

    row: int
    size: Number


class DirectionJson(TypedDict):
    """The mean residual of the touches that came from about one direction."""

    direction: Vector
    touches: int
    mean: Number
    sigma: Number


class QualifyJson(TypedDict):
    """The JSON of qualify, in the contact file's unit."""

    schema: Literal["tactfix/qualify/1"]
    tactfix_version: str
    units: str
    touches: int
    places: int
    dof: int
    sigma: Number
    sigma_interval: Annotated[list[float | None], 2]
    range: Number
    drift: ProbeDriftJson | None
    steps: list[ProbeStepJson]
    outliers: list[int]
    tip_radius: Number
    tip_radius_sigma: Number
    direction_frame: Literal["base", "flange"] | None
    directions: list[DirectionJson]
    warnings: list[str]


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


class BatchJson(TypedDict):
    """The JSON of batch: how many sets ended how, and where their rows are."""

    schema: Literal["tactfix/batch/1"]
    sets: int
    acceptable: int
    statuses: dict[str, int]
    output: str
