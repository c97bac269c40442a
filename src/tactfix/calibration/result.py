"""The result of calibrate; field names are those of its JSON."""

from collections.abc import Mapping
from typing import Any, Literal, TypeAlias

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.results import JsonResult
from tactfix.values import frozen_value

CalibrationStatus: TypeAlias = Literal["calibrated", "underdetermined", "inconsistent"]


@frozen_value(eq=True)
class ParameterResult:
    """One parameter to calibrate: nominal and calibrated error, and its sigma, in deg or the cell's units.

    identified: whether the touches determine it; if not, it is held at or near its nominal value.
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
    """base_from_fixture (4, 4), its covariance (6, 6) or None if a motion is free, and the rms residuals."""

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
    """The rms residual (length) over the places, each left out in turn, with this factor on the prior."""

    factor: float
    rms: float


@frozen_value
class Workspace:
    """Places (n, 3) of the tip in base over the joint ranges, and its sigma there (n,) before and after.

    Sigma: of the tip's place in space by the robot's parameters alone, relative to the best fitting base.
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
class Calibration(JsonResult):
    """The result of calibrate: parameters, places, their verification and accuracy.

    Attributes
    ----------
    units : str
        Of lengths; angles are rad.
    status : {"calibrated", "underdetermined", "inconsistent"}
        "calibrated" only if the robot is better at places left out.
    values : (m,) array
        Errors of all parameters of the cell (rad, lengths), the tip's radius last.
    covariance : (m, m) array
        Of them.
    parameters : tuple of ParameterResult
        Each by name, with nominal and new value and sigma.
    not_identified : tuple of str
        Parameters and directions that are not determined, in words.
    tip : TipResult
        The tip's centre and radius.
    places : tuple of PlaceResult
        Pose of each fixture, and its residuals before and after.
    left_out : tuple of LeftOut
        Residuals at places that were left out, before and after.
    shrinkage : float
        The factor on the sigmas of the prior, from 0 to 1.
    prediction : tuple of two floats
        rms sigma of the tip's place over the joint ranges, before and after.
    undetermined : float
        Share, from 0 to 1, that the touches leave over the joint ranges of robot errors that would explain the nominal
        robot's residuals; from a half on the robot is not calibrated.
    workspace : Workspace
        The same place by place.
    scores : tuple of FactorScore
        Of the factors tried, the smallest last; empty if nothing was left out.
    observability : mapping of str to float
        O1 to O5.
    touches : tuple of TouchResidual
        Residuals of each touch.
    outliers : tuple of int
        Rows of the file, counted from 1.
    reasons, warnings : tuple of str
        Why the status is not "calibrated", and further warnings.

    Examples
    --------
    >>> cell = tactfix.load_cell("samples/robot-calibration/cell.yaml")
    >>> touches = tactfix.load_touches("samples/robot-calibration/touches.csv", cell)
    >>> tactfix.calibrate(cell, touches).status
    'calibrated'
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
    undetermined: float
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
        """The JSON of `tactfix calibrate --json` as dictionaries, lists and numbers."""
        from tactfix.report.calibration_report import calibration_json

        return calibration_json(self)

    def _repr_html_(self) -> str:
        """Places, parameters and the workspace for a notebook."""
        from tactfix.report.html_calibration import calibration_html

        return calibration_html(self)

    def __repr__(self) -> str:
        before, after = self.prediction
        counts = f"{len(self.touches)} touches at {len(self.places)} places"
        return (
            f"<Calibration: {self.status}, {counts}, tip known to {before:.2g} before, {after:.2g} {self.units} after>"
        )
