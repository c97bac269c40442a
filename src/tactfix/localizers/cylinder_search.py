"""Starting axes for cylinders through any number of contacts, so that no local minimum that matters is missed.

1. A cylinder that explains all contacts explains any five of them (any four if the radius is known). So the zeros of a
   minimal subset are starts: real zeros, and the real part of a pair that noise has made complex.
2. The zeros of further subsets add cylinders that the first subset does not distinguish from others.
3. If no cylinder explains the contacts, the best circle along each direction of a covering leads to the least-squares
   optimum.
"""

from collections.abc import Callable, Iterator
from functools import cache

import numpy as np

from tactfix.geometry.arrays import EPS, Floats, Ints, basis_across
from tactfix.localizers.axis_directions import direction_zeros, tangent_zeros
from tactfix.localizers.cylinder_refinement import circle_states
from tactfix.localizers.homogeneous_forms import Complexes
from tactfix.localizers.unit_contacts import RATIO

CYLINDER_CONTACTS, FREE_CYLINDER_CONTACTS = 4, 5
"""Contacts that leave finitely many cylinders of known radius, and of free radius."""

_SUBSETS = 2
"""Minimal subsets whose zeros are starts: one of contacts far apart, and one chosen without regard to place, in case
the first is in special position."""

_COVERING_DIRECTIONS = 160
"""Directions of the covering: neighbours are 10 degrees apart, half the least angle at which two local minima were
seen."""

_DEEPEST, _STRIDE = 6, 10
"""Directions of the covering that are refined: the _DEEPEST lowest minima, and every _STRIDE-th."""

_MUCH_NOISE, _SHORT_STRIDE = 5e-3, 2
"""The stride is short if sigma exceeds _MUCH_NOISE of the contacts' extent: then the minima of the circle fit can miss
those of the cylinder fit. Of 7,972 cylinders that noise explained six were missed with the long stride, one with
the short one."""

_DEGENERATE_GAP = 1e-4
"""Gap of `common_zeros` below which the zeros may form a curve, or be multiple: rounding of 1e-16 then moves a zero
by 1e-12."""

_OBLIQUE = np.array([0.48, 0.6, 0.64])
"""A unit vector in general position: the sign of its product with the imaginary part selects one of a complex pair."""

_CONTACT_NUDGE = 1e-5
"""Standard deviation by which contacts of nearly degenerate subsets are displaced, in units of their extent: the
zeros are then isolated, and a multiple one is off by its root, 3e-3, near enough for the least squares."""


def starting_states(points: Floats, weights: Floats, radius: float | None, sigma: float) -> Iterator[Floats]:
    """Two batches of states (B, 7) from which `CylinderProblem.refined` reaches every cylinder through the contacts.

    The zeros of one minimal subset lead to all well determined ones; the second batch leads to the others. A minimal
    set has no second batch. points (n, 3) of unit size about their mean, in the order of `farthest_first`, n >= 5, or
    n >= 4 with radius; weights (n,); sigma: of the contacts.
    """
    size = CYLINDER_CONTACTS if radius is not None else FREE_CYLINDER_CONTACTS
    first, *others = _minimal_subsets(points, size)
    yield _usable(_states_through(points[first], points, weights, radius))
    if len(points) > size:  # steps 2 and 3, after step 1
        stride = _SHORT_STRIDE if sigma > _MUCH_NOISE else _STRIDE
        more = [_states_through(points[subset], points, weights, radius) for subset in others]
        yield _usable(np.concatenate([*more, _covering_states(points, weights, radius, stride)]))


def _usable(states: Floats) -> Floats:
    return np.asarray(states[np.isfinite(states).all(axis=1)])


def _states_through(subset: Floats, points: Floats, weights: Floats, radius: float | None) -> Floats:
    """States (B, 7) near the cylinders through a minimal subset (m, 3) of the contacts; empty if it is collinear."""
    spread = np.linalg.svd(subset - subset.mean(axis=0), compute_uv=False)
    if spread[1] <= RATIO * spread[0]:
        return np.zeros((0, 7))
    if radius is None:
        directions, _ = real_directions(lambda x, _: direction_zeros(x), subset[None])
        return circle_states(directions, points, weights)
    return tangent_states(subset[None], np.full((1, len(subset)), radius))


def tangent_states(centers: Floats, radii: Floats) -> Floats:
    """States (B, 7) near all lines at distances radii (k, 4) from centers (k, 4, 3), with the radius of the first.

    Each direction gives two feet: linear equations give the foot along the wider spread of the projected centres; along
    the narrower one they may give it only up to a sign.
    """
    directions, owner = real_directions(lambda x, number: tangent_zeros(x, radii[number]), centers)
    across = basis_across(directions)
    middle = centers.mean(axis=1)[owner]
    flat = (centers[owner] - middle[:, None]) @ np.swapaxes(across, -1, -2)
    u, singular, vh = np.linalg.svd(flat, full_matrices=False)
    squared = np.sum(flat**2, axis=-1) - radii[owner] ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        wide = np.einsum("bn,bn->b", u[:, :, 0], squared) / (2 * singular[:, 0])
    narrow = np.sqrt(np.maximum(-squared.mean(axis=-1) - wide**2, 0.0))
    parts = []
    for sign in (1.0, -1.0):
        place = wide[:, None] * vh[:, 0] + sign * narrow[:, None] * vh[:, 1]
        foot = middle + np.einsum("bi,bij->bj", place, across)
        foot -= np.sum(foot * directions, axis=-1, keepdims=True) * directions
        parts.append(np.concatenate([foot, directions, radii[owner, :1]], axis=-1))
    return np.concatenate(parts)


def real_directions(zeros: Callable[[Floats, Ints], tuple[Complexes, Floats]], subsets: Floats) -> tuple[Floats, Ints]:
    """Unit real parts (B, 3) of the zeros of all subsets (k, m, 3), and the index (B,) of the subset of each.

    zeros is called with subsets and their indices. For nearly degenerate subsets the zeros of a copy with displaced
    contacts are added.
    """
    found, gap = zeros(subsets, np.arange(len(subsets)))
    parts, owners = [found], [np.arange(len(subsets))]
    degenerate = np.flatnonzero(gap < _DEGENERATE_GAP)
    if degenerate.size:
        nudges = np.random.default_rng(5).normal(scale=_CONTACT_NUDGE, size=subsets[degenerate].shape)
        parts.append(zeros(subsets[degenerate] + nudges, degenerate)[0])
        owners.append(degenerate)
    every = np.concatenate(parts)
    owner = np.repeat(np.concatenate(owners), every.shape[1])
    every = every.reshape(-1, 3)
    # The two zeros of a complex pair have the same real part: one of them is kept.
    length = np.linalg.norm(every.real, axis=-1)
    usable = (length > 0) & (every.imag @ _OBLIQUE >= -EPS)
    return every.real[usable] / length[usable, None], owner[usable]


def _minimal_subsets(points: Floats, size: int) -> list[Ints]:
    """Indices (size,) of the first contacts, which are far from each other, then of others without regard to place."""
    first = np.arange(size)
    if len(points) == size:
        return [first]
    index = np.arange(1, len(points) + 1)
    # Pseudo-random, but without numpy.random, whose import takes longer than the search.
    blind = [np.sort(np.argsort(index**2 * (40503 + k) % 65537, kind="stable")[:size]) for k in range(1, _SUBSETS)]
    return [first, *(subset for subset in blind if (subset != first).any())]


def _covering_states(points: Floats, weights: Floats, radius: float | None, stride: int) -> Floats:
    """States (B, 7) of the covering: the lowest minima of the circle fit over the directions, and every stride-th."""
    directions, neighbours = _covering()
    states = circle_states(directions, points, weights)
    if radius is not None:
        states = _at_radius(states, points, radius)
    arms = points - states[:, None, :3]
    along = np.einsum("bni,bi->bn", arms, states[:, 3:6])
    distance = np.sqrt(np.maximum(np.sum(arms**2, axis=-1) - along**2, 0.0))
    cost = np.sum((weights * (distance - states[:, 6:])) ** 2, axis=1)
    cost = np.where(np.isfinite(cost), cost, np.inf)
    minima = np.flatnonzero(cost <= cost[neighbours].min(axis=1))
    deepest = minima[np.argsort(cost[minima])[:_DEEPEST]]
    followed = np.arange(_COVERING_DIRECTIONS) % stride == 0
    followed[deepest] = True
    return np.asarray(states[followed])


def _at_radius(states: Floats, points: Floats, radius: float) -> Floats:
    """The states with the known radius; each axis is moved so that an arc of contacts stays on the surface."""
    middle = points.mean(axis=0)
    away = states[:, :3] - (middle - np.sum(states[:, 3:6] * middle, axis=1, keepdims=True) * states[:, 3:6])
    moved = states.copy()
    # From the contacts' mean to the axis: as long as the radius for a short arc, zero for contacts all around.
    moved[:, :3] += (radius / states[:, 6:] - 1.0) * away
    moved[:, 6] = radius
    return moved


@cache
def _covering() -> tuple[Floats, Ints]:
    """Evenly spread directions (k, 3), one of each opposite pair, and the six neighbours (k, 6) of each."""
    index = np.arange(_COVERING_DIRECTIONS)
    z = (index + 0.5) / _COVERING_DIRECTIONS
    angle = index * np.pi * (3.0 - np.sqrt(5.0))
    flat = np.sqrt(1 - z**2)
    directions = np.column_stack([flat * np.cos(angle), flat * np.sin(angle), z])
    nearness = np.abs(directions @ directions.T)
    np.fill_diagonal(nearness, -1.0)
    return directions, np.argsort(-nearness, axis=1)[:, :6]
