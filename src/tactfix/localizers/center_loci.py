"""Points at given distances from points, axes and planes: the intersections of three such loci.

1. Two spheres are replaced by one sphere and their radical plane, so that at most one sphere remains.
2. The remaining three loci are intersected:

    sphere, plane, plane        a line meets a sphere: 2 points
    sphere, plane, cylinder     a circle meets a cylinder: 4
    sphere, cylinder, cylinder  8: common zeros of three quadrics, by a Macaulay matrix (`homogeneous_forms`)

3. Quadrics with a multiple zero are intersected a second time, with their coefficients changed by a little.
"""

import numpy as np

from tactfix.errors import DegenerateContactsError
from tactfix.geometry.arrays import Floats, Frozen, basis_across, unit
from tactfix.localizers.homogeneous_forms import common_zeros, macaulay_rows, quadratic
from tactfix.values import frozen_value

_NEVER_MEETING = 1e-7
"""Distance of planes or loci (unit size, or sine) below which they meet nowhere or everywhere within rounding: the
root of the rounding of doubles, as `unit_contacts.RATIO`."""

_EIGHT = 8
"""Common zeros of three quadrics (Bezout)."""
_MULTIPLE_GAP = 1e-4
"""Ratio of singular values of the Macaulay matrix below which zeros may be multiple, or a curve. At this ratio a
simple zero has about 12 digits."""
_QUADRIC_NUDGE = 1e-5
"""Standard deviation of the change of the coefficients of quadrics of unit size. It separates multiple zeros by
about its root, 3e-3, near enough for the least squares that follow."""
_TOUCH_ELSEWHERE = "touch somewhere else, or use another distance"


@frozen_value
class SphereLocus:
    """|c - center| = distance."""

    center: Frozen
    distance: float


@frozen_value
class PlaneLocus:
    """normal . c = offset; normal is unit."""

    normal: Frozen
    offset: float


@frozen_value
class CylinderLocus:
    """|(c - point) x direction| = distance; direction is unit."""

    point: Frozen
    direction: Frozen
    distance: float


Locus = SphereLocus | PlaneLocus | CylinderLocus


def meeting_points(loci: tuple[Locus, Locus, Locus]) -> Floats:
    """Points (k, 3), k <= 8, near every real point that lies on all three loci, one of which must be a sphere.

    Loci that just miss each other, like tangent ones with noise, give the point of closest approach: a caller has to
    refine the points and test their residuals. Lengths should be of unit size.
    Raises DegenerateContactsError if loci share a whole curve or planes are parallel.
    """
    spheres = [locus for locus in loci if isinstance(locus, SphereLocus)]
    planes = [locus for locus in loci if isinstance(locus, PlaneLocus)]
    cylinders = [locus for locus in loci if isinstance(locus, CylinderLocus)]
    planes += [_radical_plane(spheres[0], other) for other in spheres[1:]]  # step 1
    if not cylinders:  # step 2
        return _on_line(spheres[0], planes[0], planes[1])
    if planes:
        return _on_circle(spheres[0], planes[0], cylinders[0])
    return _on_two_cylinders(spheres[0], cylinders[0], cylinders[1])


def _radical_plane(first: SphereLocus, second: SphereLocus) -> PlaneLocus:
    """The plane of the circle that two spheres share: the difference of their equations (eqs. 7, 8)."""
    arm = second.center - first.center
    length = float(np.linalg.norm(arm))
    if length <= _NEVER_MEETING:
        raise DegenerateContactsError("sphere", "two spheres are concentric", length, _NEVER_MEETING, _TOUCH_ELSEWHERE)
    middle = 0.5 * (first.center + second.center)
    shift = 0.5 * (first.distance**2 - second.distance**2) / length
    return PlaneLocus(arm / length, float(arm @ middle) / length + shift)


def _on_line(sphere: SphereLocus, first: PlaneLocus, second: PlaneLocus) -> Floats:
    """The two points of a sphere on the line of two planes, or the nearest point of that line to the sphere."""
    along = np.cross(first.normal, second.normal)
    ratio = float(np.linalg.norm(along))
    if ratio <= _NEVER_MEETING:
        raise DegenerateContactsError(
            "sphere", "two conditions on the centre are the same", ratio, _NEVER_MEETING, _TOUCH_ELSEWHERE
        )
    normals = np.array([first.normal, second.normal, along / ratio])
    offsets = [first.offset, second.offset, float(normals[2] @ sphere.center)]
    foot = np.linalg.solve(normals, offsets)
    half = np.sqrt(max(sphere.distance**2 - float(np.sum((foot - sphere.center) ** 2)), 0.0))
    return np.array([foot + half * normals[2], foot - half * normals[2]])


def _on_circle(sphere: SphereLocus, plane: PlaneLocus, cylinder: CylinderLocus) -> Floats:
    """Up to four points of a cylinder on the circle that a sphere and a plane share (eqs. 48-51).

    With c = m + R (u cos t + v sin t) the distance from the axis is a trigonometric polynomial of degree two in t.
    """
    height = plane.offset - float(plane.normal @ sphere.center)
    middle = sphere.center + height * plane.normal
    radius = np.sqrt(max(sphere.distance**2 - height**2, 0.0))
    across = basis_across(cylinder.direction)
    flat_middle = across @ (middle - cylinder.point)
    u, v = radius * (across @ basis_across(plane.normal).T).T
    # Five values determine the five coefficients; of 16 the largest is far from a root.
    angles = np.linspace(0.0, 2 * np.pi, 16, endpoint=False)
    flat = flat_middle + np.cos(angles)[:, None] * u + np.sin(angles)[:, None] * v
    values = np.sum(flat**2, axis=1) - cylinder.distance**2
    size = float(np.max(np.abs(values)))
    if radius == 0.0:
        return middle[None]
    if size <= _NEVER_MEETING * max(radius**2, cylinder.distance**2):
        reason = "the whole circle on which the centre must lie is at the given distance from the axis"
        raise DegenerateContactsError("sphere", reason, size, _NEVER_MEETING, _TOUCH_ELSEWHERE)
    found = _trigonometric_zeros(angles, values)
    circle = np.column_stack([np.cos(found), np.sin(found)]) @ basis_across(plane.normal)
    return np.asarray(middle + radius * circle)


def _trigonometric_zeros(angles: Floats, values: Floats) -> Floats:
    """The angles (4,) of the zeros, or next to complex zeros, of a trigonometric polynomial of degree two.

    t = tan((angle - start) / 2), with start opposite to the largest value: the leading coefficient of the quartic in t
    is that value, and no zero is at infinity.
    """
    start = angles[np.argmax(np.abs(values))] + np.pi
    basis = _degree_two(angles - start)
    # For evenly spaced angles the columns of the basis are orthogonal.
    a0, a1, b1, a2, b2 = values @ basis / (basis**2).sum(axis=0)
    quartic = [a0 - a1 + a2, 2 * b1 - 4 * b2, 2 * a0 - 6 * a2, 2 * b1 + 4 * b2, a0 + a1 + a2]
    return np.asarray(start + 2 * np.angle(1.0 + 1j * np.roots(quartic).real))


def _degree_two(angles: Floats) -> Floats:
    """Columns 1, cos, sin, cos 2, sin 2 of the angles (n,)."""
    return np.column_stack(
        [np.ones_like(angles), np.cos(angles), np.sin(angles), np.cos(2 * angles), np.sin(2 * angles)]
    )


def _on_two_cylinders(sphere: SphereLocus, first: CylinderLocus, second: CylinderLocus) -> Floats:
    """Up to eight points that a sphere and two cylinders share: three quadrics in homogeneous coordinates."""
    gap_of_axes = np.linalg.norm(np.cross(first.direction, second.direction)) + np.linalg.norm(
        basis_across(first.direction) @ (second.point - first.point)
    )
    if gap_of_axes <= _NEVER_MEETING:
        raise DegenerateContactsError(
            "sphere", "both axes coincide", float(gap_of_axes), _NEVER_MEETING, _TOUCH_ELSEWHERE
        )
    ball = _quadric_matrix(np.eye(3), sphere.center, sphere.distance)
    quadrics = [ball, _cylinder_matrix(first), _cylinder_matrix(second)]
    found, gap = _quadric_zeros(np.array(quadrics))
    if gap < _MULTIPLE_GAP:  # step 3
        nudge = np.random.default_rng(5).normal(scale=_QUADRIC_NUDGE, size=(3, 4, 4))
        found = np.concatenate([found, _quadric_zeros(np.array(quadrics) + nudge + np.swapaxes(nudge, 1, 2))[0]])
    finite = np.abs(found[:, 3].real) > 1e-9 * np.linalg.norm(found.real, axis=1)
    return np.asarray(found[finite, :3] / found[finite, 3:])


def _quadric_zeros(matrices: Floats) -> tuple[Floats, float]:
    """Real parts (8, 4) of the common points of three quadrics (3, 4, 4), and the gap of `common_zeros`."""
    rows = np.concatenate([macaulay_rows(form, 2, 4, variables=4) for form in quadratic(matrices)])
    found, gap = common_zeros(rows, 4, _EIGHT, variables=4)
    return found.real, float(gap)


def _cylinder_matrix(cylinder: CylinderLocus) -> Floats:
    """The quadric |(c - point) x direction|^2 = distance^2 as symmetric matrix (4, 4)."""
    direction = unit(cylinder.direction)
    return _quadric_matrix(np.eye(3) - np.outer(direction, direction), cylinder.point, cylinder.distance)


def _quadric_matrix(metric: Floats, place: Floats, distance: float) -> Floats:
    """The quadric (c - place)^T metric (c - place) = distance^2 as symmetric matrix (4, 4)."""
    matrix = np.empty((4, 4))
    matrix[:3, :3] = metric
    matrix[:3, 3] = matrix[3, :3] = -metric @ place
    matrix[3, 3] = place @ metric @ place - distance**2
    return matrix
