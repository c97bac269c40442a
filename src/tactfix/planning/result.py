"""The result of planning."""

from typing import Any, Literal

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Floats, Frozen
from tactfix.planning.information import Criterion
from tactfix.results import JsonResult
from tactfix.values import frozen_value


@frozen_value(eq=True)
class PlanStep:
    """One row of the table: number of contacts, worst sigma, its relative fall from the row before, uniqueness."""

    count: int
    worst_sigma: float
    gain: float | None
    unique: bool


@frozen_value
class Plan(JsonResult):
    """Contacts to make, and the accuracy of the pose from them and from those already made.

    Attributes
    ----------
    fixture, units : str
        Name of the fixture, and the unit of all lengths.
    contacts : Contacts
        Nominal contacts (tip centres), in the frame named by frame.
    frame : {"fixture", "base"}
        "base" if contacts already made give the pose of the fixture.
    base_from_fixture : (4, 4) array or None
        Its pose by those contacts, else by its placement; None if neither is known.
    criterion : {"worst", "d", "e"}
        The criterion that was minimized.
    worst_sigma : float
        Largest standard deviation (units) of a point of the fixture's bounding box in any direction.
    worst_point : (3,) array
        That point, in the fixture frame.
    covariance : (6, 6) array
        Of the pose in the order rotation (rad), translation (units), about the fixture's origin.
    located : bool
        Whether the contacts determine a pose.
    rivals : int
        Number of other poses within ten sigma; 0 if the plan is unique.
    starts, agreeing : int
        Number of starts of the search, and of those that ended within one per cent of the best sigma.
    steps : tuple of PlanStep
        The table, if the number of contacts was left open.
    tip_sigma : float or None
        Largest standard deviation (units) of the tip's place in the flange, found together with the pose; inf if the
        orientations do not determine it, None if none were planned.

    Examples
    --------
    >>> plan = tactfix.plan(tactfix.load_fixture("fixtures/three-planes.yaml"), contacts=9, starts=1)
    >>> plan.unique
    True
    """

    fixture: str
    units: str
    contacts: Contacts
    frame: Literal["fixture", "base"]
    base_from_fixture: Floats | None
    criterion: Criterion
    worst_sigma: float
    worst_point: Frozen
    covariance: Frozen
    located: bool
    rivals: int
    starts: int
    agreeing: int
    steps: tuple[PlanStep, ...] = ()
    tip_sigma: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `tactfix plan --json` as dictionaries, lists and numbers."""
        from tactfix.report.plan_report import plan_json

        return plan_json(self)

    def __repr__(self) -> str:
        unique = "one pose" if self.unique else f"{self.rivals} other poses"
        sigma = f"worst sigma {self.worst_sigma:.2g} {self.units}"
        return f"<Plan {self.fixture!r}: {len(self.contacts)} contacts, {sigma}, {unique}>"

    @property
    def in_base(self) -> Contacts | None:
        """The contacts in base; None if the pose of the fixture is not known."""
        if self.frame == "base" or self.base_from_fixture is None:
            return self.contacts if self.frame == "base" else None
        return self.contacts.moved(self.base_from_fixture)

    @property
    def unique(self) -> bool:
        """Whether the contacts leave one pose only."""
        return self.located and not self.rivals
