"""All real zeros of trigonometric polynomials of degree three, for whole stacks, and whether that is certain.

1. On a grid of cells of width h, cubic Hermite interpolation has an error of at most h^4/384 max|g''''|. By Descartes'
   rule its Bernstein coefficients show whether a cell has no zero, exactly one, or possibly several.
2. Cells of the last kind are divided, twice.
3. A polynomial with a cell that is still undecided is marked as uncertain: it has, or nearly has, two zeros within
   about a thousandth of a rad.
4. Each zero is refined on the polynomial itself.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from tactfix.geometry.arrays import Bools, Floats, Ints
from tactfix.values import frozen_value

SLOTS = 6
"""Zeros of a trigonometric polynomial of degree three in one turn."""

CIRCLE_SAMPLES = 7
"""Values that determine a trigonometric polynomial of degree three."""
_CELLS, _PARTS, _DIVISIONS = 32, 12, 2
"""Number of cells of the circle, parts of each undecided cell, and divisions: cells of 0.08 degrees separate all
zeros that are not nearly double."""
_CUBIC_STEPS, _NEWTON_STEPS = 3, 2
"""Newton steps on the interpolating cubic, then on the polynomial itself: three and two reach the rounding of
doubles."""

_SINGLE, _DOUBLE = 2e-6, 1e-13
"""Rounding of a value relative to the amplitude, for the first grid in single precision, which is twice as fast, and in
double precision: about twenty and five hundred times the spacing of these numbers."""

_LAST_STEP, _LAST_HALLEY_STEP = 1e-5, 4e-4
"""Length in rad of a last step, of Newton's method and of Halley's: the error after it is its square, or its cube,
times a curvature that is moderate for simple zeros; either is below 1e-10."""

_FARTHEST = float(np.cos(np.pi / _CELLS))
"""Cosine of half a cell: if a zero moves farther from its interpolated place, it is another zero."""

_FOURTH = 81.0
"""Bound of |g''''| over the amplitude: the fourth power of the degree, 3."""


@frozen_value
class _Found:
    """Single zeros (r,), and open cells (d,) that may hold several.

    owner (r,), open_owner (d,): index of the polynomial; angle (r,): of the zero; open_start (d,): first edge of the
    cell, both in rad.
    """

    owner: Ints
    angle: Floats
    open_owner: Ints
    open_start: Floats


def trigonometric_zeros(samples: Floats, caution: float = 0.0) -> tuple[Floats, Bools]:
    """The zeros of trigonometric polynomials of degree three.

    samples (7, m): values at the angles 2 pi k / 7. caution: a polynomial that comes so close to zero without reaching
    it, relative to its amplitude, is uncertain. Returns the cosines and sines (2, 6, m) of the angles, nan in empty
    slots, in no order, and whether (m,) they are certainly all.
    """
    harmonics = _harmonics_from_samples() @ samples
    amplitude = np.sum(np.abs(harmonics), axis=0)
    single = (samples / amplitude).astype(np.float32)
    values, slopes = _grid()
    place = (np.arange(samples.shape[1]), None, 2 * np.pi / _CELLS)
    # Step 1.
    found = _sorted_cells(values @ single, slopes @ single, _SINGLE + caution, place)
    parts, width = [found], 2 * np.pi / _CELLS
    for _ in range(_DIVISIONS):  # step 2
        if not found.open_owner.size:
            break
        found = _divided(found, harmonics, amplitude, caution, width)
        width /= _PARTS
        parts.append(found)
    places, too_many = _slotted(parts, samples.shape[1])
    certain = np.ones(samples.shape[1], dtype=bool)
    certain[found.open_owner] = False  # step 3
    places, settled = _settled(places, harmonics)  # step 4
    return places, certain & settled & ~too_many


def _divided(found: _Found, harmonics: Floats, amplitude: Floats, caution: float, width: float) -> _Found:
    """The open cells of one level, divided and sorted."""
    owner, start = found.open_owner, found.open_start
    h = harmonics[:, owner]
    turned = [h[0]]
    for n in range(1, 4):
        cos, sin = np.cos(n * start), np.sin(n * start)
        turned += [h[2 * n - 1] * cos + h[2 * n] * sin, h[2 * n] * cos - h[2 * n - 1] * sin]
    local = np.stack(turned) / amplitude[owner]
    part = width / _PARTS
    values, slopes = _basis(part * np.arange(_PARTS + 1))
    return _sorted_cells(values @ local, part / 3 * (slopes @ local), _DOUBLE + caution, (owner, start, part))


def _sorted_cells(
    values: NDArray[np.floating],
    thirds: NDArray[np.floating],
    rounding: float,
    place: tuple[Ints, Floats | None, float],
) -> _Found:
    """Cells sorted into empty, holding one zero, and open.

    values, thirds (c + 1, k): at the edges of c cells, value, and slope times a third of the width of a cell, of
    polynomials of amplitude 1; place: the polynomial of each column, its first angle (None: 0), and that width.
    """
    owner, start, width = place
    left, right = values[:-1], values[1:]
    # Bernstein coefficients of the Hermite interpolant: left, near, far, right.
    near, far = left + thirds[:-1], right - thirds[1:]
    error = _FOURTH * width**4 / 384 + rounding
    flips = left * right < 0
    clear = (np.minimum(np.minimum(left, right), np.minimum(near, far)) > error) | (
        np.maximum(np.maximum(left, right), np.maximum(near, far)) < -error
    )
    rises = right > left
    single = (rises & ((near < -error) | (far > error))) | (~rises & ((near > error) | (far < -error)))
    single &= flips & (np.minimum(np.abs(left), np.abs(right)) > error)
    # Flat indices: those of two axes take five times as long.
    chosen = np.flatnonzero(single)
    cell, column = np.divmod(chosen, single.shape[1])
    t = _cubic_root(*(b.ravel().take(chosen).astype(np.float64) for b in (left, near, far, right)))
    open_cell, open_column = np.divmod(np.flatnonzero(~(clear | single)), single.shape[1])
    first, open_first = (0.0, 0.0) if start is None else (start[column], start[open_column])
    return _Found(
        owner[column],
        np.asarray(first + (cell + t) * width),
        owner[open_column],
        np.asarray(open_first + open_cell * width),
    )


def _cubic_root(b0: Floats, b1: Floats, b2: Floats, b3: Floats) -> Floats:
    """The approximate only zero (r,) in 0..1 of cubics with these Bernstein coefficients: Newton within a bracket."""
    c1, c2, c3 = 3 * (b1 - b0), 3 * (b0 - 2 * b1 + b2), b3 - b0 + 3 * (b1 - b2)
    t = b0 / (b0 - b3)
    low, high = np.zeros_like(t), np.ones_like(t)
    falls = b0 > 0
    for _ in range(_CUBIC_STEPS):
        value = b0 + t * (c1 + t * (c2 + t * c3))
        before = (value > 0) == falls
        low, high = np.where(before, t, low), np.where(before, high, t)
        t = t - value / (c1 + t * (2 * c2 + 3 * t * c3))
        t = np.where((t >= low) & (t <= high), t, 0.5 * (low + high))
    return t


def _slotted(parts: list[_Found], count: int) -> tuple[Floats, Bools]:
    """The zeros of all levels as points (2, 6, count) of the circle, by polynomial, and which (count,) exceed SLOTS."""
    owner = np.concatenate([part.owner for part in parts])
    angle = np.concatenate([part.angle for part in parts])
    # Sixteen bits are sorted by radix, ten times faster.
    order = np.argsort(owner.astype(np.uint16) if count <= 1 << 16 else owner, kind="stable")
    owner, place = owner.take(order), _cos_sin(angle.take(order))
    number = np.bincount(owner, minlength=count)
    rank = np.arange(len(owner)) - np.repeat(np.cumsum(number) - number, number)
    fits = rank < SLOTS
    slot = (rank * count + owner)[fits]
    places = np.full((2, SLOTS * count), np.nan)
    places[0, slot], places[1, slot] = place[0, fits], place[1, fits]
    return places.reshape(2, SLOTS, count), number > SLOTS


def _cos_sin(angles: Floats) -> Floats:
    """Cosine and sine (2, r) of angles 0..2 pi, from a table and a turn by less than half a cell.

    Several times faster than numpy's, with errors of 1e-11, which the next Newton step removes.
    """
    nearest = np.rint(angles * (_CELLS / (2 * np.pi))).astype(np.intp)
    return _turned(_corners()[:, nearest], angles - nearest * (2 * np.pi / _CELLS))


def _turned(places: Floats, angle: Floats) -> Floats:
    """Points (2, ...) of the circle, turned by small angles (...)."""
    square = angle * angle
    sin = angle * (1 - square * (1 / 6 - square * (1 / 120)))
    cos = 1 - square * (0.5 - square * (1 / 24 - square * (1 / 720)))
    return np.stack([places[0] * cos - places[1] * sin, places[1] * cos + places[0] * sin])


def _settled(places: Floats, harmonics: Floats) -> tuple[Floats, Bools]:
    """The points (2, 6, m) after Halley's step, or further Newton steps, and which polynomials (m,) have converged."""
    reached, step = _halley(places, harmonics)
    # nan compares false: an empty slot has nothing left to settle.
    slow = np.flatnonzero(np.any(np.abs(step) > _LAST_HALLEY_STEP, axis=0))
    # The dot product is the cosine of the displacement.
    arrived = ~np.any(reached[0] * places[0] + reached[1] * places[1] < _FARTHEST, axis=0)
    if slow.size:
        begun = reached[:, :, slow]
        ended, step = _newton(begun, harmonics[:, slow])
        strayed = ended[0] * begun[0] + ended[1] * begun[1] < _FARTHEST
        arrived[slow] &= ~np.any((np.abs(step) > _LAST_STEP) | strayed, axis=0)
        reached[:, :, slow] = ended
    return reached, arrived


def _halley(places: Floats, harmonics: Floats) -> tuple[Floats, Floats]:
    """The points (2, 6, m) after one step of Halley's method, and the step in rad."""
    value, slope, curvature = _derivatives(places, harmonics[:, None])
    step = np.clip(2 * value * slope / (2 * slope * slope - value * curvature), -0.2, 0.2)
    return _on_the_circle(_turned(places, -step)), step


def _on_the_circle(places: Floats) -> Floats:
    """Points (2, ...) near the circle, projected onto it: rounding and truncated series have moved them."""
    return np.asarray(places * (1.5 - 0.5 * (places[0] * places[0] + places[1] * places[1])))


def _newton(places: Floats, harmonics: Floats) -> tuple[Floats, Floats]:
    """The points (2, 6, m) after a few Newton steps, and the last of the steps in rad."""
    k, step = harmonics[:, None], np.zeros_like(places[0])
    for _ in range(_NEWTON_STEPS):
        value, slope, _ = _derivatives(places, k)
        step = np.clip(value / slope, -0.2, 0.2)
        places = _on_the_circle(_turned(places, -step))
    return places, step


def _derivatives(places: Floats, k: Floats) -> tuple[Floats, Floats, Floats]:
    """Value, slope and curvature (6, m) of the polynomials with harmonics k (7, 1, m) at places (2, 6, m)."""
    c, s = places
    c2, s2 = c * c - s * s, 2 * c * s
    c3, s3 = c * c2 - s * s2, s * c2 + c * s2
    first, second, third = k[1] * c + k[2] * s, k[3] * c2 + k[4] * s2, k[5] * c3 + k[6] * s3
    slope = k[2] * c - k[1] * s + 2 * (k[4] * c2 - k[3] * s2) + 3 * (k[6] * c3 - k[5] * s3)
    return k[0] + first + second + third, slope, -first - 4 * second - 9 * third


@cache
def _corners() -> Floats:
    """Cosine and sine (2, cells + 1) of the edges of the cells."""
    angles = 2 * np.pi * np.arange(_CELLS + 1) / _CELLS
    return np.stack([np.cos(angles), np.sin(angles)])


def _basis(angles: NDArray[np.floating]) -> tuple[Floats, Floats]:
    """Values and slopes (k, 7) of the harmonics 1, cos t, sin t, cos 2t, sin 2t, cos 3t, sin 3t at angles (k,)."""
    n = np.arange(1, 4)
    cos, sin = np.cos(np.outer(angles, n)), np.sin(np.outer(angles, n))
    values, slopes = np.ones((len(angles), CIRCLE_SAMPLES)), np.zeros((len(angles), CIRCLE_SAMPLES))
    values[:, 1::2], values[:, 2::2] = cos, sin
    slopes[:, 1::2], slopes[:, 2::2] = -n * sin, n * cos
    return values, slopes


@cache
def _harmonics_from_samples() -> Floats:
    """The matrix (7, 7) from samples to the coefficients of the harmonics."""
    return np.asarray(np.linalg.inv(_basis(2 * np.pi * np.arange(CIRCLE_SAMPLES) / CIRCLE_SAMPLES)[0]))


@cache
def _grid() -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Matrices (cells + 1, 7) from samples to values, and to slopes times a third of a cell, once around."""
    values, slopes = _basis(2 * np.pi * np.arange(_CELLS + 1) / _CELLS)
    matrix = _harmonics_from_samples()
    third = 2 * np.pi / _CELLS / 3
    return (values @ matrix).astype(np.float32), (slopes @ matrix * third).astype(np.float32)
