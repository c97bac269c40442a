"""Where to touch: the contacts that determine the pose of a fixture uniquely, with the smallest sigma for their number.

1. A task is made of the fixture, the contacts already made and the criterion (`task`).
2. With a number of contacts, or a number to add, one plan is searched: random starts, exchanges, polish (`exchange`).
3. Without one, there is a plan for each number from the fewest on, until one leaves a single pose (`uniqueness`).
4. Where orientations of the tool are asked for, each contact of the plan is given one (`orientations`).
"""

from tactfix.contacts import Contacts
from tactfix.errors import UsageError
from tactfix.fixture import Fixture
from tactfix.planning.information import CRITERIA, Criterion
from tactfix.planning.orientations import USUAL_CONTACTS, with_orientations
from tactfix.planning.result import Plan, PlanStep
from tactfix.planning.task import MapFunction, Progress, Task

__all__ = ["CRITERIA", "Criterion", "MapFunction", "Plan", "PlanStep", "Progress", "plan"]


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
    over: MapFunction = map,
    orientations: int | None = None,
) -> Plan:
    """Choose the best contacts to make on a fixture.

    Parameters
    ----------
    fixture : Fixture
        Whose file places its features.
    contacts : int, optional
        How many; None: the fewest that are unique, with a table of more.
    existing : Contacts, optional
        Already made, in base: the best next ones are chosen, in base, or in the fixture frame where those made leave a
        motion free.
    add : int, optional
        How many next ones; None: the fewest that hold the pose.
    criterion : {"worst", "d", "e"}
        "worst" makes the worst sigma over the fixture's bounding box smallest, "d" the determinant of the covariance,
        "e" the smallest singular value of the contacts' rows largest (lengths in radii of the fixture, about its
        middle).
    seed : int
        Of the random starts.
    sigma, tip_radius : float, optional
        In fixture units; those of the existing contacts, or of the fixture's probe, where None.
    progress : callable, optional
        Is called with the share done, from 0 to 1, and what is being done.
    starts : int, optional
        Random sets of touches that the search begins with: more are more likely to find the optimum.
    over : callable
        Who follows the starts: `map`, one after the other, or its like.
    orientations : int, optional
        Of the tool: each contact is planned in one of so many, chosen so that the tip's place in the flange is known
        best where it is found with the pose. Without contacts twelve are then planned. How the flange stood at existing
        contacts counts, and must be known.

    Returns
    -------
    Plan
        Touches inside the touch boxes, clear of their edges and of other features, and square to the surface unless a
        turned approach is what makes the pose unique.

    Raises
    ------
    UsageError
        Impossible numbers of contacts, a fixture whose file does not place its features or whose features leave a
        motion free, and existing contacts that do not give a pose.
    TipDoesNotFitError
        A tip that is not smaller than a bore.

    Notes
    -----
    Where the fixture has a placement, the contacts are the best beside it: what is held takes as many contacts fewer, a
    measurement counts, limits make unique. The plan then tells them in base too.

    An exchange algorithm from several starts, polished: it is no proof of the best plan, and how many starts agree
    tells how likely it is. Relations with a sigma of their own are taken as exact while choosing.

    References
    ----------
    .. [1] V. V. Fedorov, "Theory of Optimal Experiments", Academic Press 1972: exchange algorithms.

    Examples
    --------
    >>> cube = tactfix.load_fixture("fixtures/three-planes.yaml")
    >>> plan = tactfix.plan(cube, contacts=7, starts=1)
    >>> len(plan.contacts), plan.located
    (7, True)
    """
    if starts is not None and starts < 1:
        raise UsageError(f"{starts} starts cannot be followed; ask for 1 or more")
    told = progress or (lambda share, what: None)
    # Step 1.
    task = Task.of(fixture, existing, criterion, seed, sigma, tip_radius, told, starts, over, orientations is not None)
    if existing is not None:
        if contacts is not None:
            raise UsageError("contacts already made are extended with a number to add, not with a number of contacts")
        found = task.single(task.fewest if add is None else add)  # step 2
    elif add is not None:
        raise UsageError("there is nothing to add to; give the contacts already made, or a number of contacts")
    elif orientations is None:
        # Step 3, or step 2.
        return task.table() if contacts is None else task.single(contacts)
    else:
        found = task.single(USUAL_CONTACTS if contacts is None else contacts)
    if orientations is None:
        return found
    # Step 4.
    return with_orientations(found, fixture, orientations, None if task.made is None else task.made.contacts)
