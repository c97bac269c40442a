"""The fixture as frozen values, independent of its file: lengths in the fixture's units, angles in rad.

`tactfix.fixture_format` makes these from the YAML file; no other package knows the file format.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, Literal, TypeAlias

from tactfix.feature import Feature
from tactfix.geometry.arrays import Frozen
from tactfix.placement import Placement
from tactfix.values import ReadOnly, frozen_value

Axis: TypeAlias = Literal["x", "y", "z"]


@frozen_value(eq=True)
class Relation:
    """A known distance (length, fixture units) or angle (rad) between two features, with one standard deviation."""

    kind: Literal["distance", "angle"]
    between: tuple[str, str]
    value: float
    sigma: float


@frozen_value(eq=True)
class OriginRule:
    """The origin of the fixture frame.

    center_of: (sphere,); foot_of: (A, B), the point of axis or plane B nearest to A; meet_of: three planes, or
    (cylinder, plane).
    """

    kind: Literal["center_of", "foot_of", "meet_of"]
    features: tuple[str, ...]


@frozen_value(eq=True)
class AxisRule:
    """A direction: along: (cylinder or plane,); from_to: (A, B). opposite reverses it."""

    kind: Literal["along", "from_to"]
    features: tuple[str, ...]
    opposite: bool = False


@frozen_value(eq=True)
class FrameRecipe:
    """How the fixture frame is built: the first axis is exact, the second is made perpendicular to it."""

    origin: OriginRule
    first: tuple[Axis, AxisRule]
    second: tuple[Axis, AxisRule]


@frozen_value
class TouchBox:
    """Where a surface may be touched: low (3,) <= x_fixture <= high (3,), infinite if unbounded."""

    low: Frozen
    high: Frozen


@frozen_value(eq=True)
class Probe:
    """The probe block of the fixture file, None for values not given; lengths in the fixture's units.

    Parameters
    ----------
    tip_radius : float, optional
        0: contacts are points of the surface; > 0: contacts are centres of the tip.
    sigma : float, optional
        One standard deviation of a contact along the surface normal.
    approach_distance : float, optional
        Length of the probe's straight path before it touches; None: unlimited.
    tip_offset : tuple of three floats, optional
        The tip's centre (3,) in the flange frame.
    tip_within : float, optional
        Largest distance of the true centre from tip_offset.

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


@frozen_value
class Fixture:
    """A fixture: its features, their relations, and the frame to locate.

    Parameters
    ----------
    name : str
        As in the fixture file.
    units : {"mm", "m", "um", "in"}
        Of all lengths here; angles are rad.
    probe : Probe
        Defaults of the probe.
    features : mapping of str to Feature
        In file order.
    relations : tuple of Relation
        Distances and angles between features.
    frame : FrameRecipe or None
        How the fixture frame is built from the features; None if the features have places.
    touch : mapping of str to TouchBox
        Where each surface may be touched, in the fixture frame.
    placement : Placement, optional
        Prior knowledge of the pose; None without any.

    Notes
    -----
    `Fixture.from_features`, `from_dict` and `from_text` make one with checks; `to_yaml` writes it.

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
        """A fixture by geometry, from features with places; checked like a fixture file.

        touch: where a feature may be touched, such as {"pin": {"z": (6.0, None)}}; None is unbounded.
        Raises FileError with all problems.
        """
        from tactfix.files.fixture_file import fixture_from_dict

        bare = cls(name, units, probe or Probe(), {n: replace(f, name=n) for n, f in features.items()}, (), None, {})
        document = bare.to_dict() | ({"touch": dict(touch)} if touch else {})
        return fixture_from_dict(document)

    @classmethod
    def from_dict(cls, document: Mapping[str, Any]) -> "Fixture":
        """The fixture from the mapping of a fixture file.

        Raises FileError with all problems.
        """
        from tactfix.files.fixture_file import fixture_from_dict

        return fixture_from_dict(document)

    @classmethod
    def from_text(cls, text: str) -> "Fixture":
        """The fixture from the text of a fixture file (YAML).

        Raises FileError with all problems, by line and column.
        """
        from tactfix.files.fixture_file import fixture_from_text

        return fixture_from_text(text)

    def to_dict(self) -> dict[str, Any]:
        """The mapping of its fixture file."""
        from tactfix.fixture_format.write import fixture_document

        return fixture_document(self)

    def to_yaml(self) -> str:
        """The text of its fixture file."""
        from tactfix.files.fixture_file import fixture_text

        return fixture_text(self)

    def __repr__(self) -> str:
        features = ", ".join(f"{name} {feature.type}" for name, feature in self.features.items())
        return f"<Fixture {self.name!r}: {features}; {self.units}>"

    def equations(self, features: Iterable[str]) -> int:
        """The total number of equations of contacts on these features, one name for each contact."""
        return sum(self.features[name].equations for name in features)

    def dof(self, features: Iterable[str]) -> int:
        """Equations of contacts on these features, and of a measured pose, less the unknowns of the pose."""
        known = self.placement
        return self.equations(features) - 6 if known is None else self.equations(features) + known.dof

    @property
    def is_placed(self) -> bool:
        """Whether each feature has its place in the fixture frame (by geometry, not by relations)."""
        return all(feature.surface is not None for feature in self.features.values())
