"""The method of the paper: every combination of the surfaces that explain each feature's own contacts.

1. Each feature is located by its own contacts (`features_alone`), if these are enough.
2. Every choice of one candidate for each located feature is a combination.
3. In each combination a remaining sphere is located by its contacts and its distances to located features (eqs. 48-51).
   It may then locate the next one.
4. If a feature remains, there are no combinations.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import islice, product

from tactfix.contacts import Contacts
from tactfix.errors import DegenerateContactsError
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Surface
from tactfix.relations.features_alone import (
    FeatureCandidate,
    candidates_alone,
    candidates_by_distance,
    is_flat,
    is_weak,
)
from tactfix.values import frozen_value

FLAT_CANDIDATES = 12
"""Candidates that are kept of a round feature whose contacts are coplanar within noise. Four contacts leave at most
twelve cylinders of one radius, which are all kept. More contacts may leave a hundred local minima, none of them near
the truth; from any of them, a joint fit moves the feature to where the other features and relations require it. The
result is then not complete."""


@frozen_value
class Combinations:
    """Combinations of the features' surfaces in base.

    weak: some surface is so weakly determined that noise may have merged it with another one, or misplaced those
    located from it. thinned: only some candidates were kept of a feature whose contacts do not determine its curvature.
    """

    surfaces: Sequence[Mapping[str, Surface]]
    weak: bool
    thinned: bool = False


@frozen_value
class LocatedAlone:
    """The candidates of each feature that its own contacts locate; thinned as in `Combinations`."""

    candidates: Mapping[str, Sequence[FeatureCandidate]]
    thinned: bool


def located_alone(fixture: Fixture, contacts: Contacts, sigmas: Floats) -> LocatedAlone:
    """The candidates of each feature by its own contacts (step 1); sigmas (n,) of the residuals."""
    alone: dict[str, Sequence[FeatureCandidate]] = {}
    thinned = False
    for name, feature in fixture.features.items():
        if name not in contacts.by_feature:
            continue
        try:
            candidates = candidates_alone(feature, contacts.on(name), sigmas[contacts.by_feature[name]])
        except DegenerateContactsError:
            continue
        flat = len(candidates) > FLAT_CANDIDATES and is_flat(feature, contacts.on(name))
        thinned |= flat
        alone[name] = sorted(candidates, key=lambda c: c.chi2)[:FLAT_CANDIDATES] if flat else candidates
    return LocatedAlone(alone, thinned)


def without_weak(alone: Mapping[str, Sequence[FeatureCandidate]]) -> dict[str, Sequence[FeatureCandidate]]:
    """The candidates of those features that all are determined well."""
    return {name: found for name, found in alone.items() if not any(is_weak(candidate) for candidate in found)}


def combinations(fixture: Fixture, contacts: Contacts, alone: LocatedAlone, most: int) -> Combinations | None:
    """Every combination of candidate surfaces, at most so many; None if a feature cannot be located.

    There is none if no surface explains the contacts of a feature.
    """
    found = combinations_of(fixture, contacts, alone.candidates, most)
    return None if found is None else replace(found, thinned=alone.thinned)


def combinations_of(
    fixture: Fixture, contacts: Contacts, alone: Mapping[str, Sequence[FeatureCandidate]], most: int
) -> Combinations | None:
    """The same from the candidates of those features that can be located alone."""
    weak = any(is_weak(candidate) for candidates in alone.values() for candidate in candidates)
    choices = islice(product(*alone.values()), most)  # step 2
    found: list[dict[str, FeatureCandidate]] = [dict(zip(alone, choice, strict=True)) for choice in choices]
    missing = [name for name in fixture.features if name not in alone]
    while missing and found:
        locatable = next((n for n in missing if _is_locatable(fixture, contacts, n, found[0])), None)
        if locatable is None:
            return None
        missing.remove(locatable)
        try:
            # Step 3.
            found = [more for known in found for more in _with_one_more(fixture, contacts, locatable, known)]
        except DegenerateContactsError:
            return None
        weak |= any(is_weak(known[locatable]) for known in found)
    if missing:
        return None  # step 4
    surfaces = [{name: candidate.surface for name, candidate in known.items()} for known in found[:most]]
    return Combinations(surfaces, weak)


def _with_one_more(
    fixture: Fixture, contacts: Contacts, name: str, known: Mapping[str, FeatureCandidate]
) -> list[dict[str, FeatureCandidate]]:
    """The combination with each position of one more sphere; DegenerateContactsError if there are infinitely many."""
    placed = candidates_by_distance(fixture, fixture.features[name], contacts.on(name), known)
    return [{**known, name: candidate} for candidate in placed]


def _is_locatable(fixture: Fixture, contacts: Contacts, name: str, known: Mapping[str, FeatureCandidate]) -> bool:
    """Whether a sphere has three contacts and distances to known features together."""
    if fixture.features[name].type != "sphere":
        return False
    partners = {b if a == name else a for a, b in _distances(fixture) if name in (a, b)}
    own = len(contacts.by_feature.get(name, ()))
    return own > 0 and own + len(partners & set(known)) >= 3


def _distances(fixture: Fixture) -> list[tuple[str, str]]:
    return [relation.between for relation in fixture.relations if relation.kind == "distance"]
