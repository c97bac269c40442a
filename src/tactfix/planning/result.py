"""What plan answers."""

from typing import Literal

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Floats, Frozen
from tactfix.planning.information import Criterion
from tactfix.values import frozen_value


@frozen_value(eq=True)
class PlanStep:
    """One row of the table: how many contacts, the worst sigma, the share it falls by from the row before, unique."""

    count: int
    worst_sigma: float
    gain: float | None
    unique: bool


@frozen_value
class Plan:
    """Contacts to make, and what they are worth together with those already made.

    contacts: nominal, tip centres, in the frame that frame names: base where contacts already made say where the
    fixture stands, else the fixture's. base_from_fixture (4, 4): where it stands by those contacts, else by its
    placement, None where nothing is known. worst_sigma: largest standard deviation of a point of the fixture's
    bounding box in any direction, at worst_point (3,) of the fixture frame. covariance (6, 6): of the pose in the order
    rotation (rad), translation, about the fixture's origin. unique: no second pose is within ten sigma; rivals: how
    many are. located: the contacts fix a pose at all. starts: random sets of touches that the search began with;
    agreeing: those that led to within one per cent of the best sigma. steps: the table, where the number of contacts
    was left open.
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

    @property
    def in_base(self) -> Contacts | None:
        """The contacts in base, None where it is not known where the fixture stands."""
        if self.frame == "base" or self.base_from_fixture is None:
            return self.contacts if self.frame == "base" else None
        return self.contacts.moved(self.base_from_fixture)

    @property
    def unique(self) -> bool:
        """Whether the contacts leave one pose only."""
        return self.located and not self.rivals
