"""The result of qualify, in the contacts' unit."""

from typing import Any

from tactfix.geometry.arrays import Floats
from tactfix.results import JsonResult
from tactfix.values import frozen_value


@frozen_value(eq=True)
class Drift:
    """The slope of the readings over the sequence of touches, and its standard deviation."""

    per_touch: float
    sigma: float


@frozen_value(eq=True)
class Step:
    """A step of the mean reading by size, from the touch in this row on."""

    row: int
    size: float


@frozen_value
class DirectionMean:
    """Touches of a ball whose outward normal is nearest to direction (3,): their mean distance off the mean ball."""

    direction: Floats
    touches: int
    mean: float
    sigma: float


@frozen_value
class QualifyResult(JsonResult):
    """Sigma of a touch with its 95 per cent interval, and deviations from pure noise.

    Attributes
    ----------
    units : str
        Of all lengths.
    touches, places, dof : int
        Number of touches and of places, and the degrees of freedom of sigma.
    sigma : float
        One standard deviation of a touch.
    sigma_interval : tuple of two floats
        95 per cent.
    range : float
        The largest difference between touches of one place, or between distances from the centre of the ball.
    drift : Drift or None
        Over the sequence of touches.
    steps : tuple of Step
        By row, counted from 1.
    outliers : tuple of int
        Rows, counted from 1.
    tip_radius, tip_radius_sigma : float or None
        Effective, from a ball of known radius.
    directions : tuple of DirectionMean
        In the frame that direction_frame names.
    direction_frame : str
        "base" or "flange".
    warnings : tuple of str
        In words.

    Examples
    --------
    >>> touches = tactfix.contacts_from_arrays(
    ...     "top", [[0, 0, 0.01], [0, 0, -0.01], [0, 0, 0.02]], [[0, 0, -1]] * 3, sigma=1.0, tip_radius=0.0
    ... )
    >>> tactfix.qualify(touches).dof
    2
    """

    units: str
    touches: int
    places: int
    dof: int
    sigma: float
    sigma_interval: tuple[float, float]
    range: float
    drift: Drift | None
    steps: tuple[Step, ...]
    outliers: tuple[int, ...]
    tip_radius: float | None = None
    tip_radius_sigma: float | None = None
    directions: tuple[DirectionMean, ...] = ()
    direction_frame: str = "base"
    warnings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        low, high = self.sigma_interval
        sigma = f"sigma {self.sigma:.2g} {self.units}".rstrip() + f" ({low:.2g} to {high:.2g})"
        tip = "" if self.tip_radius is None else f", tip radius {self.tip_radius:.6g}"
        return f"<QualifyResult: {sigma}{tip}, {self.touches} touches, {len(self.outliers)} outliers>"

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `tactfix qualify --json` as dictionaries, lists and numbers."""
        from tactfix.report.qualify_report import qualify_json

        return qualify_json(self)

    @classmethod
    def from_json(cls, text: str | bytes) -> "QualifyResult":
        """The result from the JSON of `to_json` or `tactfix qualify --json`. Raises UsageError for any other text."""
        from tactfix.report.json_reader import qualify_result

        return qualify_result(text)
