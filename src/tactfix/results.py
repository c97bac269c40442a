"""What results are made of: poses, free motions, residuals, mistakes, as plain frozen values.

In base coordinates and the fixture's units unless a name says otherwise. The report layer turns them into text and
JSON; the names here are the names there.
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
    """Why a candidate fell: which test, at which feature and which contact (row counts data rows from 1)."""

    code: ReasonCode
    feature: str | None
    row: int | None
    message: str


@frozen_value
class Candidate:
    """A pose that explains the contacts, or did until one of reasons; surfaces are the features in base."""

    base_from_fixture: Frozen
    surfaces: Mapping[str, Surface]
    chi2: float
    rms: float
    reasons: tuple[Reason, ...] = ()

    @property
    def accepted(self) -> bool:
        """Whether nothing speaks against it."""
        return not self.reasons


@frozen_value
class FreeMotion:
    """A motion that the contacts do not see: twist at the origin of its frame, rotation (3,) rad, translation (3,)."""

    rotation: Frozen
    translation: Frozen
    message: str


@frozen_value
class NextContact:
    """The contact to make next: it tells the remaining poses apart best, or takes away a free motion.

    point (3,) on the surface and approach (3,) unit in base, None where no pose is known; point_in_fixture and
    approach_in_fixture in the fixture frame. A touch on a point has no approach: None. further: the other contacts that
    are missing at least, where more are.
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

    rows and features: which are concerned. value: what would be right instead, or how far a contact is off (lengths in
    fixture units, places in the fixture frame), None where there is no number. chi2: what is left of chi-square without
    the mistake. one_of: the contacts cannot tell the causes apart; this is then the most plausible of them, with the
    rows and features of all.
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

    approach_angle_deg: angle between the approach and the inward normal, 0 when the probe came square to the surface,
    90 at grazing; None without an approach.
    """

    row: int
    feature: str
    residual: float
    approach_angle_deg: float | None


POSE_UNKNOWNS: Final = ("rx", "ry", "rz", "tx", "ty", "tz")
"""The names of what a pose is found for, in the order of its covariance."""


@frozen_value
class TipEstimate:
    """The tip as the contacts have it: its centre (3,) in the flange frame, None where nothing says it, and its radius.

    covariance (k, k): of those that were unknown: x, y, z of the centre, the radius.
    """

    offset: Floats | None
    radius: float
    covariance: Floats
    message: str


@frozen_value(eq=True)
class WithoutPrior:
    """What the contacts alone would leave, without what is known beforehand.

    poses: how many poses would be left; of an ambiguous result at least so many, None where a motion would be free.
    """

    status: Status
    poses: int | None


class JsonResult:
    """A result with the JSON of a command: to_dict says it, to_json writes it."""

    def to_dict(self) -> dict[str, Any]:
        """The JSON as dictionaries, lists and numbers."""
        raise NotImplementedError

    def to_json(self) -> str:
        """The text that the command prints with --json."""
        from tactfix.report.json_report import text_of

        return text_of(self.to_dict())


@frozen_value
class Touched:
    """What a result was found from: the fixture, and the contacts as they were given."""

    fixture: "Fixture"
    contacts: "Contacts"
