"""The daily check: the movement of a fixture since a reference pose, its significance, and an upper bound of it.

1. The fixture is located; if it is not, nothing is compared.
2. The reference is converted to the fixture's units; without a covariance it is exact.
3. The movement is compared with its covariance.
4. The corner of the box around the fixture that moved farthest is found, and a bound for all points (95 %).
5. The history of the same reference, with this check, is tested for a drift (`drift`).
"""

from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any, Final

import numpy as np

from tactfix.acceptance import point_covariance, worst_sigma
from tactfix.accessibility.touchable import extreme_points
from tactfix.contacts import Contacts
from tactfix.errors import OtherFixtureError
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Frozen
from tactfix.geometry.rigid import inverse
from tactfix.geometry.surfaces import moved
from tactfix.localization.locate import locate
from tactfix.locate_result import LocateResult
from tactfix.monitoring.drift import CHANCE, CheckRecord, Drift, drift_of
from tactfix.pose_formats.comparison import Limits, Movement, compare, exceeded
from tactfix.pose_formats.pose import Pose
from tactfix.results import JsonResult
from tactfix.units import factor
from tactfix.values import frozen_value

ONE_SIDED_95: Final = 1.6449
"""The 95 per cent quantile of the standard normal distribution."""
_POINT_EXTENT: Final = 1e-3
"""Extent (m) of a fixture that is a single point."""
EXACT_REFERENCE: Final = "the reference has no covariance: it is taken as exact"


@frozen_value
class WorstPoint:
    """The corner (3,), in the fixture frame, of the box around all touchable parts that moved farthest.

    displacement, and its sigma along the displacement, in units.
    """

    point: Frozen
    displacement: float
    sigma: float


@frozen_value
class CheckResult(JsonResult):
    """The result of a check; all but result, reference, limits and warnings is None if the fixture is not located.

    Attributes
    ----------
    result : LocateResult
        Of today's contacts.
    reference : Pose
        The pose of comparison.
    limits : Limits
        Largest allowed movement.
    movement : Movement or None
        From the reference to today.
    worst : WorstPoint or None
        The point of the fixture that moved farthest.
    bound : float or None
        No point of the fixture has moved farther, with 95 % confidence (units).
    record : CheckRecord or None
        For the history.
    drift : Drift or None
        Over the history with this check; None for fewer than three checks against this reference.
    warnings : tuple of str
        In words.

    Notes
    -----
    has_moved: by the limits; without limits, whether noise alone would move it so far less than once in 1000 times.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> contacts = tactfix.load_contacts("samples/robot-cell-plate/contacts.csv", fixture)
    >>> yesterday = tactfix.locate(fixture, contacts).pose
    >>> tactfix.check(fixture, contacts, yesterday, limits=tactfix.Limits(translation=0.1)).exceeded
    {}
    """

    result: LocateResult
    reference: Pose
    limits: Limits
    movement: Movement | None = None
    worst: WorstPoint | None = None
    bound: float | None = None
    record: CheckRecord | None = None
    drift: Drift | None = None
    warnings: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `tactfix check --json` as dictionaries, lists and numbers."""
        from tactfix.report.movement_report import check_json

        return check_json(self)

    def __repr__(self) -> str:
        if self.movement is None:
            return f"<CheckResult {self.result.fixture!r}: {self.result.status}>"
        verdict = "has moved" if self.has_moved else "has not moved"
        return f"<CheckResult {self.result.fixture!r}: {verdict}, {self.movement.distance:.2g} {self.result.units}>"

    @property
    def exceeded(self) -> dict[str, str]:
        """Names of the limits that the movement exceeds, each with a sentence."""
        return {} if self.movement is None else exceeded(self.movement, self.limits)

    @property
    def has_moved(self) -> bool | None:
        """Whether a limit is exceeded, or without limits the p-value is below 1 in 1000; None if not located."""
        if self.movement is None:
            return None
        if self.limits != Limits():
            return bool(self.exceeded)
        return self.movement.chance is not None and self.movement.chance < CHANCE


def check(
    fixture: Fixture,
    contacts: Contacts,
    reference: Pose,
    *,
    limits: Limits | None = None,
    history: Sequence[CheckRecord] = (),
    scale_sigma: bool = False,
) -> CheckResult:
    """Locate a fixture and compare its pose with a reference.

    Parameters
    ----------
    fixture : Fixture
        The fixture that is touched.
    contacts : Contacts
        Today's, in base coordinates and in the fixture's units.
    reference : Pose
        The earlier pose, such as `load_pose` of a result of `locate`; in the fixture's units if it has none. Without a
        covariance it is taken as exact, with a warning.
    limits : Limits, optional
        Largest allowed translation of its origin (units) and rotation (rad).
    history : sequence of CheckRecord
        Earlier checks, oldest first. Those against another reference are ignored.
    scale_sigma : bool
        As of `locate`.

    Returns
    -------
    CheckResult

    Raises
    ------
    OtherFixtureError
        A reference, or a history, of another fixture.

    Notes
    -----
    bound: let a point have moved by u, along the unit vector n, and d be its measured displacement. Then |d| >= n . d,
    and n . d is normally distributed about |u| with at most the point's worst sigma. So |u| <= |d| + 1.645 sigma with
    95 % confidence, for whichever point moved farthest. Both terms are convex functions of the point, so a corner of
    the box has the largest sum.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> contacts = tactfix.load_contacts("samples/robot-cell-plate/contacts.csv", fixture)
    >>> yesterday = tactfix.locate(fixture, contacts).pose
    >>> tactfix.check(fixture, contacts, yesterday).has_moved
    False
    """
    for name in (reference.fixture, *(record.fixture for record in history)):
        if name and name != fixture.name:
            raise OtherFixtureError(fixture.name, name)
    result = locate(fixture, contacts, scale_sigma=scale_sigma)  # step 1
    limits = limits or Limits()
    if result.base_from_fixture is None:
        return CheckResult(result, reference, limits, warnings=result.warnings)
    warnings = result.warnings if reference.covariance is not None else (*result.warnings, EXACT_REFERENCE)
    before = _in_units(reference, fixture.units)  # step 2
    movement = compare(before, result.pose)  # step 3
    worst, bound = _farthest(fixture, result, before, movement)  # step 4
    record = _record(fixture, before, result.pose)  # step 5
    same = [earlier for earlier in history if _is_against(earlier, record)]
    return CheckResult(
        result=result,
        reference=before,
        limits=limits,
        movement=movement,
        worst=worst,
        bound=bound,
        record=record,
        drift=drift_of([*same, record]),
        warnings=warnings,
    )


def _in_units(reference: Pose, units: str) -> Pose:
    """The reference in units (those of the fixture if it has none), with zero covariance if it has none."""
    pose = replace(reference, units=units) if reference.units is None else reference.in_units(units)
    return pose if pose.covariance is not None else replace(pose, covariance=np.zeros((6, 6)))


def _farthest(fixture: Fixture, result: LocateResult, before: Pose, movement: Movement) -> tuple[WorstPoint, float]:
    """The corner that moved farthest, and the bound for all points (95 %)."""
    pose = result.pose.base_from_fixture
    surfaces = {name: moved(inverse(pose), surface) for name, surface in result.surfaces.items()}
    corners = extreme_points(surfaces, fixture.touch, least=_POINT_EXTENT * factor("m", fixture.units))
    ways = corners @ (pose[:3, :3] - before.rotation).T + movement.translation
    assert movement.covariance is not None
    covariances = point_covariance(before.base_from_fixture, movement.covariance, corners)
    distances = np.linalg.norm(ways, axis=1)
    at = int(np.argmax(distances))
    along = ways[at] / (distances[at] or 1.0)
    sigma = float(np.sqrt(max(along @ covariances[at] @ along, 0.0)))
    bound = float((distances + ONE_SIDED_95 * worst_sigma(covariances)).max())
    return WorstPoint(corners[at], float(distances[at]), sigma), bound


def _record(fixture: Fixture, before: Pose, after: Pose) -> CheckRecord:
    """The record of this check for the history, with separate covariances by the errors of both poses."""
    zero = np.zeros((6, 6))
    of_check = compare(replace(before, covariance=zero), after)
    of_reference = compare(before, replace(after, covariance=zero))
    assert of_check.covariance is not None
    assert of_reference.covariance is not None
    return CheckRecord(
        time=datetime.now(UTC).isoformat(timespec="seconds"),
        fixture=fixture.name,
        units=fixture.units,
        reference=before.base_from_fixture,
        motion=np.concatenate([of_check.rotation, of_check.translation]),
        covariance=of_check.covariance,
        reference_covariance=of_reference.covariance,
    )


def _is_against(earlier: CheckRecord, record: CheckRecord) -> bool:
    """Whether an earlier check was against the same reference, in the same units."""
    return earlier.units == record.units and np.array_equal(earlier.reference, record.reference)
