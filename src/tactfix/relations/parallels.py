"""Features that angles make parallel, and axes that are treated as parallel because they nearly are."""

from collections.abc import Mapping
from functools import lru_cache
from itertools import combinations

import numpy as np

from tactfix.fixture import Fixture, Relation
from tactfix.geometry.nearest import ALMOST_PARALLEL, PARALLEL
from tactfix.geometry.surfaces import Cylinder, Surface


@lru_cache(maxsize=64)
def parallel_pairs(relations: tuple[Relation, ...]) -> frozenset[frozenset[str]]:
    """The pairs of features that angles of 0 and 180 degrees make parallel, directly or through others."""
    groups: list[set[str]] = []
    for relation in relations:
        if relation.kind == "angle" and np.sin(relation.value) < PARALLEL:
            joined = [group for group in groups if group & set(relation.between)]
            groups = [group for group in groups if group not in joined]
            groups.append(set(relation.between).union(*joined))
    return frozenset(frozenset(pair) for group in groups for pair in combinations(sorted(group), 2))


def uncertain_distances(fixture: Fixture, surfaces: Mapping[str, Surface]) -> tuple[str, ...]:
    """Warnings about distances of axes that are treated as parallel only because they nearly are.

    `geometry.nearest` takes their spacing as the distance; for skew axes it would be the common perpendicular.
    """
    known = parallel_pairs(fixture.relations)
    warnings = []
    for relation in fixture.relations:
        axes = [surface for name in relation.between if isinstance(surface := surfaces.get(name), Cylinder)]
        if relation.kind == "distance" and len(axes) == 2 and frozenset(relation.between) not in known:
            sine = float(np.linalg.norm(np.cross(axes[0].direction, axes[1].direction)))
            if sine < ALMOST_PARALLEL:
                one, other = relation.between
                warnings.append(
                    f"{one} and {other} are {np.degrees(np.arcsin(sine)):.2g} deg from parallel and no angle is given: "
                    "their distance was taken for the spacing of parallel axes; give their angle, 0 if they are"
                )
    return tuple(warnings)
