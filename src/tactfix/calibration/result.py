"""What calibrate answers; the names here are those of its JSON."""

from collections.abc import Mapping
from typing import Literal, TypeAlias

from tactfix.geometry.arrays import Floats
from tactfix.values import frozen_value

CalibrationStatus: TypeAlias = Literal["calibrated", "underdetermined", "inconsistent"]


@frozen_value(eq=True)
class ParameterResult:
    """One parameter that was asked for: nominal and calibrated error, and its sigma, in deg or the cell's units.

    identified: whether the touches have told it; where not it is held, or as good as held, at its nominal value.
    """

    name: str
    joint: str | None
    unit: str
    nominal: float
    value: float
    sigma: float
    identified: bool


@frozen_value
class PlaceResult:
    """base_from_fixture (4, 4), its covariance (6, 6) or None where a motion is free, and the rms residuals."""

    name: str
    base_from_fixture: Floats
    covariance: Floats | None
    rms_before: float
    rms_after: float


@frozen_value(eq=True)
class LeftOut:
    """A place that the robot was not fitted to: its rms residual with the nominal and with the calibrated robot."""

    place: str
    rms_before: float
    rms_after: float
    held_out: bool


@frozen_value(eq=True)
class TouchResidual:
    """The distance of the tip from its feature at one touch, before and after."""

    row: int
    place: str
    feature: str
    before: float
    after: float


@frozen_value
class Calibration:
    """The answer: status, parameters, places, what checks them, and what they are good for.

    values (m,): errors of all parameters of the cell (rad, lengths), the tip's radius last. covariance (m, m): of them.
    prediction: rms sigma of the tip's place over the joint ranges, before and after.
    """

    units: str
    status: CalibrationStatus
    values: Floats
    covariance: Floats
    parameters: tuple[ParameterResult, ...]
    not_identified: tuple[str, ...]
    places: tuple[PlaceResult, ...]
    left_out: tuple[LeftOut, ...]
    shrinkage: float
    prediction: tuple[float, float]
    observability: Mapping[str, float]
    touches: tuple[TouchResidual, ...]
    outliers: tuple[int, ...]
    reasons: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def is_written(self) -> bool:
        """Whether this robot may be written."""
        return self.status == "calibrated"
