"""Results as lines of plain text: what goes to standard output, and the verdict in words."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface
from tactfix.results import LocateResult, Reason

if TYPE_CHECKING:
    from tactfix.fitting.fit import FitResult

_MOST_REASONS = 3


def decimal(value: float) -> str:
    """The shortest decimal that reads back as the same double; zero has no sign."""
    return repr(float(value) + 0.0)


def matrix_text(matrix: Floats) -> str:
    """Lines of numbers that numpy.loadtxt reads, in columns; they give back the same doubles."""
    cells = [[decimal(value) for value in row] for row in matrix]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return "".join("  ".join(map(str.rjust, row, widths)) + "\n" for row in cells)


def surface_text(surface: Surface) -> str:
    """A surface in lines of a name and its numbers."""
    match surface:
        case Plane():
            rows: dict[str, Sequence[float]] = {"point": surface.point.tolist(), "normal": surface.normal.tolist()}
        case Sphere():
            rows = {"center": surface.center.tolist(), "radius": [surface.radius]}
        case Point():
            rows = {"point": surface.point.tolist()}
        case Cylinder():
            axis = {"point": surface.point.tolist(), "direction": surface.direction.tolist()}
            rows = {**axis, "radius": [surface.radius]}
    return "".join(f"{name} {' '.join(map(decimal, values))}\n" for name, values in rows.items())


def verdict_lines(result: LocateResult) -> Iterator[str]:
    """Why there is no pose, and what to do about it; nothing where the fixture is located."""
    match result.status:
        case "underdetermined":
            free = "; ".join(motion.message for motion in result.free_motions)
            yield f"underdetermined: the contacts leave a motion free: {free or 'see the warnings'}"
        case "ambiguous":
            left = sum(candidate.accepted for candidate in result.candidates)
            yield f"ambiguous: {left} poses explain the contacts; --json lists them"
        case "inconsistent":
            yield f"inconsistent: no pose explains the contacts{_best(result)}"
            for candidate in result.candidates[:_MOST_REASONS]:
                yield from (f"  {reason_text(reason)}" for reason in candidate.reasons[:_MOST_REASONS])
        case "located":
            pass
    if result.next_contact is not None:
        yield f"next contact: {result.next_contact.message}"


def fit_verdict_lines(result: "FitResult") -> Iterator[str]:
    """Why there is no surface; nothing where there is one."""
    match result.status:
        case "underdetermined":
            yield f"underdetermined: the contacts leave the {result.kind} free to move"
        case "ambiguous":
            left = [candidate for candidate in result.candidates if candidate.accepted]
            yield f"ambiguous: {len(left)} {result.kind}s explain the contacts; --json lists them"
        case "inconsistent":
            yield f"inconsistent: no {result.kind} explains the contacts"
            for candidate in result.candidates[:_MOST_REASONS]:
                yield from (f"  {reason_text(reason)}" for reason in candidate.reasons[:_MOST_REASONS])
        case "located":
            pass


def reason_text(reason: Reason) -> str:
    """Why a candidate fell, with the feature and the row."""
    place = ", ".join(part for part in (reason.feature, f"row {reason.row}" if reason.row else None) if part)
    return f"{reason.code}: {place}: {reason.message}" if place else f"{reason.code}: {reason.message}"


def _best(result: LocateResult) -> str:
    if result.chi2 is None or result.chi2_limit is None:
        return ""
    return f" (chi2 {result.chi2:.3g}, limit {result.chi2_limit:.3g})"
