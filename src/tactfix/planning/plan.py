"""Planning: the contacts that determine a fixture's pose uniquely, with the smallest sigma for their number.

1. A task is made of the fixture, the contacts already made and the criterion (`task`).
2. With a number of contacts, or a number to add, one plan is searched for: random starts, exchanges, pattern search
   (`exchange`).
3. Without one, there is a plan for each number from the fewest on, until one leaves a single pose (`uniqueness`).
4. If tool orientations are asked for, each contact of the plan gets one (`orientations`).
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
        Number of contacts; None: the fewest with a unique pose, and a table for more.
    existing : Contacts, optional
        Contacts already made, in base: the best next ones are chosen, in base, or in the fixture frame if those made
        leave a motion free.
    add : int, optional
        Number of next contacts; None: the fewest that determine the pose.
    criterion : {"worst", "d", "e"}
        "worst" makes the worst sigma over the fixture's bounding box smallest, "d" the determinant of the covariance,
        "e" the smallest singular value of the contacts' rows largest (lengths in radii of the fixture, about its
        middle).
    seed : int
        Of the random starts.
    sigma, tip_radius : float, optional
        In fixture units; None: those of the existing contacts, or of the fixture's probe.
    progress : callable, optional
        Called with the share done, from 0 to 1, and the name of the present step.
    starts : int, optional
        Random sets of touches that the search begins with: more are more likely to find the optimum.
    over : callable
        Maps the search over its starts: `map`, or a parallel function with its signature.
    orientations : int, optional
        Number of tool orientations: each contact gets one of them, so that the sigma of the tip's place in the flange,
        found with the pose, is smallest. Without contacts, twelve are planned. Existing contacts must have flange
        rotations, which count.

    Returns
    -------
    Plan
        Touches inside the touch boxes, clear of their edges and of other features, with approaches along the normal
        unless a tilted one makes the pose unique.

    Raises
    ------
    UsageError
        Impossible numbers of contacts; a fixture whose file does not place its features, or whose features leave a
        motion free; existing contacts without a pose.
    TipDoesNotFitError
        A tip that is not smaller than a bore.

    Notes
    -----
    The placement of a fixture is used: each constrained direction needs one contact less, a measured pose adds
    information, and limits exclude poses. The plan is then given in base too.

    An exchange algorithm from several starts with a pattern search does not prove that a plan is optimal; the number of
    starts that agree indicates it. Relations with a sigma of their own are taken as exact in the search.

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
    report = progress or (lambda share, activity: None)
    # Step 1.
    task = Task.of(
        fixture, existing, criterion, seed, sigma, tip_radius, report, starts, over, orientations is not None
    )
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
