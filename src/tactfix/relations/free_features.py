"""Underdetermined features of a fixture by relations: not in the frame, with few contacts and relations.

Such a feature can move independently of all others, so it does not constrain the pose, and its free motion does not
move the frame.

1. The degrees of freedom of each feature outside the frame are compared with the equations of its contacts and
   relations.
2. A feature with fewer equations than degrees of freedom is left out with its contacts and relations. Relations of
   angles concern its direction alone: if they give more equations than a direction has, they relate other features,
   and the feature stays.
3. Steps 1 and 2 are repeated: a feature that was related to one that is left out may now be left out too.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

import numpy as np

from tactfix.contacts import Contacts
from tactfix.feature import Feature
from tactfix.fixture import Fixture, Relation
from tactfix.frame import recipe_of
from tactfix.geometry.nearest import ALMOST_PARALLEL

DIRECTION_FREEDOM = 2
"""Degrees of freedom of a direction."""


def without_free_features(fixture: Fixture, contacts: Contacts) -> tuple[Fixture, Contacts]:
    """The fixture without its underdetermined features, and the contacts on the others.

    Fixture and contacts are unchanged if no contact would remain.
    """
    if fixture.is_placed:
        return fixture, contacts
    counts = {name: len(index) for name, index in contacts.by_feature.items()}
    part = _reduced(fixture, tuple(counts.items()))
    counted = [i for i, name in enumerate(contacts.features) if name in part.features]
    if not counted:
        return fixture, contacts
    return part, contacts.subset(counted) if len(counted) < len(contacts) else contacts


@lru_cache(maxsize=32)
def _reduced(fixture: Fixture, counts: tuple[tuple[str, int], ...]) -> Fixture:
    recipe, touched = recipe_of(fixture), dict(counts)
    in_frame = {*recipe.origin.features, *recipe.first[1].features, *recipe.second[1].features}
    kept, relations = dict(fixture.features), fixture.relations
    while True:  # step 3
        free = next((n for n in kept if n not in in_frame and _is_free(kept[n], touched, relations)), None)
        if free is None:
            break
        del kept[free]
        relations = tuple(relation for relation in relations if free not in relation.between)
    if len(kept) == len(fixture.features):
        return fixture
    touch = {name: box for name, box in fixture.touch.items() if name in kept}
    return replace(fixture, features=kept, relations=relations, touch=touch)


def _is_free(feature: Feature, touched: Mapping[str, int], relations: tuple[Relation, ...]) -> bool:
    """Whether the feature is underdetermined even if all others are fixed (steps 1 and 2)."""
    own = [relation for relation in relations if feature.name in relation.between]
    angles = sum(_most_equations(relation) for relation in own if relation.kind == "angle")
    distances = sum(_most_equations(relation) for relation in own if relation.kind == "distance")
    equations = angles + distances + feature.equations * touched.get(feature.name, 0)
    return angles <= DIRECTION_FREEDOM and equations < (4 if feature.type == "cylinder" else 3)


def _most_equations(relation: Relation) -> int:
    """The largest number of equations of a relation: parallel directions give two, coincident centres three."""
    if relation.kind == "angle":
        return 2 if min(relation.value, np.pi - relation.value) < ALMOST_PARALLEL else 1
    return 3 if relation.value == 0 else 1
