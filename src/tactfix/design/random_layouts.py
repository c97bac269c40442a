"""Random contact sets of a fixture: the contacts that make the pose unique in practice, and the poses of minimal sets.

1. A layout begins with a minimal set of random touches, followed by further random touches on any feature.
2. Each is located with that set, and the poses that explain it are counted by the kind of the set.
3. For each number of contacts the share of layouts that leave more than one pose, or a motion free, is computed.
4. These are located again with one contact more, and so on. Further contacts cannot add poses, so a layout with one
   pose is not located again.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import field
from functools import partial
from statistics import median
from typing import Final, TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.design.nominal_contacts import Locator
from tactfix.fixture import Fixture
from tactfix.results import Status
from tactfix.simulation.simulate import simulate, streams
from tactfix.values import frozen_value

DEFAULT_LAYOUTS: Final = 8
"""Enough to see which number of contacts is too few; one standard error of a share is up to 0.18."""

MOST_LAYOUTS: Final = 100_000
"""Largest study: one standard error of a share is then below 0.002."""
QUICK_LAYOUT_CONTACTS: Final = 9
"""Contacts of the largest layouts of a quick study."""
MOST_LAYOUT_CONTACTS: Final = 12
"""Random layouts of more contacts than this are hardly ever ambiguous unless the fixture itself is; a quick study ends
at QUICK_LAYOUT_CONTACTS."""

_SEEDS: Final = 100_000
"""Seeds of one study: as many as MOST_LAYOUTS, so that the layouts of studies with different seeds do not meet."""


Outcome: TypeAlias = tuple[Status, int]
"""The status of a layout, and how many poses explain it before the tests of approach and touch boxes."""

MapFunction: TypeAlias = Callable[[Callable[[Contacts], Outcome], Iterable[Contacts]], Iterable[Outcome]]
"""Like map, in this process or in parallel; results are in order."""


@frozen_value(eq=True)
class Study:
    """The number of random layouts of a study, its seed, and the probe (fixture units)."""

    layouts: int
    seed: int
    sigma: float
    tip_radius: float


@frozen_value(eq=True)
class UniqueShare:
    """Of random layouts with so many contacts, the shares with more than one pose, and with a free motion."""

    contacts: int
    layouts: int
    ambiguous: float
    underdetermined: float


@frozen_value(eq=True)
class RealPoses:
    """The numbers of real poses of random minimal sets, before the tests of approach and touch boxes.

    Seen in a simulation, not proved: rarer layouts have more, up to the complex count.
    """

    layouts: int
    fewest_seen: int
    median: float
    most_seen: int


@frozen_value(eq=True)
class LayoutStudy:
    """shares: by number of contacts, up to the first at which every layout is located or to the last that was tried.

    real_poses: by kind of the minimal set; layouts that leave a motion free do not count.
    """

    shares: tuple[UniqueShare, ...] = ()
    real_poses: Mapping[str, RealPoses] = field(default_factory=dict)


@frozen_value
class _Layout:
    """Contacts in order, and the kind of the minimal set that they begin with."""

    kind: str
    contacts: Contacts


def study_layouts(
    fixture: Fixture,
    study: Study,
    sets: Sequence[tuple[str, Mapping[str, int]]],
    locator: Locator,
    *,
    up_to: int = MOST_LAYOUT_CONTACTS,
    progress: Callable[[float, str], None] = lambda share, activity: None,
    over: MapFunction = map,
) -> LayoutStudy:
    """Locate random layouts that begin with each of sets (kind, contacts by feature) in turn, of up to up_to contacts.

    All sets have the same number of contacts. Touches are inside the touch boxes, within 20 degrees of the normal.
    progress, over: as in `design_check`. Raises UsageError as simulate does.
    """
    layouts = [_layout(fixture, study, k, sets) for k in range(study.layouts)]  # step 1
    seen: dict[str, list[int]] = {}
    shares: list[UniqueShare] = []
    left = layouts
    fewest = sum(sets[0][1].values())
    for count in range(fewest, 1 + min(up_to, *(len(layout.contacts) for layout in layouts))):
        outcomes: list[Outcome] = []
        sets_of_contacts = [layout.contacts.subset(range(count)) for layout in left]
        for layout, outcome in zip(left, over(partial(_outcome, locator), sets_of_contacts), strict=True):
            outcomes.append(outcome)
            progress((count - fewest + len(outcomes) / len(left)) / (up_to - fewest + 1), f"{count} contacts")
            status, poses = outcome
            if count == fewest and status != "underdetermined":
                seen.setdefault(layout.kind, []).append(poses)  # step 2
        shares.append(_share(count, study.layouts, [status for status, _ in outcomes]))  # step 3
        # Step 4.
        left = [layout for layout, (s, _) in zip(left, outcomes, strict=True) if s in ("ambiguous", "underdetermined")]
        if not left:
            break
    return LayoutStudy(tuple(shares), {kind: _real_poses(counts) for kind, counts in seen.items()})


def _layout(fixture: Fixture, study: Study, k: int, sets: Sequence[tuple[str, Mapping[str, int]]]) -> _Layout:
    """Layout number k; if there are more sets than layouts, sets are taken at equal steps along their list."""
    seed = _SEEDS * study.seed + k
    kind, counts = sets[k * len(sets) // study.layouts if study.layouts < len(sets) else k % len(sets)]
    made = simulate(fixture, sigma=study.sigma, tip_radius=study.tip_radius, seed=seed).contacts
    on = {name: [i for i, feature in enumerate(made.features) if feature == name] for name in counts}
    first = [i for name, count in counts.items() for i in on[name][:count]]
    rest = np.setdiff1d(np.arange(len(made)), first)
    (stream,) = streams(seed, 1)
    return _Layout(kind, made.subset([*first, *stream.permutation(rest).tolist()]))


def _outcome(locator: Locator, contacts: Contacts) -> Outcome:
    """The outcome of one set of contacts; may run in a worker process."""
    result = locator(contacts)
    return result.status, len(result.candidates)


def _share(count: int, layouts: int, statuses: Sequence[Status]) -> UniqueShare:
    ambiguous, free = (statuses.count(status) / layouts for status in ("ambiguous", "underdetermined"))
    return UniqueShare(count, layouts, ambiguous, free)


def _real_poses(counts: list[int]) -> RealPoses:
    return RealPoses(len(counts), min(counts), float(median(counts)), max(counts))
