"""The types of the JSON of design-check, in the fixture frame and units; see json_types."""

from typing import Literal, TypedDict

from tactfix.report.json_types import Covariance, FreeMotionJson, Matrix, Number, Vector


class SymmetryJson(TypedDict):
    """A motion that maps the unbounded features onto themselves, and what breaks this symmetry in practice."""

    transform: Matrix
    broken_by: Literal["touch", "approach", "labels", "placement"] | None
    broken_in_part_by: list[str]
    exchanges: dict[str, str]
    message: str


class RealPosesJson(TypedDict):
    """The number of poses that random sets of this kind left: observed numbers, not bounds."""

    layouts: int
    fewest_seen: int
    median: Number
    most_seen: int


class RandomLayoutsJson(TypedDict):
    """The shares of random layouts with this number of contacts that do not determine one pose."""

    contacts: int
    layouts: int
    ambiguous: Number
    underdetermined: Number


class DesignContactsJson(TypedDict):
    """How many contacts are needed; complex_poses and real_poses: one entry for each minimal set."""

    minimum_total: int
    alone: dict[str, int]
    alone_radius_unknown: dict[str, int]
    with_distances: dict[str, int]
    minimal_sets: list[dict[str, int]]
    minimal_sets_complete: bool
    complex_poses: list[int | None]
    complex_poses_source: list[str | None]
    real_poses: list[RealPosesJson | None]
    paper: dict[str, int]
    paper_radius_unknown: dict[str, int]
    random_layouts: list[RandomLayoutsJson]


class PointSigmaJson(TypedDict):
    """A point, one standard deviation along its worst direction, and that direction."""

    point: Vector
    sigma: Number
    direction: Vector


class InfluenceJson(TypedDict):
    """A contact, and the worst sigma without it; null if a motion is then free."""

    contact: str
    feature: str
    point: Vector
    worst_sigma_without: Number


class AccuracyJson(TypedDict):
    """The accuracy of the pose; covariance at the fixture's origin: rx ry rz (rad), tx ty tz."""

    of: str
    contacts: int
    covariance: Covariance
    observability: dict[str, Number]
    worst_point: PointSigmaJson
    extreme_points: list[PointSigmaJson]
    at: list[PointSigmaJson]
    worst_motion: FreeMotionJson
    matters_most: InfluenceJson
    matters_least: InfluenceJson


class WrongPoseJson(TypedDict):
    """The wrong pose that fits best."""

    transform: Matrix
    sigmas_behind: Number
    shift: Number


class FragileJson(TypedDict):
    """A contact without which the pose is not unique, and what is then left."""

    contact: str
    feature: str
    leaves: str


class MarginsJson(TypedDict):
    """How much worse than the right pose the wrong poses fit."""

    nearest_wrong_pose: WrongPoseJson | None
    looked_within_sigmas: Number
    accepted_within_sigmas: Number
    contacts_left_out: int
    must_not_be_lost: list[FragileJson]


class CylinderLayoutJson(TypedDict):
    """The number of cylinders on which the contacts of one feature lie; null: infinitely many."""

    feature: str
    contacts: int
    of_its_radius: int | None
    of_any_radius: int | None


class BlindSpotJson(TypedDict):
    """A mistake, whether the residuals show it, and the error of the pose that it causes."""

    error: str
    detectable: bool
    pose_shift: Number
    probability_shown: Number
    message: str


class DesignCheckItemJson(TypedDict):
    """A finding."""

    code: str
    status: Literal["ok", "warning", "error"]
    message: str
    hint: str


class DesignCheckJson(TypedDict):
    """The JSON of design-check."""

    schema: Literal["tactfix/design-check/1"]
    tactfix_version: str
    fixture: str
    units: str
    status: Literal["ok", "warning", "error"]
    rigid: bool
    free_motions: list[FreeMotionJson]
    symmetries: list[SymmetryJson]
    contacts: DesignContactsJson
    accuracy: AccuracyJson | None
    margins: MarginsJson | None
    cylinder_layouts: list[CylinderLayoutJson]
    blind_spots: list[BlindSpotJson]
    checks: list[DesignCheckItemJson]
