"""Changes of a fixture that are proposed: a touch box, a feature to move, or a type of feature to add.

Boxes and moves are verified before they are proposed.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import TypeAlias

import numpy as np

from tactfix.design.symmetries import Symmetry, symmetries
from tactfix.design.touch_regions import regions_meet
from tactfix.fixture import TouchBox
from tactfix.geometry.arrays import Floats
from tactfix.geometry.motions import Fixed, common_motions
from tactfix.geometry.nearest import same_surface
from tactfix.geometry.rigid import homogeneous
from tactfix.geometry.scale import SPECIAL_POSITION, middle_of, size_of, tolerance_for
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, moved
from tactfix.results import FreeMotion

_CLEAR = 0.1
"""Share of the fixture's size between a new touch box and the place where it would overlap its image under the motion:
enough for a person to see the side. On six bad designs of the tests 0.05 and 0.2 give the same
remedies with nearer and farther limits."""
_MIDDLE_CUTOFF = 1e-12
"""Ratio of eigenvalues below which a direction does not determine the middle."""
_MOVE = 0.1
"""Share of the fixture's size by which a feature is moved, about: enough that the symmetry is broken by far more
than sigma, and a fixture can still be built so. On six bad designs of the tests 0.05 and 0.2 move the same
features, by half and twice as much."""


def symmetry_remedy(symmetry: Symmetry, surfaces: Mapping[str, Surface], boxes: Mapping[str, TouchBox]) -> str:
    """A touch box or a moved feature that breaks the symmetry, or else a further feature."""
    add = "add a feature that the motion does not map onto itself, such as a sphere off its axis"
    move = move_remedy(surfaces, boxes, _is_unsymmetric)
    add = f"{move}; or {add}" if move else add
    for name, box, words in _one_sided(symmetry, surfaces, boxes):
        size = _length(surfaces, box)
        exists = regions_meet(surfaces[name], box, box, np.eye(4), size)
        if exists and not regions_meet(surfaces[name], box, box, symmetry.image_from_fixture, size):
            return f"touch {name} on one side only and limit it in the fixture file: touch: {words}; or {add}"
    return add


Test: TypeAlias = Callable[[Mapping[str, Surface], Mapping[str, TouchBox]], bool]


def move_remedy(surfaces: Mapping[str, Surface], boxes: Mapping[str, TouchBox], is_mended: Test) -> str:
    """The feature to move, and where to, so that is_mended holds for surfaces and boxes; empty if no move does.

    Spheres first, which are easiest to move; a feature's touch box moves with it.
    """
    length = float(f"{_MOVE * (size_of(surfaces.values()) or _length(surfaces, None)):.1g}")
    order = {Sphere: 0, Point: 0, Cylinder: 1}
    for name in sorted(surfaces, key=lambda n: order.get(type(surfaces[n]), 2)):
        for k in range(3):
            shift = length * np.eye(3)[k]
            shifted = {**surfaces, name: moved(homogeneous(np.eye(3), shift), surfaces[name])}
            if same_surface(surfaces[name], shifted[name], SPECIAL_POSITION * length, SPECIAL_POSITION):
                continue
            along = {n: TouchBox(b.low + shift, b.high + shift) if n == name else b for n, b in boxes.items()}
            if is_mended(shifted, along):
                return f"move {name} by {length:g} along {'xyz'[k]}"
    return ""


def _is_unsymmetric(surfaces: Mapping[str, Surface], boxes: Mapping[str, TouchBox]) -> bool:
    """Whether no motion is free and every symmetry is broken."""
    if not isinstance(common_motions(surfaces.values(), tolerance_for(surfaces)), Fixed):
        return False
    return all(symmetry.broken_by is not None for symmetry in symmetries(surfaces, boxes))


def relabelling_remedy(surfaces: Mapping[str, Surface], boxes: Mapping[str, TouchBox], ratio: float) -> str:
    """What distinguishes equal features. ratio: share of the fixture's size up to which positions are equal."""

    def is_mended(shifted: Mapping[str, Surface], along: Mapping[str, TouchBox]) -> bool:
        if not isinstance(common_motions(shifted.values(), tolerance_for(shifted)), Fixed):
            return False
        return not any(symmetry.confusable for symmetry in symmetries(shifted, along, ratio))

    move = move_remedy(surfaces, boxes, is_mended)
    if not move:
        differ = "limit them by touch boxes that the exchange does not map onto each other, or add a further feature"
    else:
        differ = f"make their distances or radii differ by more than ten sigma, for instance {move}"
    return f"{differ}; or check the labels on the first part"


def _one_sided(
    symmetry: Symmetry, surfaces: Mapping[str, Surface], boxes: Mapping[str, TouchBox]
) -> Iterator[tuple[str, TouchBox, str]]:
    """Boxes that leave one side of a feature, cylinders first: name, box, and the line for the fixture file."""
    middle = middle_of(surfaces.values(), cutoff=_MIDDLE_CUTOFF)
    order = {Cylinder: 0, Plane: 1}
    kept = [n for n, image in symmetry.images.items() if n == image and not isinstance(surfaces[n], Point)]
    for name in sorted(kept, key=lambda n: order.get(type(surfaces[n]), 2)):
        size = size_of(surfaces.values()) or _length(surfaces, boxes.get(name))
        for k in _axes(surfaces[name]):
            low = np.full(3, -np.inf) if name not in boxes else boxes[name].low.copy()
            high = np.full(3, np.inf) if name not in boxes else boxes[name].high.copy()
            low[k] = max(low[k], float(f"{middle[k] + _CLEAR * size:.3g}"))
            if low[k] < high[k]:
                end = "null" if np.isinf(high[k]) else f"{high[k]:g}"
                yield name, TouchBox(low, high), f"{name}: {{{'xyz'[k]}: [{low[k] + 0.0:g}, {end}]}}"


def _axes(surface: Surface) -> list[int]:
    """The coordinate axes, the one most parallel to the cylinder's axis or to the plane first."""
    if isinstance(surface, Cylinder):
        return [int(k) for k in np.argsort(-np.abs(surface.direction))]
    if isinstance(surface, Plane):
        return [int(k) for k in np.argsort(np.abs(surface.normal))]
    return [0, 1, 2]


def _length(surfaces: Mapping[str, Surface], box: TouchBox | None) -> float:
    sides = np.zeros(0) if box is None else np.concatenate([box.low, box.high])
    return max(size_of(surfaces.values()), float(np.abs(sides[np.isfinite(sides)]).max(initial=0.0))) or 1.0


def feature_remedy(motion: FreeMotion, surfaces: Mapping[str, Surface]) -> str:
    """The types of feature that would constrain a free motion."""
    rotation: Floats = motion.rotation
    if not rotation.any():
        axis = ", ".join(f"{value + 0.0:.3g}" for value in np.round(motion.translation, 9))
        return f"add a sphere, or a plane that is not parallel to ({axis})"
    if all(isinstance(surface, Plane) for surface in surfaces.values()):
        return "add a sphere or cylinder, or a plane that is not parallel to the others"
    return "add a sphere or cylinder away from that line, or a plane that is not perpendicular to it"
