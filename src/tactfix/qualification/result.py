"""What qualify answers, in the contacts' unit."""

from typing import Any

from tactfix.geometry.arrays import Floats
from tactfix.values import frozen_value


@frozen_value(eq=True)
class Drift:
    """How much a touch reads more than the one before it, and one standard deviation of that."""

    per_touch: float
    sigma: float


@frozen_value(eq=True)
class Step:
    """From the touch in this row on all read more by size."""

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
class QualifyResult:
    """Sigma of a touch, with an interval that holds it in 95 of 100 cases, and what disturbs it.

    range: the largest difference between touches of one place, or between distances from the centre of the ball. steps
    and outliers by row, counted from 1. tip_radius: effective, from a ball of known radius. directions: in the frame
    that direction_frame names.
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

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `tactfix qualify --json` as dictionaries, lists and numbers."""
        from tactfix.report.qualify_report import qualify_json

        return qualify_json(self)

    def to_json(self) -> str:
        """The text that `tactfix qualify --json` prints."""
        from tactfix.report.json_report import text_of

        return text_of(self.to_dict())
