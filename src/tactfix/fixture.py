"""What a fixture is, once its file has been read: plain frozen values in the fixture's units, angles in rad.

`tactfix.fixture_format` makes these from the YAML file; nothing else knows how the file looks.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Annotated, Any, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from tactfix.errors import UsageError
from tactfix.geometry.arrays import Bools, Floats, Frozen, frozen
from tactfix.geometry.surfaces import Cylinder, FeatureType, Plane, Point, Side, Sphere, Surface
from tactfix.values import ReadOnly, frozen_value

Axis: TypeAlias = Literal["x", "y", "z"]
Direction: TypeAlias = Literal["x", "y", "z", "rx", "ry", "rz"]
"""A translation along a base axis, or a rotation about one."""
DIRECTIONS: tuple[Direction, ...] = get_args(Direction)

SINGULAR_CORRELATION = 1e-12
"""Smallest eigenvalue of a correlation matrix below which the covariance holds a direction."""


@frozen_value
class Feature:
    """One thing to touch; `Feature.plane`, `sphere`, `cylinder` and `point` make one that is checked.

    Parameters
    ----------
    name : str
        As in the fixture file.
    type : {"plane", "sphere", "cylinder", "point"}
        What it is.
    radius : float or None
        In the fixture's units; None for a plane and a point.
    side : {"outer", "inner"}
        Outer for a boss, inner for a bore.
    sigma : float
        Its own form and calibration error along the normal, added to the probe's in quadrature.
    surface : Plane, Sphere, Cylinder, Point or None
        Its place in the fixture frame; None where only relations say where it is.

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

        Raises UsageError for what no plane can be, as the other features do.
        """
        place = _place("plane", point=point, normal=normal)
        return _checked(cls("", "plane", None, "outer", sigma, None if place is None else Plane(place[0], place[1])))

    @classmethod
    def sphere(
        cls, radius: float, center: ArrayLike | None = None, *, side: Side = "outer", sigma: float = 0.0
    ) -> "Feature":
        """A sphere, outer (a ball) or inner (a socket); center (3,): its place, or none."""
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
        """A seat, cone, nest or mark that holds the tip's centre; point (3,): its place, or none."""
        place = _place("point", point=point)
        return _checked(cls("", "point", None, "outer", sigma, None if place is None else Point(place[0])))

    @property
    def equations(self) -> int:
        """How many equations a contact on it gives: three on a point, one on all others."""
        return 3 if self.type == "point" else 1


def _place(kind: str, **vectors: ArrayLike | None) -> list[Floats] | None:
    """The vectors (3,) that place a feature, None where none is given."""
    given = {name: np.asarray(vector, dtype=np.float64) for name, vector in vectors.items() if vector is not None}
    if not given:
        return None
    if len(given) < len(vectors):
        raise UsageError(f"a {kind} is placed by {' and '.join(vectors)}; give them all, or none")
    for name, vector in given.items():
        if vector.shape != (3,) or not np.isfinite(vector).all():
            raise UsageError(f"{name} of a {kind} is three finite numbers")
        if name in ("normal", "direction") and not vector.any():
            raise UsageError(f"{name} of a {kind} is zero; it must point somewhere")
    return list(given.values())


def _checked(feature: Feature) -> Feature:
    """The feature; UsageError where its numbers can be none."""
    if feature.radius is not None and not 0 < feature.radius < np.inf:
        raise UsageError(f"the radius of a {feature.type} is a finite number above 0, not {feature.radius:g}")
    if not 0 <= feature.sigma < np.inf:
        raise UsageError(f"the sigma of a {feature.type} is a finite number, 0 or above, not {feature.sigma:g}")
    if feature.side not in ("outer", "inner"):
        raise UsageError(f"the side of a {feature.type} is outer or inner, not {feature.side!r}")
    return feature


@frozen_value(eq=True)
class Relation:
    """A known distance (length, fixture units) or angle (rad) between two features, with one standard deviation."""

    kind: Literal["distance", "angle"]
    between: tuple[str, str]
    value: float
    sigma: float


@frozen_value(eq=True)
class OriginRule:
    """Where the fixture's origin is.

    center_of: (sphere,); foot_of: (A, B), the point of axis or plane B nearest to A; meet_of: three planes, or
    (cylinder, plane).
    """

    kind: Literal["center_of", "foot_of", "meet_of"]
    features: tuple[str, ...]


@frozen_value(eq=True)
class AxisRule:
    """A direction: along: (cylinder or plane,); from_to: (A, B). opposite turns it round."""

    kind: Literal["along", "from_to"]
    features: tuple[str, ...]
    opposite: bool = False


@frozen_value(eq=True)
class FrameRecipe:
    """How the fixture frame is built: the first axis holds exactly, the second is made square to it."""

    origin: OriginRule
    first: tuple[Axis, AxisRule]
    second: tuple[Axis, AxisRule]


@frozen_value
class TouchBox:
    """Where a surface may be touched: low (3,) <= x_fixture <= high (3,), infinite where open."""

    low: Frozen
    high: Frozen


@frozen_value(eq=True)
class Probe:
    """What the fixture file says of the probe, None where it says nothing; lengths in the fixture's units.

    Parameters
    ----------
    tip_radius : float, optional
        0: contacts are points of the surface; > 0: contacts are centres of the tip.
    sigma : float, optional
        One standard deviation of a contact along the surface normal.
    approach_distance : float, optional
        How far the probe comes in a straight line before it touches; None: from far away.
    tip_offset : tuple of three floats, optional
        The tip's centre (3,) in the flange frame.
    tip_within : float, optional
        How far from there it can be at most.

    Examples
    --------
    >>> tactfix.load_fixture("fixtures/robot-cell-plate.yaml").probe.tip_radius
    3.0
    """

    tip_radius: float | None = None
    sigma: float | None = None
    approach_distance: float | None = None
    tip_offset: tuple[float, float, float] | None = None
    tip_within: float | None = None


def _frozen_if_array(sigma: tuple[float, float] | Floats) -> tuple[float, float] | Floats:
    return frozen(sigma) if isinstance(sigma, np.ndarray) else sigma


@frozen_value
class Placement:
    """What is known of where the fixture stands before it is touched.

    Parameters
    ----------
    near : (4, 4) array
        base_from_fixture, in the fixture's units.
    within : tuple of two floats, optional
        Limits of the translation of the fixture's origin (length) and of the rotation (rad) from near.
    sigma : tuple of two floats or (6, 6) array, optional
        near is a measurement with these standard deviations of each component, translation (length) and rotation (rad),
        or with this covariance in the order of a pose's: rotation (rad), translation, base axes.
    free : frozenset of {"x", "y", "z", "rx", "ry", "rz"}, optional
        Only these may differ from near, rotations about base axes through the fixture's origin at near, then
        translations; None: all.

    Raises
    ------
    UsageError
        What cannot be meant: no rigid motion, within and sigma together, no direction.

    Examples
    --------
    >>> tactfix.Placement(np.eye(4), within=(20.0, 0.1)).within
    (20.0, 0.1)
    """

    near: Frozen
    within: tuple[float, float] | None = None
    sigma: Annotated[tuple[float, float] | Floats, _frozen_if_array] | None = None
    free: frozenset[Direction] | None = None

    def __post_init__(self) -> None:
        if self.within is not None and self.sigma is not None:
            raise UsageError("the pose known beforehand has limits or a sigma, not both")
        if self.within is not None and not min(self.within) >= 0:
            raise UsageError("the limits of the pose known beforehand must not be negative")
        if self.free is not None and not self.free:
            raise UsageError(f"nothing may differ from the pose known beforehand; name one of {', '.join(DIRECTIONS)}")
        covariance = self.covariance
        if covariance is not None and not _is_positive_definite(covariance):
            what = "the sigma of the pose known beforehand must be above zero in every direction"
            raise UsageError(f"{what}; where one is held, name the others as free")

    @property
    def is_in_fit(self) -> bool:
        """Whether it takes part in the fit, as a measurement or by directions that are held; limits only eliminate."""
        return self.sigma is not None or self.free is not None

    @property
    def is_known(self) -> bool:
        """Whether it says anything of poses; near alone does not."""
        return self.within is not None or self.is_in_fit

    @property
    def covariance(self) -> Floats | None:
        """The covariance (6, 6) of near where it is a measurement: rx ry rz (rad), tx ty tz (length)."""
        if self.sigma is None or isinstance(self.sigma, np.ndarray):
            return self.sigma
        translation, rotation = self.sigma
        return np.diag([rotation**2] * 3 + [translation**2] * 3)

    @property
    def dof(self) -> int:
        """How many equations a measurement gives, less the unknowns of the pose."""
        return (6 if self.sigma is not None else 0) - int(self.turns.sum() + self.shifts.sum())

    @property
    def turns(self) -> Bools:
        """The base axes (3,) about which the fixture may be turned from near."""
        return np.array([self.free is None or f"r{axis}" in self.free for axis in "xyz"])

    @property
    def shifts(self) -> Bools:
        """The base axes (3,) along which the fixture may be shifted from near."""
        return np.array([self.free is None or axis in self.free for axis in "xyz"])


def _is_positive_definite(covariance: Floats) -> bool:
    """Whether it is a finite covariance (6, 6) of full rank, whatever the unit of length."""
    if covariance.shape != (6, 6) or not np.isfinite(covariance).all():
        return False
    sigmas = np.sqrt(np.abs(np.diag(covariance)))
    scaled = covariance / np.outer(sigmas, sigmas) if sigmas.all() else np.zeros((6, 6))
    return bool(np.allclose(scaled, scaled.T) and np.linalg.eigvalsh(scaled)[0] > SINGULAR_CORRELATION)


@frozen_value
class Fixture:
    """A fixture: what can be touched, what is known of it, and the frame that is looked for.

    Parameters
    ----------
    name : str
        As in the file.
    units : {"mm", "m", "um", "in"}
        Of every length here; angles are rad.
    probe : Probe
        Defaults of the probe.
    features : mapping of str to Feature
        In file order.
    relations : tuple of Relation
        Distances and angles between features.
    frame : FrameRecipe or None
        How the fixture frame is built from the features; None where the features say their places.
    touch : mapping of str to TouchBox
        Where each surface may be touched, in the fixture frame.
    placement : Placement, optional
        What is known of where it stands; None where nothing is.

    Notes
    -----
    `Fixture.from_features`, `from_dict` and `from_text` make one that is checked; `to_yaml` writes it.

    Examples
    --------
    >>> pin = tactfix.Feature.cylinder(8.0, (0, 0, 0), (0, 0, 1))
    >>> tactfix.Fixture.from_features("mine", "mm", {"pin": pin}).is_placed
    True
    """

    name: str
    units: str
    probe: Probe
    features: ReadOnly[str, Feature]
    relations: tuple[Relation, ...]
    frame: FrameRecipe | None
    touch: ReadOnly[str, TouchBox]
    placement: Placement | None = None

    @classmethod
    def from_features(
        cls,
        name: str,
        units: str,
        features: Mapping[str, Feature],
        *,
        probe: Probe | None = None,
        touch: Mapping[str, Mapping[str, tuple[float | None, float | None]]] | None = None,
    ) -> "Fixture":
        """A fixture by geometry, of features that carry their places; held to all that a fixture file is held to.

        touch: where a feature may be touched, such as {"pin": {"z": (6.0, None)}}, None being open.
        Raises FileError with all that is wrong with it.
        """
        from tactfix.files.fixture_file import fixture_from_dict

        bare = cls(name, units, probe or Probe(), {n: replace(f, name=n) for n, f in features.items()}, (), None, {})
        document = bare.to_dict() | ({"touch": dict(touch)} if touch else {})
        return fixture_from_dict(document)

    @classmethod
    def from_dict(cls, document: Mapping[str, Any]) -> "Fixture":
        """The fixture that the mapping of a fixture file describes.

        Raises FileError with all that is wrong with it.
        """
        from tactfix.files.fixture_file import fixture_from_dict

        return fixture_from_dict(document)

    @classmethod
    def from_text(cls, text: str) -> "Fixture":
        """The fixture that the text of a fixture file (YAML) describes.

        Raises FileError with all that is wrong with it, by line and column.
        """
        from tactfix.files.fixture_file import fixture_from_text

        return fixture_from_text(text)

    def to_dict(self) -> dict[str, Any]:
        """The mapping that a fixture file of it holds."""
        from tactfix.fixture_format.write import fixture_document

        return fixture_document(self)

    def to_yaml(self) -> str:
        """The text of a fixture file that describes it."""
        from tactfix.files.fixture_file import fixture_text

        return fixture_text(self)

    def __repr__(self) -> str:
        features = ", ".join(f"{name} {feature.type}" for name, feature in self.features.items())
        return f"<Fixture {self.name!r}: {features}; {self.units}>"

    def equations(self, features: Iterable[str]) -> int:
        """How many equations contacts on these features, one named for each contact, give in all."""
        return sum(self.features[name].equations for name in features)

    def dof(self, features: Iterable[str]) -> int:
        """How many equations contacts on these features, and a measured pose, give beyond the unknowns of the pose."""
        known = self.placement
        return self.equations(features) - 6 if known is None else self.equations(features) + known.dof

    @property
    def is_placed(self) -> bool:
        """Whether each feature carries its place in the fixture frame (by geometry, not by relations)."""
        return all(feature.surface is not None for feature in self.features.values())
