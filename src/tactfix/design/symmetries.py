"""The finite group of proper motions that map a fixture's unbounded surfaces onto themselves, and what breaks each.

1. If a motion is free the group is infinite, and no element is listed.
2. Otherwise its elements share a fixed point, the unique point nearest to all surfaces: each is a rotation about it.
3. A rotation follows from the images of two independent arrows: normals, axes, and vectors from the middle to centres
   and axes. Every pair of like arrows gives a candidate.
4. A candidate is an element if the image of each surface is one of the surfaces.
5. Labels, approaches or touch boxes, in this order, may break it.
"""

from collections.abc import Mapping
from typing import Literal, TypeAlias

import numpy as np

from tactfix.design.touch_regions import reach_of, regions_meet
from tactfix.fixture import TouchBox
from tactfix.geometry.arrays import Bools, Floats, Frozen
from tactfix.geometry.motions import Fixed, Line, are_parallel, common_motions
from tactfix.geometry.nearest import anchored
from tactfix.geometry.rigid import homogeneous, rotation_angle
from tactfix.geometry.scale import Tolerance, middle_of, tolerance_for
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, moved, reference_point
from tactfix.localization.motion_words import line_in_words
from tactfix.values import frozen_value
from tactfix.wording import listed

BrokenBy: TypeAlias = Literal["labels", "approach", "touch", "placement"]

LAID_ON = 4e-6
"""Share of the fixture's size, and rad, by which an image may differ from a surface: four times scale.SPECIAL_POSITION,
the rounding of typed numbers. Two surfaces contribute, each a direction and a length."""
_SQUARED_COSINE = 1e-12
"""Squared cosine below which directions are perpendicular, for the computation of the middle."""


@frozen_value
class Symmetry:
    """A motion other than the identity that maps the surfaces onto themselves, in the fixture frame.

    image_from_fixture (4, 4); images: the feature onto which each feature is mapped; broken_by: what excludes it in
    practice, None if nothing does. partly: features whose touch box and its image overlap in part, so that contacts
    outside the overlap exclude the motion and contacts inside do not. confusable: contacts with features exchanged like
    this would pass every test (sides, outward normals and touch boxes agree).
    """

    image_from_fixture: Frozen
    images: Mapping[str, str]
    broken_by: BrokenBy | None
    partly: tuple[str, ...]
    confusable: bool
    message: str


def symmetries(
    surfaces: Mapping[str, Surface], boxes: Mapping[str, TouchBox], ratio: float = LAID_ON
) -> tuple[Symmetry, ...]:
    """Every element of the group but the identity, by angle; empty if a motion is free (the group is infinite).

    ratio: share of the fixture's size by which an image may differ from a surface.
    """
    tolerance = tolerance_for(surfaces, ratio)
    if not isinstance(common_motions(surfaces.values(), tolerance), Fixed):
        return ()  # step 1
    middle = middle_of(surfaces.values(), cutoff=_SQUARED_COSINE)  # step 2
    centred = {name: _about(anchored(surface, middle), middle) for name, surface in surfaces.items()}
    found: list[tuple[Floats, dict[str, str]]] = []
    for rotation in _candidate_rotations(list(centred.values()), tolerance):  # step 3
        images = _images(rotation, centred, tolerance)  # step 4
        if images is not None and not any(rotation_angle(rotation.T @ r) < _SAME_ROTATION for r, _ in found):
            found.append((rotation, images))
    found.sort(key=lambda element: round(rotation_angle(element[0]), 6))
    return tuple(_symmetry(r, images, middle, surfaces, boxes) for r, images in found)  # step 5


_SAME_ROTATION = 1e-3
"""Rad within which two rotations are the same element of the group. A turn of a finite group of k sides is at least
2 pi / k, and no fixture has thousands of features; candidates of one element differ by LAID_ON at most."""


def _about(surface: Surface, middle: Floats) -> Surface:
    return moved(homogeneous(np.eye(3), -middle), surface)


@frozen_value
class _Arrows:
    """Directions (n, 3) of the surfaces about the middle; images of each other have one kind and length (n,)."""

    directions: Floats
    lengths: Floats
    kinds: tuple[str, ...]


def _arrows(surfaces: list[Surface], tolerance: Tolerance) -> _Arrows:
    """The arrows of surfaces given about their middle; one without a sense is listed in both directions."""
    directions: list[Floats] = []
    lengths: list[float] = []
    kinds: list[str] = []

    def add(kind: str, direction: Floats, length: float, both_ways: bool) -> None:
        for sign in (1.0, -1.0) if both_ways else (1.0,):
            directions.append(sign * direction)
            lengths.append(length)
            kinds.append(kind)

    for surface in surfaces:
        point = reference_point(surface)
        distance = float(np.linalg.norm(point))
        is_off = distance > tolerance.length
        match surface:
            case Plane():
                add("plane", point / distance if is_off else surface.normal, distance, both_ways=not is_off)
            case Sphere() | Point():
                if is_off:
                    add("sphere", point / distance, distance, both_ways=False)
            case Cylinder():
                add("axis", surface.direction, distance, both_ways=True)
                if is_off:
                    add("foot", point / distance, distance, both_ways=False)
    return _Arrows(np.array(directions).reshape(-1, 3), np.array(lengths), tuple(kinds))


def _candidate_rotations(surfaces: list[Surface], tolerance: Tolerance) -> list[Floats]:
    """Rotations (3, 3) except the identity that map the two best arrows to like arrows at the same angle."""
    arrows = _arrows(surfaces, tolerance)
    size = tolerance.length / tolerance.angle
    # The direction of a short arrow is uncertain; that of a normal or axis is not, whatever its offset.
    certainty = np.array(
        [
            1.0 if k in {"plane", "axis"} else min(1.0, n / size)
            for k, n in zip(arrows.kinds, arrows.lengths, strict=True)
        ]
    )
    spread = np.linalg.norm(np.cross(arrows.directions[:, None], arrows.directions[None]), axis=2)
    first, second = np.unravel_index(np.argmax(spread * np.minimum.outer(certainty, certainty)), spread.shape)
    tolerated = max(
        _SIEVE, 10 * tolerance.angle / float(spread[first, second] * min(certainty[first], certainty[second]))
    )
    cosines = arrows.directions @ arrows.directions.T
    own = _triad(arrows.directions[first], arrows.directions[second])
    rotations = []
    for i in np.flatnonzero(_like(arrows, int(first), tolerance)):
        for j in np.flatnonzero(_like(arrows, int(second), tolerance)):
            if abs(cosines[i, j] - cosines[first, second]) <= tolerated and spread[i, j] > 0.5 * spread[first, second]:
                rotation = _triad(arrows.directions[i], arrows.directions[j]) @ own.T
                if rotation_angle(rotation) > _SAME_ROTATION:
                    rotations.append(rotation)
    return rotations


_SIEVE = 1e-3
"""Difference of cosines up to which pairs of arrows are compared: a coarse test before the surfaces are compared with
their images, far wider than LAID_ON."""


def _like(arrows: _Arrows, index: int, tolerance: Tolerance) -> Bools:
    """Which arrows (n,) the one at index can be mapped to."""
    same_kind = np.array([kind == arrows.kinds[index] for kind in arrows.kinds])
    return np.asarray(same_kind & (np.abs(arrows.lengths - arrows.lengths[index]) <= 2 * tolerance.length))


def _triad(first: Floats, second: Floats) -> Floats:
    """The right-handed orthonormal matrix (3, 3) of first, the part of second perpendicular to it, and their normal."""
    normal = np.cross(first, second)
    normal = normal / np.linalg.norm(normal)
    return np.column_stack([first, np.cross(normal, first), normal])


def _images(rotation: Floats, centred: Mapping[str, Surface], tolerance: Tolerance) -> dict[str, str] | None:
    """The feature onto which each one is mapped, itself if possible; None if the image of one is no feature."""
    images: dict[str, str] = {}
    turn = homogeneous(rotation, np.zeros(3))
    for name, surface in centred.items():
        image = moved(turn, surface)
        on = next((n for n in (name, *centred) if _coincide(image, centred[n], tolerance)), None)
        if on is None:
            return None
        images[name] = on
    return images


def _coincide(a: Surface, b: Surface, tolerance: Tolerance) -> bool:
    """Whether two surfaces, with the points nearest to the origin, are the same set of points."""
    match a, b:
        case Plane(), Plane():
            return are_parallel(a.normal, b.normal, tolerance) and _near(a.point, b.point, tolerance)
        case Sphere(), Sphere():
            return abs(a.radius - b.radius) <= tolerance.length and _near(a.center, b.center, tolerance)
        case Point(), Point():
            return _near(a.point, b.point, tolerance)
        case Cylinder(), Cylinder():
            same_size = abs(a.radius - b.radius) <= tolerance.length
            return (
                same_size and are_parallel(a.direction, b.direction, tolerance) and _near(a.point, b.point, tolerance)
            )
        case _:
            return False


def _near(a: Floats, b: Floats, tolerance: Tolerance) -> bool:
    return bool(np.linalg.norm(a - b) <= tolerance.length)


def _symmetry(
    rotation: Floats,
    images: dict[str, str],
    middle: Floats,
    surfaces: Mapping[str, Surface],
    boxes: Mapping[str, TouchBox],
) -> Symmetry:
    """One element with what breaks it."""
    motion = homogeneous(rotation, middle - rotation @ middle)
    exchanged = [name for name, image in images.items() if image != name]
    turned = [
        n for n, s in surfaces.items() if isinstance(s, Plane) and not _keeps_side(motion, s, surfaces[images[n]])
    ]
    sides_kept = all(_keeps_side(motion, s, surfaces[images[n]]) for n, s in surfaces.items())
    length = reach_of(surfaces, boxes, middle)
    # The boxes are only compared if labels and sides do not decide: that takes a hundred times as long.
    compared = surfaces if (sides_kept if exchanged else not turned) else {}
    apart = [n for n, s in compared.items() if not regions_meet(s, boxes.get(n), boxes.get(images[n]), motion, length)]
    broken_by: BrokenBy | None = "labels" if exchanged else "approach" if turned else "touch" if apart else None
    return Symmetry(
        image_from_fixture=motion,
        images=images,
        broken_by=broken_by,
        partly=tuple(
            n for n in images if broken_by is None and not _keeps_box(motion, boxes.get(n), surfaces[n], length)
        ),
        confusable=bool(exchanged) and sides_kept and not apart,
        message=_in_words(rotation, middle, exchanged, images, surfaces),
    )


def _keeps_side(motion: Floats, surface: Surface, image: Surface) -> bool:
    """Whether the outward side of the moved surface is that of its image."""
    if isinstance(surface, Plane):
        assert isinstance(image, Plane)
        return bool((motion[:3, :3] @ surface.normal) @ image.normal > 0)
    if isinstance(surface, Point):
        return True
    return isinstance(image, Sphere | Cylinder) and surface.side == image.side


def _keeps_box(motion: Floats, box: TouchBox | None, surface: Surface, length: float) -> bool:
    """Whether the motion, which maps the surface onto itself, maps its touchable region into itself."""
    if box is None:
        return True
    for k in range(3):
        for low, high in ((box.high[k], np.inf), (-np.inf, box.low[k])):
            beyond_low, beyond_high = np.full(3, -np.inf), np.full(3, np.inf)
            beyond_low[k], beyond_high[k] = low, high
            is_closed = np.isfinite(low) or np.isfinite(high)
            if is_closed and regions_meet(surface, box, TouchBox(beyond_low, beyond_high), motion, length):
                return False
    return True


def _in_words(
    rotation: Floats, middle: Floats, exchanged: list[str], images: Mapping[str, str], surfaces: Mapping[str, Surface]
) -> str:
    """half-turn about ..., exchanging ball_1 and ball_2."""
    angle = rotation_angle(rotation)
    values, vectors = np.linalg.eigh(rotation + rotation.T)
    line = Line(middle, vectors[:, np.argmax(values)])
    parts = 2 * np.pi / angle
    turns = {2: "half-turn", 3: "third of a turn", 4: "quarter-turn"}
    turn = turns.get(round(parts), "") if abs(parts - round(parts)) < _SAME_ROTATION else ""
    axis = line_in_words(line, surfaces, tolerance_for(surfaces, LAID_ON))
    words = f"{turn or f'turn by {np.degrees(angle):.4g} deg'} about {axis}"
    return f"{words}, exchanging {listed(exchanged)}" if exchanged else words
