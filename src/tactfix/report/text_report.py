"""Results as lines of plain text: the standard output, and the status in words."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from tactfix.acceptance import sigma_at
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface
from tactfix.locate_result import LocateResult
from tactfix.results import Candidate, NextContact, Reason
from tactfix.wording import decimals, fixed, listed

if TYPE_CHECKING:
    from tactfix.fitting.result import FitCandidate, FitResult

_MOST_REASONS = 3
"""Largest number of reasons listed per candidate, and of candidates listed with reasons."""
SIGMAS_95: Final = 1.96
"""Standard deviations to either side of the mean that contain 95 per cent of a normal distribution."""


def decimal(value: float) -> str:
    """The shortest decimal that reads back as the same double; zero has no sign."""
    return repr(float(value) + 0.0)


def matrix_text(matrix: Floats) -> str:
    """Numbers in columns, as numpy.loadtxt reads them; they read back as the same doubles."""
    cells = [[decimal(value) for value in row] for row in matrix]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return "".join("  ".join(map(str.rjust, row, widths)) + "\n" for row in cells)


def rounded_matrix_text(matrix: Floats, covariance: Floats | None) -> str:
    """A pose (4, 4) for people: two digits beyond the first of the smallest sigma; all digits without covariance."""
    if covariance is None:
        return matrix_text(matrix)
    sigmas = np.sqrt(np.diag(covariance))
    turn, shift = (decimals(_smallest(part)) for part in (sigmas[:3], sigmas[3:]))
    cells = [[fixed(value, turn) for value in row[:3]] + [fixed(row[3], shift)] for row in matrix[:3]]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return "".join("  ".join(map(str.rjust, row, widths)) + "\n" for row in [*cells, ["0", "0", "0", "1"]])


def _smallest(sigmas: Floats) -> float:
    """The smallest sigma above 0; constrained directions have sigma 0."""
    return float(min((sigma for sigma in sigmas if sigma > 0), default=0.0))


def surface_text(surface: Surface, sigma: Mapping[str, Floats] | None = None) -> str:
    """A surface as lines of a name and its numbers; with sigma, rounded accordingly."""
    lines = []
    for name, values in surface_rows(surface).items():
        spread = None if sigma is None or name not in sigma else _smallest(sigma[name])
        shown = [decimal(value) if not spread else fixed(value, decimals(spread)) for value in values]
        lines.append(f"{name} {' '.join(shown)}\n")
    return "".join(lines)


def surface_rows(surface: Surface) -> dict[str, Sequence[float]]:
    """The numbers of a surface by name."""
    match surface:
        case Plane():
            return {"point": surface.point.tolist(), "normal": surface.normal.tolist()}
        case Sphere():
            return {"center": surface.center.tolist(), "radius": [surface.radius]}
        case Point():
            return {"point": surface.point.tolist()}
        case Cylinder():
            axis = {"point": surface.point.tolist(), "direction": surface.direction.tolist()}
            return {**axis, "radius": [surface.radius]}


def sentence(result: LocateResult) -> str:
    """The answer in one sentence."""
    if result.status != "located":
        return next(status_lines(result))
    sigma = sigma_at(result)
    if sigma is None:
        return "located"
    return f"located; the origin is known to {SIGMAS_95 * sigma:.2g} {result.units} (95 %, along its worst direction)"


def status_lines(result: LocateResult, listed: str = "") -> Iterator[str]:
    """Why there is no pose, and what to do about it; empty if the fixture is located.

    listed: a pointer to the list of ambiguous poses, with its leading semicolon.
    """
    match result.status:
        case "underdetermined":
            free = "; ".join(motion.message for motion in result.free_motions)
            yield f"underdetermined: the contacts leave a motion free: {free or 'see the warnings'}"
        case "ambiguous":
            accepted = sum(candidate.accepted for candidate in result.candidates)
            yield f"ambiguous: {accepted} poses explain the contacts{listed}"
        case "inconsistent":
            yield f"inconsistent: no pose explains the contacts{_best(result)}"
            yield from _reason_lines(result.candidates)
        case "located":
            pass
    if result.next_contact is not None:
        yield f"next contact: {result.next_contact.message}{_further(result.next_contact)}"


def _further(contact: NextContact) -> str:
    """The further contacts to make after this one, in words."""
    touches = [touch.message.removeprefix("touch ") for touch in contact.further]
    return f"; these are enough: then {listed(touches)}" if touches else ""


def _reason_lines(candidates: "Sequence[Candidate | FitCandidate]") -> Iterator[str]:
    """Why the first candidates were eliminated, one reason per line."""
    for candidate in candidates[:_MOST_REASONS]:
        yield from (f"  {reason_text(reason)}" for reason in candidate.reasons[:_MOST_REASONS])


def fit_status_lines(result: "FitResult", listed: str = "", size: str = "") -> Iterator[str]:
    """Why there is no surface; empty if there is one.

    listed: as in `status_lines`. size: the given radius with its unit, in words after the kind.
    """
    match result.status:
        case "underdetermined":
            yield f"underdetermined: the contacts leave the {result.kind} free to move"
        case "ambiguous":
            accepted = [candidate for candidate in result.candidates if candidate.accepted]
            yield f"ambiguous: {len(accepted)} {result.kind}s explain the contacts{listed}"
        case "inconsistent":
            yield f"inconsistent: no {result.kind}{size} explains the contacts"
            yield from _reason_lines(result.candidates)
        case "located":
            pass


LEAST_RESIDUAL: Final = 1e-6
"""If all residuals (units) are smaller, they are written in powers of ten: the contacts were computed, not measured."""


def residual_text(residual: float, largest: float) -> str:
    """A residual with its sign, all of one table with the decimals that give the largest one three digits."""
    if largest <= LEAST_RESIDUAL:
        return f"{residual:+.2e}"
    return f"{residual + 0.0:+.{decimals(largest) + 1}f}"


def reason_text(reason: Reason) -> str:
    """Why a candidate was eliminated, with feature and row, unless the message names them."""
    row = f"row {reason.row}" if reason.row else ""
    place = ", ".join(part for part in (reason.feature, row) if part and (part != row or row not in reason.message))
    return f"{reason.code}: {place}: {reason.message}" if place else f"{reason.code}: {reason.message}"


def _best(result: LocateResult) -> str:
    if result.chi2 is None or result.chi2_limit is None:
        return ""
    return f" (chi2 {result.chi2:.3g}, limit {result.chi2_limit:.3g})"
