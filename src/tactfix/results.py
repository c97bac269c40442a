"""The parts of results as frozen values: poses, free motions, residuals, mistakes.

In base coordinates and the fixture's units unless stated otherwise. The report package turns them into text and JSON
with the same names.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

from tactfix.geometry.arrays import Floats, Frozen
from tactfix.geometry.surfaces import Surface
from tactfix.mistakes import DiagnosisCode
from tactfix.values import frozen_value

if TYPE_CHECKING:
    from tactfix.contacts import Contacts
    from tactfix.fixture import Fixture

Status: TypeAlias = Literal["located", "underdetermined", "ambiguous", "inconsistent"]
ReasonCode: TypeAlias = Literal["fit", "relation", "approach", "touch", "path", "tip", "prior"]


@frozen_value(eq=True)
class Reason:
    """Why a candidate was eliminated: which test, at which feature and which contact (row counts data rows from 1)."""

    code: ReasonCode
    feature: str | None
    row: int | None
    message: str


@frozen_value
class Candidate:
    """A pose that explains the contacts, eliminated if it has reasons; surfaces: the features in base."""

    base_from_fixture: Frozen
    surfaces: Mapping[str, Surface]
    chi2: float
    rms: float
    reasons: tuple[Reason, ...] = ()

    @property
    def accepted(self) -> bool:
        """Whether it is not eliminated."""
        return not self.reasons


@frozen_value
class FreeMotion:
    """A motion left free by the contacts: twist at the origin of its frame, rotation (3,) rad, translation (3,)."""

    rotation: Frozen
    translation: Frozen
    message: str


@frozen_value
class NextContact:
    """The contact to make next: it discriminates best between the remaining poses, or constrains a free motion.

    point (3,) on the surface and approach (3,) unit in base, None if no pose is known; point_in_fixture and
    approach_in_fixture in the fixture frame. A touch on a point has no approach: None. further: the other
    contacts needed at least, if any.
    """

    feature: str
    point: Frozen | None
    approach: Frozen | None
    message: str
    point_in_fixture: Frozen | None = None
    approach_in_fixture: Frozen | None = None
    further: tuple["NextContact", ...] = ()


@frozen_value(eq=True)
class Diagnosis:
    """A mistake that explains why the contacts do not agree.

    rows and features: those concerned. value: the corrected value, or the error of a contact (lengths in fixture units,
    places in the fixture frame), None if not a number. chi2: chi-square without the mistake. one_of: the contacts do
    not distinguish the causes; this is then the most plausible of them, with the rows and features of all.
    """

    code: DiagnosisCode
    rows: tuple[int, ...]
    features: tuple[str, ...]
    value: float | tuple[float, ...] | None
    chi2: float | None
    message: str
    one_of: bool = False
    causes: tuple["Diagnosis", ...] = ()


@frozen_value(eq=True)
class ContactResidual:
    """How one contact fits: residual along the outward normal, positive out of the material (fixture units).

    approach_angle_deg: angle between the approach and the inward normal, 0 for a perpendicular approach, 90 at
    grazing; None without an approach.
    """

    row: int
    feature: str
    residual: float
    approach_angle_deg: float | None


POSE_UNKNOWNS: Final = ("rx", "ry", "rz", "tx", "ty", "tz")
"""The names of the pose parameters, in the order of the covariance."""


@frozen_value
class TipEstimate:
    """The estimated tip: its centre (3,) in the flange frame, None if unknown, and its radius.

    covariance (k, k): of the estimated ones of x, y, z of the centre and the radius.
    """

    offset: Floats | None
    radius: float
    covariance: Floats
    message: str


@frozen_value(eq=True)
class WithoutPrior:
    """The status from the contacts alone, without prior knowledge of the pose.

    poses: the number of poses (a lower bound if ambiguous), None if a motion would be free.
    """

    status: Status
    poses: int | None


class JsonResult:
    """A result with the JSON of a command: as a dictionary or as text."""

    def to_dict(self) -> dict[str, Any]:
        """The JSON as dictionaries, lists and numbers."""
        raise NotImplementedError

    def to_json(self) -> str:
        """The text that the command prints with --json."""
        from tactfix.report.json_report import text_of

        return text_of(self.to_dict())


@frozen_value
class Touched:
    """The data of a result: the fixture, and the contacts as given."""

    fixture: "Fixture"
    contacts: "Contacts"
