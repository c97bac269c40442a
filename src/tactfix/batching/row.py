"""The row of results of one contact set in a batch."""

import math
from collections.abc import Mapping
from typing import Any, Literal, TypeAlias

import numpy as np

from tactfix.locate_result import LocateResult
from tactfix.results import Status
from tactfix.values import frozen_value

RowStatus: TypeAlias = Literal[Status, "error"]


@frozen_value(eq=True)
class BatchRow:
    """The result of one set, in the fixture's units.

    Attributes
    ----------
    name : str
        Of the set.
    status : {"located", "underdetermined", "ambiguous", "inconsistent", "error"}
        That of locate, or "error" if there is no result.
    acceptable : bool
        Located and within all gates.
    message : str
        Why the set is not acceptable; empty if it is.
    units : str
        Of all lengths.
    transform : tuple of 16 floats or None
        base_from_fixture, row by row; None unless located, as sigmas.
    sigmas : tuple of 6 floats or None
        Of rx ry rz (rad) and tx ty tz (units).
    chi2 : float or None
        As in the result of `locate`, like dof and rms; None if there is none.
    dof : int or None
        Equations minus unknowns.
    rms : float or None
        Of the residuals, in units.
    warnings : tuple of str
        In words.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> row = tactfix.batch(fixture, ["samples/robot-cell-plate/contacts.csv"])[0]
    >>> row.acceptable, row.dof
    (True, 9)
    """

    name: str
    status: RowStatus
    acceptable: bool
    message: str
    units: str
    transform: tuple[float, ...] | None = None
    sigmas: tuple[float, ...] | None = None
    chi2: float | None = None
    dof: int | None = None
    rms: float | None = None
    warnings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        detail = self.message or ("" if self.rms is None else f"rms {self.rms:.2g} {self.units}")
        return f"<BatchRow {self.name!r}: {self.status}{detail and f', {detail}'}>"


def row_of_result(
    name: str, result: LocateResult, message: str, *, acceptable: bool, notes: tuple[str, ...]
) -> BatchRow:
    """The row of a result; notes from reading its contacts precede its warnings."""
    pose, covariance = result.base_from_fixture, result.covariance
    return BatchRow(
        name=name,
        status=result.status,
        acceptable=acceptable,
        message=message,
        units=result.units,
        transform=None if pose is None else tuple((pose + 0.0).ravel().tolist()),
        sigmas=None if covariance is None else tuple(np.sqrt(np.diag(covariance)).tolist()),
        chi2=_finite(result.chi2),
        dof=result.dof,
        rms=_finite(result.rms),
        warnings=(*notes, *result.warnings),
    )


def row_of_failure(name: str, message: str, units: str) -> BatchRow:
    """The row of a set without a result; the lines of its message are joined."""
    return BatchRow(name, "error", acceptable=False, message="; ".join(message.splitlines()), units=units)


def row_json(row: BatchRow) -> dict[str, Any]:
    """The JSON of a row: the transform as 4 rows of 4, null for missing values."""
    flat = row.transform
    return {
        "set": row.name,
        "status": row.status,
        "acceptable": row.acceptable,
        "message": row.message,
        "units": row.units,
        "transform": None if flat is None else [list(flat[4 * k : 4 * k + 4]) for k in range(4)],
        "sigmas": None if row.sigmas is None else list(row.sigmas),
        "chi2": row.chi2,
        "dof": row.dof,
        "rms": row.rms,
        "warnings": list(row.warnings),
    }


def row_of_json(saved: Mapping[str, Any]) -> BatchRow:
    """The inverse of row_json."""
    transform, sigmas = saved["transform"], saved["sigmas"]
    return BatchRow(
        name=saved["set"],
        status=saved["status"],
        acceptable=saved["acceptable"],
        message=saved["message"],
        units=saved["units"],
        transform=None if transform is None else tuple(value for line in transform for value in line),
        sigmas=None if sigmas is None else tuple(sigmas),
        chi2=saved["chi2"],
        dof=saved["dof"],
        rms=saved["rms"],
        warnings=tuple(saved["warnings"]),
    )


def _finite(value: float | None) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None
