"""The summary of fit for people: the surface with its unit and sigmas, and the residual of every contact."""

from collections.abc import Sequence
from typing import IO, Final

from rich.console import Console, Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from tactfix.contacts import Contacts
from tactfix.fitting.result import FitResult
from tactfix.geometry.surfaces import Plane, Point, Surface
from tactfix.report.summary import freedom, residual_table, upright_table
from tactfix.report.text_report import SIGMAS_95, surface_rows
from tactfix.results import ContactResidual
from tactfix.wording import decimals

_UNITLESS: Final = ("normal", "direction")
"""Names of numbers that have no unit."""


def print_fit_sentence(result: FitResult, units: str, file: IO[str]) -> None:
    """Print the answer in one sentence on a file."""
    what, name = {"plane": ("plane", "point"), "sphere": ("centre", "center"), "cylinder": ("axis", "point")}[
        result.kind
    ]
    sure = SIGMAS_95 * float(result.sigma[name].max())
    Console(file=file, highlight=False).print(
        Text(f"located; the {what} is known to {sure:.2g} {units} (95 %, along the worst axis)", "bold green")
    )


def print_fit(result: FitResult, contacts: Contacts, units: str, file: IO[str]) -> None:
    """Print the summary of what was fitted to contacts on a file; nothing where there is no surface."""
    if result.surface is None:
        return
    console = Console(file=file, highlight=False)
    parts: list[RenderableType] = [_fit(result, units), _place(result, result.surface, units)]
    parts += _radius(result, result.surface, units)
    if len(result.residuals):
        parts.append(residual_table(_residuals(result, contacts), units, ascii_only=console.options.ascii_only))
    console.print(Group(*(Padding(part, (0, 0, 1, 1)) for part in parts)))


def _fit(result: FitResult, units: str) -> Text:
    rms = "" if result.rms is None else f"rms {result.rms:.2g} {units}, "
    return Text(rms + freedom(result.dof, len(result.residuals)))


def _place(result: FitResult, surface: Surface, units: str) -> Table:
    """Each vector of the surface, its sigma beside it."""
    columns: dict[str, Sequence[str]] = {"": [*"xyz"]}
    for place, (name, values) in enumerate(surface_rows(surface).items(), 1):
        if name == "radius":
            continue
        sigmas = result.sigma.get(name)
        spread = [0.0] * len(values) if sigmas is None else sigmas.tolist()
        title = name if name in _UNITLESS else f"{name} {units}"
        columns[title] = [f"{value + 0.0:.{decimals(sigma)}f}" for value, sigma in zip(values, spread, strict=True)]
        # One column may have the name of another only with more blanks behind it.
        columns["sigma" + " " * place] = [f"{sigma:.2g}" for sigma in spread]
    return upright_table(columns)


def _radius(result: FitResult, surface: Surface, units: str) -> list[Text]:
    """The radius with its sigma, or that it was given; nothing of a plane."""
    if isinstance(surface, Plane | Point):
        return []
    sigma = float(result.sigma["radius"][0]) if "radius" in result.sigma else 0.0
    spread = f"sigma {sigma:.2g} {units}" if sigma > 0 else "given"
    return [Text(f"radius {surface.radius:.{decimals(sigma)}f} {units}, {spread}")]


def _residuals(result: FitResult, contacts: Contacts) -> list[ContactResidual]:
    return [
        ContactResidual(row, feature, float(residual), None)
        for row, feature, residual in zip(contacts.rows, contacts.features, result.residuals, strict=True)
    ]
