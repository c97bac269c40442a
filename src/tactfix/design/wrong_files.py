"""Mistakes in the fixture file: would contacts on the real fixture show them?

A small mistake is fitted from the true pose. With one that makes the file describe another body, all poses are searched
for as in a diagnosis; the best that approaches and touch boxes do not reject counts.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import permutations

import numpy as np

from tactfix.design.blind_spot import BlindSpot, Case, no_pose, power_of, refined, refitted, spot_of
from tactfix.design.nominal_contacts import ERROR_SIGMAS, Touched, shift_of
from tactfix.diagnosis.fixture_mistakes import exchanged_coordinates, reflections, sides
from tactfix.diagnosis.hypotheses import Explanation, Hypothesis, Problem
from tactfix.diagnosis.trial_search import searched_anew
from tactfix.fixture import TouchBox
from tactfix.geometry.arrays import Floats
from tactfix.geometry.nearest import direction_between
from tactfix.geometry.rigid import homogeneous
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, Surface, moved
from tactfix.localization.outcome import assess
from tactfix.mistakes import BlindSpotCode
from tactfix.placement import Placement
from tactfix.poses.pose_fit import PoseFit
from tactfix.poses.prior import contradiction
from tactfix.poses.rigid import solution_at
from tactfix.values import frozen_value
from tactfix.wording import listed


def wrong_place(case: Case) -> Iterator[BlindSpot]:
    """One distance between two features is ERROR_SIGMAS sigma larger in the file than it is."""
    for wrong in misplaced(case.touched.surfaces, ERROR_SIGMAS * case.touched.rms_sigma):
        yield refitted("distance", replace(case.touched, surfaces=wrong.surfaces), case.touched.contacts, wrong.message)


@frozen_value
class Misplaced:
    """The surfaces of the wrong file, and the mistake in words."""

    surfaces: Mapping[str, Surface]
    message: str


def misplaced(surfaces: Mapping[str, Surface], off: float) -> Iterator[Misplaced]:
    """Each feature moved by off (units) away from each other feature to which it has a distance."""
    for name, other in permutations(surfaces, 2):
        direction = direction_between(surfaces[other], surfaces[name])
        if direction is not None:
            motion = homogeneous(np.eye(3), off * direction)
            message = f"{name} {off:.3g} farther from {other} in the file than it is"
            yield Misplaced({**surfaces, name: moved(motion, surfaces[name])}, message)


def wrong_radius(case: Case) -> Iterator[BlindSpot]:
    """One radius off by ERROR_SIGMAS sigma."""
    touched = case.touched
    off = ERROR_SIGMAS * touched.rms_sigma
    for name, surface in touched.surfaces.items():
        if isinstance(surface, Sphere | Cylinder):
            wrong = {**touched.surfaces, name: replace(surface, radius=surface.radius + off)}
            mistake = f"radius of {name} off by {off:.3g}"
            yield refitted("radius", replace(touched, surfaces=wrong), touched.contacts, mistake)


def diameters(case: Case) -> list[BlindSpot]:
    """The diameter in place of the radius, of one feature or of all."""
    doubled: dict[str, Surface] = {
        name: replace(surface, radius=2 * surface.radius)
        for name, surface in case.touched.surfaces.items()
        if isinstance(surface, Sphere | Cylinder)
    }
    wrong = [{name: surface} for name, surface in doubled.items()] + ([doubled] if len(doubled) > 1 else [])
    words = {_key(one): f"radius of {listed(list(one))} doubled" for one in wrong}
    hypotheses = [Hypothesis("diameter", features=tuple(one), surfaces=one) for one in wrong]
    return _spots("diameter", case, case.trials.explanations(hypotheses), words)


def wrong_side(case: Case) -> list[BlindSpot]:
    """A boss written as a bore, or a bore as a boss."""
    hypotheses = sides(case.problem)
    words = {_key(h.surfaces): f"side of {h.features[0]} taken for the other" for h in hypotheses}
    return _spots("side", case, case.trials.explanations(hypotheses), words)


def exchanged_axes(case: Case) -> list[BlindSpot]:
    """Two coordinates of one feature exchanged."""
    hypotheses = exchanged_coordinates(case.problem)
    words = {_key(h.surfaces): f"{h.note[0]} and {h.note[1]} of {_what(case, h)} exchanged" for h in hypotheses}
    return _spots("axes", case, case.trials.explanations(hypotheses), words)


def _what(case: Case, hypothesis: Hypothesis) -> str:
    """The name of what has its coordinates exchanged: a feature, or its point without its direction."""
    (name,) = hypothesis.features
    given, other = case.touched.surfaces[name], hypothesis.surfaces[name]
    if isinstance(given, Plane) and isinstance(other, Plane) and np.array_equal(given.normal, other.normal):
        return f"the point of {name}"
    if isinstance(given, Cylinder) and isinstance(other, Cylinder) and np.array_equal(given.direction, other.direction):
        return f"the point of {name}"
    return name


def mirror_image(case: Case) -> list[BlindSpot]:
    """The file describes the mirror image, with its touch boxes."""
    boxes = {}
    for name, box in case.fixture.touch.items():
        low, high = box.low.copy(), box.high.copy()
        low[0], high[0] = -box.high[0], -box.low[0]
        boxes[name] = TouchBox(low, high)
    mirrored = replace(case, fixture=replace(case.fixture, touch=boxes))
    hypotheses = reflections(case.problem)
    words = {_key(h.surfaces): "file of the mirror image" for h in hypotheses}
    return _spots("mirrored", mirrored, searched_anew(case.problem, hypotheses), words)


def _key(surfaces: Mapping[str, Surface]) -> tuple[int, ...]:
    return tuple(map(id, surfaces.values()))


def _spots(
    code: BlindSpotCode, case: Case, found: Sequence[Explanation], words: Mapping[tuple[int, ...], str]
) -> list[BlindSpot]:
    """The blind spot of each hypothesis, at the best of its poses that neither approach nor touch box rejects."""
    fits = {_key(one.hypothesis.surfaces): _best_left(case, one) for one in found}
    spots = []
    for key, mistake in words.items():
        way = fits.get(key)
        fit = None if way is None else _with_placement(case, way)
        if fit is None:
            spots.append(no_pose(code, mistake))
        else:
            chi2, pose = fit
            spots.append(spot_of(code, power_of(chi2, case.touched.dof), shift_of(pose, case.touched.corners), mistake))
    return spots


def _with_placement(case: Case, way: Explanation) -> tuple[float, Floats] | None:
    """Chi-square and pose (4, 4) of an explanation; fitted again with what is known of the pose beforehand.

    None if every such fit is beyond the limits.
    """
    if case.touched.placement is None:
        return way.chi2, way.base_from_fixture
    problem = way.hypothesis.corrected(case.problem, way.values)
    touched = replace(case.touched, surfaces=problem.surfaces, sigmas=problem.sigmas)
    fits = [refined(touched, problem.contacts, start) for start in (way.base_from_fixture, np.eye(4))]
    best = min((fit for fit in fits if _is_possible(touched, problem, fit)), key=lambda fit: fit.chi2, default=None)
    return None if best is None else (best.chi2, best.base_from_fixture)


def _is_possible(touched: Touched, problem: Problem, fit: PoseFit) -> bool:
    """Whether a pose that was fitted with what is known beforehand is within its limits."""
    limits = _limits(touched.placement)
    if limits is None:
        return True
    pose = solution_at(fit.base_from_fixture, problem.surfaces, problem.contacts, problem.sigmas)
    return contradiction(limits, pose, "", fitted=True) is None


def _limits(placement: Placement | None) -> Placement | None:
    """The limits on the motion between two poses that are both within the limits, in the fixture frame."""
    if placement is None or placement.within is None:
        return None
    translation, rotation = placement.within
    return Placement(np.eye(4), (2 * translation, 2 * rotation))


def _best_left(case: Case, one: Explanation) -> Explanation | None:
    """The best of its poses that no test rejects; if directions are constrained, `_with_placement` tests the limits."""
    known = case.touched.placement
    limits = _limits(known) if known is not None and known.free is None else None
    displaced = one.hypothesis.surfaces if one.hypothesis.code == "axes" else {}
    touch = {name: box for name, box in case.fixture.touch.items() if name not in displaced}
    fixture = replace(case.fixture, touch=touch, placement=limits)
    for way in one.ways:
        problem = way.hypothesis.corrected(case.problem, way.values)
        pose = solution_at(way.base_from_fixture, problem.surfaces, problem.contacts, problem.sigmas)
        if not assess(fixture, problem.contacts, pose, use_path=False).reasons:
            return way
    return None
