"""Guidance while a fixture is touched: what the touches so far leave open, and where to touch next.

1. The touches so far are located.
2. A located pose is held against the gates that the user has set.
3. The status says what is open: a free motion, several poses, or a contradiction; `next_contact` says where to touch.
"""

from typing import Any, Final

from tactfix.acceptance import exceeded_gates, shown_sigma
from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.localization.locate import locate
from tactfix.locate_result import LocateResult
from tactfix.results import JsonResult
from tactfix.values import frozen_value

MOST_MOTIONS: Final = 2
"""Free motions that a line names; of more it tells the number."""


@frozen_value
class GuideStep(JsonResult):
    """What so many touches tell.

    Attributes
    ----------
    touches : int
        How many.
    result : LocateResult
        What locate makes of them.
    exceeded : tuple of str
        The gates that a located pose does not keep to, in words.
    untouched : tuple of str
        Features without a touch.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> contacts = tactfix.load_contacts("samples/robot-cell-plate/contacts.csv", fixture)
    >>> tactfix.guide(fixture, contacts[:8]).untouched
    ('ball',)
    """

    touches: int
    result: LocateResult
    exceeded: tuple[str, ...]
    untouched: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """The JSON of one line of `tactfix guide --json` as dictionaries, lists and numbers."""
        from tactfix.report.movement_report import guide_json

        return guide_json(self)

    def to_json(self) -> str:
        """The line that `tactfix guide --json` prints."""
        from tactfix.report.movement_report import guide_json_line

        return guide_json_line(self)

    def __repr__(self) -> str:
        return f"<GuideStep {self.result.fixture!r}: {self.touches} touches, {self.result.status}>"

    @property
    def is_done(self) -> bool:
        """Whether the fixture is located within the gates."""
        return self.result.status == "located" and not self.exceeded

    @property
    def state(self) -> str:
        """Where things stand, in one line."""
        result = self.result
        match result.status:
            case "located":
                sure = f"located, worst sigma of the origin {shown_sigma(result)}"
                return "; ".join([sure, *self.exceeded])
            case "underdetermined":
                free = [motion.message for motion in result.free_motions]
                if len(free) > MOST_MOTIONS:
                    return f"{len(free)} motions are still free"
                return f"still free: {'; '.join(free) or 'more than can be told'}"
            case "ambiguous":
                left = sum(candidate.accepted for candidate in result.candidates)
                return f"{left} poses are left"
            case _:
                why = result.diagnosis[0].message if result.diagnosis else "is this the fixture, and the right feature?"
                return f"no pose explains the touches: {why}"

    @property
    def advice(self) -> str:
        """What to do next, in one line."""
        if self.is_done:
            return "done"
        if self.result.status == "inconsistent":
            return "repeat or remove the touch that is named, or begin anew"
        if self.result.next_contact is not None:
            return self.result.next_contact.message
        if self.result.status == "located":
            return "touch more, far from the touches that were made; plan says where, asked to add 1 to these"
        if self.untouched:
            return f"touch {' or '.join(self.untouched)}, which nothing has touched yet"
        return "touch far from the touches that were made"


def guide(
    fixture: Fixture,
    contacts: Contacts,
    *,
    point_fixture: Floats | None = None,
    max_sigma: float | None = None,
    max_rms: float | None = None,
) -> GuideStep:
    """Tell what the touches so far leave open, and where to touch next.

    Parameters
    ----------
    fixture : Fixture
        What is touched.
    contacts : Contacts
        The touches so far, at least one, in base coordinates and in the fixture's units.
    point_fixture : (3,) array, optional
        The point of the fixture frame at which max_sigma holds; its origin where None.
    max_sigma, max_rms : float, optional
        The gates of `tactfix locate`, in units: guidance goes on until a located pose keeps to them.

    Returns
    -------
    GuideStep

    Raises
    ------
    UsageError
        Contacts on unknown features, or in another unit.

    Notes
    -----
    The next touch is `next_contact` of the result: where a motion is free, the one that sees it best; where several
    poses are left, the one at which they differ most in sigma.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> contacts = tactfix.load_contacts("samples/robot-cell-plate/contacts.csv", fixture)
    >>> tactfix.guide(fixture, contacts).is_done
    True
    """
    result = locate(fixture, contacts)  # step 1
    # Step 2.
    exceeded = exceeded_gates(result, point_fixture, max_sigma, max_rms) if result.status == "located" else []
    # Step 3.
    untouched = tuple(name for name in fixture.features if name not in contacts.by_feature)
    return GuideStep(len(contacts), result, tuple(exceeded), untouched)
