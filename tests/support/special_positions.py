"""Combinations of features in general and special positions, with results derived by hand from symmetry groups.

How the columns are derived:

- free: the motions common to the groups of all features (sphere: rotations about its centre; plane: translations along
  it and rotations about its normal; cylinder: rotations about and translations along its axis), as rotations R and
  translations T.
- unsided, sided: the number of proper motions that map every feature onto ITSELF, including the identity. A motion that
  fixes a point off a plane keeps the plane's normal; one that fixes a point in it may reverse it; an axis may always be
  reversed. sided excludes motions that reverse a plane's outward side. None if a motion is free.
- everything: the number of motions that map the set of surfaces onto itself if features may be exchanged; given if it
  follows from a regular figure. None: not stated.
- ranks: 6 minus the dimension of the common motions, for each subset of two or more features (letters of the names);
  a single plane or sphere has 3, a cylinder 4.
"""

from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, Surface


def plane(point: list[float], normal: list[float]) -> Plane:
    return Plane(np.array(point, dtype=float), np.array(normal, dtype=float))


def sphere(center: list[float], radius: float = 1.0) -> Sphere:
    return Sphere(np.array(center, dtype=float), radius)


def cylinder(point: list[float], direction: list[float], radius: float = 1.0) -> Cylinder:
    return Cylinder(np.array(point, dtype=float), np.array(direction, dtype=float), radius)


@dataclass(frozen=True)
class Position:
    name: str
    features: tuple[Surface, ...]
    free: str
    unsided: int | None
    sided: int | None
    ranks: dict[str, int] = field(default_factory=dict)
    everything: int | None = None

    @property
    def surfaces(self) -> dict[str, Surface]:
        return dict(zip("abcdefgh", self.features, strict=False))


X, Y, Z = [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]
O = [0.0, 0.0, 0.0]  # noqa: E741 - the origin
OBLIQUE = [0.48, 0.6, 0.64]

# The positions of data/combinations.json under the same names; the results are in that file.
REFERENCE: dict[tuple[str, str], tuple[Surface, ...]] = {
    ("plane", "-"): (plane([1, 2, 3], OBLIQUE),),
    ("sphere", "-"): (sphere([1, 2, 3], 4),),
    ("cylinder", "-"): (cylinder([1, 2, 3], OBLIQUE, 4),),
    ("plane plane", "parallel"): (plane(O, OBLIQUE), plane([3, 1, 4], OBLIQUE)),
    ("plane plane", "non-parallel"): (plane(O, OBLIQUE), plane([3, 1, 4], X)),
    ("plane sphere", "any"): (plane(O, OBLIQUE), sphere([3, 1, 4])),
    ("plane cylinder", "axis oblique"): (plane(O, Z), cylinder([3, 1, 4], OBLIQUE)),
    ("sphere sphere", "distinct centres"): (sphere(O), sphere([3, 1, 4], 2)),
    ("sphere cylinder", "centre on axis"): (sphere([1.48, 1.6, 1.64]), cylinder([1, 1, 1], OBLIQUE)),
    ("sphere cylinder", "centre off axis"): (sphere([3, 1, 4]), cylinder(O, OBLIQUE)),
    ("cylinder cylinder", "coaxial"): (cylinder([1, 1, 1], OBLIQUE), cylinder([1.48, 1.6, 1.64], OBLIQUE, 2)),
    ("cylinder cylinder", "parallel"): (cylinder([1, 1, 1], OBLIQUE), cylinder([3, 1, 4], OBLIQUE, 2)),
    ("cylinder cylinder", "skew, oblique"): (cylinder([1, 1, 1], OBLIQUE), cylinder([3, 1, 4], X, 2)),
    ("plane plane plane", "orthogonal (3-2-1)"): (plane([1, 2, 3], X), plane([1, 2, 3], Y), plane([1, 2, 3], Z)),
    ("sphere sphere sphere", "non-collinear"): (sphere(O), sphere([5, 0, 0], 2), sphere([1, 3, 0], 3)),
    ("sphere sphere sphere", "collinear"): (sphere(O), sphere([5, 5, 0], 2), sphere([2, 2, 0], 3)),
    ("plane plane cylinder", "planes parallel, axis ⟂ planes"): (
        plane(O, OBLIQUE), plane([3, 1, 4], OBLIQUE), cylinder([2, 0, 1], OBLIQUE)),
    ("plane sphere cylinder", "axis ⟂ plane, centre off axis (boss+ball on a table)"): (
        plane(O, Z), sphere([4, 0, 2]), cylinder([1, 1, 7], Z)),
    ("plane cylinder cylinder", "generic (skew)"): (
        plane(O, Z), cylinder([1, 2, 3], OBLIQUE), cylinder([4, -1, 2], [0.6, 0.0, 0.8], 2)),
    ("plane cylinder cylinder", "coaxial, plane oblique"): (
        plane(O, Z), cylinder([1, 2, 3], OBLIQUE), cylinder([1, 2, 3], OBLIQUE, 2)),
    ("plane cylinder cylinder", "common perpendicular of axes ⟂ plane (axes || plane, skew oblique)"): (
        plane(O, Z), cylinder([0, 0, 1], X), cylinder([0, 0, 3], [0.6, 0.8, 0.0], 2)),
}  # fmt: skip

# 60 degrees from x, in the xy plane.
SIXTY = [0.5, np.sqrt(3) / 2, 0.0]
TETRAHEDRON = ([1.0, 1, 1], [1.0, -1, -1], [-1.0, 1, -1], [-1.0, -1, 1])
ALL_FIVE = {"ab": 5, "ac": 5, "bc": 5}

# Opposite faces a-d, b-e, c-f: pairs 3, any set of faces along one direction (without one of the pairs) 5.
CUBE = {
    **dict.fromkeys(("".join(pair) for pair in combinations("abcdef", 2)), 5),
    **dict.fromkeys(("ad", "be", "cf"), 3),
    **dict.fromkeys(("abd", "acd", "ade", "adf", "abe", "bce", "bde", "bef", "acf", "bcf", "cdf", "cef"), 5),
    **dict.fromkeys(("abde", "acdf", "bcef"), 5),
}

POSITIONS = [
    # -- two features
    Position("two concentric spheres", (sphere([1, 2, 3]), sphere([1, 2, 3], 2)), "3R0T", None, None, {"ab": 3}),
    Position("plane through a sphere's centre", (plane(O, Z), sphere([4, 2, 0])), "1R0T", None, None, {"ab": 5}),
    Position("plane square to a cylinder", (plane(O, Z), cylinder([4, 2, 9], Z)), "1R0T", None, None, {"ab": 5}),
    Position("plane parallel to an axis", (plane(O, Z), cylinder([4, 2, 9], SIXTY)), "0R1T", None, None, {"ab": 5}),
    Position("plane through an axis", (plane(O, Z), cylinder([4, 2, 0], SIXTY)), "0R1T", None, None, {"ab": 5}),
    Position("one plane twice", (plane(O, Z), plane([5, 5, 0], Z)), "1R2T", None, None, {"ab": 3}),
    Position("two sides of a slab", (plane(O, Z), plane([5, 5, -3], [0, 0, -1.0])), "1R2T", None, None, {"ab": 3}),
    # Axes that cross at right angles: half-turns about either axis and about their common perpendicular.
    Position("cylinders crossing square", (cylinder(O, X), cylinder(O, Y, 2)), "none", 4, 4, {"ab": 6}, 4),
    # Of equal size they can also change places: the eight motions of a square.
    Position("equal cylinders crossing square", (cylinder(O, X), cylinder(O, Y)), "none", 4, 4, {"ab": 6}, 8),
    Position("cylinders crossing at 60 deg", (cylinder(O, X), cylinder(O, SIXTY, 2)), "none", 2, 2, {"ab": 6}, 2),
    # Equal axes that cross obliquely: half-turns about the two bisectors as well.
    Position("equal cylinders crossing at 60 deg", (cylinder(O, X), cylinder(O, SIXTY)), "none", 2, 2, {"ab": 6}, 4),
    Position("cylinders square and apart", (cylinder(O, X), cylinder([0, 0, 3], Y, 2)), "none", 2, 2, {"ab": 6}, 2),
    Position("equal cylinders square and apart", (cylinder(O, X), cylinder([0, 0, 3], Y)), "none", 2, 2, {"ab": 6}, 4),
    Position("bore in a boss", (cylinder(O, Z, 5), cylinder([0, 0, 4], Z, 2)), "1R1T", None, None, {"ab": 4}),
    # -- three planes
    Position(
        "three oblique planes", (plane(O, X), plane(O, OBLIQUE), plane(O, [0, 0.6, 0.8])), "none", 1, 1, ALL_FIVE
    ),
    # Two upright planes at 60 degrees on a table: the half-turn about the upright line turns both over.
    Position("wedge on a table", (plane(O, X), plane(O, SIXTY), plane(O, Z)), "none", 2, 1, ALL_FIVE),
    Position("three sides of a prism", (plane(O, X), plane([0, 4, 0], SIXTY), plane([7, 0, 0], Y)), "0R1T", None, None,
             {**ALL_FIVE, "abc": 5}),
    Position("three planes through a line", (plane(O, X), plane(O, SIXTY), plane(O, Y)), "0R1T", None, None,
             {**ALL_FIVE, "abc": 5}),
    Position("slot and end", (plane(O, X), plane([4, 0, 0], X), plane(O, Y)), "0R1T", None, None,
             {"ab": 3, "ac": 5, "bc": 5, "abc": 5}),
    Position("three parallel planes", (plane(O, Z), plane([0, 0, 4], Z), plane([0, 0, 7], Z)), "1R2T", None, None,
             {"ab": 3, "ac": 3, "bc": 3, "abc": 3}),
    # Corner of a cube: as bare planes, the 24 rotations of a cube.
    Position("corner of a cube", (plane([9, 9, 9], X), plane([9, 9, 9], Y), plane([9, 9, 9], Z)), "none", 4, 1,
             ALL_FIVE, 24),
    # -- two planes and a sphere: the centre fixes a point, each plane off it keeps its normal
    Position("edge, sphere off both planes", (plane(O, X), plane(O, SIXTY), sphere([4, 5, 1])), "none", 1, 1, ALL_FIVE),
    # On the edge of square planes: half-turns about the edge and about both normals.
    Position("square edge, sphere on it", (plane(O, X), plane(O, Y), sphere([0, 0, 7])), "none", 4, 1, ALL_FIVE),
    Position("60 deg edge, sphere on it", (plane(O, X), plane(O, SIXTY), sphere([0, 0, 7])), "none", 2, 1, ALL_FIVE),
    # In one of two square planes: the half-turn about the other's normal turns that one over.
    Position("square edge, sphere in one plane", (plane(O, X), plane(O, Y), sphere([0, 4, 7])), "none", 2, 1, ALL_FIVE),
    Position("60 deg edge, sphere in one plane", (plane(O, X), plane(O, SIXTY), sphere([0, 4, 7])), "none", 1, 1,
             ALL_FIVE),
    Position("slab and sphere", (plane(O, Z), plane([0, 0, 4], Z), sphere([5, 1, 2])), "1R0T", None, None,
             {"ab": 3, "ac": 5, "bc": 5, "abc": 5}),
    # -- plane and two spheres: both centres stay, so the motion is a rotation about their line
    Position("plane and two spheres", (plane(O, Z), sphere([0, 0, 2]), sphere([5, 1, 3], 2)), "none", 1, 1, ALL_FIVE),
    Position("plane, spheres on its normal", (plane(O, Z), sphere([5, 1, 2]), sphere([5, 1, 9], 2)), "1R0T", None, None,
             {**ALL_FIVE, "abc": 5}),
    Position("plane through two centres", (plane(O, Z), sphere([5, 1, 0]), sphere([0, 7, 0], 2)), "none", 2, 1,
             ALL_FIVE),
    Position("plane parallel to the line of centres", (plane(O, Z), sphere([5, 1, 4]), sphere([0, 7, 4], 2)), "none", 1,
             1, ALL_FIVE),
    Position("plane, concentric spheres", (plane(O, Z), sphere([5, 1, 4]), sphere([5, 1, 4], 2)), "1R0T", None, None,
             {"ab": 5, "ac": 5, "bc": 3, "abc": 5}),
    # -- spheres alone: the motions of the triangle, tetrahedron, square
    Position("equilateral equal spheres", (sphere([3, 0, 0]), sphere([0, 3, 0]), sphere([0, 0, 3])), "none", 1, 1,
             ALL_FIVE, 6),
    Position("isosceles equal spheres", (sphere([3, 0, 0]), sphere([-3, 0, 0]), sphere([0, 7, 0])), "none", 1, 1,
             ALL_FIVE, 2),
    Position("equilateral, one radius apart", (sphere([3, 0, 0]), sphere([0, 3, 0]), sphere([0, 0, 3], 2)), "none", 1,
             1, ALL_FIVE, 2),
    Position("regular tetrahedron of spheres", tuple(sphere(c, 0.5) for c in TETRAHEDRON), "none", 1, 1,
             dict.fromkeys(("ab", "ac", "ad", "bc", "bd", "cd"), 5), 12),
    Position("square of spheres", tuple(sphere(c, 0.5) for c in ([1.0, 1, 0], [-1.0, 1, 0], [-1.0, -1, 0],
             [1.0, -1, 0])), "none", 1, 1, dict.fromkeys(("ab", "ac", "ad", "bc", "bd", "cd"), 5), 8),
    Position("regular tetrahedron of planes", tuple(plane(n, n) for n in TETRAHEDRON), "none", 1, 1,
             dict.fromkeys(("ab", "ac", "ad", "bc", "bd", "cd"), 5), 12),
    # -- spheres and a cylinder
    Position("two spheres on an axis", (sphere([0, 0, 2]), sphere([0, 0, 7], 2), cylinder(O, Z)), "1R0T", None, None,
             {**ALL_FIVE, "abc": 5}),
    Position("one sphere on the axis, one off", (sphere([0, 0, 2]), sphere([4, 0, 7], 2), cylinder(O, Z)), "none", 1, 1,
             {"ab": 5, "ac": 5, "bc": 6}),
    # The line of centres meets the axis square: the half-turn about it reverses the axis.
    Position("one on, one off, square", (sphere([0, 0, 2]), sphere([4, 0, 2], 2), cylinder(O, Z)), "none", 2, 2,
             {"ab": 5, "ac": 5, "bc": 6}),
    Position("both sides of an axis, square", (sphere([-3, 0, 2]), sphere([4, 0, 2], 2), cylinder(O, Z)), "none", 2, 2,
             {"ab": 5, "ac": 6, "bc": 6}),
    # Equal and opposite: the half-turn about the axis, and about the line square to both, make them change places.
    Position("equal, both sides of an axis", (sphere([-4, 0, 2]), sphere([4, 0, 2]), cylinder(O, Z)), "none", 2, 2,
             {"ab": 5, "ac": 6, "bc": 6}, 4),
    Position("two spheres off an axis", (sphere([-3, 1, 2]), sphere([4, 0, 5], 2), cylinder(O, Z)), "none", 1, 1,
             {"ab": 5, "ac": 6, "bc": 6}),
    # -- a sphere and two cylinders
    Position("parallel cylinders, sphere beside", (sphere([1, 4, 0]), cylinder(O, Z), cylinder([5, 0, 0], Z, 2)),
             "none", 1, 1, {"ab": 6, "ac": 6, "bc": 5}),
    Position("parallel cylinders, sphere between", (sphere([1, 0, 0]), cylinder(O, Z), cylinder([5, 0, 0], Z, 2)),
             "none", 2, 2, {"ab": 6, "ac": 6, "bc": 5}),
    Position("coaxial cylinders, sphere off", (sphere([1, 4, 0]), cylinder(O, Z), cylinder(O, Z, 2)), "none", 2, 2,
             {"ab": 6, "ac": 6, "bc": 4}),
    Position("skew cylinders, sphere on one", (sphere([4, 0, 0]), cylinder(O, X), cylinder([0, 0, 3], SIXTY, 2)),
             "none", 1, 1, {"ab": 5, "ac": 6, "bc": 6}),
    Position("skew cylinders, sphere at the foot", (sphere(O), cylinder(O, X), cylinder([0, 0, 3], SIXTY, 2)),
             "none", 2, 2, {"ab": 5, "ac": 6, "bc": 6}),
    Position("skew cylinders, sphere anywhere", (sphere([4, 1, 7]), cylinder(O, X), cylinder([0, 0, 3], SIXTY, 2)),
             "none", 1, 1, {"ab": 6, "ac": 6, "bc": 6}),
    # -- three cylinders
    Position("cross of cylinders", (cylinder(O, X), cylinder(O, Y, 2), cylinder(O, Z, 3)), "none", 4, 4,
             {"ab": 6, "ac": 6, "bc": 6}, 4),
    Position("cross of equal cylinders", (cylinder(O, X), cylinder(O, Y), cylinder(O, Z)), "none", 4, 4,
             {"ab": 6, "ac": 6, "bc": 6}, 24),
    Position("three parallel cylinders", (cylinder(O, Z), cylinder([4, 0, 0], Z, 2), cylinder([0, 5, 0], Z, 3)),
             "0R1T", None, None, {**ALL_FIVE, "abc": 5}),
    Position("three coaxial cylinders", (cylinder(O, Z), cylinder(O, Z, 2), cylinder([0, 0, 5], Z, 3)), "1R1T", None,
             None, {"ab": 4, "ac": 4, "bc": 4, "abc": 4}),
    # Two rails and a rung: the half-turn about the rung; of equal rails also two that make them change places.
    Position("ladder", (cylinder([4, 0, 0], Z), cylinder([-4, 0, 0], Z), cylinder(O, X, 0.5)), "none", 2, 2,
             {"ab": 5, "ac": 6, "bc": 6}, 4),
    # -- plane, sphere, cylinder
    Position("plane square, sphere on the axis", (plane(O, Z), sphere([1, 1, 4]), cylinder([1, 1, 0], Z)), "1R0T",
             None, None, {**ALL_FIVE, "abc": 5}),
    Position("bar above a plane, sphere beside", (plane(O, Z), sphere([4, 0, 2]), cylinder([0, 0, 3], Y)), "none", 1, 1,
             {"ab": 5, "ac": 5, "bc": 6}),
    # The sphere stands over the bar: the half-turn about the upright keeps even the plane's side.
    Position("bar above a plane, sphere over it", (plane(O, Z), sphere([0, 0, 9]), cylinder([0, 0, 3], Y)), "none", 2,
             2, {"ab": 5, "ac": 5, "bc": 6}),
    Position("bar and sphere in a plane", (plane(O, Z), sphere([4, 0, 0]), cylinder(O, Y)), "none", 2, 1,
             {"ab": 5, "ac": 5, "bc": 6}),
    Position("bar in a plane, sphere over it", (plane(O, Z), sphere([0, 0, 4]), cylinder(O, Y)), "none", 2, 2,
             {"ab": 5, "ac": 5, "bc": 6}),
    Position("oblique bar, sphere anywhere", (plane(O, Z), sphere([4, 1, 5]), cylinder(O, [0.6, 0.0, 0.8])), "none", 1,
             1, {"ab": 5, "ac": 6, "bc": 6}),
    # In the plane, on the line through the piercing point square to the bar: the half-turn about that line.
    Position("oblique bar, sphere on the half-turn", (plane(O, Z), sphere([0, 5, 0]), cylinder(O, [0.6, 0.0, 0.8])),
             "none", 2, 1, {"ab": 5, "ac": 6, "bc": 6}),
    # -- planes and cylinders
    # Each plane alone has a half-turn with the bar, but not about the same point; both change places about the middle.
    Position("slab and oblique bar", (plane(O, Z), plane([0, 0, 4], Z), cylinder(O, [0.6, 0.0, 0.8])), "none", 1, 1,
             {"ab": 3, "ac": 6, "bc": 6}, 2),
    Position("bar along an edge", (plane(O, X), plane(O, Y), cylinder([3, 4, 0], Z)), "0R1T", None, None,
             {**ALL_FIVE, "abc": 5}),
    # Turned about the line from the bar square to the second plane: the first is turned over.
    Position("bar square to one plane, along the other", (plane(O, Z), plane(O, X), cylinder([3, 4, 0], Z)), "none", 2,
             1, ALL_FIVE),
    Position("bar in one plane, square to the other", (plane(O, Z), plane(O, X), cylinder([0, 4, 0], Z)), "none", 4, 1,
             ALL_FIVE),
    Position("oblique planes and bar", (plane(O, Z), plane(O, X), cylinder([3, 4, 0], OBLIQUE)), "none", 1, 1,
             {"ab": 5, "ac": 6, "bc": 6}),
    # One face, two pins: turned over about the line of the pins; equal pins change places without turning the face.
    Position("face and two pins", (plane(O, Z), cylinder([4, 0, 0], Z), cylinder([-4, 0, 0], Z, 2)), "none", 2, 1,
             ALL_FIVE, 2),
    Position("face and two equal pins", (plane(O, Z), cylinder([4, 0, 0], Z), cylinder([-4, 0, 0], Z)), "none", 2, 1,
             ALL_FIVE, 4),
    Position("rails along a plane", (plane(O, Z), cylinder([4, 0, 3], Y), cylinder([-4, 0, 3], Y, 2)), "0R1T", None,
             None, {**ALL_FIVE, "abc": 5}),
    # -- many
    Position("corner and sphere", (plane(O, X), plane(O, Y), plane(O, Z), sphere([4, 5, 7])), "none", 1, 1,
             dict.fromkeys(("ab", "ac", "ad", "bc", "bd", "cd"), 5)),
    # A sphere on the diagonal of the corner: the third-turns about the diagonal exchange the planes.
    Position("corner and sphere on its diagonal", (plane(O, X), plane(O, Y), plane(O, Z), sphere([4, 4, 4])), "none", 1,
             1, dict.fromkeys(("ab", "ac", "ad", "bc", "bd", "cd"), 5), 3),
    Position("corner with a sphere in it", (plane(O, X), plane(O, Y), plane(O, Z), sphere(O)), "none", 4, 1,
             dict.fromkeys(("ab", "ac", "ad", "bc", "bd", "cd"), 5), 24),
    Position("cube of six planes", tuple(plane(n, n) for n in (X, Y, Z, [-1.0, 0, 0], [0, -1.0, 0], [0, 0, -1.0])),
             "none", 1, 1, CUBE, 24),
]  # fmt: skip
