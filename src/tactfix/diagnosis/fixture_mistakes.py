"""Mistakes in the fixture file: sizes, sides, places, coordinates exchanged or mirrored, features exchanged."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import combinations, pairwise, permutations

import numpy as np

from tactfix.diagnosis.hypotheses import Hypothesis, Problem
from tactfix.geometry.arrays import Floats
from tactfix.geometry.nearest import same_surface
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, reference_point
from tactfix.mistakes import DiagnosisCode

AXIS_LETTERS = "xyz"
MOST_PERMUTED = 4
"""Features, or blocks of contacts, of which all permutations are tried: 23 for four; of five there would be 119,
each with a search of its own. Of more only two are exchanged."""
UNCHANGED_SHARE = 1e-9
"""Share of the coordinates up to which two surfaces are the same: far above rounding, far below any manufactured
difference."""


def radii(problem: Problem) -> list[Hypothesis]:
    """A wrong radius of each round feature that is touched."""
    round_ = _round(problem)
    return [Hypothesis("radius", features=(name,), alternatives=len(round_), free="radius") for name in round_]


def diameters(problem: Problem) -> list[Hypothesis]:
    """A diameter for the radius of each round feature that is touched."""
    halves = _halves(problem)
    return [
        Hypothesis("diameter", features=(name,), alternatives=len(halves) + 1, surfaces={name: half})
        for name, half in halves.items()
    ]


def all_diameters(problem: Problem) -> list[Hypothesis]:
    """Diameters for the radii of all round features that are touched, if these are several."""
    halves = _halves(problem)
    found = [Hypothesis("diameter", features=tuple(halves), alternatives=len(halves) + 1, surfaces=halves)]
    return found if len(halves) > 1 else []


def _halves(problem: Problem) -> dict[str, Surface]:
    return {name: replace(surface, radius=surface.radius / 2) for name, surface in _round(problem).items()}


def _round(problem: Problem) -> dict[str, Sphere | Cylinder]:
    touched = problem.contacts.by_feature
    return {n: s for n in touched if isinstance(s := problem.surfaces[n], Sphere | Cylinder)}


def sides(problem: Problem) -> list[Hypothesis]:
    """The other side of each round feature that is touched: a pin for a bore, or a bore for a pin."""
    tip = problem.contacts.tip_radius
    others = {n: turned_out(s) for n, s in _round(problem).items() if s.side == "inner" or s.radius > tip}
    return [
        Hypothesis("side", features=(name,), alternatives=len(others), surfaces={name: other})
        for name, other in others.items()
    ]


def turned_out(surface: Sphere | Cylinder) -> Sphere | Cylinder:
    """The surface with its material on the other side."""
    return replace(surface, side="outer" if surface.side == "inner" else "inner")


def places(problem: Problem) -> list[Hypothesis]:
    """Each touched feature elsewhere."""
    names = _touched_of_several(problem)
    return [Hypothesis("feature_place", features=(name,), alternatives=len(names), free="place") for name in names]


def exchanged_coordinates(problem: Problem) -> list[Hypothesis]:
    """Each touched feature but points with two of its coordinates exchanged."""
    return _exchanged(problem, _sided_of_several(problem))


def signs(problem: Problem) -> list[Hypothesis]:
    """Each touched feature but points with one coordinate of the wrong sign."""
    return _turned_round(problem, _sided_of_several(problem))


def coordinates_of_each(problem: Problem) -> list[Hypothesis]:
    """Each touched feature, points too, with two of its coordinates exchanged, or one of the wrong sign."""
    names = _touched_of_several(problem)
    return _exchanged(problem, names) + _turned_round(problem, names)


def _exchanged(problem: Problem, names: Iterable[str]) -> list[Hypothesis]:
    return [h for name in names for h in _mapped_feature(problem, name, "axes", _exchanges())]


def _turned_round(problem: Problem, names: Iterable[str]) -> list[Hypothesis]:
    return [h for name in names for h in _mapped_feature(problem, name, "mirrored", _mirrors())]


def _sided_of_several(problem: Problem) -> list[str]:
    return [name for name in _touched_of_several(problem) if not isinstance(problem.surfaces[name], Point)]


def _touched_of_several(problem: Problem) -> list[str]:
    """The touched features; none if there is only one, whose place in the fixture is not observable."""
    touched = list(problem.contacts.by_feature)
    return touched if len(touched) > 1 else []


def _mapped_feature(
    problem: Problem, name: str, code: DiagnosisCode, ways: list[tuple[Floats, str]]
) -> Iterator[Hypothesis]:
    alternatives = 3 * (len(problem.contacts.by_feature) + 1)
    for matrix, note in ways:
        for other in _ways_mapped(problem.surfaces[name], matrix):
            yield Hypothesis(code, features=(name,), alternatives=alternatives, surfaces={name: other}, note=note)


def _ways_mapped(surface: Surface, matrix: Floats) -> list[Surface]:
    """The surface with all coordinates mapped, and with those of its place alone, as far as these differ from it."""
    whole = mapped(surface, matrix)
    ways = [whole]
    if isinstance(surface, Plane | Cylinder):
        ways.append(replace(surface, point=matrix @ surface.point))
    different = [way for way in ways if not is_same(surface, way)]
    return different[:1] if len(different) == 2 and is_same(*different) else different


def exchanged_axes(problem: Problem) -> list[Hypothesis]:
    """The whole fixture with two coordinates exchanged: any two give the same body in another frame."""
    matrix, axes = _exchanges()[0]
    return [Hypothesis("axes", surfaces={n: mapped(s, matrix) for n, s in problem.surfaces.items()}, note=axes)]


def reflections(problem: Problem) -> list[Hypothesis]:
    """The whole fixture mirrored: any plane gives the same body in another frame."""
    matrix, axis = _mirrors()[0]
    return [Hypothesis("mirrored", surfaces={n: mapped(s, matrix) for n, s in problem.surfaces.items()}, note=axis)]


def exchanges(problem: Problem) -> list[Hypothesis]:
    """The labels of two features exchanged, or those of two blocks of contacts."""
    return [one for one in _exchanges_of_features(problem) if len(one.features) == 2]


def reorderings(problem: Problem) -> list[Hypothesis]:
    """The labels of more than two features permuted, or those of blocks of contacts."""
    return [one for one in _exchanges_of_features(problem) if len(one.features) > 2]


def _exchanges_of_features(problem: Problem) -> list[Hypothesis]:
    names = problem.contacts.features
    touched = tuple(problem.contacts.by_feature)
    orders = list(permutations(touched)) if len(touched) <= MOST_PERMUTED else list(_two_exchanged(touched))
    labels = {tuple(dict(zip(touched, order, strict=True))[name] for name in names) for order in orders}
    labels |= set(_blocks_reordered(names))
    labels -= {names}
    return [
        Hypothesis("feature_exchange", features=_changed(names, other), alternatives=len(labels), labels=other)
        for other in sorted(labels)
    ]


def _changed(names: tuple[str, ...], other: tuple[str, ...]) -> tuple[str, ...]:
    pairs = zip(names, other, strict=True)
    return tuple(dict.fromkeys(name for pair in pairs if pair[0] != pair[1] for name in pair))


def _two_exchanged(names: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    for i, k in combinations(range(len(names)), 2):
        order = list(names)
        order[i], order[k] = order[k], order[i]
        yield tuple(order)


def _blocks_reordered(names: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    """Labels with the blocks of contacts on one feature, in the order of the file, permuted."""
    starts = [0, *(i for i in range(1, len(names)) if names[i] != names[i - 1]), len(names)]
    blocks = [names[a:b] for a, b in pairwise(starts)]
    if len(blocks) <= MOST_PERMUTED:
        for order in permutations(blocks):
            yield tuple(name for block in order for name in block)


def _exchanges() -> list[tuple[Floats, str]]:
    return [(exchange(a, b), AXIS_LETTERS[a] + AXIS_LETTERS[b]) for a, b in combinations(range(3), 2)]


def exchange(a: int, b: int) -> Floats:
    """The matrix (3, 3) that exchanges two coordinates."""
    order = [0, 1, 2]
    order[a], order[b] = b, a
    return np.eye(3)[order]


def changed_by(surface: Surface, matrix: Floats) -> bool:
    """Whether mapping the coordinates by an orthogonal matrix (3, 3) changes the surface."""
    return not is_same(surface, mapped(surface, matrix))


def _mirrors() -> list[tuple[Floats, str]]:
    return [(np.diag([-1.0 if k == a else 1.0 for k in range(3)]), AXIS_LETTERS[a]) for a in range(3)]


def mapped(surface: Surface, matrix: Floats) -> Surface:
    """The surface with all its coordinates mapped by an orthogonal matrix (3, 3)."""
    match surface:
        case Plane():
            return Plane(matrix @ surface.point, matrix @ surface.normal)
        case Sphere():
            return replace(surface, center=matrix @ surface.center)
        case Cylinder():
            return replace(surface, point=matrix @ surface.point, direction=matrix @ surface.direction)
        case Point():
            return Point(matrix @ surface.point)


def is_same(one: Surface, other: Surface) -> bool:
    """Whether two surfaces of one feature agree but for rounding."""
    point = reference_point(one)
    return same_surface(one, other, UNCHANGED_SHARE * max(float(np.abs(point).max()), math.ulp(1.0)), UNCHANGED_SHARE)
