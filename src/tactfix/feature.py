"""A feature of a fixture: a plane, a sphere, a cylinder or a point."""

import numpy as np
from numpy.typing import ArrayLike

from tactfix.errors import UsageError
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Cylinder, FeatureType, Plane, Point, Side, Sphere, Surface
from tactfix.values import frozen_value


@frozen_value
class Feature:
    """A feature to touch; `Feature.plane`, `sphere`, `cylinder` and `point` make one with checks.

    Parameters
    ----------
    name : str
        As in the fixture file.
    type : {"plane", "sphere", "cylinder", "point"}
        Kind of surface.
    radius : float or None
        In the fixture's units; None for a plane and a point.
    side : {"outer", "inner"}
        Outer for a boss, inner for a bore.
    sigma : float
        Its own form and calibration error along the normal, added to the probe's in quadrature.
    surface : Plane, Sphere, Cylinder, Point or None
        Its place in the fixture frame; None if it is given by relations only.

    Examples
    --------
    >>> tactfix.Feature.sphere(12.7, (220, 130, 45)).radius
    12.7
    """

    name: str
    type: FeatureType
    radius: float | None
    side: Side
    sigma: float
    surface: Surface | None

    @classmethod
    def plane(cls, point: ArrayLike | None = None, normal: ArrayLike | None = None, *, sigma: float = 0.0) -> "Feature":
        """A plane; point (3,), normal (3,) out of the material, of any length: its place, or neither.

        Raises UsageError for invalid values, as the other features do.
        """
        place = _place("plane", point=point, normal=normal)
        return _checked(cls("", "plane", None, "outer", sigma, None if place is None else Plane(place[0], place[1])))

    @classmethod
    def sphere(
        cls, radius: float, center: ArrayLike | None = None, *, side: Side = "outer", sigma: float = 0.0
    ) -> "Feature":
        """A sphere, outer (a ball) or inner (a socket); center (3,): its place, optional."""
        place = _place("sphere", center=center)
        return _checked(
            cls(
                "",
                "sphere",
                float(radius),
                side,
                sigma,
                None if place is None else Sphere(place[0], float(radius), side),
            )
        )

    @classmethod
    def cylinder(
        cls,
        radius: float,
        point: ArrayLike | None = None,
        direction: ArrayLike | None = None,
        *,
        side: Side = "outer",
        sigma: float = 0.0,
    ) -> "Feature":
        """A cylinder, outer (a pin) or inner (a bore); point (3,) and direction (3,), of any length: its axis."""
        place = _place("cylinder", point=point, direction=direction)
        surface = None if place is None else Cylinder(place[0], place[1], float(radius), side)
        return _checked(cls("", "cylinder", float(radius), side, sigma, surface))

    @classmethod
    def point(cls, point: ArrayLike | None = None, *, sigma: float = 0.0) -> "Feature":
        """A seat, cone, nest or mark that holds the tip's centre; point (3,): its place, optional."""
        place = _place("point", point=point)
        return _checked(cls("", "point", None, "outer", sigma, None if place is None else Point(place[0])))

    @property
    def equations(self) -> int:
        """The number of equations of a contact on it: three on a point, one on all others."""
        return 3 if self.type == "point" else 1


def _place(kind: str, **vectors: ArrayLike | None) -> list[Floats] | None:
    """The vectors (3,) that place a feature, None if not given."""
    given = {name: np.asarray(vector, dtype=np.float64) for name, vector in vectors.items() if vector is not None}
    if not given:
        return None
    if len(given) < len(vectors):
        raise UsageError(f"a {kind} is placed by {' and '.join(vectors)}; give them all, or none")
    for name, vector in given.items():
        if vector.shape != (3,) or not np.isfinite(vector).all():
            raise UsageError(f"{name} of a {kind} is three finite numbers")
        if name in ("normal", "direction") and not vector.any():
            raise UsageError(f"{name} of a {kind} is zero; give a vector of any other length")
    return list(given.values())


def _checked(feature: Feature) -> Feature:
    """The feature; raises UsageError for invalid numbers."""
    if feature.radius is not None and not 0 < feature.radius < np.inf:
        raise UsageError(f"the radius of a {feature.type} is a finite number above 0, not {feature.radius:g}")
    if not 0 <= feature.sigma < np.inf:
        raise UsageError(f"the sigma of a {feature.type} is a finite number, 0 or above, not {feature.sigma:g}")
    if feature.side not in ("outer", "inner"):
        raise UsageError(f"the side of a {feature.type} is outer or inner, not {feature.side!r}")
    return feature
