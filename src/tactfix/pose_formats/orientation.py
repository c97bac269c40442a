"""Rotations as numbers of controllers: Euler angles, quaternions, rotation vectors, one angle.

scipy's Rotation does the arithmetic. Canonical numbers: angles in (-180, 180]; the middle angle in [-90, 90], or in
[0, 180] if the first and last axis are the same; in gimbal lock the last intrinsic angle is 0; of q and -q the one
whose first non-zero number of (w, x, y, z) is positive; of two rotation vectors at 180 degrees the one whose first
non-zero number is positive; 0.0 instead of -0.0.
"""

import warnings
from typing import Literal, Protocol

import numpy as np

from tactfix.formats import MOST_OFF_UNIT, MOST_RADIANS
from tactfix.geometry.arrays import Floats
from tactfix.pose_formats.pose import syntax_error
from tactfix.values import frozen_value

_ZERO = 1e-12
"""Numbers smaller than this are rounded zeros (some 1e-16, times a chain of products), and their sign is ignored."""
LOCK_SLACK = 2e-7
"""Largest change (rad) of a rotation near gimbal lock: scipy treats a middle angle within 1e-7 rad as locked and drops
a rotation up to that size; together with that of the angle, twice 1e-7."""


def _refuse_turns(angle: float) -> None:
    """Raise PoseSyntaxError for an angle (rad) of more than a full turn."""
    if angle > MOST_RADIANS:
        raise syntax_error(f"an angle of {angle:.6g} rad is more than a full turn", "write it in rad, not in degrees")


class Orientation(Protocol):
    """A representation of rotations (3, 3) by numbers (n,)."""

    @property
    def radians(self) -> float:
        """Largest rotation angle (rad) per unit change of one number."""
        ...

    def numbers(self, rotation: Floats) -> Floats:
        """The canonical numbers (n,) of rotation (3, 3)."""
        ...

    def rotation(self, numbers: Floats) -> Floats:
        """The rotation (3, 3) of numbers (n,)."""
        ...

    def nearest(self, numbers: Floats, reference: Floats) -> Floats:
        """Of all numbers (n,) of the same rotation, those nearest to reference (n,)."""
        ...


@frozen_value(eq=True)
class EulerAngles:
    """Three angles about the intrinsic axes of sequence ("ZYX": R = Rz(a) Ry(b) Rx(c)).

    order: written[i] = intrinsic[order[i]].
    """

    sequence: Literal["ZYX", "XYZ", "ZYZ", "ZXZ"]
    order: tuple[int, int, int] = (0, 1, 2)
    degrees: bool = True

    @property
    def radians(self) -> float:
        """Rad per unit of one angle."""
        return np.pi / 180 if self.degrees else 1.0

    @property
    def same_axis(self) -> bool:
        """Whether the first and the last angle turn about the same axis (proper Euler angles)."""
        return self.sequence[0] == self.sequence[2]

    def lock_distance(self, rotation: Floats) -> float:
        """Distance (rad) of the middle angle from gimbal lock."""
        middle = self._intrinsic(rotation)[1]
        return float(min(middle, np.pi - middle) if self.same_axis else np.pi / 2 - abs(middle))

    def numbers(self, rotation: Floats) -> Floats:
        """Angles (3,) in the written order."""
        angles = self._intrinsic(rotation)[list(self.order)]
        angles = np.where(angles <= -np.pi, np.pi, angles)
        return (np.rad2deg(angles) if self.degrees else angles) + 0.0  # + 0.0 turns -0.0 into 0.0

    def rotation(self, numbers: Floats) -> Floats:
        """R (3, 3) of angles (3,) in the written order."""
        from scipy.spatial.transform import Rotation

        if not self.degrees:
            _refuse_turns(float(np.abs(numbers).max()))
        intrinsic = np.empty(3)
        intrinsic[list(self.order)] = numbers
        return np.asarray(Rotation.from_euler(self.sequence, intrinsic, degrees=self.degrees).as_matrix())

    def nearest(self, numbers: Floats, reference: Floats) -> Floats:
        """Each angle within half a turn of its reference."""
        return _unwrapped(numbers, reference, 360.0 if self.degrees else 2 * np.pi)

    def _intrinsic(self, rotation: Floats) -> Floats:
        """Intrinsic angles (3,) in rad; in gimbal lock scipy warns and sets the last one to zero, as wanted."""
        from scipy.spatial.transform import Rotation

        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Gimbal lock")
            return np.asarray(Rotation.from_matrix(rotation.copy()).as_euler(self.sequence))


@frozen_value(eq=True)
class Quaternion:
    """A unit quaternion, scalar first (w, x, y, z) or last (x, y, z, w)."""

    scalar_first: bool

    @property
    def radians(self) -> float:
        """A rotation angle is twice that of its quaternion."""
        return 2.0

    def numbers(self, rotation: Floats) -> Floats:
        """Quaternion (4,) in the written order."""
        from scipy.spatial.transform import Rotation

        wxyz = np.roll(Rotation.from_matrix(rotation.copy()).as_quat(), 1)
        wxyz = _first_positive(wxyz) + 0.0
        return wxyz if self.scalar_first else np.roll(wxyz, -1)

    def rotation(self, numbers: Floats) -> Floats:
        """R (3, 3) of a quaternion (4,) in the written order; q and -q are the same rotation."""
        from scipy.spatial.transform import Rotation

        length = float(np.linalg.norm(numbers))
        if abs(length - 1) > MOST_OFF_UNIT:
            raise syntax_error(f"the quaternion has length {length:.6g}, not 1", "check the order of its values")
        return np.asarray(Rotation.from_quat(np.roll(numbers, -1) if self.scalar_first else numbers).as_matrix())

    def nearest(self, numbers: Floats, reference: Floats) -> Floats:
        """q or -q."""
        return -numbers if numbers @ reference < 0 else numbers


@frozen_value(eq=True)
class RotationVector:
    """Axis times angle, in rad."""

    @property
    def radians(self) -> float:
        """Rad per rad."""
        return 1.0

    def numbers(self, rotation: Floats) -> Floats:
        """Rotation vector (3,) in rad, no longer than pi."""
        from scipy.spatial.transform import Rotation

        vector = np.asarray(Rotation.from_matrix(rotation.copy()).as_rotvec())
        half_turn = np.linalg.norm(vector) > np.pi - _ZERO
        return (_first_positive(vector) if half_turn else vector) + 0.0

    def rotation(self, numbers: Floats) -> Floats:
        """R (3, 3) of a rotation vector (3,)."""
        from scipy.spatial.transform import Rotation

        _refuse_turns(float(np.linalg.norm(numbers)))
        return np.asarray(Rotation.from_rotvec(numbers).as_matrix())

    def nearest(self, numbers: Floats, reference: Floats) -> Floats:
        """The vector, or the one with the opposite sense of rotation."""
        angle = float(np.linalg.norm(numbers))
        other = numbers if angle == 0 else numbers * (1 - 2 * np.pi / angle)
        return other if np.linalg.norm(other - reference) < np.linalg.norm(numbers - reference) else numbers


@frozen_value(eq=True)
class TurnAboutZ:
    """One angle about z in degrees; any tilt is lost."""

    @property
    def radians(self) -> float:
        """Rad per degree."""
        return np.pi / 180

    def numbers(self, rotation: Floats) -> Floats:
        """The angle (1,) of the rotation about z nearest to rotation."""
        angle = np.arctan2(rotation[1, 0] - rotation[0, 1], rotation[0, 0] + rotation[1, 1])
        return np.array([180.0 if angle <= -np.pi else np.rad2deg(angle) + 0.0])

    def rotation(self, numbers: Floats) -> Floats:
        """R (3, 3) of a rotation about z."""
        cosine, sine = np.cos(np.deg2rad(numbers[0])), np.sin(np.deg2rad(numbers[0]))
        return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])

    def nearest(self, numbers: Floats, reference: Floats) -> Floats:
        """The angle within half a turn of its reference."""
        return _unwrapped(numbers, reference, 360.0)


def _first_positive(numbers: Floats) -> Floats:
    """Numbers or their negative, whichever has its first non-zero number positive."""
    return np.asarray(numbers * np.sign(numbers[np.argmax(np.abs(numbers) > _ZERO)]))


def _unwrapped(angles: Floats, reference: Floats, turn: float) -> Floats:
    """Angles within half a turn of reference."""
    return np.asarray(reference + (angles - reference + turn / 2) % turn - turn / 2)
