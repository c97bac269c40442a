"""Real common zeros of a conic and a cubic, for whole stacks of pairs; pairs that may be incomplete are marked.

1. The conic becomes a circle: s(t) = a cos t + b sin t + c runs over all its real points (`_circle_of_conic`).
   a. The eigenvector whose eigenvalue differs in sign from the other two gives the direction of c.
   b. A rotation about it turns any two perpendicular axes into the other two eigenvectors.
   c. The conic has real points if their eigenvalues both have the other sign. If an eigenvalue is nearly zero, the
      conic is nearly a pair of lines, and this is not certain.
   d. Along the eigenvectors a, b, c are as long as the roots of the smallest eigenvalue over theirs.
2. On it the cubic is a trigonometric polynomial of degree three in t, so seven samples give its values and slopes
   anywhere. `trigonometric_zeros` finds its zeros and marks polynomials for which they may be incomplete.
3. Newton steps on both equations refine each zero.
4. A pair is complete if all of these steps are certain. The others are solved by a slower method.

Components are the first axis of all arrays, (k, m) for m pairs, so that every operation is contiguous.
"""

import numpy as np

from tactfix.geometry.arrays import Bools, Floats, basis_across
from tactfix.stacks.trigonometric_zeros import CIRCLE_SAMPLES, trigonometric_zeros
from tactfix.values import frozen_value

_FAR, _MORE_STEPS = 1e-8, 3
"""Length of a Newton step in rad after which another one follows, and how many at most. The error after a step is its
square times the curvature, 1e-16 for simple zeros, more where zeros are close together."""


_PAIR_OF_LINES = 1e-7
"""Smallest eigenvalue of a conic that is not a pair of lines, as a share of the sum of absolute eigenvalues: far above
rounding, and the points of a flatter conic lose half of the digits."""


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
    circle, real, clear = _circle_of_conic(conic, caution)  # step 1
    places, complete = trigonometric_zeros(_samples(circle, cubic), caution)  # step 2
    places[:, :, ~real] = np.nan
    zeros, arrived = _settled(_on_circle(circle[:, :, None], places), conic, cubic)  # step 3
    return CommonZeros(zeros, ((complete & arrived) | ~real) & clear)  # step 4


def _circle_of_conic(k: Floats, caution: float) -> tuple[Floats, Bools, Bools]:
    """The vectors a, b, c (3, 3, m) of s(t) = a cos t + b sin t + c for conics k (6, m).

    In the frame of its eigenvectors a conic is l_a x^2 + l_b y^2 = -l_c z^2, with l_c the eigenvalue of the other sign;
    if all signs agree, it has no real point. The longest of the vectors has unit length. Returns also whether (m,) the
    conic is real, and whether that is certain: near a pair of lines it is not. caution: added to the relative distance
    from a pair of lines below which it is uncertain.
    """
    lone = _lone_eigenvector(k)  # step a
    u, v = np.moveaxis(basis_across(lone.T), 0, -1)
    l_c = _form(k, lone, lone)
    uu, uv, vv = _form(k, u, u), _form(k, u, v), _form(k, v, v)
    difference, middle = 0.5 * (uu - vv), 0.5 * (uu + vv)
    half = np.sqrt(difference * difference + uv * uv)
    # Step b: half of the angle whose cosine is difference / half; a round pair has none, and needs none.
    double = np.divide(difference, half, out=np.ones_like(half), where=half > 0)
    cos, sin = np.sqrt(0.5 * (1 + double)), np.copysign(np.sqrt(0.5 * (1 - double)), uv)
    l_a, l_b = middle + half, middle - half
    # Step c.
    real = (l_a * l_c < 0) & (l_b * l_c < 0)
    smallest = np.minimum(np.minimum(np.abs(l_a), np.abs(l_b)), np.abs(l_c))
    clear = smallest > (_PAIR_OF_LINES + caution) * (np.abs(l_a) + np.abs(l_b) + np.abs(l_c))
    with np.errstate(divide="ignore", invalid="ignore"):  # step d
        a, b, c = (np.sqrt(smallest / np.abs(value)) for value in (l_a, l_b, l_c))
    return np.stack([a * (cos * u + sin * v), b * (cos * v - sin * u), c * lone]), real, clear


def _form(k: Floats, s: Floats, t: Floats) -> Floats:
    """The bilinear form s^T K t of conics k (6, m)."""
    diagonal = k[0] * s[0] * t[0] + k[1] * s[1] * t[1] + k[2] * s[2] * t[2]
    mixed = k[3] * (s[0] * t[1] + s[1] * t[0]) + k[4] * (s[0] * t[2] + s[2] * t[0]) + k[5] * (s[1] * t[2] + s[2] * t[1])
    return np.asarray(diagonal + 0.5 * mixed)


def _lone_eigenvector(k: Floats) -> Floats:
    """The unit eigenvector (3, m) whose eigenvalue differs in sign from the others: the largest or the smallest."""
    xx, yy, zz, xy, xz, yz = k[0], k[1], k[2], 0.5 * k[3], 0.5 * k[4], 0.5 * k[5]
    mean = (xx + yy + zz) / 3
    ax, ay, az = xx - mean, yy - mean, zz - mean
    spread = np.sqrt((ax * ax + ay * ay + az * az + 2 * (xy * xy + xz * xz + yz * yz)) / 6)
    det = ax * (ay * az - yz * yz) - xy * (xy * az - yz * xz) + xz * (xy * yz - ay * xz)
    with np.errstate(divide="ignore", invalid="ignore"):
        third = np.arccos(np.clip(det / (2 * spread**3), -1.0, 1.0)) / 3
    cos = np.cos(third)
    largest = mean + 2 * spread * cos
    smallest = mean - spread * (cos + np.sqrt(3 * (1 - cos * cos)))
    # The middle eigenvalue has the sign of the two that agree.
    value = np.where(3 * mean - largest - smallest > 0, smallest, largest)
    return _null_vector(xx - value, yy - value, zz - value, xy, xz, yz)


def _null_vector(xx: Floats, yy: Floats, zz: Floats, xy: Floats, xz: Floats, yz: Floats) -> Floats:
    """The unit null vector (3, m) of symmetric matrices of rank two: the longest column of the adjugate."""
    a, b, c = yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy
    d, e, f = xz * yz - xy * zz, xy * yz - xz * yy, xy * xz - xx * yz
    # The diagonal of an adjugate of rank one is the squares of the vector.
    a2, b2, c2 = np.abs(a), np.abs(b), np.abs(c)
    first, second = (a2 >= b2) & (a2 >= c2), b2 >= c2
    x = np.where(first, a, np.where(second, d, e))
    y = np.where(first, d, np.where(second, b, f))
    z = np.where(first, e, np.where(second, f, c))
    scale = 1.0 / np.sqrt(x * x + y * y + z * z)
    return np.stack([x * scale, y * scale, z * scale])


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
    """The unit vectors (3, 6, m) after Newton steps until they are short, and whether (m,) they have become so."""
    settled, gone = _polished(zeros, conic, cubic)
    # nan compares false: an empty slot has nothing left to settle.
    far = np.flatnonzero(np.any(gone > _FAR * _FAR, axis=0))
    for _ in range(_MORE_STEPS):
        settled[:, :, far], gone = _polished(settled[:, :, far], conic[:, far], cubic[:, far])
        far = far[np.any(gone > _FAR * _FAR, axis=0)]
    arrived = np.ones(zeros.shape[2], dtype=bool)
    arrived[far] = False
    return settled, arrived


def _conic_value_and_gradient(s: Floats, k: Floats) -> tuple[Floats, tuple[Floats, Floats, Floats]]:
    """The conics k (6, ...: x^2, y^2, z^2, xy, xz, yz) and their gradients at s (3, ...)."""
    x, y, z = s
    fx = 2 * k[0] * x + k[3] * y + k[4] * z
    fy = k[3] * x + 2 * k[1] * y + k[5] * z
    fz = k[4] * x + k[5] * y + 2 * k[2] * z
    return 0.5 * (x * fx + y * fy + z * fz), (fx, fy, fz)


def _polished(s: Floats, conic: Floats, cubic: Floats) -> tuple[Floats, Floats]:
    """The unit vectors (3, 6, m) after one Newton step on both equations, and its squared length (6, m)."""
    x, y, z = s
    k = cubic[:, None]
    f, (fx, fy, fz) = _conic_value_and_gradient(s, conic[:, None])
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
