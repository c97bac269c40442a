"""Real common zeros of a conic and a cubic, for whole stacks of pairs: fast, with a mark where they may be incomplete.

1. The conic is a circle in the right coordinates: s(t) = a cos t + b sin t + c (`conic_circle`).
2. On it the cubic is a trigonometric polynomial of degree three in t, so seven samples give its values and slopes
   anywhere. `trigonometric_zeros` finds its zeros and marks polynomials for which they may be incomplete.
3. Newton steps on both equations refine each zero.
4. A pair is complete if all of these steps are certain. The others are left to a slower method, so that no zero is lost
   unnoticed.

Arrays are components first, (k, m) for m pairs, which keeps every operation contiguous.
"""

import numpy as np

from tactfix.geometry.arrays import Bools, Floats
from tactfix.stacks.conic_circle import circle_of_conic, conic_value_and_gradient
from tactfix.stacks.trigonometric_zeros import CIRCLE_SAMPLES, trigonometric_zeros
from tactfix.values import frozen_value

_FAR, _MORE_STEPS = 1e-8, 3
"""Length of a Newton step in rad after which another one follows, and how many at most. The error after a step is its
square times the curvature, 1e-16 for simple zeros, more where zeros are close together."""


@frozen_value
class CommonZeros:
    """zeros (3, 6, m), unit vectors, nan in empty slots; complete (m,): whether these are certainly all of a pair."""

    zeros: Floats
    complete: Bools


def real_common_zeros(conic: Floats, cubic: Floats, caution: float = 0.0) -> CommonZeros:
    """The real points that a conic and a cubic share, for m pairs.

    conic (6, m): coefficients of x^2, y^2, z^2, xy, xz, yz; cubic (7, m): of x^2 y, x y^2, x^2 z, x z^2, y^2 z, y z^2,
    xyz (a cubic through the corners of the frame has no others). caution: a pair is not complete if its cubic comes so
    close to zero, relative to its amplitude, without reaching it, or its conic to a pair of lines.
    """
    circle, real, clear = circle_of_conic(conic, caution)  # step 1
    places, complete = trigonometric_zeros(_samples(circle, cubic), caution)  # step 2
    places[:, :, ~real] = np.nan
    zeros, arrived = _settled(_on_circle(circle[:, :, None], places), conic, cubic)  # step 3
    return CommonZeros(zeros, ((complete & arrived) | ~real) & clear)  # step 4


def _samples(circle: Floats, cubic: Floats) -> Floats:
    """The cubic (7, m) at seven even angles of the circle (3, 3, m: the vectors a, b, c)."""
    angles = 2 * np.pi * np.arange(CIRCLE_SAMPLES) / CIRCLE_SAMPLES
    return _cubic_value(_on_circle(circle[:, :, None], np.stack([np.cos(angles), np.sin(angles)])[:, :, None]), cubic)


def _on_circle(circle: Floats, places: Floats) -> Floats:
    """The points (3, k, m) a cos t + b sin t + c for cosines and sines (2, k, m)."""
    return np.asarray(circle[0] * places[0] + circle[1] * places[1] + circle[2])


def _cubic_value(s: Floats, cubic: Floats) -> Floats:
    x, y, z = s
    k = cubic[:, None] if s.ndim > 2 else cubic
    return np.asarray(
        x * y * (k[0] * x + k[1] * y + k[6] * z) + z * (x * (k[2] * x + k[3] * z) + y * (k[4] * y + k[5] * z))
    )


def _settled(zeros: Floats, conic: Floats, cubic: Floats) -> tuple[Floats, Bools]:
    """The unit vectors (3, 6, m) after a Newton step, or a few where it was long; and whether (m,) the last was not."""
    settled, gone = _polished(zeros, conic, cubic)
    # nan compares false: an empty slot has nothing left to settle.
    far = np.flatnonzero(np.any(gone > _FAR * _FAR, axis=0))
    for _ in range(_MORE_STEPS):
        settled[:, :, far], gone = _polished(settled[:, :, far], conic[:, far], cubic[:, far])
        far = far[np.any(gone > _FAR * _FAR, axis=0)]
    arrived = np.ones(zeros.shape[2], dtype=bool)
    arrived[far] = False
    return settled, arrived


def _polished(s: Floats, conic: Floats, cubic: Floats) -> tuple[Floats, Floats]:
    """The unit vectors (3, 6, m) after one Newton step on both equations, square to s, and its square (6, m)."""
    x, y, z = s
    k = cubic[:, None]
    f, (fx, fy, fz) = conic_value_and_gradient(s, conic[:, None])
    g = _cubic_value(s, cubic)
    gx = y * (2 * k[0] * x + k[1] * y + k[6] * z) + z * (2 * k[2] * x + k[3] * z)
    gy = x * (k[0] * x + 2 * k[1] * y + k[6] * z) + z * (2 * k[4] * y + k[5] * z)
    gz = k[6] * x * y + x * (k[2] * x + 2 * k[3] * z) + y * (k[4] * y + 2 * k[5] * z)
    # Solve grad f . d = -f, grad g . d = -g, s . d = 0 by cross products.
    ux, uy, uz = gy * z - gz * y, gz * x - gx * z, gx * y - gy * x
    vx, vy, vz = y * fz - z * fy, z * fx - x * fz, x * fy - y * fx
    det = fx * ux + fy * uy + fz * uz
    p, q = -f / det, -g / det
    dx, dy, dz = p * ux + q * vx, p * uy + q * vy, p * uz + q * vz
    x, y, z = x + dx, y + dy, z + dz
    shrink = 1.0 / (x * x + y * y + z * z)
    scale = np.sqrt(shrink)
    return np.stack([x * scale, y * scale, z * scale]), (dx * dx + dy * dy + dz * dz) * shrink
