"""The types of the JSON of the other commands; see json_types."""

from typing import Annotated, Literal, TypedDict

from tactfix.mistakes import FaultKind
from tactfix.report.json_types import Covariance, LocateJson, Matrix, Number, Vector


class MovedJson(TypedDict):
    """A motion in the axes of one frame."""

    translation: Vector
    rotation_deg: Vector


class CompareJson(TypedDict):
    """The JSON of compare. chance: the probability of this or a larger movement if nothing moved."""

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
    """The drift over the history, per check."""

    checks: int
    detected: bool
    chance: Number
    translation_per_check: Vector
    rotation_per_check_deg: Vector
    covariance: list[list[float | None]] | None


class CheckJson(TypedDict):
    """The JSON of check; base and fixture: the movement in the axes of each. locate: the result of the contacts."""

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
    """A contact of a plan; in base too if the pose of the fixture is known."""

    point_in_base: Vector | None
    approach_in_base: Vector | None
    flange_in_fixture: list[Vector] | None


class StepJson(TypedDict):
    """The accuracy of the pose with this number of contacts of a plan."""

    contacts: int
    worst_sigma: Number
    gain: Number
    unique: bool | None


class PlanJson(TypedDict):
    """The JSON of plan: contacts in the frame that frame names; transform: the pose of the fixture, null if unknown."""

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
    """The JSON of simulate: contacts in base, and the true pose. mistake: the effect of the fault in words."""

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
    """A straight line fitted to the touches in their order: its slope, and the sigma of that."""

    per_touch: Number
    sigma: Number


class ProbeStepJson(TypedDict):
    """A step: from this row on the touches are displaced by size."""

    row: int
    size: Number


class DirectionJson(TypedDict):
    """The mean residual of the touches from approximately one direction."""

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


class BatchJson(TypedDict):
    """The JSON of batch: the number of sets with each status, and the file with their rows."""

    schema: Literal["tactfix/batch/1"]
    sets: int
    acceptable: int
    statuses: dict[str, int]
    output: str
