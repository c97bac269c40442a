"""The summary of locate for people: the answer in a sentence, pose, sigmas, residuals as bars, candidates."""

import math
from collections.abc import Mapping, Sequence
from itertools import zip_longest
from typing import IO, Final

import numpy as np
from rich.console import Console, Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from tactfix.acceptance import point_covariance, sigma_at, worst_sigma
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import rotation_vectors
from tactfix.locate_result import LocateResult
from tactfix.report.text_report import reason_text, residual_text, sentence, status_lines
from tactfix.results import Candidate, ContactResidual, Status
from tactfix.wording import decimals, fixed

_CONTACTS_LISTED: Final = 20
"""Number of contacts listed on a terminal."""
_CANDIDATES_LISTED: Final = 8
"""Number of candidates listed."""
_HALF_BAR: Final = 10
"""Characters of a bar to either side of zero."""
_STATUS_COLORS: Final[dict[Status, str]] = {
    "located": "green",
    "underdetermined": "yellow",
    "ambiguous": "yellow",
    "inconsistent": "red",
}


def print_sentence(result: LocateResult, file: IO[str]) -> None:
    """Print the answer in one sentence on a file."""
    Console(file=file, highlight=False).print(Text(sentence(result), f"bold {_STATUS_COLORS[result.status]}"))


def print_summary(result: LocateResult, file: IO[str], at: Floats | None = None) -> None:
    """Print the details without the status; at: a point (3,) of the fixture frame whose sigma is printed too."""
    console = Console(file=file, highlight=False)
    console.print(_details(result, at, ascii_only=console.options.ascii_only))


def summary(result: LocateResult, at: Floats | None = None, *, ascii_only: bool = False) -> RenderableType:
    """The result in a sentence, the next contact, and the details, as a rich renderable."""
    answer, *others = [sentence(result)] if result.status == "located" else status_lines(result)
    name = (f"{result.fixture} ", "bold")
    lines = [Text.assemble(name, (answer, f"bold {_STATUS_COLORS[result.status]}")), *map(Text, others)]
    return Group(Padding(Group(*lines), (0, 0, 1, 1)), _details(result, at, ascii_only=ascii_only))


def _details(result: LocateResult, at: Floats | None, *, ascii_only: bool) -> RenderableType:
    parts: list[RenderableType] = [] if result.chi2 is None and result.rms is None else [_fit(result)]
    if result.base_from_fixture is not None:
        parts.append(_pose(result, result.base_from_fixture))
        if at is not None:
            parts.append(_point(result, result.base_from_fixture, at))
    if result.contacts:
        parts.append(residual_table(result.contacts, result.units, ascii_only=ascii_only))
    if len(result.candidates) > 1 or result.status != "located":
        parts.append(_candidates(result))
    return Group(*(Padding(part, (0, 0, 1, 1)) for part in parts))


def _fit(result: LocateResult) -> Text:
    line = Text()
    if result.rms is not None:
        line.append(f"rms {result.rms:.2g} {result.units}, ")
    if result.chi2 is not None:
        limit = "" if result.chi2_limit is None else f" (limit {result.chi2_limit:.3g})"
        line.append(f"chi2 {result.chi2:.3g}{limit}, ")
    return line.append(freedom(result.dof, len(result.contacts)))


def freedom(dof: int, contacts: int) -> str:
    """The degrees of freedom and the number of contacts, in words."""
    given = f"{contacts} contact{'' if contacts == 1 else 's'}"
    if dof < 0:
        return f"{given}: {-dof} equation{'' if dof == -1 else 's'} too few"
    return f"{dof} degree{'' if dof == 1 else 's'} of freedom, {given}"


def _pose(result: LocateResult, base_from_fixture: Floats) -> Table:
    """Origin and rotation vector in base with their sigmas."""
    sigmas = None if result.covariance is None else np.sqrt(np.diag(result.covariance))
    turn = np.rad2deg(rotation_vectors(base_from_fixture[:3, :3][None])[0])
    origin = base_from_fixture[:3, 3]
    if sigmas is None or result.covariance is None:
        columns = {f"origin {result.units}": _rounded(origin), "rotation vector deg": _rounded(turn)}
        return upright_table({"in base": [*"xyz"], **columns})
    most = math.degrees(float(worst_sigma(result.covariance[:3, :3])))
    columns = {
        "in base": [*"xyz", "worst"],
        f"origin {result.units}": [*_rounded(origin, sigmas[3:]), ""],
        "sigma": [f"{sigma:.2g}" for sigma in (*sigmas[3:], sigma_at(result) or 0.0)],
        "rotation vector deg": [*_rounded(turn, np.rad2deg(sigmas[:3])), ""],
        "sigma ": [f"{sigma:.2g}" for sigma in (*np.rad2deg(sigmas[:3]), most)],
    }
    return upright_table(columns)


def _point(result: LocateResult, base_from_fixture: Floats, at: Floats) -> Table:
    """A point of the fixture in base, with its sigmas."""
    point = base_from_fixture[:3, :3] @ at + base_from_fixture[:3, 3]
    name = f"({', '.join(f'{value:g}' for value in at)}) {result.units}"
    if result.covariance is None:
        return upright_table({"in base": [*"xyz"], name: _rounded(point)})
    sigmas = np.sqrt(np.diag(point_covariance(base_from_fixture, result.covariance, at)))
    spread = [f"{sigma:.2g}" for sigma in (*sigmas, sigma_at(result, at) or 0.0)]
    return upright_table({"in base": [*"xyz", "worst"], name: [*_rounded(point, sigmas), ""], "sigma": spread})


def _rounded(values: Floats, sigmas: Floats | None = None) -> list[str]:
    """Numbers rounded according to their sigmas."""
    digits = [6] * len(values) if sigmas is None else [decimals(float(sigma)) for sigma in sigmas]
    return [fixed(value, n) for value, n in zip(values, digits, strict=True)]


def upright_table(columns: Mapping[str, Sequence[str]]) -> Table:
    """Columns of numbers by their names; the first column names the rows."""
    table = Table(*columns, box=None, pad_edge=False, header_style="dim")
    for column in table.columns[1:]:
        column.justify = "right"
    for row in zip_longest(*columns.values(), fillvalue=""):
        table.add_row(*row)
    _keep_whole(table)
    return table


def _keep_whole(table: Table) -> None:
    """Let a narrow terminal break cells between words only: a truncated number would be misread."""
    for column in table.columns:
        column.overflow = "fold"
        cells = [str(cell) for cell in (column.header, *column.cells) if isinstance(cell, str | Text)]
        column.min_width = min(max((len(word) for cell in cells for word in cell.split()), default=1), 24)


def residual_table(contacts: Sequence[ContactResidual], units: str, *, ascii_only: bool) -> Table:
    """The residual of each contact as a number and a bar; only the largest if there are many."""
    shown, caption = contacts, None
    if len(shown) > _CONTACTS_LISTED:
        shown = sorted(shown, key=lambda contact: -abs(contact.residual))[:_CONTACTS_LISTED]
        caption = f"the largest {_CONTACTS_LISTED} of {len(contacts)}"
    largest = max(abs(contact.residual) for contact in shown) or 1.0
    names = ["row", "feature", f"residual {units}", " into the | out of it", "approach deg off"]
    table = Table(*names, box=None, pad_edge=False, header_style="dim", caption=caption, caption_justify="left")
    for index in (0, 2, 4):
        table.columns[index].justify = "right"
    for contact in shown:
        angle = "" if contact.approach_angle_deg is None else f"{contact.approach_angle_deg:.0f}"
        bar = _bar(contact.residual / largest, ascii_only)
        table.add_row(str(contact.row), Text(contact.feature), residual_text(contact.residual, largest), bar, angle)
    _keep_whole(table)
    table.columns[3].no_wrap = True
    return table


def _bar(share: float, ascii_only: bool) -> Text:
    """A bar from the middle: to the left for into the material, to the right for out of it."""
    full, middle = ("#", "|") if ascii_only else ("━", "│")
    length = round(abs(share) * _HALF_BAR)
    left, right = (length, 0) if share < 0 else (0, length)
    text = " " * (_HALF_BAR - left) + full * left + middle + full * right
    return Text(text, "cyan" if abs(share) < 1 else "magenta", overflow="crop", no_wrap=True)


def _candidates(result: LocateResult) -> Table:
    """Every pose that explains the contacts, and why it was accepted or eliminated."""
    names = ("pose", "origin in base", "rotation vector deg", "chi2", "verdict")
    table = Table(*names, box=None, pad_edge=False, header_style="dim")
    table.columns[3].justify = "right"
    for number, candidate in enumerate(result.candidates[:_CANDIDATES_LISTED], 1):
        pose = candidate.base_from_fixture
        origin = " ".join(fixed(value, 4) for value in pose[:3, 3])
        turn = " ".join(fixed(value, 1) for value in np.rad2deg(rotation_vectors(pose[None, :3, :3])[0]))
        table.add_row(str(number), origin, turn, f"{candidate.chi2:.3g}", _outcome(candidate))
    _keep_whole(table)
    more = len(result.candidates) - _CANDIDATES_LISTED
    if more > 0:
        table.add_row("", f"and {more} more")
    return table


def _outcome(candidate: Candidate) -> Text:
    if candidate.accepted:
        return Text("accepted", "green")
    more = len(candidate.reasons) - 1
    return Text("rejected: " + reason_text(candidate.reasons[0]) + (f" (and {more} more)" if more else ""))
