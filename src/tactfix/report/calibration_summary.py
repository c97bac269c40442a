"""The summary of calibrate for people: places before and after, parameters with sigma and bars, unknowns left."""

from typing import IO, Final

from rich.console import Console, Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from tactfix.calibration.result import Calibration, ParameterResult
from tactfix.calibration.touch_plan import TouchPlan
from tactfix.report.calibration_report import calibration_sentence
from tactfix.wording import borne

_BAR: Final = 24
"""Characters of the longest bar."""
_CALIBRATION_COLORS: Final = {"calibrated": "green", "underdetermined": "yellow", "inconsistent": "red"}


def print_calibration_sentence(result: Calibration, file: IO[str]) -> None:
    """Print the answer in one sentence on a file."""
    style = f"bold {_CALIBRATION_COLORS[result.status]}"
    Console(file=file, highlight=False).print(Text(calibration_sentence(result), style))


def print_calibration(result: Calibration, file: IO[str]) -> None:
    """Print the summary on a file."""
    console = Console(file=file, highlight=False)
    console.print(calibration_summary(result, ascii_only=console.options.ascii_only))


def calibration_summary(result: Calibration, *, ascii_only: bool = False) -> RenderableType:
    """Places before and after, parameters with sigma, and those not identified, as a rich renderable."""
    head = Text(f"{len(result.touches)} touches, shrinkage {result.shrinkage:g} (factor on the prior)")
    parts: list[RenderableType] = [head, _places(result, ascii_only=ascii_only), _parameters(result)]
    parts += [Text(f"not known: {words}", "yellow") for words in result.not_identified if "held at" not in words]
    return Group(*(Padding(part, (0, 0, 1, 1)) for part in parts))


def _places(result: Calibration, *, ascii_only: bool) -> Table:
    table = Table("place", f"rms before {result.units}", "after", "", box=None, pad_edge=False, header_style="dim")
    rows = [(place.name, place.rms_before, place.rms_after) for place in result.places]
    for item in result.left_out:
        rows.append((f"{item.place} ({'held out' if item.held_out else 'left out'})", item.rms_before, item.rms_after))
    most = max((max(before, after) for _, before, after in rows), default=1.0) or 1.0
    full = "#" if ascii_only else "━"
    for name, before, after in rows:
        bar = Text(full * round(_BAR * after / most), "cyan" if after <= before else "magenta")
        table.add_row(name, f"{before:.4f}", f"{after:.4f}", bar)
    return table


def _parameters(result: Calibration) -> Table:
    table = Table("parameter", "error", "sigma", "unit", "", box=None, pad_edge=False, header_style="dim")
    for column in table.columns[1:3]:
        column.justify = "right"
    for item in result.parameters:
        table.add_row(item.name, borne(item.value, item.sigma), f"{item.sigma:.2g}", item.unit, _remark(item))
    return table


def _remark(item: ParameterResult) -> Text:
    if item.identified:
        return Text("")
    return Text("held at nominal" if item.sigma == 0 else "weakly determined", "dim")


def print_touch_plan(plan: TouchPlan, file: IO[str]) -> None:
    """The sigma of each parameter: by the prior, after the planned touches, and with the added ones."""
    table = Table("parameter", "prior", "planned", "with added", "unit", "", box=None, header_style="dim")
    for item in plan.parameters:
        sigmas = (f"{value:.3g}" for value in (item.prior, item.planned, item.with_added))
        table.add_row(item.name, *sigmas, item.unit, "" if item.identified else "weakly determined")
    Console(file=file, highlight=False).print(table)
