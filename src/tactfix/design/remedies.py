"""What to change in a fixture: which touch box to add and where, which kind of feature removes a motion."""

from collections.abc import Iterator, Mapping

import numpy as np

from tactfix.design.symmetries import Symmetry
from tactfix.design.touch_regions import regions_meet
from tactfix.fixture import TouchBox
from tactfix.geometry.arrays import Floats
from tactfix.geometry.scale import middle_of, size_of
from tactfix.geometry.surfaces import Cylinder, Plane, Surface
from tactfix.results import FreeMotion

# A new touch box keeps this share of the fixture's size away from where the motion would make it overlap itself.
_CLEAR = 0.1
_MIDDLE_CUTOFF = 1e-12


def touch_box_remedy(symmetry: Symmetry, surfaces: Mapping[str, Surface], boxes: Mapping[str, TouchBox]) -> str:
    """The touch box that breaks a symmetry, tried out; a further feature where no box of one side does."""
    add = "add a feature that the motion does not lay on itself, such as a sphere off its axis"
    for name, box, words in _one_sided(symmetry, surfaces, boxes):
        size = _length(surfaces, box)
        exists = regions_meet(surfaces[name], box, box, np.eye(4), size)
        if exists and not regions_meet(surfaces[name], box, box, symmetry.image_from_fixture, size):
            return f"touch {name} on one side only and say so in the fixture file: touch: {words}; or {add}"
    return add


def _one_sided(
    symmetry: Symmetry, surfaces: Mapping[str, Surface], boxes: Mapping[str, TouchBox]
) -> Iterator[tuple[str, TouchBox, str]]:
    """Boxes that leave one side of a feature, cylinders first: name, box, and the line for the fixture file."""
    middle = middle_of(surfaces.values(), cutoff=_MIDDLE_CUTOFF)
    order = {Cylinder: 0, Plane: 1}
    kept = [name for name, image in symmetry.images.items() if name == image]
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
    """The coordinate axes, the one that runs most along a cylinder or plane first."""
    if isinstance(surface, Cylinder):
        return [int(k) for k in np.argsort(-np.abs(surface.direction))]
    if isinstance(surface, Plane):
        return [int(k) for k in np.argsort(np.abs(surface.normal))]
    return [0, 1, 2]


def _length(surfaces: Mapping[str, Surface], box: TouchBox | None) -> float:
    sides = np.zeros(0) if box is None else np.concatenate([box.low, box.high])
    return max(size_of(surfaces.values()), float(np.abs(sides[np.isfinite(sides)]).max(initial=0.0))) or 1.0


def feature_remedy(motion: FreeMotion, surfaces: Mapping[str, Surface]) -> str:
    """A feature that a free motion does not lay on itself."""
    rotation: Floats = motion.rotation
    if not rotation.any():
        axis = ", ".join(f"{value + 0.0:.3g}" for value in np.round(motion.translation, 9))
        return f"add a sphere, or a plane that is not parallel to ({axis})"
    if all(isinstance(surface, Plane) for surface in surfaces.values()):
        return "add a sphere or cylinder, or a plane that is not parallel to the others"
    return "add a sphere or cylinder away from that line, or a plane that is not square to it"
