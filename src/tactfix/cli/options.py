"""Arguments and options that several commands share; those that belong together are groups in `inputs`."""

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from tactfix.cli import completion
from tactfix.decimal_text import numbers_of
from tactfix.errors import UsageError
from tactfix.formats import LOG_NAMES

FixturePath: TypeAlias = Annotated[
    Path, typer.Argument(metavar="FIXTURE", help="Fixture file (YAML).", show_default=False)
]
ContactsPath: TypeAlias = Annotated[
    str, typer.Argument(metavar="CONTACTS", help="Contact file (CSV); - is standard input.", show_default=False)
]
Output: TypeAlias = Annotated[
    Path | None,
    typer.Option("--output", "-o", metavar="FILE", help="Write the result to FILE, whole or not at all; - prints it."),
]
AsJson: TypeAlias = Annotated[bool, typer.Option("--json", help="Print the whole result as JSON.")]
Scheduler: TypeAlias = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="Work on this Dask cluster instead, such as tcp://host:8786.")
]
Units: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="U",
        help="Unit of the contact file and of the lengths below: mm, m, um or in.",
        autocompletion=completion.units,
    ),
]
TipRadius: TypeAlias = Annotated[
    float | None,
    typer.Option(metavar="R", help="Radius of the probe tip, in the contact file's unit; 0: points of the surface."),
]
Sigma: TypeAlias = Annotated[
    float | None,
    typer.Option(metavar="S", help="One standard deviation of a contact along the normal, in the contact file's unit."),
]
ScaleSigma: TypeAlias = Annotated[
    bool, typer.Option("--scale-sigma", help="Scale the covariance by the residuals instead of trusting sigma.")
]
Quiet: TypeAlias = Annotated[bool, typer.Option("--quiet", "-q", help="No warnings and no summary.")]
Verbose: TypeAlias = Annotated[bool, typer.Option("--verbose", "-v", help="A summary on standard error in any case.")]
ContactsFormat: TypeAlias = Annotated[
    str,
    typer.Option(
        "--contacts-format",
        metavar="NAME",
        help=f"csv, or the machine log: {', '.join(LOG_NAMES)}.",
        autocompletion=completion.contact_formats,
    ),
]
Features: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="NAME:N,...",
        help="Which contacts of a machine log are on which feature, in order.",
        autocompletion=completion.feature_runs,
    ),
]
TipOffset: TypeAlias = Annotated[
    str | None, typer.Option(metavar="X,Y,Z", help="Tip centre in the flange frame, for flange poses.")
]


def vector(text: str, option: str) -> tuple[float, float, float]:
    """'x,y,z' as three numbers, none beyond 1e30."""
    numbers = numbers_of(text)
    x, y, z = numbers if len(numbers) == 3 else (None, None, None)
    if x is None or y is None or z is None:
        raise UsageError(f"{option} {text!r} is not three numbers; write x,y,z such as 10,0,-2.5")
    return x, y, z
