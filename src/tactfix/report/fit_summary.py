"""The summary of fit for people: the surface with its unit and sigmas, and the residual of every contact."""

from collections.abc import Sequence
from typing import IO, Final

from rich.console import Console, Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from tactfix.fitting.result import FitResult
from tactfix.geometry.surfaces import Plane, Point, Surface
from tactfix.report.summary import freedom, residual_table, upright_table
from tactfix.report.text_report import SIGMAS_95, fit_status_lines, surface_rows
from tactfix.results import ContactResidual
from tactfix.wording import decimals, fixed, with_unit

_UNITLESS: Final = ("normal", "direction")
"""Names of dimensionless values."""


def print_fit_sentence(result: FitResult, file: IO[str]) -> None:
    """Print the answer in one sentence on a file."""
    Console(file=file, highlight=False).print(Text(_sentence(result), "bold green"))


def print_fit(result: FitResult, file: IO[str]) -> None:
    """Print the summary to a file; nothing without a surface."""
    if result.surface is None:
        return
    console = Console(file=file, highlight=False)
    console.print(_details(result, result.surface, ascii_only=console.options.ascii_only))


def fit_summary(result: FitResult) -> RenderableType:
    """The result in a sentence, surface and residuals, as a rich renderable."""
    if result.surface is None:
        return Text("\n".join([*fit_status_lines(result), *result.warnings]))
    answer = Text.assemble((f"{result.kind} ", "bold"), (_sentence(result), "bold green"))
    return Group(Padding(answer, (0, 0, 1, 1)), _details(result, result.surface, ascii_only=False))


def fit_html(result: FitResult) -> str:
    """The surface with its sigmas, and the residuals, for a notebook."""
    # Imported here: the command line does not need the notebook modules.
    from tactfix.report.notebook import text_html

    return text_html(fit_summary(result))


def _sentence(result: FitResult) -> str:
    element, name = {"plane": ("plane", "point"), "sphere": ("centre", "center"), "cylinder": ("axis", "point")}[
        result.kind
    ]
    accuracy = with_unit(f"{SIGMAS_95 * float(result.sigma[name].max()):.2g}", result.units)
    return f"located; the {element} is known to {accuracy} (95 %, along the worst axis)"


def _details(result: FitResult, surface: Surface, *, ascii_only: bool) -> RenderableType:
    parts: list[RenderableType] = [_fit(result), _place(result, surface), *_radius(result, surface)]
    if len(result.residuals):
        parts.append(residual_table(_residuals(result), result.units or "", ascii_only=ascii_only))
    return Group(*(Padding(part, (0, 0, 1, 1)) for part in parts))


def _fit(result: FitResult) -> Text:
    rms = "" if result.rms is None else f"rms {with_unit(f'{result.rms:.2g}', result.units)}, "
    return Text(rms + freedom(result.dof, len(result.residuals)))


def _place(result: FitResult, surface: Surface) -> Table:
    """Each vector of the surface with its sigma."""
    columns: dict[str, Sequence[str]] = {"": [*"xyz"]}
    for place, (name, values) in enumerate(surface_rows(surface).items(), 1):
        if name == "radius":
            continue
        sigmas = result.sigma.get(name)
        spread = [0.0] * len(values) if sigmas is None else sigmas.tolist()
        title = name if name in _UNITLESS else with_unit(name, result.units)
        columns[title] = [fixed(value, decimals(sigma)) for value, sigma in zip(values, spread, strict=True)]
        # Column names must differ: repeated ones get trailing blanks.
        columns["sigma" + " " * place] = [f"{sigma:.2g}" for sigma in spread]
    return upright_table(columns)


def _radius(result: FitResult, surface: Surface) -> list[Text]:
    """The radius with its sigma, or marked as given; empty for a plane."""
    if isinstance(surface, Plane | Point):
        return []
    sigma = float(result.sigma["radius"][0]) if "radius" in result.sigma else 0.0
    spread = f"sigma {with_unit(f'{sigma:.2g}', result.units)}" if sigma > 0 else "given"
    return [Text(f"radius {with_unit(fixed(surface.radius, decimals(sigma)), result.units)}, {spread}")]


def _residuals(result: FitResult) -> list[ContactResidual]:
    """The residuals by row; by index if their rows are unknown."""
    contacts, count = result.contacts, len(result.residuals)
    rows = range(1, count + 1) if contacts is None else contacts.rows
    names = [result.kind] * count if contacts is None else contacts.features
    return [
        ContactResidual(row, name, float(residual), None)
        for row, name, residual in zip(rows, names, result.residuals, strict=True)
    ]
