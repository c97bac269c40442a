"""Where to touch: the contacts that fix the pose of a fixture uniquely and as surely as their number allows."""

from tactfix.contacts import Contacts
from tactfix.errors import UsageError
from tactfix.fixture import Fixture
from tactfix.planning.information import CRITERIA, Criterion
from tactfix.planning.result import Plan, PlanStep
from tactfix.planning.task import Over, Progress, Task

__all__ = ["CRITERIA", "Criterion", "Over", "Plan", "PlanStep", "Progress", "plan"]


def plan(
    fixture: Fixture,
    contacts: int | None = None,
    existing: Contacts | None = None,
    add: int | None = None,
    criterion: Criterion = "worst",
    seed: int = 0,
    sigma: float | None = None,
    tip_radius: float | None = None,
    progress: Progress | None = None,
    starts: int | None = None,
    over: Over = map,
) -> Plan:
    """The best contacts to make on a fixture: contacts of them, or the fewest that are unique with a table of more.

    With existing (contacts in base, already made) the add next ones. criterion: "worst" makes the worst sigma over the
    fixture's bounding box smallest, "d" the determinant of the covariance, "e" the smallest singular value of the
    contacts' rows largest (lengths in radii of the fixture, about its middle). sigma and tip_radius default to those of
    the existing contacts, then to the fixture's probe. All touches are inside the touch boxes, clear of their edges
    and of other features, and square to the surface unless a turned approach is what makes the pose unique.

    Where the fixture has a placement, the contacts are the best beside it: what is held takes as many contacts fewer, a
    measurement counts, limits make unique. The plan then tells them in base too.

    The optimum is that of an exchange from several seeded starts, polished; it is no proof of the best plan. More
    starts are more likely to find it, and how many agree tells how likely; over, which is like map, may have a cluster
    follow them. Relations with a sigma of their own are taken as exact while choosing.

    Raises UsageError for impossible numbers of contacts, for a fixture whose file does not place its features or whose
    features leave a motion free, and for existing contacts that do not give a pose; TipDoesNotFitError.
    """
    if starts is not None and starts < 1:
        raise UsageError(f"{starts} starts cannot be followed; ask for 1 or more")
    told = progress or (lambda share, what: None)
    task = Task.of(fixture, existing, criterion, seed, sigma, tip_radius, told, starts, over)
    if existing is not None:
        if contacts is not None:
            raise UsageError("contacts already made are extended with a number to add, not with a number of contacts")
        return task.single(1 if add is None else add, fewest=1)
    if add is not None:
        raise UsageError("there is nothing to add to; give the contacts already made, or a number of contacts")
    return task.table() if contacts is None else task.single(contacts, fewest=task.fewest)
