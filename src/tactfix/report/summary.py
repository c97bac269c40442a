"""The summary of locate for people: pose, sigmas, residuals as bars, candidates, what to do next; 80 columns."""

import math
from collections.abc import Sequence
from io import StringIO
from typing import IO, Final

import numpy as np
from rich.console import Console, Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from tactfix.acceptance import point_covariance, sigma_at, worst_sigma
from tactfix.geometry.arrays import Floats
from tactfix.report.text_report import reason_text
from tactfix.results import Candidate, ContactResidual, LocateResult, Status

_MOST_CONTACTS: Final = 20
_MOST_CANDIDATES: Final = 8
_HALF_BAR: Final = 10
_COLORS: Final[dict[Status, str]] = {
    "located": "green",
    "underdetermined": "yellow",
    "ambiguous": "yellow",
    "inconsistent": "red",
}


def print_summary(result: LocateResult, file: IO[str], at: Floats | None = None) -> None:
    """Print the summary on a file; at: a point (3,) of the fixture frame whose sigma is told too."""
    console = Console(file=file, highlight=False)
    console.print(summary(result, at, ascii_only=console.options.ascii_only))


def summary_html(result: LocateResult) -> str:
    """The summary as HTML with its styles inline, for notebooks."""
    console = Console(file=StringIO(), record=True, width=100, highlight=False)
    console.print(summary(result))
    return console.export_html(inline_styles=True, code_format="<pre style='line-height:1.2'><code>{code}</code></pre>")


def summary(result: LocateResult, at: Floats | None = None, *, ascii_only: bool = False) -> RenderableType:
    """The summary as something that rich prints."""
    parts: list[RenderableType] = [_headline(result)]
    if result.base_from_fixture is not None:
        parts.append(_pose(result, result.base_from_fixture, at))
    if result.contacts:
        parts.append(_residuals(result, ascii_only))
    if len(result.candidates) > 1 or result.status != "located":
        parts.append(_candidates(result))
    parts += [Text(f"free: {motion.message}", "yellow") for motion in result.free_motions]
    return Group(*(Padding(part, (0, 0, 1, 1)) for part in parts))


def _headline(result: LocateResult) -> Text:
    line = Text.assemble((result.fixture, "bold"), "  ", (result.status, f"bold {_COLORS[result.status]}"))
    if result.chi2 is not None:
        limit = "" if result.chi2_limit is None else f" (limit {result.chi2_limit:.3g})"
        line.append(f"  chi2 {result.chi2:.3g}{limit}, dof {result.dof}")
    if result.rms is not None:
        line.append(f", rms {result.rms:.2g} {result.units}")
    return line


def _pose(result: LocateResult, base_from_fixture: Floats, at: Floats | None) -> Table:
    """Origin and rotation vector with their sigmas, then the axes of the fixture in base."""
    table = Table("in base", *"xyz", "worst", box=None, pad_edge=False, header_style="dim")
    for column in table.columns[1:]:
        column.justify = "right"
    _keep_whole(table)
    sigmas = None if result.covariance is None else np.sqrt(np.diag(result.covariance))
    rotation = np.rad2deg(_rotation_vector(base_from_fixture[:3, :3]))
    origin = base_from_fixture[:3, 3]
    worst = sigma_at(result)
    _number_row(table, f"origin {result.units}", origin, None if sigmas is None else sigmas[3:], worst)
    turn = None if sigmas is None else np.rad2deg(sigmas[:3])
    most = None if result.covariance is None else math.degrees(float(worst_sigma(result.covariance[:3, :3])))
    _number_row(table, "rotation vector deg", rotation, turn, most)
    if at is not None:
        _point_row(table, result, base_from_fixture, at)
    for k, axis in enumerate("xyz"):
        table.add_row(f"axis {axis}", *(f"{value:.9f}" for value in base_from_fixture[:3, k] + 0.0))
    return table


def _keep_whole(table: Table) -> None:
    """Let a narrow terminal break what is too wide for it: a number without its last digits is another one."""
    for column in table.columns:
        column.overflow = "fold"


def _point_row(table: Table, result: LocateResult, base_from_fixture: Floats, at: Floats) -> None:
    sigmas = None
    if result.covariance is not None:
        sigmas = np.sqrt(np.diag(point_covariance(base_from_fixture, result.covariance, at)))
    point = base_from_fixture[:3, :3] @ at + base_from_fixture[:3, 3]
    name = f"({', '.join(f'{value:g}' for value in at)}) {result.units}"
    _number_row(table, name, point, sigmas, sigma_at(result, at))


def _number_row(table: Table, name: str, values: Floats, sigmas: Floats | None, worst: float | None) -> None:
    """Numbers to one digit beyond their sigma, and the sigmas below."""
    if sigmas is None:
        table.add_row(name, *(f"{value:.6f}" for value in values + 0.0))
        return
    digits = [_digits(float(sigma)) for sigma in sigmas]
    cells = [f"{value:.{n}f}" for value, n in zip(values + 0.0, digits, strict=True)]
    table.add_row(Text(name, "bold"), *(Text(cell, "bold") for cell in cells))
    spread = [f"{sigma:.2g}" for sigma in sigmas]
    table.add_row("  sigma", *spread, "" if worst is None else f"{worst:.2g}", style="dim")


def _digits(sigma: float) -> int:
    return 6 if sigma <= 0 else max(0, min(12, 2 - math.ceil(math.log10(sigma))))


def _rotation_vector(rotation: Floats) -> Floats:
    """The rotation vector (3,) in rad of a rotation matrix, accurate from no turn to half a turn.

    By the unit quaternion q, whose products 4 q q^T are sums of the matrix's entries: its row with the largest diagonal
    is q times a number that is not small. scipy would take three times as long to import as numpy.
    """
    (a, b, c), (d, e, f), (g, h, i) = rotation
    products = np.array(
        [
            [1 + a + e + i, h - f, c - g, d - b],
            [h - f, 1 + a - e - i, b + d, c + g],
            [c - g, b + d, 1 - a + e - i, f + h],
            [d - b, c + g, f + h, 1 - a - e + i],
        ]
    )
    q = products[np.argmax(np.diag(products))]
    q = np.copysign(1.0, q[0]) * q / np.linalg.norm(q)
    sine = float(np.linalg.norm(q[1:]))
    return np.asarray(2 * np.arctan2(sine, q[0]) * q[1:] / sine) if sine > 0 else np.zeros(3)


def _residuals(result: LocateResult, ascii_only: bool) -> Table:
    """The residual of each contact as a number and a bar; the largest where there are many."""
    shown: Sequence[ContactResidual] = result.contacts
    caption = None
    if len(shown) > _MOST_CONTACTS:
        shown = sorted(shown, key=lambda contact: -abs(contact.residual))[:_MOST_CONTACTS]
        caption = f"the largest {_MOST_CONTACTS} of {len(result.contacts)}"
    largest = max(abs(contact.residual) for contact in shown) or 1.0
    table = Table(
        "row",
        "feature",
        f"residual {result.units}",
        "  into the | out of it",
        "approach",
        box=None,
        pad_edge=False,
        header_style="dim",
        caption=caption,
        caption_justify="left",
    )
    for index in (0, 2, 4):
        table.columns[index].justify = "right"
    _keep_whole(table)
    for contact in shown:
        angle = "" if contact.approach_angle_deg is None else f"{contact.approach_angle_deg:.0f} deg off"
        bar = _bar(contact.residual / largest, ascii_only)
        table.add_row(str(contact.row), Text(contact.feature), f"{contact.residual:+.2e}", bar, angle)
    return table


def _bar(share: float, ascii_only: bool) -> Text:
    """A bar from the middle: to the left for into the material, to the right for out of it."""
    full, middle = ("#", "|") if ascii_only else ("━", "│")
    length = round(abs(share) * _HALF_BAR)
    left, right = (length, 0) if share < 0 else (0, length)
    text = " " * (_HALF_BAR - left) + full * left + middle + full * right
    return Text(text, "cyan" if abs(share) < 1 else "magenta", overflow="crop", no_wrap=True)


def _candidates(result: LocateResult) -> Table:
    """Every pose that explains the contacts, and why each that fell did."""
    table = Table("pose", "origin in base", "chi2", "why it fell", box=None, pad_edge=False, header_style="dim")
    table.columns[2].justify = "right"
    _keep_whole(table)
    for number, candidate in enumerate(result.candidates[:_MOST_CANDIDATES], 1):
        origin = "  ".join(f"{value:.4f}" for value in candidate.base_from_fixture[:3, 3] + 0.0)
        table.add_row(str(number), origin, f"{candidate.chi2:.3g}", _why(candidate))
    more = len(result.candidates) - _MOST_CANDIDATES
    if more > 0:
        table.add_row("", f"and {more} more", "", "")
    return table


def _why(candidate: Candidate) -> Text:
    if candidate.accepted:
        return Text("it did not", "green")
    more = len(candidate.reasons) - 1
    return Text(reason_text(candidate.reasons[0]) + (f" (and {more} more)" if more else ""))
