"""What tactfix answers: plain frozen values, in base coordinates and the fixture's units unless a name says otherwise.

The report layer turns these into text and JSON; the names here are the names there.
"""

from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from tactfix.errors import NotLocatedError, UsageError
from tactfix.geometry.arrays import Floats, Frozen
from tactfix.geometry.surfaces import Surface
from tactfix.mistakes import DiagnosisCode
from tactfix.values import frozen_value

if TYPE_CHECKING:
    from tactfix.contacts import Contacts
    from tactfix.fixture import Fixture
    from tactfix.pose_formats.pose import Pose

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
    approach_in_fixture in the fixture frame. further: the other contacts that are missing at least, where more are.
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


@frozen_value
class LocateResult(JsonResult):
    """The answer of locate; "JSON of locate" in samples/README.md says more of each field.

    Attributes
    ----------
    fixture, units : str
        Name of the fixture, and the unit of all lengths.
    status : {"located", "underdetermined", "ambiguous", "inconsistent"}
        "located" if and only if exactly one pose is left.
    base_from_fixture : (4, 4) array or None
        The pose; None unless located.
    covariance : (6, 6) array or None
        Of d_rot (rad) and d_t (units), base axes, rotation about the fixture's origin; None unless located.
    dof : int
        Equations minus unknowns.
    chi2, chi2_limit, rms : float or None
        Sum of squared residuals over sigma, what it was held against, and the rms of the residuals (units).
    candidates : tuple of Candidate
        Every pose that explains the contacts, and why it fell if it did.
    surfaces : mapping of str to surface
        The features in base, whenever they are known.
    contacts : tuple of ContactResidual
        Residual and approach of each contact.
    free_motions : tuple of FreeMotion
        What the contacts leave free.
    next_contact : NextContact or None
        Where to touch next.
    warnings : tuple of str
        In words.
    diagnosis : tuple of Diagnosis
        What may be wrong, most plausible first.
    unknowns : tuple of str
        Names (u) of all that was found together: the pose, and the tip where it was unknown.
    joint_covariance : (u, u) array or None
        Of the unknowns in that order, where the tip was unknown.
    tip : TipEstimate or None
        Wherever the contacts determine it.
    without_prior : WithoutPrior or None
        What would be left without what was known beforehand; None where nothing was.
    touched : Touched or None
        The fixture and the contacts that it was found from, for the scene in a notebook. The JSON does not hold them:
        None in a result that was read from JSON.

    Notes
    -----
    The sigmas of the frame are the square roots of the covariance's diagonal. `pose` is what `write_pose` takes.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> contacts = tactfix.load_contacts("samples/robot-cell-plate/contacts.csv", fixture)
    >>> result = tactfix.locate(fixture, contacts)
    >>> tactfix.LocateResult.from_json(result.to_json())
    <LocateResult 'robot-cell-plate': located, 15 contacts, rms 0.067 mm>
    """

    fixture: str
    units: str
    status: Status
    base_from_fixture: Floats | None
    covariance: Floats | None
    dof: int
    chi2: float | None
    chi2_limit: float | None
    rms: float | None
    candidates: tuple[Candidate, ...]
    surfaces: Mapping[str, Surface]
    contacts: tuple[ContactResidual, ...]
    free_motions: tuple[FreeMotion, ...] = ()
    next_contact: NextContact | None = None
    warnings: tuple[str, ...] = ()
    diagnosis: tuple[Diagnosis, ...] = ()
    unknowns: tuple[str, ...] = POSE_UNKNOWNS
    joint_covariance: Floats | None = None
    tip: TipEstimate | None = None
    without_prior: WithoutPrior | None = None
    touched: Touched | None = None

    @property
    def pose(self) -> "Pose":
        """The pose with its covariance, for `write_pose` and `compare`.

        Raises NotLocatedError unless status is "located".
        """
        from tactfix.pose_formats.pose import Pose

        if self.base_from_fixture is None:
            raise NotLocatedError(self.fixture, self.status)
        return Pose(self.base_from_fixture, self.units, self.covariance, self.fixture)

    def sigma_at(self, point_fixture: ArrayLike = (0.0, 0.0, 0.0)) -> float:
        """One standard deviation (units) of a point (3,) of the fixture frame along its worst direction.

        Raises NotLocatedError unless status is "located", UsageError for what is no point.
        """
        from tactfix.acceptance import sigma_at

        point = np.asarray(point_fixture, dtype=np.float64)
        if point.shape != (3,) or not np.isfinite(point).all():
            raise UsageError("a point of the fixture is three finite numbers x, y, z; ask for one point at a time")
        sigma = sigma_at(self, point)
        if sigma is None:
            raise NotLocatedError(self.fixture, self.status)
        return sigma

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `tactfix locate --json` as dictionaries, lists and numbers."""
        from tactfix.report.json_report import locate_json

        return locate_json(self)

    @classmethod
    def from_json(cls, text: str | bytes) -> "LocatedResult | NotLocatedResult":
        """The result that `to_json`, or `tactfix locate --json`, has written.

        Raises UsageError for a text that is no such JSON. Surfaces of candidates are not written and come back empty.
        """
        from tactfix.report.json_reader import locate_result

        return locate_result(text).as_told

    @property
    def as_told(self) -> "LocatedResult | NotLocatedResult":
        """The same values as the type that its status means."""
        values = {each.name: getattr(self, each.name) for each in fields(self)}
        return LocatedResult(**values) if self.status == "located" else NotLocatedResult(**values)

    def _repr_html_(self) -> str:
        """The summary and the scene for a notebook; the summary alone where the result was read from JSON."""
        from tactfix.report.notebook import located_html

        return located_html(self)

    def __repr__(self) -> str:
        rms = "" if self.rms is None else f", rms {self.rms:.2g} {self.units}"
        return f"<LocateResult {self.fixture!r}: {self.status}, {len(self.contacts)} contacts{rms}>"


@frozen_value
class LocatedResult(LocateResult):
    """A result that is located: pose and covariance are there, as a type checker knows after asking for the status.

    Attributes
    ----------
    status : {"located"}
        One pose is left.
    base_from_fixture : (4, 4) array
        The pose, in units.
    covariance : (6, 6) array
        Of d_rot (rad) and d_t (units), base axes, rotation about the fixture's origin.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> contacts = tactfix.load_contacts("samples/robot-cell-plate/contacts.csv", fixture)
    >>> isinstance(tactfix.locate(fixture, contacts), tactfix.LocatedResult)
    True
    """

    status: Literal["located"]
    base_from_fixture: Frozen
    covariance: Frozen


@frozen_value
class NotLocatedResult(LocateResult):
    """A result without a pose: free_motions, candidates, diagnosis and next_contact say why, and what to do.

    Attributes
    ----------
    status : {"underdetermined", "ambiguous", "inconsistent"}
        Why there is none.
    base_from_fixture, covariance : None
        There is none.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> contacts = tactfix.load_contacts("samples/robot-cell-plate/contacts.csv", fixture)
    >>> tactfix.locate(fixture, contacts[:4]).status
    'underdetermined'
    """

    status: Literal["underdetermined", "ambiguous", "inconsistent"]
    base_from_fixture: None
    covariance: None
