"""The result of locate: a frozen value with conversion to and from JSON.

In base coordinates and the fixture's units unless stated otherwise; the fields have the names of the JSON.
"""

from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from tactfix.errors import NotLocatedError, UsageError
from tactfix.geometry.arrays import Floats, Frozen
from tactfix.geometry.surfaces import Surface
from tactfix.results import (
    POSE_UNKNOWNS,
    Candidate,
    ContactResidual,
    Diagnosis,
    FreeMotion,
    JsonResult,
    NextContact,
    Status,
    TipEstimate,
    Touched,
    WithoutPrior,
)
from tactfix.values import frozen_value

if TYPE_CHECKING:
    from tactfix.pose_formats.pose import Pose


@frozen_value
class LocateResult(JsonResult):
    """The result of locate; "JSON of locate" in samples/README.md describes each field.

    Attributes
    ----------
    fixture, units : str
        Name of the fixture, and the unit of all lengths.
    status : {"located", "underdetermined", "ambiguous", "inconsistent"}
        "located" if and only if exactly one pose is accepted.
    base_from_fixture : (4, 4) array or None
        The pose; None unless located.
    covariance : (6, 6) array or None
        Of d_rot (rad) and d_t (units), base axes, rotation about the fixture's origin; None unless located.
    dof : int
        Equations minus unknowns.
    chi2, chi2_limit, rms : float or None
        Sum of squared residuals over sigma, its limit, and the rms of the residuals (units).
    candidates : tuple of Candidate
        Every pose that explains the contacts, with the reasons if it was eliminated.
    surfaces : mapping of str to surface
        The features in base, if known.
    contacts : tuple of ContactResidual
        Residual and approach of each contact.
    free_motions : tuple of FreeMotion
        Motions that the contacts do not constrain.
    next_contact : NextContact or None
        The best contact to make next.
    warnings : tuple of str
        Messages.
    diagnosis : tuple of Diagnosis
        Possible mistakes, most plausible first.
    unknowns : tuple of str
        Names (u) of all parameters estimated together: the pose, and the tip if unknown.
    joint_covariance : (u, u) array or None
        Of the unknowns in that order, if the tip was unknown.
    tip : TipEstimate or None
        The estimated tip, if the contacts determine it.
    without_prior : WithoutPrior or None
        The status without the prior knowledge of the pose; None if there was none.
    touched : Touched or None
        The fixture and the contacts, for the scene in a notebook. They are not part of the JSON: None in a result read
        from JSON.

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

        Raises NotLocatedError unless status is "located", UsageError for an invalid point.
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
        """The result from the text of `to_json` or `tactfix locate --json`.

        Raises UsageError for any other text. Surfaces of candidates are not in the JSON and are empty here.
        """
        from tactfix.report.json_reader import locate_result

        return locate_result(text).by_status

    @property
    def by_status(self) -> "LocatedResult | NotLocatedResult":
        """The same values as the subclass for its status."""
        values = {each.name: getattr(self, each.name) for each in fields(self)}
        return LocatedResult(**values) if self.status == "located" else NotLocatedResult(**values)

    def _repr_html_(self) -> str:
        """The summary and the scene for a notebook; the summary alone if the result was read from JSON."""
        from tactfix.report.notebook import located_html

        return located_html(self)

    def __repr__(self) -> str:
        rms = "" if self.rms is None else f", rms {self.rms:.2g} {self.units}"
        return f"<LocateResult {self.fixture!r}: {self.status}, {len(self.contacts)} contacts{rms}>"


@frozen_value
class LocatedResult(LocateResult):
    """A located result: pose and covariance are not None, which a type checker infers from the status.

    Attributes
    ----------
    status : {"located"}
        Exactly one pose is accepted.
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
    """A result without a pose: free_motions, candidates, diagnosis and next_contact give the cause and the remedy.

    Attributes
    ----------
    status : {"underdetermined", "ambiguous", "inconsistent"}
        Why there is no pose.
    base_from_fixture, covariance : None
        Always None.

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
