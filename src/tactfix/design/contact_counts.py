"""The fewest contacts that a fixture needs: in all, on each feature alone, and their distributions over the features.

n_i contacts on feature i are independent in general position if and only if, for every subset of the features, the sum
of n_i is at most the rank of that subset (Rado's theorem on independent transversals, the contacts on a feature being
general rows of its constraint space). The rank of a subset is 6 less the dimension of its common motions. One contact
on a point constrains all that the point can constrain, so the condition applies to the motions that touched points
leave free.

1. A choice of points to touch is kept if with all other features its rank is that of all points.
2. The choices with the fewest contacts, one for each point and one for each remaining degree of freedom, give the
   minimum.
3. The remaining contacts are distributed feature by feature, up to as many on each as Rado's condition allows.
4. The first MINIMAL_SETS_LISTED distributions are listed.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import cache
from itertools import combinations, islice
from types import MappingProxyType
from typing import Final, TypeAlias

from tactfix.design.known_place import left_free, unknowns
from tactfix.feature import Feature
from tactfix.fixture import Relation
from tactfix.geometry.motions import common_motions, twists
from tactfix.geometry.scale import Tolerance
from tactfix.geometry.surfaces import FeatureType, Point, Surface
from tactfix.placement import Placement
from tactfix.values import frozen_value

# Fewest contacts that leave finitely many surfaces of their own, with the size known and with it unknown.
CONTACTS_ALONE: Final[Mapping[FeatureType, int]] = MappingProxyType(
    {"plane": 3, "sphere": 3, "cylinder": 4, "point": 1}
)
ALONE_ANY_SIZE: Final[Mapping[FeatureType, int]] = MappingProxyType({**CONTACTS_ALONE, "sphere": 4, "cylinder": 5})
# The paper's counts (sections 3 to 5): its cylinder takes a fifth contact, and a sixth if the radius is unknown.
PAPER: Final[Mapping[FeatureType, int]] = MappingProxyType({**CONTACTS_ALONE, "cylinder": 5})
PAPER_ANY_SIZE: Final[Mapping[FeatureType, int]] = MappingProxyType({**CONTACTS_ALONE, "sphere": 4, "cylinder": 6})
PAPER_SPHERE_AT_DISTANCE: Final = 2
"""Contacts of a sphere at a known distance from the axis of a located cylinder: section 6 of the paper, eqs. 48-51."""

MINIMAL_SETS_LISTED: Final = 500
"""Minimal sets listed at most; a fixture of many features has millions."""


@frozen_value(eq=True)
class FeatureCounts:
    """Contacts by feature. alone: the fewest that leave finitely many surfaces; paper: the counts of its localizers.

    any_size: the same with the feature's own radius unknown. others_located: the fewest if all other features are
    located and the known distances and angles to them are used.
    """

    alone: Mapping[str, int]
    alone_any_size: Mapping[str, int]
    paper: Mapping[str, int]
    paper_any_size: Mapping[str, int]
    others_located: Mapping[str, int]


@frozen_value(eq=True)
class ContactCounts:
    """The numbers of contacts that a fixture needs.

    minimum_total: the fewest that leave no more motions free than all features together; without points their rank, 6
    if no motion is free. minimal_sets: contacts by feature; complete is False if there are more of them than
    MINIMAL_SETS_LISTED.
    """

    minimum_total: int
    each: FeatureCounts
    minimal_sets: tuple[Mapping[str, int], ...]
    complete: bool = True


def contact_counts(
    features: Mapping[str, Feature],
    surfaces: Mapping[str, Surface],
    distances: set[frozenset[str]],
    tolerance: Tolerance,
    placement: Placement | None = None,
) -> ContactCounts:
    """The counts of a rigid fixture with its features at surfaces; constrained directions of placement need none.

    distances: the pairs between which a distance is known; of a placed fixture all pairs that have one.
    """
    sets = minimal_sets(surfaces, tolerance, MINIMAL_SETS_LISTED + 1, placement)
    total = _rank(surfaces, tolerance, placement)
    others = {name: {n: s for n, s in surfaces.items() if n != name} for name in surfaces}
    further = {name: total - _rank(rest, tolerance, placement) for name, rest in others.items()}
    further = {name: min(n, 1) if features[name].type == "point" else n for name, n in further.items()}
    return ContactCounts(
        minimum_total=sum(sets[0].values()),
        each=_each(features, distances, further),
        minimal_sets=sets[:MINIMAL_SETS_LISTED],
        complete=len(sets) <= MINIMAL_SETS_LISTED,
    )


def _rank(surfaces: Mapping[str, Surface], tolerance: Tolerance, placement: Placement | None) -> int:
    """How many degrees of freedom that placement leaves free contacts on these surfaces can constrain."""
    if not surfaces:
        return 0
    free = twists(common_motions(surfaces.values(), tolerance))
    return unknowns(placement) - len(left_free(free, placement, tolerance.length / tolerance.angle))


def separate_counts(features: Mapping[str, Feature], relations: tuple[Relation, ...]) -> ContactCounts:
    """The counts if relations leave the shape open: each feature has to be located alone."""
    distances = {frozenset(r.between) for r in relations if r.kind == "distance"}
    further = {name: _with_distances(name, feature, distances) for name, feature in features.items()}
    each = _each(features, distances, further)
    return ContactCounts(sum(each.alone.values()), each, minimal_sets=(each.alone,))


def _with_distances(name: str, feature: Feature, distances: set[frozenset[str]]) -> int:
    """Contacts without a rigid body: each known distance to a located feature saves a sphere one, except the last.

    (src/tactfix/README.md, localizers: a sphere at one known distance takes two contacts, at two known distances one.)
    """
    known = sum(name in pair for pair in distances) if feature.type == "sphere" else 0
    return max(CONTACTS_ALONE[feature.type] - known, 1)


def _each(features: Mapping[str, Feature], distances: set[frozenset[str]], further: Mapping[str, int]) -> FeatureCounts:
    near = {n for n, f in features.items() if f.type == "sphere" and _has_cylinder(n, features, distances)}
    paper = {name: PAPER[f.type] for name, f in features.items()}
    return FeatureCounts(
        alone={name: CONTACTS_ALONE[f.type] for name, f in features.items()},
        alone_any_size={name: ALONE_ANY_SIZE[f.type] for name, f in features.items()},
        paper={name: PAPER_SPHERE_AT_DISTANCE if name in near else n for name, n in paper.items()},
        paper_any_size={name: PAPER_ANY_SIZE[f.type] for name, f in features.items()},
        others_located=further,
    )


def _has_cylinder(sphere: str, features: Mapping[str, Feature], distances: set[frozenset[str]]) -> bool:
    """Whether the distance from the sphere to some cylinder is known."""
    return any(f.type == "cylinder" and frozenset((sphere, name)) in distances for name, f in features.items())


Rank: TypeAlias = Callable[[frozenset[str]], int]


def minimal_sets(
    surfaces: Mapping[str, Surface], tolerance: Tolerance, most: int, placement: Placement | None = None
) -> tuple[Mapping[str, int], ...]:
    """Every distribution of the fewest contacts that is independent in general position, at most most of them.

    Each set names every feature, with 0 for those without a contact.
    """

    @cache
    def rank(subset: frozenset[str]) -> int:
        return _rank({name: surface for name, surface in surfaces.items() if name in subset}, tolerance, placement)

    names = tuple(surfaces)
    points = [name for name in names if isinstance(surfaces[name], Point)]
    sided = tuple(name for name in names if name not in points)
    total = rank(frozenset(names))
    choices = [frozenset(c) for size in range(len(points) + 1) for c in combinations(points, size)]
    enough = [chosen for chosen in choices if rank(chosen.union(sided)) == total]  # step 1
    fewest = min(len(chosen) + total - rank(chosen) for chosen in enough)  # step 2

    def sets() -> Iterator[Mapping[str, int]]:
        for touched in enough:
            left = total - rank(touched)
            if len(touched) + left == fewest:
                beyond = _beyond(rank, touched)  # step 3
                yield from ({**dict.fromkeys(touched, 1), **d} for d in _distributions({}, sided, left, beyond))

    # Step 4.
    return tuple({name: chosen.get(name, 0) for name in names} for chosen in islice(sets(), most))


def _beyond(rank: Rank, touched: frozenset[str]) -> Rank:
    """The rank of subsets over the motions that the touched points leave free."""
    return lambda subset: rank(subset | touched) - rank(touched)


def _distributions(
    chosen: dict[str, int], names: tuple[str, ...], left: int, rank: Rank
) -> Iterator[Mapping[str, int]]:
    """Every independent distribution of left more contacts over the features names, in addition to those chosen."""
    if left == 0:
        yield chosen
        return
    # The features that remain must be able to take the remaining contacts.
    if not names or rank(frozenset((*chosen, *names))) < left + sum(chosen.values()):
        return
    first, *others = names
    for count in range(min(left, rank(frozenset((first,)))), 0, -1):
        if _is_independent(more := {**chosen, first: count}, rank):
            yield from _distributions(more, tuple(others), left - count, rank)
    yield from _distributions(chosen, tuple(others), left, rank)


def _is_independent(chosen: Mapping[str, int], rank: Rank) -> bool:
    """Rado's condition for the subsets with the feature chosen last; the others were tested before."""
    *others, last = chosen
    return all(
        sum(chosen[name] for name in subset) + chosen[last] <= rank(frozenset((*subset, last)))
        for size in range(len(others) + 1)
        for subset in combinations(others, size)
    )
