"""Kinds of problems: feature types and the number of the six contacts on each; written cylinder4+sphere2."""

import re

TYPE_ORDER = ("cylinder", "sphere", "plane")

# kind: number of complex poses. Confirmed by this project's reference table, which uses another method.
CONFIRMED = {
    "plane3+plane2+plane1": 4,
    "plane2+plane2+plane2": 8,
    "sphere3+plane2+plane1": 8,
    "sphere2+plane3+plane1": 8,
    "sphere2+plane2+plane2": 16,
    "sphere1+plane3+plane2": 8,
    "sphere3+sphere2+plane1": 8,
    "sphere3+sphere1+plane2": 8,
    "sphere2+sphere2+plane2": 16,
    "sphere2+sphere1+plane3": 8,
    "sphere3+sphere2+sphere1": 8,
    "sphere2+sphere2+sphere2": 16,
    "cylinder4+plane2": 48,
    "cylinder3+plane3": 24,
    "cylinder4+sphere2": 96,
    "cylinder3+sphere3": 48,
    "cylinder4+cylinder2": 192,
    "cylinder3+cylinder3": 288,
    "sphere1+sphere1+sphere1+sphere1+sphere1+sphere1": 40,
}
# Computed by monodromy.py and confirmed by hand: the four contacts leave twelve axes, each in two senses; the other two
# then fix a turn and a shift along it, two equations in (cos, sin, shift) on the circle: two solutions for two planes,
# four for a plane and another or for two spheres (their difference is linear), else eight.
BY_HAND = {
    "cylinder4+plane1+plane1": 48,
    "cylinder4+sphere1+plane1": 96,
    "cylinder4+sphere1+sphere1": 96,
    "cylinder4+cylinder1+plane1": 96,
    "cylinder4+cylinder1+sphere1": 192,
    "cylinder4+cylinder1+cylinder1": 192,
}
# Computed here by monodromy.py, not confirmed elsewhere.
UNCONFIRMED = {
    "cylinder1+plane3+plane2": 8,
    "cylinder1+sphere2+plane3": 16,
    "cylinder1+sphere3+plane2": 16,
    "cylinder1+sphere3+sphere2": 16,
    "cylinder2+plane2+plane2": 32,
    "cylinder2+plane3+plane1": 16,
    "cylinder2+sphere1+plane3": 32,
    "cylinder2+sphere2+plane2": 80,
    "cylinder2+sphere2+sphere2": 96,
    "cylinder2+sphere3+plane1": 48,
    "cylinder2+sphere3+sphere1": 48,
    "cylinder3+plane2+plane1": 48,
    "cylinder3+sphere1+plane2": 96,
    "cylinder3+sphere2+plane1": 144,
    "cylinder3+sphere2+sphere1": 144,
    "cylinder2+cylinder1+plane3": 32,
    "cylinder2+cylinder1+sphere3": 96,
    "cylinder2+cylinder2+plane2": 128,
    "cylinder2+cylinder2+sphere2": 384,
    "cylinder3+cylinder1+plane2": 96,
    "cylinder3+cylinder1+sphere2": 288,
    "cylinder3+cylinder2+plane1": 192,
    "cylinder3+cylinder2+sphere1": 384,
    "cylinder2+cylinder2+cylinder2": 512,
    "cylinder3+cylinder2+cylinder1": 384,
}
# The default kinds of the studies.
STUDIED = (
    "plane3+plane2+plane1",
    "plane2+plane2+plane2",
    "sphere3+sphere2+sphere1",
    "sphere2+sphere2+sphere2",
    "cylinder3+sphere3",
    "cylinder4+sphere2",
    "cylinder3+cylinder3",
    "cylinder4+cylinder2",
    "cylinder3+plane3",
    "cylinder4+plane2",
    "cylinder3+sphere2+plane1",
    "cylinder2+sphere2+plane2",
    "cylinder4+sphere1+plane1",
    "sphere2+plane3+plane1",
)
KINDS = {**CONFIRMED, **BY_HAND, **UNCONFIRMED}


def kind_of(counts: list[tuple[str, int]]) -> str:
    """The name of a kind from (type, contacts) of each feature, in any order."""
    ordered = sorted(counts, key=lambda item: (TYPE_ORDER.index(item[0]), -item[1]))
    return "+".join(f"{name}{count}" for name, count in ordered)


def feature_list(kind: str) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """Feature types and contacts on each, in the order of the name."""
    parts = [re.fullmatch(r"(plane|sphere|cylinder)(\d)", part) for part in kind.split("+")]
    if not all(parts) or sum(int(p[2]) for p in parts if p) != 6:
        raise ValueError(f"not a kind of problem with six contacts: {kind!r}")
    return tuple(p[1] for p in parts if p), tuple(int(p[2]) for p in parts if p)
