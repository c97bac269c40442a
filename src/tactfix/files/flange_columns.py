"""Orientation of the flange at each touch, from the columns of a contact file; their names determine the convention.

base_from_flange, rotations (n, 3, 3): qw, qx, qy, qz, a quaternion; rx, ry, rz, a rotation vector in rad; a, b, c in
degrees as KUKA has them, Rz(a) Ry(b) Rx(c); w, p, r in degrees as Fanuc has them, about the fixed axes x, y, z: the
same product Rz(r) Ry(p) Rx(w).
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final, TypeAlias

import numpy as np

from tactfix.errors import Problem
from tactfix.files.contact_header import ORIENTATION_COLUMNS
from tactfix.files.contact_table import Table, numbers
from tactfix.formats import MOST_OFF_UNIT, MOST_RADIANS
from tactfix.geometry.arrays import Bools, Floats, lengths
from tactfix.geometry.rigid import rotation_from_quaternion, rotation_from_vector
from tactfix.units import MOST_LENGTH

_MOST_DEGREES: Final = 720.0
"""Largest valid Euler angle: two turns, more than any controller shows."""

Check: TypeAlias = Callable[[Floats], Bools]


def _from_quaternions(numbers: Floats) -> Floats:
    return rotation_from_quaternion(numbers / lengths(numbers)[:, None])


def _from_zyx(angles: Floats) -> Floats:
    """Rz Ry Rx of angles (n, 3) in degrees, in that order."""
    z, y, x = (rotation_from_vector(np.radians(angles[:, k, None]) * np.eye(3)[2 - k]) for k in range(3))
    return np.asarray(z @ y @ x)


_ROTATIONS: Final[Mapping[tuple[str, ...], Callable[[Floats], Floats]]] = MappingProxyType(
    {
        ("qw", "qx", "qy", "qz"): _from_quaternions,
        ("rx", "ry", "rz"): rotation_from_vector,
        ("a", "b", "c"): _from_zyx,
        ("w", "p", "r"): lambda angles: _from_zyx(angles[:, ::-1]),
    }
)
"""The rotations of the numbers (n, k) of each set of columns."""

_NO_ANGLE: Final[tuple[Check, str, str]] = (
    lambda angles: np.abs(angles).max(axis=1) > _MOST_DEGREES,
    "an angle of the flange is more than two turns",
    "write degrees",
)
_WRONG: Final[Mapping[tuple[str, ...], tuple[Check, str, str]]] = MappingProxyType(
    {
        ("qw", "qx", "qy", "qz"): (
            lambda q: np.abs(lengths(q) - 1) > MOST_OFF_UNIT,
            "the quaternion qw, qx, qy, qz is not of length 1",
            "check the order and the digits; the scalar part is qw",
        ),
        ("rx", "ry", "rz"): (
            lambda v: lengths(v) > MOST_RADIANS,
            "the rotation vector rx, ry, rz is longer than a full turn in rad",
            "write it in rad; if these are degrees, divide by 57.29578, if they are angles, name the columns so",
        ),
        ("a", "b", "c"): _NO_ANGLE,
        ("w", "p", "r"): _NO_ANGLE,
    }
)


def flange_rotations(table: Table, problems: list[Problem]) -> Floats | None:
    """base_from_flange (n, 3, 3) of each row; None if the file has no such columns, or they have problems."""
    names = next((names for names in ORIENTATION_COLUMNS if names[0] in table.columns), None)
    if names is None:
        return None
    before = len(problems)
    values = numbers(table, names, problems)
    if len(problems) == before:
        is_wrong, message, remedy = _WRONG[names]
        # Clipped, so that no square overflows: each check rejects values this large.
        wrong = is_wrong(np.clip(values, -MOST_LENGTH, MOST_LENGTH))
        problems += [table.problem(int(index), message, remedy) for index in np.flatnonzero(wrong)]
    return _ROTATIONS[names](values) if len(problems) == before else None
