"""The paper's way to a fixture: the surfaces of each feature from its own contacts, in every combination.

A sphere with too few contacts of its own is placed by its known distances to features that are located (eqs. 48-51).
"""

from collections.abc import Mapping, Sequence
from itertools import islice, product

from tactfix.contacts import Contacts
from tactfix.errors import DegenerateContactsError
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Surface
from tactfix.relations.features_alone import surfaces_alone, surfaces_by_distance


def combinations(fixture: Fixture, contacts: Contacts, sigmas: Floats, most: int) -> list[Mapping[str, Surface]] | None:
    """Every combination of candidate surfaces in base, at most so many; None where a feature cannot be located so.

    sigmas (n,) of the residuals. A feature whose contacts no surface explains leaves no combination.
    """
    alone: dict[str, Sequence[Surface]] = {}
    for name, feature in fixture.features.items():
        if name not in contacts.by_feature:
            continue
        try:
            alone[name] = surfaces_alone(feature, contacts.on(name), sigmas[contacts.by_feature[name]])
        except DegenerateContactsError:
            continue
    choices = islice(product(*alone.values()), most)
    found: list[Mapping[str, Surface]] = [dict(zip(alone, choice, strict=True)) for choice in choices]
    missing = [name for name in fixture.features if name not in alone]
    while missing and found:
        reached = next((n for n in missing if _is_reached(fixture, contacts, n, found[0])), None)
        if reached is None:
            return None
        missing.remove(reached)
        found = [
            {**known, reached: surface}
            for known in found
            for surface in surfaces_by_distance(fixture, fixture.features[reached], contacts.on(reached), known)
        ]
    return None if missing else found[:most]


def _is_reached(fixture: Fixture, contacts: Contacts, name: str, known: Mapping[str, Surface]) -> bool:
    """Whether a sphere has three contacts and distances to known features together."""
    if fixture.features[name].type != "sphere":
        return False
    partners = {b if a == name else a for a, b in _distances(fixture) if name in (a, b)}
    own = len(contacts.by_feature.get(name, ()))
    return own > 0 and own + len(partners & set(known)) >= 3


def _distances(fixture: Fixture) -> list[tuple[str, str]]:
    return [relation.between for relation in fixture.relations if relation.kind == "distance"]
