"""The input of a calibration: robot, places, unknown parameters, and touches. Lengths in the cell's units."""

from collections.abc import Sequence
from dataclasses import field, replace
from typing import Final

import numpy as np

from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats, Frozen, Ints
from tactfix.kinematics.chain import Chain, Parameter
from tactfix.placement import Placement
from tactfix.values import ReadOnly, frozen_value

TIP_RADIUS: Final = Parameter("tip_radius", "tip", False, "the effective radius of the tip")
"""The one unknown that is not of the chain: the last in every vector of values."""


@frozen_value(eq=True)
class Prior:
    """Sigmas of the errors of the nominal robot: rad, lengths."""

    joint_offset: float
    length: float
    angle: float
    tip: float

    def sigma(self, parameter: Parameter) -> float:
        """The sigma of one parameter."""
        return float(getattr(self, parameter.kind))


@frozen_value
class Place:
    """A fixture somewhere in the cell.

    placement: prior knowledge of its pose, if any. of: the place that it is rigidly joined to, with the pose
    of_from_place (4, 4) there; None if it is not joined. A joined place has no placement of its own.
    """

    name: str
    fixture: Fixture
    placement: Placement | None = None
    of: str | None = None
    of_from_place: Floats | None = None


@frozen_value
class Cell:
    """The robot's chain, the tip's radius, the fixtures at their places, and what is unknown.

    unknown: as in the file: "all", "joint_offsets", "tip", or names of parameters. joint_ranges (k, 2): of the robot's
    work, if given. flange: name of the frame that carries the tip; flange_from_tip (4, 4): nominal.
    """

    units: str
    chain: Chain
    tip_radius: float
    unknown: tuple[str, ...]
    prior: Prior
    places: ReadOnly[str, Place]
    joint_ranges: Floats | None = None
    flange: str = "flange"
    flange_from_tip: Frozen = field(default_factory=lambda: np.eye(4))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Those of the chain, then the tip's radius."""
        return (*self.chain.parameters, TIP_RADIUS)

    def root(self, name: str) -> tuple[str, Floats]:
        """The last place in the chain of joined places, or the place itself, and root_from_place (4, 4)."""
        root_from_place = np.eye(4)
        place = self.places[name]
        while place.of is not None and place.of_from_place is not None:
            root_from_place = place.of_from_place @ root_from_place
            place = self.places[place.of]
        return place.name, root_from_place


@frozen_value
class Touches:
    """n touches: place, feature, joint coordinates and sigma of each.

    Attributes
    ----------
    places, features : tuple of str
        Names of the place and feature of each touch (n).
    joints : (n, k) array
        Of k joints from base to tip: rad, lengths for prismatic ones.
    approaches : (n, 3) array
        Unit travel of the probe in base, or in the flange if in_flange; nan if not known.
    in_flange : bool
        The frame of the approaches.
    sigmas : (n,) array
        One standard deviation of the probe along the normal.
    rows : tuple of int
        Of the file (n), counted from 1.

    Examples
    --------
    >>> cell = tactfix.load_cell("samples/robot-calibration/cell.yaml")
    >>> touches = tactfix.load_touches("samples/robot-calibration/touches.csv", cell)
    >>> touches.subset([0, 1]).places
    ('front', 'front')
    """

    places: tuple[str, ...]
    features: tuple[str, ...]
    joints: Frozen
    approaches: Frozen
    in_flange: bool
    sigmas: Frozen
    rows: tuple[int, ...]

    def __len__(self) -> int:
        return len(self.places)

    def subset(self, index: Sequence[int] | Ints) -> "Touches":
        """Those with these indices (from 0), in that order."""
        pick = [int(i) for i in index]
        return replace(
            self,
            places=tuple(self.places[i] for i in pick),
            features=tuple(self.features[i] for i in pick),
            joints=self.joints[pick],
            approaches=self.approaches[pick],
            sigmas=self.sigmas[pick],
            rows=tuple(self.rows[i] for i in pick),
        )

    def at(self, names: Sequence[str]) -> "Touches":
        """Those at the places with these names."""
        return self.subset([i for i, place in enumerate(self.places) if place in names])

    @property
    def touched(self) -> tuple[str, ...]:
        """The places, in the order in which they were first touched."""
        return tuple(dict.fromkeys(self.places))
