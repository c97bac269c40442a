"""What calibrate answers; the names here are those of its JSON."""

from collections.abc import Mapping
from typing import Any, Literal, TypeAlias

import numpy as np

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


@frozen_value(eq=True)
class FactorScore:
    """The rms over the places of the residuals where they were left out, with this factor on the prior: a length."""

    factor: float
    rms: float


@frozen_value
class Workspace:
    """Where the tip may be: n places (n, 3) in base over the joint ranges, and the sigma there (n,) before and after.

    Sigma: of the tip's place in space, as the robot's parameters alone leave it, relative to the best fitting base.
    """

    points: Floats
    before: Floats
    after: Floats

    @property
    def prediction(self) -> tuple[float, float]:
        """The rms of the sigmas, before and after."""
        before, after = (float(np.sqrt((sigmas**2).mean())) for sigmas in (self.before, self.after))
        return before, after


@frozen_value
class TipResult:
    """flange_from_tip (4, 4) of the calibrated robot, the covariance (3, 3) of its origin in the flange, the radius.

    flange: the frame that carries the tip, a link of the URDF or the frame of the last row.
    """

    flange: str
    flange_from_tip: Floats
    covariance: Floats
    radius: float
    radius_sigma: float


@frozen_value
class Calibration:
    """The answer: status, parameters, places, what checks them, and what they are good for.

    values (m,): errors of all parameters of the cell (rad, lengths), the tip's radius last. covariance (m, m): of them.
    prediction: rms sigma of the tip's place over the joint ranges, before and after; workspace: place by place. scores:
    of the factors tried, the smallest last; empty where nothing was left out.
    """

    units: str
    status: CalibrationStatus
    values: Floats
    covariance: Floats
    parameters: tuple[ParameterResult, ...]
    not_identified: tuple[str, ...]
    tip: TipResult
    places: tuple[PlaceResult, ...]
    left_out: tuple[LeftOut, ...]
    shrinkage: float
    prediction: tuple[float, float]
    workspace: Workspace
    scores: tuple[FactorScore, ...]
    observability: Mapping[str, float]
    touches: tuple[TouchResidual, ...]
    outliers: tuple[int, ...]
    reasons: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def is_written(self) -> bool:
        """Whether this robot may be written."""
        return self.status == "calibrated"

    def to_dict(self) -> dict[str, Any]:
        """What `tactfix calibrate --json` prints."""
        from tactfix.report.calibration_json import calibration_json

        return calibration_json(self)

    def to_json(self) -> str:
        """The text that `tactfix calibrate --json` prints."""
        from tactfix.report.json_report import text_of

        return text_of(self.to_dict())

    def __repr__(self) -> str:
        before, after = self.prediction
        what = f"{len(self.touches)} touches at {len(self.places)} places"
        return f"<Calibration: {self.status}, {what}, tip known to {before:.2g} before, {after:.2g} {self.units} after>"
