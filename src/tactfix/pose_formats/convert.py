"""Writes a pose in a dialect, reads it back and compares it; rejects it if too much accuracy was lost."""

from dataclasses import replace
from typing import Final

import numpy as np

from tactfix.errors import PoseRefusedError, UsageError
from tactfix.formats import LEVER_ARM_MM
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import rotation_from_vector, skew
from tactfix.pose_formats import find_dialect
from tactfix.pose_formats.dialect import Dialect, Numbers
from tactfix.pose_formats.orientation import EulerAngles, RotationVector, TurnAboutZ
from tactfix.pose_formats.pose import Pose
from tactfix.settings import Setting
from tactfix.units import factor
from tactfix.values import frozen_value

_MOST_OF_SIGMA: Final = 0.1
"""Largest rounding of the text as a share of the pose's sigma: added in quadrature, a tenth enlarges sigma by half a
per cent."""
_NOTED_OF_SIGMA: Final = 0.01
"""Rounding up to this share of sigma gets no note: in quadrature it adds 0.005 per cent to sigma."""
_MOST_TILT: Final = 9.21
"""99 per cent quantile of chi-square with two degrees of freedom (-2 log 0.01): a larger tilt is significant, and a
format without tilt would lose it."""
_ROUND_TRIP: Final = 1e-12
"""Differences of pose and text up to this (rad, or relative) are double arithmetic, some thousand roundings of 2e-16;
larger ones are rounding of the text."""
_ANGLE_STEP: Final = 1e-6
"""Step of the central differences, in rad: relative truncation error 1e-12, rounding error 1e-10."""
_LOCK: Final = 1e-5
"""Distance from gimbal lock (rad) below which only the sum or difference of two angles is determined; the same below
_LOCK_SIGMAS sigma. A derivative of the angles grows as 1 / distance: here it is 1e5, and a rounding of the text
to 1e-6 degrees becomes 0.1 degrees."""
_LOCK_SIGMAS: Final = 5.0
"""Distance from gimbal lock, in sigmas of the rotation."""


@frozen_value(eq=True)
class Written:
    """A pose as text in a dialect, read back and compared, and notes such as on its rounding."""

    text: str | bytes
    notes: tuple[str, ...]


@frozen_value
class Rounding:
    """Deviation of a text from its pose: d_rot (3,) in rad and d_t (3,) in units, in base axes; lever_arm in units."""

    d_rot: Floats
    d_t: Floats
    units: str
    lever_arm: float

    @property
    def at_lever_arm(self) -> float:
        """Upper bound (units) of the displacement of a point at lever_arm from the fixture's origin."""
        return float(np.linalg.norm(self.d_t) + self.lever_arm * np.linalg.norm(self.d_rot))

    def of_sigma(self, covariance: Floats) -> float:
        """Largest ratio of displacement to sigma, by coordinate, at the origin and at lever_arm along each axis."""
        arms = self.lever_arm * np.vstack([np.zeros(3), np.eye(3), -np.eye(3)])
        by_rotation = -skew(arms)  # d_x = d_rot x arm + d_t
        shifts = np.abs(by_rotation @ self.d_rot + self.d_t)
        jacobians = np.concatenate([by_rotation, np.broadcast_to(np.eye(3), (7, 3, 3))], axis=2)
        variances = np.einsum("kij,jl,kil->ki", jacobians, covariance, jacobians)
        sigmas = np.sqrt(np.maximum(variances, 0.0))
        with np.errstate(divide="ignore", invalid="ignore"):
            return float(np.nanmax(np.where(shifts == 0, 0.0, shifts / sigmas)))

    def __str__(self) -> str:
        origin, turn = np.linalg.norm(self.d_t), np.rad2deg(np.linalg.norm(self.d_rot))
        return (
            f"the origin by {origin:.2g} {self.units} and the rotation by {turn:.2g} deg, together at most "
            f"{self.at_lever_arm:.2g} {self.units} at {self.lever_arm:g} {self.units} from the fixture's origin"
        )


def write_pose(name: str, pose: Pose, *, force: bool = False, lever_arm_mm: float = LEVER_ARM_MM) -> Written:
    """Write a pose for a controller, ROS, or a file.

    Parameters
    ----------
    name : str
        The format, such as "kuka" or "urdf".
    pose : Pose
        base_from_fixture with its unit; lengths are written in the unit of the format.
    force : bool
        Write the pose even if the loss exceeds what is allowed.
    lever_arm_mm : float
        Distance from the fixture's origin at which rounding is assessed, in mm.

    Returns
    -------
    Written
        text (str, or bytes of a binary format), and notes.

    Raises
    ------
    PoseRefusedError
        The format cannot represent the pose (a tilt in G10), or its rounding exceeds a tenth of sigma anywhere within
        lever_arm_mm of the fixture's origin, unless forced. Smaller rounding gives a note, above a hundredth of sigma
        or without a covariance.
    UsageError
        The format needs a unit and the pose has none.

    Notes
    -----
    The text is read back and compared. A tilt that is not significant by the covariance (at 99 per cent) is dropped if
    the format has no tilt.

    Examples
    --------
    >>> pose = tactfix.load_pose("samples/robot-cell-plate/expected.json")
    >>> print(tactfix.write_pose("ur", pose).text.splitlines()[-1][:20])
    p[1.184200000, -0.35
    """
    dialect = find_dialect(name)
    if dialect.units and pose.units is None:
        raise UsageError(
            f"{name} is in {dialect.units}, and the pose does not say its unit; give " + Setting.UNITS.word
        )
    pose = pose.in_units(dialect.units) if dialect.units else pose
    sigmas = () if dialect.numbers is None or pose.covariance is None else (_sigmas(dialect.numbers, pose),)
    text = dialect.write(pose, sigmas)
    rounding = measured(pose, dialect.read(text), lever_arm_mm)
    notes = _rounding_notes(dialect, pose, rounding, force)
    return Written(text, notes if dialect.comments else (*notes, *(f"{name}: {remark}" for remark in sigmas)))


def measured(pose: Pose, back: Pose, lever_arm_mm: float) -> Rounding:
    """Deviation of back from pose; both in the same units."""
    d_rot = RotationVector().numbers(back.rotation @ pose.rotation.T)
    d_t = back.translation - pose.translation
    if np.linalg.norm(d_rot) < _ROUND_TRIP:
        d_rot = np.zeros(3)
    arm = lever_arm_mm * factor("mm", pose.units) if pose.units else lever_arm_mm
    return Rounding(
        d_rot, np.where(np.abs(d_t) < _ROUND_TRIP * np.abs(pose.translation), 0.0, d_t), pose.units or "", arm
    )


def _rounding_notes(dialect: Dialect, pose: Pose, rounding: Rounding, force: bool) -> tuple[str, ...]:
    """Notes on rounding; PoseRefusedError if it is too large."""
    most_t, most_rot = dialect.most_rounding
    turn = float(np.linalg.norm(rounding.d_rot))
    far = float(np.abs(rounding.d_t).max())
    if far > most_t * (1 + 1e-6) + _ROUND_TRIP * (1 + np.abs(pose.translation).max()) or turn > most_rot + _ROUND_TRIP:
        if pose.covariance is not None and _is_level(dialect, pose, rounding):
            level = replace(rounding, d_rot=rounding.d_rot * [0.0, 0.0, 1.0])
            tilt = np.rad2deg(np.linalg.norm(rounding.d_rot[:2]))
            note = f"{dialect.name} leaves out a tilt of {tilt:.2g} deg, which is within its sigma"
            return (note, *_rounding_notes(dialect, pose, level, force))
        reason = f"cannot represent this pose: it would lose {np.rad2deg(turn):.3g} deg of tilt and move {rounding}"
        if not force:
            raise PoseRefusedError(
                dialect.name, reason, "take a dialect that can tilt, level the fixture, or give " + Setting.FORCE.word
            )
        return (f"{dialect.name}: forced, although it {reason}",)
    if rounding.at_lever_arm == 0:
        return ()
    description = f"rounds {rounding}"
    if pose.covariance is None:
        return (f"{dialect.name} {description}",)
    ratio = rounding.of_sigma(pose.covariance)
    description += f" ({ratio:.2g} sigma)"
    if ratio > _MOST_OF_SIGMA and not force:
        raise PoseRefusedError(
            dialect.name, description, "more than a tenth of sigma; take another dialect, or give " + Setting.FORCE.word
        )
    return (f"{dialect.name} {description}",) if ratio > _NOTED_OF_SIGMA else ()


def _is_level(dialect: Dialect, pose: Pose, rounding: Rounding) -> bool:
    """Whether a dialect without tilt loses only a tilt that is not significant at 99 per cent."""
    tilt = rounding.d_rot[:2]
    if dialect.numbers is None or not isinstance(dialect.numbers.orientation, TurnAboutZ) or not tilt.any():
        return False
    assert pose.covariance is not None
    with np.errstate(all="ignore"):
        chi2 = float(tilt @ np.linalg.pinv(pose.covariance[:2, :2], hermitian=True) @ tilt)
    explained = pose.covariance[:2, :2] @ np.linalg.pinv(pose.covariance[:2, :2], hermitian=True) @ tilt
    return bool(np.allclose(explained, tilt, rtol=1e-6, atol=0)) and chi2 < _MOST_TILT


def sigmas_of_numbers(numbers: Numbers, pose: Pose) -> Floats:
    """One standard deviation of each number of the dialect (n,), in its unit; pose in numbers.units.

    First order, by central differences of the numbers over a rotation about each base axis. In gimbal lock the
    angles have none (nan): first and last are determined only together, and the middle one folds back at its limit.
    """
    if pose.covariance is None:
        raise ValueError("the covariance of this pose is not known")
    orientation, rotation = numbers.orientation, pose.rotation
    reference = orientation.numbers(rotation)
    columns = []
    for step in _ANGLE_STEP * np.eye(3):
        ahead, behind = (
            orientation.nearest(orientation.numbers(rotation_from_vector(s) @ rotation), reference)
            for s in (step, -step)
        )
        columns.append((ahead - behind) / (2 * _ANGLE_STEP))
    jacobian = np.column_stack(columns)
    sigmas = np.sqrt(np.einsum("ij,jk,ik->i", jacobian, pose.covariance[:3, :3], jacobian))
    if isinstance(orientation, EulerAngles) and _locked(orientation, pose):
        sigmas[:] = np.nan
    return np.concatenate([np.sqrt(np.diag(pose.covariance)[3:]), sigmas])


def _locked(orientation: EulerAngles, pose: Pose) -> bool:
    """Whether the middle angle is so close to gimbal lock that first and last angle are not determined separately."""
    return orientation.lock_distance(pose.rotation) < max(_LOCK, _LOCK_SIGMAS * _rotation_sigma(pose))


def _rotation_sigma(pose: Pose) -> float:
    """Largest sigma (rad) of the rotation about any axis."""
    assert pose.covariance is not None
    return float(np.sqrt(np.linalg.eigvalsh(pose.covariance[:3, :3])[-1]))


def _sigmas(numbers: Numbers, pose: Pose) -> str:
    """The sigmas as one line; in gimbal lock the largest sigma of the rotation instead of those of the angles."""
    sigmas = sigmas_of_numbers(numbers, pose)
    units = [numbers.units] * 3 + [numbers.angle_unit] * (len(sigmas) - 3)
    rows = list(zip(numbers.labels, sigmas, units, strict=True))
    parts = [f"{label} {sigma:.2g} {unit}".strip() for label, sigma, unit in rows if not np.isnan(sigma)]
    if np.isnan(sigmas).any():
        parts.append(f"rotation {np.rad2deg(_rotation_sigma(pose)):.2g} deg, no angle for itself in gimbal lock")
    return "sigma: " + ", ".join(parts)
