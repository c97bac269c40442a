"""The placement of a fixture in the check of its design: motions that it constrains, symmetries that it excludes.

The fixture is checked at the pose near, which is known roughly, and so are the directions of base's axes in the
fixture. So a motion is constrained if all but a small part of it (KNOWN_SHARE) is, and a feature whose displacement by
a free motion is as small does not constrain it.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from tactfix.design.symmetries import Symmetry
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import inverse
from tactfix.placement import Placement
from tactfix.poses.placement_terms import search_limits
from tactfix.poses.prior import deviation

KNOWN_SHARE: Final = 0.02
"""Rad, and share of the fixture's size: about a degree, the uncertainty of the rotation of a rough pose."""


def unknowns(placement: Placement | None) -> int:
    """The number of unknowns of the pose."""
    return 6 if placement is None else int(placement.turns.sum() + placement.shifts.sum())


def left_free(twists: Floats, placement: Placement | None, size: float) -> Floats:
    """Of motions (k, 6), twists at the fixture's origin, a basis (j, 6) of those that placement leaves free.

    A measured pose constrains none of them exactly. size: of the fixture (length).
    """
    if placement is None or not len(twists):
        return twists
    to_angles = np.array([1.0] * 3 + [1 / (size or 1.0)] * 3)
    motions = np.linalg.qr((twists * to_angles).T)[0]
    free = _free_axes(placement)
    _, off, mixtures = np.linalg.svd(motions - free @ (free.T @ motions))
    kept = (motions @ mixtures[off <= KNOWN_SHARE].T).T
    return np.asarray(kept / to_angles)


def _free_axes(placement: Placement) -> Floats:
    """The unconstrained rotations and translations (6, u) along base's axes, in fixture coordinates."""
    rotation = placement.near[:3, :3]
    axes = np.zeros((6, 6))
    axes[:3, :3] = axes[3:, 3:] = rotation.T
    return axes[:, np.concatenate([placement.turns, placement.shifts])]


def settled(found: Sequence[Symmetry], placement: Placement | None, size: float) -> tuple[Symmetry, ...]:
    """The symmetries, those that the placement excludes broken by it unless they are broken otherwise."""
    if placement is None:
        return tuple(found)
    return tuple(_settled(symmetry) if _excludes(placement, symmetry, size) else symmetry for symmetry in found)


def _settled(symmetry: Symmetry) -> Symmetry:
    return replace(symmetry, broken_by=symmetry.broken_by or "placement", partly=(), confusable=False)


def _excludes(placement: Placement, symmetry: Symmetry, size: float) -> bool:
    """Whether the placement allows only one of two poses that a symmetry takes into each other.

    Two poses within the limits differ by at most twice the limits.
    """
    off = deviation(placement, placement.near @ inverse(symmetry.image_from_fixture))
    turn, shift = float(np.linalg.norm(off[:3])), float(np.linalg.norm(off[3:]))
    most_turn, most_shift = search_limits(placement, 6)
    if turn > 2 * most_turn or shift > 2 * most_shift:
        return True
    turned, shifted = np.abs(off[:3][~placement.turns]), np.abs(off[3:][~placement.shifts])
    return bool((turned > KNOWN_SHARE).any() or (shifted > KNOWN_SHARE * (size or 1.0)).any())
