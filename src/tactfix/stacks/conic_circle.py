"""A conic as a circle: s(t) = a cos t + b sin t + c runs over all its real points, for whole stacks of conics.

1. The eigenvector whose eigenvalue differs in sign from the other two gives the direction of c.
2. A rotation about it turns any two perpendicular axes into the other two eigenvectors.
3. The conic has real points if their eigenvalues both have the other sign. If an eigenvalue is nearly zero, the conic
   is nearly a pair of lines, and this is not certain.
4. Along the eigenvectors a, b, c are as long as the roots of the smallest eigenvalue over theirs.
"""

import numpy as np

from tactfix.geometry.arrays import Bools, Floats, basis_across

_PAIR_OF_LINES = 1e-7
"""Smallest eigenvalue of a conic that is not a pair of lines, as a share of the sum of absolute eigenvalues: far above
rounding, and the points of a flatter conic lose half of the digits."""


def conic_value_and_gradient(s: Floats, k: Floats) -> tuple[Floats, tuple[Floats, Floats, Floats]]:
    """The conics k (6, ...: x^2, y^2, z^2, xy, xz, yz) and their gradients at s (3, ...)."""
    x, y, z = s
    fx = 2 * k[0] * x + k[3] * y + k[4] * z
    fy = k[3] * x + 2 * k[1] * y + k[5] * z
    fz = k[4] * x + k[5] * y + 2 * k[2] * z
    return 0.5 * (x * fx + y * fy + z * fz), (fx, fy, fz)


def circle_of_conic(k: Floats, caution: float) -> tuple[Floats, Bools, Bools]:
    """The vectors a, b, c (3, 3, m) of s(t) = a cos t + b sin t + c for conics k (6, m).

    In the frame of its eigenvectors a conic is l_a x^2 + l_b y^2 = -l_c z^2, with l_c the eigenvalue whose sign is
    alone; if all signs agree, it has no real point. The longest of the vectors has unit length. Returns also whether
    (m,) the conic is real, and whether that is certain: near a pair of lines it is not, and most of the conic is at one
    place of the circle. caution: relative distance from a pair of lines that counts as uncertain beyond rounding.
    """
    lone = _lone_eigenvector(k)  # step 1
    u, v = np.moveaxis(basis_across(lone.T), 0, -1)
    l_c = _form(k, lone, lone)
    uu, uv, vv = _form(k, u, u), _form(k, u, v), _form(k, v, v)
    difference, middle = 0.5 * (uu - vv), 0.5 * (uu + vv)
    half = np.sqrt(difference * difference + uv * uv)
    # Step 2: half of the angle whose cosine is difference / half; a round pair has none, and needs none.
    double = np.divide(difference, half, out=np.ones_like(half), where=half > 0)
    cos, sin = np.sqrt(0.5 * (1 + double)), np.copysign(np.sqrt(0.5 * (1 - double)), uv)
    l_a, l_b = middle + half, middle - half
    # Step 3.
    real = (l_a * l_c < 0) & (l_b * l_c < 0)
    smallest = np.minimum(np.minimum(np.abs(l_a), np.abs(l_b)), np.abs(l_c))
    clear = smallest > (_PAIR_OF_LINES + caution) * (np.abs(l_a) + np.abs(l_b) + np.abs(l_c))
    with np.errstate(divide="ignore", invalid="ignore"):  # step 4
        a, b, c = (np.sqrt(smallest / np.abs(value)) for value in (l_a, l_b, l_c))
    return np.stack([a * (cos * u + sin * v), b * (cos * v - sin * u), c * lone]), real, clear


def _form(k: Floats, s: Floats, t: Floats) -> Floats:
    """The bilinear form s^T K t of conics k (6, m)."""
    diagonal = k[0] * s[0] * t[0] + k[1] * s[1] * t[1] + k[2] * s[2] * t[2]
    mixed = k[3] * (s[0] * t[1] + s[1] * t[0]) + k[4] * (s[0] * t[2] + s[2] * t[0]) + k[5] * (s[1] * t[2] + s[2] * t[1])
    return np.asarray(diagonal + 0.5 * mixed)


def _lone_eigenvector(k: Floats) -> Floats:
    """The unit eigenvector (3, m) whose eigenvalue has a sign of its own: the largest or the smallest of the three."""
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
    # The middle one has the sign of the two that are alike.
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
