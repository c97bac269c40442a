"""How many poses a minimal set of contacts can have, and how many contacts make the pose unique in practice."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from tactfix.design.blind_spots import Locator
from tactfix.fixture import Fixture
from tactfix.geometry.surfaces import FeatureType
from tactfix.simulate import simulate

# Complex poses that put six contacts on features in general position, copies by symmetry included; the key is the kinds
# with their contacts, in the order plane, sphere, cylinder and by rising count. Reference figures handed to the project
# with its contract; a special position has as many or fewer.
COMPLEX_POSES: Final[Mapping[str, int]] = MappingProxyType(
    {
        "plane 1, plane 2, plane 3": 4,
        "plane 2, plane 2, plane 2": 8,
        "plane 1, plane 2, sphere 3": 8,
        "plane 1, plane 3, sphere 2": 8,
        "plane 2, plane 2, sphere 2": 16,
        "plane 2, plane 3, sphere 1": 8,
        "plane 1, sphere 2, sphere 3": 8,
        "plane 2, sphere 1, sphere 3": 8,
        "plane 2, sphere 2, sphere 2": 16,
        "plane 3, sphere 1, sphere 2": 8,
        "sphere 1, sphere 2, sphere 3": 8,
        "sphere 2, sphere 2, sphere 2": 16,
        "sphere 1, sphere 1, sphere 1, sphere 1, sphere 1, sphere 1": 40,
        "plane 2, cylinder 4": 48,
        "plane 3, cylinder 3": 24,
        "sphere 2, cylinder 4": 96,
        "sphere 3, cylinder 3": 48,
        "cylinder 2, cylinder 4": 192,
        "cylinder 3, cylinder 3": 288,
    }
)
_KINDS: Final[tuple[FeatureType, ...]] = ("plane", "sphere", "cylinder")


def complex_poses(fixture: Fixture, counts: Mapping[str, int]) -> int | None:
    """The number of complex poses of this distribution of six contacts; None where it is not known."""
    touched = [(_KINDS.index(fixture.features[name].type), count) for name, count in counts.items() if count]
    return COMPLEX_POSES.get(", ".join(f"{_KINDS[kind]} {count}" for kind, count in sorted(touched)))


@dataclass(frozen=True, slots=True)
class UniqueShare:
    """Of layouts random layouts of this many contacts: the share that leave more than one pose, or a motion free."""

    contacts: int
    layouts: int
    ambiguous: float
    underdetermined: float


# Random layouts of more contacts than this are hardly ever ambiguous unless the fixture itself is.
_MOST: Final = 12


@dataclass(frozen=True, slots=True)
class Study:
    """A study of layouts random layouts for each number of contacts, with this probe; one seed gives one study."""

    layouts: int
    seed: int
    sigma: float
    tip_radius: float


def unique_shares(
    fixture: Fixture, study: Study, locator: Locator, progress: Callable[[float, str], None]
) -> tuple[UniqueShare, ...]:
    """The shares for six contacts and more, until every layout is located or at twelve.

    Layouts are seeded random touches inside the touch boxes, approached from within 20 degrees of the normal. progress
    is told the share of the work that is done. Raises UsageError as simulate does.
    """
    found = []
    for count in range(6, _MOST + 1):
        statuses = []
        for k in range(study.layouts):
            progress((count - 6 + k / study.layouts) / (_MOST - 5), f"{count} contacts")
            made = simulate(fixture, sigma=study.sigma, tip_radius=study.tip_radius, seed=study.seed + k, count=count)
            statuses.append(locator(made.contacts).status)
        ambiguous, free = (statuses.count(status) / study.layouts for status in ("ambiguous", "underdetermined"))
        found.append(UniqueShare(count, study.layouts, ambiguous, free))
        if statuses.count("located") == study.layouts:
            break
    return tuple(found)
