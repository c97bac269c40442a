"""One planning task, from the search to the test of uniqueness.

1. Starts are random sets of touches; in a table the first is the set of the row before and the best further touch.
2. From each of them single touches are exchanged (`exchange`, Fedorov 1972).
3. The best sets are refined by a pattern search over the surfaces.
4. In order of their score they are tested for `uniqueness`; the first with one pose only is the plan, else the best.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from typing import TypeAlias

import numpy as np

from tactfix.acceptance import point_covariance, worst_sigma
from tactfix.accessibility.access import access_of
from tactfix.contacts import Contacts
from tactfix.errors import UsageError
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.localization.nominal import expected_pose
from tactfix.planning.contacts_made import Made, contacts_made
from tactfix.planning.exchange import Choice, Search, exchanged, extended, polished, started
from tactfix.planning.information import Criterion, Known, Objective, flat, known_of
from tactfix.planning.pool import Touches, joined_contacts, pool_of, touches_made
from tactfix.planning.result import Plan, PlanStep
from tactfix.planning.uniqueness import separating_approaches, uniqueness_of
from tactfix.poses.pose_fit import covariance_at
from tactfix.probe import probe_settings
from tactfix.simulation.simulate import nominal_surfaces
from tactfix.values import frozen_value

_LARGEST_PLAN = 14
"""Contacts of the largest plan before a fixture is taken to have no unique plan: twice the seven that are enough if
approaches and touch boxes can exclude the other poses at all."""
_AGREEING_START = 1.01
"""Ratio to the best sigma up to which a start agrees with it: one per cent of sigma is of no importance."""
_PLAN_STARTS = 8
"""Starts of the search for one plan. With 4 the worst sigma of the plan on the plate with pin and ball (8
contacts) is 4 per cent larger, with 16 that on three planes (9 contacts) 2 per cent smaller; the others of five
plans change by less."""
_STARTS_IN_TABLE = 2
"""Starts for each row of the table; one of them is the row before with a touch more."""
_POLISHED = 3
"""Best sets that are refined by a pattern search. With 1 none of those five plans has a worst sigma larger by 2 per
cent."""
_POLISHED_IN_TABLE = 1
"""The same for each row of the table."""
_FREE_MOTION_RATIO = 1e-7
"""Ratio of the smallest to the largest singular value of all candidates together, below which a motion is free: a
tenth of scale.SPECIAL_POSITION, to which fixtures are typed."""
MOST_PLANNED = 200
"""Time grows with the contacts, a sixth of a second of processor time for each: 34 s for so many on the plate with pin
and ball. Their sigma shrinks with the root of their number alone; a fixture that needs more is the wrong fixture."""

Progress = Callable[[float, str], None]
"""Called with the share of the work that is done (0 to 1) and the name of the present step."""
MapFunction: TypeAlias = Callable[[Callable[[Touches], Choice], Iterable[Touches]], Iterable[Choice]]
"""Like map, in this process or in parallel; results are in order."""


@frozen_value
class Task:
    """One planning task: search, contacts already made, sigma and tip radius of the probe, seed, and number of starts.

    starts: None for the default. over: maps the search over its starts.
    """

    fixture: Fixture
    search: Search
    made: Made | None
    probe: tuple[float, float]
    seed: int
    progress: Progress
    starts: int | None
    over: MapFunction

    @staticmethod
    def of(
        fixture: Fixture,
        existing: Contacts | None,
        criterion: Criterion,
        seed: int,
        sigma: float | None,
        tip_radius: float | None,
        progress: Progress,
        starts: int | None,
        over: MapFunction,
        tip_unknown: bool,
    ) -> "Task":
        """The task of planning on this fixture; see `planning.plan.plan`. tip_unknown: as in `contacts_made`."""
        probe = probe_settings(fixture, existing, sigma, tip_radius)
        surfaces = nominal_surfaces(fixture)
        access = access_of(fixture, surfaces, probe[1])
        sigmas = {name: float(np.hypot(probe[0], feature.sigma)) for name, feature in fixture.features.items()}
        pool = pool_of(access, sigmas)
        made = None if existing is None else contacts_made(fixture, existing, tip_unknown)
        known = known_of(fixture.placement, _pose(fixture, made), access.centre, access.radius)
        _refuse_free_motion(fixture, pool.touches, known)
        corners = (access.corners - access.centre) / access.radius
        objective = Objective(criterion, corners, min(sigmas.values()), known)
        touches = touches_made(pool, None if made is None else made.contacts, fixture)
        return Task(fixture, Search(objective, pool, touches), made, probe, seed, progress, starts, over)

    @property
    def fewest(self) -> int:
        """The fewest contacts that can determine the pose: one on a point constrains up to three motions, others one.

        Contacts already made count, but one more is planned at least. A measured pose does not count: it is to be
        checked.
        """
        touches, known = self.search.pool.touches, self.search.objective.known
        count, constrained = 0, flat(self.search.made.rows) @ known.basis
        for at in np.flatnonzero(self.search.pool.on_points(touches.which)):
            more = np.concatenate([constrained, touches.rows[at] @ known.basis])
            if _rank(more) > _rank(constrained):
                count, constrained = count + 1, more
        return max(count + known.unknowns - _rank(constrained), 0 if self.made is None else 1)

    def single(self, count: int) -> Plan:
        """The plan of count contacts."""
        fewest = self.fewest
        if count < fewest:
            who = "the pose needs" if self.made is None else "the motions that the contacts leave free need"
            raise UsageError(f"{count} contacts cannot be planned: {who} more; ask for {fewest} or more")
        if count > MOST_PLANNED:
            raise UsageError(f"{count} contacts are more than are planned at once; ask for {MOST_PLANNED} or fewer")
        found = self._found(count, None, (0.0, 1.0))[1]
        self.progress(1.0, "done")
        return found

    def table(self) -> Plan:
        """The plan of the fewest contacts with a unique pose, and the gain of further contacts up to twice as many."""
        steps: list[PlanStep] = []
        first: Plan | None = None
        last: Choice | None = None
        fewest = self.fewest
        count, end = fewest, _LARGEST_PLAN
        while count <= end:
            share = (count - fewest) / (end - fewest + 1), 1 / (end - fewest + 1)
            last, found = self._found(count, last, share)
            gain = 1 - found.worst_sigma / steps[-1].worst_sigma if steps else None
            steps.append(PlanStep(count, found.worst_sigma, gain, found.unique))
            if first is None and found.unique:
                first, end = found, 2 * count
            count += 1
        self.progress(1.0, "done")
        return replace(first or found, steps=tuple(steps))

    def _found(self, count: int, smaller: Choice | None, share: tuple[float, float]) -> tuple[Choice, Plan]:
        """The best choice of count touches, and its plan; unique if one of the choices is.

        smaller: the choice of the row before, in a table. share: where in the whole work this begins, and its share.
        """
        begun = self._starts(count, smaller)  # step 1
        ended: list[Choice] = []  # step 2
        for choice in self.over(partial(exchanged, self.search), begun):
            ended.append(choice)
            self.progress(share[0] + share[1] * len(ended) / (len(begun) + 1), f"{count} contacts")
        # A set that was unique with one contact less stays so with one more: it needs no further search.
        choices = [*ended, *([] if smaller is None else [self.search.choice(begun[0])])]
        choices.sort(key=lambda choice: choice.score)
        # Step 3.
        few = _POLISHED if smaller is None else _POLISHED_IN_TABLE
        choices[:few] = [polished(self.search, choice) for choice in choices[:few]]
        choices.sort(key=lambda choice: choice.score)
        plans: list[Plan] = []  # step 4
        for k, choice in enumerate(choices):
            done = len(begun) + k / len(choices)
            self.progress(share[0] + share[1] * done / (len(begun) + 1), f"{count} contacts: unique?")
            plans.append(self._plan(choice.touches, ended))
            if plans[-1].unique:
                return choice, plans[-1]
        return choices[0], plans[0]

    def _starts(self, count: int, smaller: Choice | None) -> list[Touches]:
        """Starts of count touches: random ones; in a table the first is the set before with one more."""
        usual = _PLAN_STARTS if smaller is None else _STARTS_IN_TABLE
        rng = np.random.Generator(np.random.PCG64([self.seed, count]))
        begun = [started(self.search, count, rng) for _ in range(self.starts or usual)]
        return begun if smaller is None else [extended(self.search, smaller), *begun[1:]]

    def _agreeing(self, ended: Sequence[Choice]) -> int:
        """How many of the ends of the search agree with the best of them."""
        sigmas = np.array([self.search.objective.sigma_of(choice.score) for choice in ended])
        return int((sigmas <= _AGREEING_START * sigmas.min()).sum())

    def _plan(self, touches: Touches, ended: Sequence[Choice]) -> Plan:
        """The plan of these touches, with approaches tilted if that makes it unique; ended: all ends of the search."""
        pool = self.search.pool
        order = np.argsort(touches.which, kind="stable")
        touches = touches.take(order)
        names = [pool.names[i] for i in touches.which]
        nominal = pool.access.nominal_contacts(names, touches.points, touches.normals, self.probe[0])
        fixed = None if self.made is None else self.made.contacts
        base_from_fixture = _pose(self.fixture, self.made)
        by_contacts = None if self.made is None else self.made.base_from_fixture
        found = uniqueness_of(self.fixture, joined_contacts(fixed, nominal), base_from_fixture)
        if found.rivals:
            turned = separating_approaches(pool.access, nominal, touches.normals, found.rivals)
            second = uniqueness_of(self.fixture, joined_contacts(fixed, turned), base_from_fixture)
            if second.located and len(second.rivals) < len(found.rivals):
                nominal, found = turned, second
        # The covariance of locate includes the sigmas of relations, which the search took as exact.
        covariance = found.result.covariance
        covariance = self._covariance(touches) if covariance is None else covariance
        corners = pool.access.corners
        sigmas = worst_sigma(point_covariance(np.eye(4), covariance, corners))
        return Plan(
            fixture=self.fixture.name,
            units=self.fixture.units,
            contacts=nominal if by_contacts is None else nominal.moved(by_contacts),
            frame="fixture" if by_contacts is None else "base",
            base_from_fixture=base_from_fixture,
            criterion=self.search.objective.criterion,
            worst_sigma=float(sigmas.max()),
            worst_point=corners[np.argmax(sigmas)],
            covariance=covariance,
            located=found.located,
            rivals=len(found.rivals),
            starts=len(ended),
            agreeing=self._agreeing(ended),
        )

    def _covariance(self, touches: Touches) -> Floats:
        """Covariance (6, 6) of the pose about the fixture's origin, rotation first."""
        access = self.search.pool.access
        scale = np.array([1 / access.radius] * 3 + [1.0] * 3)
        covariance = self.search.objective.known.covariance(self.search.information(touches))
        return covariance_at(scale[:, None] * covariance * scale, -access.centre)


def _pose(fixture: Fixture, made: Made | None) -> Floats | None:
    """The pose base_from_fixture (4, 4): by contacts already made, else by the placement; None if neither gives it."""
    return expected_pose(fixture) if made is None or made.base_from_fixture is None else made.base_from_fixture


def _rank(rows: Floats) -> int:
    """The rank of the rows (k, u)."""
    singular = np.linalg.svd(rows, compute_uv=False)
    return int((singular >= _FREE_MOTION_RATIO * singular.max(initial=0.0)).sum())


def _refuse_free_motion(fixture: Fixture, touches: Touches, known: Known) -> None:
    if _rank(flat(touches.rows) @ known.basis) < known.unknowns:
        raise UsageError(
            f"{fixture.name}: a motion stays free whatever is touched, so no plan can determine the pose; "
            "design-check names the motion and what to add"
        )
