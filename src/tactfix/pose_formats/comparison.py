"""The movement of a fixture between two poses, in base and in its own frame, and whether noise explains it."""

from typing import Any

import numpy as np

from tactfix.errors import OtherFixtureError, UsageError
from tactfix.geometry.arrays import Floats, Frozen
from tactfix.geometry.rigid import inverse_left_jacobian
from tactfix.pose_formats.orientation import RotationVector
from tactfix.pose_formats.pose import Pose
from tactfix.results import JsonResult
from tactfix.settings import Setting
from tactfix.values import frozen_value


@frozen_value
class Movement(JsonResult):
    """The movement of a fixture from before to after; lengths in units, angles in rad.

    Attributes
    ----------
    units : str or None
        Unit of lengths.
    rotation, translation : (3,) array
        R_after = exp([rotation]) R_before (rad) and t_after = t_before + translation (units), in base axes, about the
        fixture's origin.
    rotation_in_fixture, translation_in_fixture : (3,) array
        The same in the axes of the fixture before the movement.
    covariance : (6, 6) array or None
        Of (rotation, translation) in base axes, from both poses; None unless both have one.

    Examples
    --------
    >>> before = tactfix.Pose(np.eye(4), "mm")
    >>> after = tactfix.Pose([[1, 0, 0, 3], [0, 1, 0, 4], [0, 0, 1, 0], [0, 0, 0, 1]], "mm")
    >>> tactfix.compare(before, after).distance
    5.0
    """

    units: str | None
    rotation: Frozen
    translation: Frozen
    rotation_in_fixture: Frozen
    translation_in_fixture: Frozen
    covariance: Frozen | None

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `tactfix compare --json`, without limits, as dictionaries, lists and numbers."""
        from tactfix.report.movement_report import compare_json

        return compare_json(self, Limits())

    def __repr__(self) -> str:
        def shown(size: float, sigma: float | None, unit: str) -> str:
            return f"{size:.3g} {unit}".rstrip() + ("" if sigma is None else f" (sigma {sigma:.2g})")

        to_deg = 180 / np.pi
        turned = shown(self.angle * to_deg, None if self.angle_sigma is None else self.angle_sigma * to_deg, "deg")
        return f"<Movement: moved {shown(self.distance, self.distance_sigma, self.units or '')}, turned {turned}>"

    @property
    def distance(self) -> float:
        """How far the fixture's origin moved (units)."""
        return float(np.linalg.norm(self.translation))

    @property
    def angle(self) -> float:
        """How far the fixture turned (rad)."""
        return float(np.linalg.norm(self.rotation))

    @property
    def distance_sigma(self) -> float | None:
        """Sigma of distance (units) along the translation; the largest of any direction if the translation is zero."""
        return None if self.covariance is None else _sigma_along(self.translation, self.covariance[3:, 3:])

    @property
    def angle_sigma(self) -> float | None:
        """Sigma of angle (rad) about the rotation axis; the largest of any axis if the rotation is zero."""
        return None if self.covariance is None else _sigma_along(self.rotation, self.covariance[:3, :3])

    @property
    def chance(self) -> float | None:
        """p-value of the movement if the fixture has not moved: chi-square with 6 degrees of freedom."""
        if self.covariance is None:
            return None
        return chance_of(np.concatenate([self.rotation, self.translation]), self.covariance)


def chance_of(motion: Floats, covariance: Floats) -> float | None:
    """p-value of a motion (6,) with covariance (6, 6) if the true motion is zero: chi-square, 6 degrees of freedom.

    None if a component has no variance.
    """
    from scipy.special import gammaincc

    scale = np.sqrt(np.diag(covariance))
    if not np.all(scale > 0):
        return None
    whitened, correlation = motion / scale, covariance / np.outer(scale, scale)
    return float(gammaincc(3.0, whitened @ np.linalg.pinv(correlation, hermitian=True) @ whitened / 2))


@frozen_value(eq=True)
class Limits:
    """The largest acceptable movement of a fixture; None means no limit.

    Parameters
    ----------
    translation : float, optional
        Distance moved by the fixture's origin, in units.
    rotation : float, optional
        Angle of rotation, in rad.

    Examples
    --------
    >>> tactfix.Limits(translation=0.2).rotation is None
    True
    """

    translation: float | None = None
    rotation: float | None = None


def exceeded(movement: Movement, limits: Limits) -> dict[str, str]:
    """The limits exceeded ("translation", "rotation"), each with a sentence; empty if none is."""
    beyond = {}
    if limits.translation is not None and movement.distance > limits.translation:
        unit = movement.units or ""
        beyond["translation"] = f"moved {movement.distance:.6g} {unit}, the limit is {limits.translation:g} {unit}"
    if limits.rotation is not None and movement.angle > limits.rotation:
        turned, limit = np.rad2deg(movement.angle), np.rad2deg(limits.rotation)
        beyond["rotation"] = f"turned {turned:.6g} deg, the limit is {limit:g} deg"
    return beyond


def compare(before: Pose, after: Pose) -> Movement:
    """Compute the movement from one pose of a fixture to another.

    Parameters
    ----------
    before, after : Pose
        Poses of the same fixture; if both have a covariance, their errors are taken as independent.

    Returns
    -------
    Movement
        In the units of before.

    Raises
    ------
    UsageError
        Only one of the poses has a unit.
    OtherFixtureError
        The poses name different fixtures.

    Notes
    -----
    R_after = exp([rotation]) R_before and t_after = t_before + translation; the covariances add up. chance is the
    p-value of d^T C^-1 d, d = (rotation, translation), by chi-square with six degrees of freedom.

    Examples
    --------
    >>> pose = tactfix.load_pose("samples/robot-cell-plate/expected.json")
    >>> tactfix.compare(pose, pose).distance
    0.0
    """
    if before.fixture and after.fixture and before.fixture != after.fixture:
        raise OtherFixtureError(before.fixture, after.fixture)
    if (before.units is None) != (after.units is None):
        raise UsageError(
            "one pose says its unit and the other does not; give " + Setting.UNITS.word + " for the one that does not"
        )
    if before.units is not None:
        after = after.in_units(before.units)
    turned = after.rotation @ before.rotation.T
    rotation = RotationVector().numbers(turned)
    translation = after.translation - before.translation
    return Movement(
        units=before.units,
        rotation=rotation,
        translation=translation,
        rotation_in_fixture=before.rotation.T @ rotation,
        translation_in_fixture=before.rotation.T @ translation,
        covariance=_covariance(before, after, turned, rotation),
    )


def _covariance(before: Pose, after: Pose, turned: Floats, rotation: Floats) -> Floats | None:
    """Covariance (6, 6) of (rotation, translation), to first order in the errors of both poses.

    exp([d2]) R2 (exp([d1]) R1)^T = exp([d2 - D d1]) D with D = R2 R1^T, and log(exp([e]) D) = log D + J^-1 e with the
    left Jacobian J of log D.
    """
    if before.covariance is None or after.covariance is None:
        return None
    to_log = np.eye(6)
    to_log[:3, :3] = inverse_left_jacobian(rotation[None])[0]
    from_before = np.eye(6)
    from_before[:3, :3] = turned
    total = after.covariance + from_before @ before.covariance @ from_before.T
    return np.asarray(to_log @ total @ to_log.T)


def _sigma_along(vector: Floats, covariance: Floats) -> float:
    """Sigma along vector (3,) by covariance (3, 3); the largest of any direction if vector is zero."""
    length = float(np.linalg.norm(vector))
    if length == 0:
        return float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]))
    direction = vector / length
    return float(np.sqrt(direction @ covariance @ direction))
