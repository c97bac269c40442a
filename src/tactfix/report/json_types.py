"""The types of the JSON of locate, fit, check and guide, from which `tactfix schema --of` generates its schemas.

Lengths in the unit of "units", in base coordinates, unless stated otherwise. The number annotated to a list is its
length.
"""

from typing import Annotated, Literal, NotRequired, TypeAlias, TypedDict

from tactfix.mistakes import DiagnosisCode
from tactfix.results import ReasonCode, Status

Number: TypeAlias = float | None
"""A finite number, or null if unknown."""
Vector: TypeAlias = Annotated[list[float], 3]
Matrix: TypeAlias = Annotated[list[Annotated[list[float], 4]], 4]
Covariance: TypeAlias = Annotated[list[Annotated[list[float], 6]], 6]
Numbers: TypeAlias = list[float | None]


class PlaneJson(TypedDict):
    """A plane: a point of it, its outward unit normal."""

    type: Literal["plane"]
    point: Vector
    normal: Vector


class SphereJson(TypedDict):
    """A sphere."""

    type: Literal["sphere"]
    center: Vector
    radius: float


class CylinderJson(TypedDict):
    """A cylinder: a point of its axis, the axis' unit direction."""

    type: Literal["cylinder"]
    point: Vector
    direction: Vector
    radius: float


class PointJson(TypedDict):
    """A seat, cone, nest or mark that holds the tip's centre."""

    type: Literal["point"]
    point: Vector


SurfaceJson: TypeAlias = PlaneJson | SphereJson | CylinderJson | PointJson


class ReasonJson(TypedDict):
    """Why a candidate is rejected: the test, and the feature and the data row (from 1) if it concerns one."""

    code: ReasonCode
    feature: str | None
    row: int | None
    message: str


class CandidateJson(TypedDict):
    """A pose that explains the contacts; accepted if there are no reasons against it."""

    transform: Matrix
    chi2: Number
    rms: Number
    accepted: bool
    reasons: list[ReasonJson]


class ContactJson(TypedDict):
    """One contact: its residual along the outward normal, and the angle from the inward normal to its approach."""

    row: int
    feature: str
    residual: Number
    approach_angle_deg: Number


class FreeMotionJson(TypedDict):
    """A motion that remains free: rotation vector (rad), and translation of the frame's origin."""

    rotation: Vector
    translation: Vector
    message: str


class NextContactJson(TypedDict):
    """The contact to make next; null in base if no pose is known, without approach for a point. further: the other
    contacts of a smallest set that is needed.
    """

    feature: str
    point: Vector | None
    approach: Vector | None
    point_in_fixture: Vector | None
    approach_in_fixture: Vector | None
    message: str
    further: NotRequired[list["NextContactJson"]]


class WithoutPriorJson(TypedDict):
    """The result without what is known beforehand: the status, and the number of poses left."""

    status: Status
    poses: int | None


class DiagnosisJson(TypedDict):
    """A mistake that explains the contacts; causes are given if one_of is true: contacts do not distinguish them."""

    code: DiagnosisCode
    rows: list[int]
    features: list[str]
    value: float | list[float] | None
    chi2: Number
    message: str
    one_of: bool
    causes: NotRequired[list["DiagnosisJson"]]


class TipJson(TypedDict):
    """The tip found: its centre in the flange frame, its radius, and the covariance of the unknown ones of these."""

    offset: Vector | None
    radius: float
    covariance: list[Numbers]
    message: str


class AtJson(TypedDict):
    """A requested point of the fixture: its position in base, and the uncertainty of that."""

    point_fixture: Vector
    point: Vector | None
    covariance: Annotated[list[Vector], 3] | None
    worst_sigma: Number


class LocateJson(TypedDict):
    """The JSON of locate. transform is base_from_fixture, null unless located; covariance: rx ry rz (rad), tx ty tz."""

    schema: Literal["tactfix/locate/1"]
    tactfix_version: str
    fixture: str
    units: str
    status: Status
    transform: Matrix | None
    covariance: Covariance | None
    dof: int
    chi2: Number
    chi2_limit: Number
    rms: Number
    candidates: list[CandidateJson]
    features: dict[str, SurfaceJson]
    contacts: list[ContactJson]
    free_motions: list[FreeMotionJson]
    next_contact: NextContactJson | None
    without_prior: WithoutPriorJson | None
    diagnosis: list[DiagnosisJson]
    warnings: list[str]
    unknowns: NotRequired[list[str]]
    joint_covariance: NotRequired[list[Numbers] | None]
    tip: NotRequired[TipJson | None]
    at: NotRequired[AtJson]


class FitCandidateJson(TypedDict):
    """A surface through the contacts."""

    surface: SurfaceJson
    chi2: Number
    rms: Number
    accepted: bool
    poorly_determined: bool
    reasons: list[ReasonJson]


class SurfaceSigmaJson(TypedDict, total=False):
    """One standard deviation of each number of a surface; null if it is not determined."""

    point: Numbers
    normal: Numbers
    center: Numbers
    direction: Numbers
    radius: Number


class FitJson(TypedDict):
    """The JSON of fit, in the contact file's unit; residuals in the order of the contacts."""

    schema: Literal["tactfix/fit/1"]
    tactfix_version: str
    kind: Literal["plane", "sphere", "cylinder"]
    units: str | None
    status: Status
    surface: SurfaceJson | None
    candidates: list[FitCandidateJson]
    dof: int
    chi2: Number
    chi2_limit: Number
    rms: Number
    residuals: Numbers
    sigma: SurfaceSigmaJson
    warnings: list[str]


class GuideJson(TypedDict):
    """One line of guide: the result of the touches so far."""

    schema: Literal["tactfix/guide/1"]
    touches: int
    done: bool
    tactfix_version: str
    fixture: str
    units: str
    status: Status
    transform: Matrix | None
    covariance: Covariance | None
    rms: Number
    free_motions: list[FreeMotionJson]
    next_contact: NextContactJson | None
    diagnosis: list[DiagnosisJson]
    warnings: list[str]
    sigma: Number
    exceeded: list[str]
    state: str
    advice: str
