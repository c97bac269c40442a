"""Small displacements of surfaces in local coordinates: as many numbers as the surface has degrees of freedom.

plane: tilt (2, rad) about its reference point, shift along the normal. sphere and point: shift (3). cylinder: tilt (2,
rad) about its reference point, shift perpendicular to the axis (2). `basis_across` gives the two directions of a tilt.
"""

from dataclasses import replace

import numpy as np

from tactfix.geometry.arrays import Floats, basis_across, cross, unit
from tactfix.geometry.nearest import direction_of, foot
from tactfix.geometry.surfaces import (
    Cylinder,
    Plane,
    Point,
    Sphere,
    Surface,
    outward_normals,
    reference_point,
    residuals,
)


def dimension(surface: Surface) -> int:
    """Degrees of freedom of the surface: plane 3, sphere 3, point 3, cylinder 4."""
    return 4 if isinstance(surface, Cylinder) else 3


def across(surface: Plane | Cylinder) -> Floats:
    """Two orthonormal vectors (2, 3) perpendicular to the normal or axis."""
    return basis_across(direction_of(surface))


def displaced(surface: Surface, step: Floats) -> Surface:
    """The surface after a displacement step (dimension,), or the stack of it after steps (k, dimension)."""
    match surface:
        case Sphere():
            return replace(surface, center=surface.center + step)
        case Point():
            return Point(surface.point + step)
        case Plane():
            normal = unit(surface.normal + step[..., :2] @ across(surface))
            return Plane(surface.point + step[..., 2:] * surface.normal, normal)
        case Cylinder():
            basis = across(surface)
            direction = unit(surface.direction + step[..., :2] @ basis)
            return replace(surface, point=surface.point + step[..., 2:] @ basis, direction=direction)


def equations(surface: Surface, points: Floats, tip_radius: float) -> Floats:
    """The residuals (n, 1) of contacts with tip centres points (n, 3), or the offsets (n, 3) from a point feature."""
    if isinstance(surface, Point):
        return np.asarray(points - surface.point)
    return residuals(surface, points, tip_radius)[:, None]


def equations_jacobian(surface: Surface, points: Floats) -> Floats:
    """Derivative (n, k, dimension) of the equations of tip centres points (n, 3) with respect to a displacement."""
    if isinstance(surface, Point):
        return np.broadcast_to(-np.eye(3), (len(points), 3, 3))
    return residual_jacobian(surface, points)[:, None]


def residual_jacobian(surface: Plane | Sphere | Cylinder, points: Floats) -> Floats:
    """Derivative (n, dimension) of the residuals of tip centres points (n, 3) with respect to a displacement."""
    match surface:
        case Sphere():
            return -outward_normals(surface, points)
        case Plane():
            arms = points - surface.point
            return np.column_stack([arms @ across(surface).T, -np.ones(len(points))])
        case Cylinder():
            outward = outward_normals(surface, points) @ across(surface).T
            height = (points - surface.point) @ surface.direction
            return np.asarray(-np.hstack([height[:, None] * outward, outward]))


def material_displacement(surface: Surface, point: Floats) -> Floats:
    """Derivative (3, dimension) of a point (3,) fixed to the surface by a displacement; of planes along the normal."""
    match surface:
        case Sphere() | Point():
            return np.eye(3)
        case Plane():
            tilts = -(across(surface) @ (point - surface.point))[:, None] * surface.normal
            return np.vstack([tilts, surface.normal]).T
        case Cylinder():
            basis = across(surface)
            return np.vstack([((point - surface.point) @ surface.direction) * basis, basis]).T


def rigid_displacements(surface: Surface, centre: Floats) -> Floats:
    """Derivative (dimension, 6) of the displacement by rotations about centre (3,) and translations along the axes."""
    turns, shifts = np.eye(3), np.eye(3)
    moves = np.hstack([cross(turns, reference_point(surface) - centre).T, shifts])
    if isinstance(surface, Sphere | Point):
        return moves
    basis = across(surface)
    tilts = np.hstack([basis @ cross(turns, direction_of(surface)).T, np.zeros((2, 3))])
    rows = direction_of(surface)[None] if isinstance(surface, Plane) else basis
    return np.vstack([tilts, rows @ moves])


def displacement_between(one: Surface, other: Surface) -> Floats | None:
    """The displacement (dimension,) that takes one to the other, to first order.

    None for two types of surface, and for normals more than a right angle apart. Axes have no sign.
    """
    match one, other:
        case Sphere(), Sphere():
            return np.asarray(other.center - one.center)
        case Point(), Point():
            return np.asarray(other.point - one.point)
        case Plane(), Plane() if one.normal @ other.normal > 0:
            tilt = across(one) @ other.normal
            return np.append(tilt, (other.point - one.point) @ other.normal / (one.normal @ other.normal))
        case Cylinder(), Cylinder():
            basis = across(one)
            sense = 1.0 if one.direction @ other.direction > 0 else -1.0
            tilt = sense * (basis @ other.direction)
            return np.concatenate([tilt, basis @ (foot(other, one.point) - one.point)])
    return None
