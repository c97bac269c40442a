"""Guidance while a fixture is touched: what the touches so far leave undetermined, and where to touch next.

1. The fixture is located by the touches so far.
2. A located pose is compared with the gates that the user has set.
3. Features without a touch are listed. The status says what is undetermined (a free motion, several poses, a
   contradiction), and `next_contact` where to touch.
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
"""Most free motions that a line names; of more it gives the number."""


@frozen_value
class GuideStep(JsonResult):
    """The state of a fixture after the touches so far.

    Attributes
    ----------
    touches : int
        Number of touches.
    result : LocateResult
        Of these touches.
    exceeded : tuple of str
        The gates that a located pose exceeds, in words.
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
        """The state of the location, in one line."""
        result = self.result
        match result.status:
            case "located":
                located = f"located, worst sigma of the origin {shown_sigma(result)}"
                return "; ".join([located, *self.exceeded])
            case "underdetermined":
                free = [motion.message for motion in result.free_motions]
                if len(free) > MOST_MOTIONS:
                    return f"{len(free)} motions are still free"
                return f"still free: {'; '.join(free) or 'more motions than can be named'}"
            case "ambiguous":
                left = sum(candidate.accepted for candidate in result.candidates)
                return f"{left} poses are left"
            case _:
                why = result.diagnosis[0].message if result.diagnosis else "is this the fixture, and the right feature?"
                return f"no pose explains the touches: {why}"

    @property
    def advice(self) -> str:
        """The next action, in one line."""
        if self.is_done:
            return "done"
        if self.result.status == "inconsistent":
            return "repeat or remove the touch that is named, or start again"
        if self.result.next_contact is not None:
            return self.result.next_contact.message
        if self.result.status == "located":
            return "touch more, far from the touches made so far; plan, asked to add 1 to these, says where"
        if self.untouched:
            return f"touch {' or '.join(self.untouched)}, which is not touched yet"
        return "touch far from the touches made so far"


def guide(
    fixture: Fixture,
    contacts: Contacts,
    *,
    point_fixture: Floats | None = None,
    max_sigma: float | None = None,
    max_rms: float | None = None,
) -> GuideStep:
    """Evaluate the touches so far, and advise where to touch next.

    Parameters
    ----------
    fixture : Fixture
        The fixture that is touched.
    contacts : Contacts
        The touches so far, at least one, in base coordinates and in the fixture's units.
    point_fixture : (3,) array, optional
        The point of the fixture frame at which max_sigma applies; its origin if None.
    max_sigma, max_rms : float, optional
        The gates of `tactfix locate`, in units: guidance continues until a located pose is within them.

    Returns
    -------
    GuideStep

    Raises
    ------
    UsageError
        Contacts on unknown features, or in another unit.

    Notes
    -----
    The next touch is `next_contact` of the result: the one that determines a free motion best, or the one at which the
    remaining poses differ most in sigma.

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
