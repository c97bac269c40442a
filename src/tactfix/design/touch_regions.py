"""Whether the image of one touchable region under a motion meets another: exact, without sampling.

A touchable region is a surface within a box.

1. The points x of one box that a motion maps into another box form a convex polytope of at most twelve faces.
2. If it has no corner it is empty.
3. The distance from a centre, an axis or a plane is greatest at a corner. It is least at a stationary point on the
   intersection of no face, or of one, two or three.
4. The polytope is connected, so that distance takes every value between: the surface has a point in it if and only if
   its radius (0 of a plane) lies between the two.
"""

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from tactfix.fixture import TouchBox
from tactfix.geometry.arrays import Floats
from tactfix.geometry.scale import block_of, size_of
from tactfix.geometry.surfaces import Surface, radius_of, reference_point

_OPEN_SIDE = 1e3
"""Fixture sizes at which an open side of a box is closed, so that the small systems stay bounded: no contact on the
fixture is made farther away."""


def regions_meet(
    surface: Surface, box: TouchBox | None, image_box: TouchBox | None, image_from_surface: Floats, length: float
) -> bool:
    """Whether image_from_surface (4, 4) maps some point of surface within box into image_box.

    length: the fixture's size (fixture units); boxes that only touch each other do not meet. A box without thickness
    (a face typed as z: [0, 0]) contains the face.
    """
    if box is None and image_box is None:
        return True
    point = reference_point(surface)
    normals, offsets = _faces(box, image_box, image_from_surface, point, length)  # step 1
    block = block_of(surface)
    corners = _stationary(np.zeros((3, 3)), normals, offsets, (3,))
    if not len(corners):
        return False  # step 2
    nearest = _stationary(block, normals, offsets, (0, 1, 2, 3))  # step 3
    radius = radius_of(surface) / length
    least = np.linalg.norm(nearest @ block, axis=1).min()
    greatest = np.linalg.norm(corners @ block, axis=1).max()
    # Step 4.
    return bool(least <= radius + _SYSTEM_ROUNDING and greatest >= radius - _SYSTEM_ROUNDING)


def reach_of(surfaces: Mapping[str, Surface], boxes: Mapping[str, TouchBox], middle: Floats) -> float:
    """The largest of the surfaces' distances and of the closed sides of the boxes; 1 if there is no length."""
    sides = [np.abs(side - middle) for box in boxes.values() for side in (box.low, box.high)]
    closed = [float(side[np.isfinite(side)].max(initial=0.0)) for side in sides]
    return max(size_of(surfaces.values()), *closed, 0.0) or 1.0


_SYSTEM_ROUNDING = 1e-7
"""Rounding of the linear systems below, in fixture sizes: a tenth of _SHRINK."""
_SHRINK = 1e-6
"""Shift of each face inwards, in fixture sizes, so that rounding cannot make regions meet."""


def _faces(
    box: TouchBox | None, image_box: TouchBox | None, image_from_surface: Floats, point: Floats, length: float
) -> tuple[Floats, Floats]:
    """Normals (12, 3) and offsets (12,) of {x: normals x <= offsets}, x from point in units of length."""
    rotation, translation = image_from_surface[:3, :3], image_from_surface[:3, 3]
    low, high = _closed(box, point, length)
    image_low, image_high = _closed(image_box, rotation @ point + translation, length)
    normals = np.vstack([np.eye(3), -np.eye(3), rotation, -rotation])
    return normals, np.concatenate([high, -low, image_high, -image_low])


def _closed(box: TouchBox | None, point: Floats, length: float) -> tuple[Floats, Floats]:
    """The box about point in units of length, open sides closed far away, shrunk by _SHRINK (a thin box widened)."""
    low = np.full(3, -np.inf) if box is None else (box.low - point) / length
    high = np.full(3, np.inf) if box is None else (box.high - point) / length
    low, high = (
        np.maximum(low, np.minimum(-_OPEN_SIDE, high - _OPEN_SIDE)),
        np.minimum(high, np.maximum(_OPEN_SIDE, low + _OPEN_SIDE)),
    )
    middle, half = (low + high) / 2, (high - low) / 2
    half = np.maximum(half - _SHRINK, _SHRINK)
    return middle - half, middle + half


def _stationary(block: Floats, normals: Floats, offsets: Floats, sizes: tuple[int, ...]) -> Floats:
    """Feasible points (k, 3) that minimize |block x| on each intersection of that many of the faces.

    Solves [[block, N^T], [N, 0]] [x, multipliers] = [0, offsets] for every subset N of the faces; the least of a convex
    quadratic over a polytope is among them. With block = 0 and three faces these are the corners.
    """
    found = [np.zeros((0, 3))]
    for size in sizes:
        chosen = list(combinations(range(len(normals)), size))
        subsets = np.array(chosen, dtype=np.intp).reshape(len(chosen), size)
        system = np.zeros((len(subsets), 3 + size, 3 + size))
        system[:, :3, :3] = block
        system[:, :3, 3:] = np.swapaxes(normals[subsets], 1, 2)
        system[:, 3:, :3] = normals[subsets]
        right = np.concatenate([np.zeros((len(subsets), 3)), offsets[subsets]], axis=1)
        points = (np.linalg.pinv(system, rcond=1e-9, hermitian=True) @ right[..., None])[:, :3, 0]
        reach = _SYSTEM_ROUNDING * (1 + np.abs(points).max(axis=1, initial=0.0))
        found.append(points[(points @ normals.T <= offsets + reach[:, None]).all(axis=1)])
    return np.concatenate(found)
