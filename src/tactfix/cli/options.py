"""Arguments and options that several commands share, said the same way everywhere, and their texts as values.

Text that can be no value is a usage error that names its option.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, TypeAlias

import typer

from tactfix.cli import completion
from tactfix.decimal_text import numbers_of
from tactfix.errors import UsageError

if TYPE_CHECKING:
    from tactfix.contacts import Unknown as UnknownOfTip


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
AsJson: TypeAlias = Annotated[bool, typer.Option("--json", help="Print everything that is known, as JSON.")]
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
        help="csv, or the machine log that CONTACTS is (see README).",
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
Unknown: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="WHAT",
        help="Find the tip too: tip (its offset, from flange poses), tip-radius, or tip,tip-radius.",
        autocompletion=completion.unknowns,
    ),
]
TipOffset: TypeAlias = Annotated[
    str | None, typer.Option(metavar="X,Y,Z", help="Tip centre in the flange frame, for flange poses.")
]
MaxSigma: TypeAlias = Annotated[
    float | None,
    typer.Option(metavar="S", min=0, help="Exit 1 where the worst sigma of the origin (or of --at) exceeds S."),
]
MaxRms: TypeAlias = Annotated[
    float | None, typer.Option(metavar="R", min=0, help="Exit 1 where the rms of the residuals exceeds R.")
]
At: TypeAlias = Annotated[
    str | None, typer.Option(metavar="X,Y,Z", help="Tell sigma at this point of the fixture frame too.")
]
Approach: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="X,Y,Z", help="Approach of a machine log that tells none, for all features, or feature:X,Y,Z;... each."
    ),
]
Repeats: TypeAlias = Annotated[
    str,
    typer.Option(
        metavar="all|last",
        help="Of consecutive touches of one place in a log: all, or the last.",
        autocompletion=completion.names("all", "last"),
    ),
]
WorkOffset: TypeAlias = Annotated[
    str | None,
    typer.Option(metavar="POSE", help="The frame that the machine reported in: a file, any pose format."),
]
Near: TypeAlias = Annotated[
    str | None,
    typer.Option(metavar="POSE", help="Roughly where the fixture stands: a file, any pose format; beats placement."),
]
Within: TypeAlias = Annotated[
    str | None,
    typer.Option(metavar="T,R", help="How far from --near it can stand at most: fixture's units, degrees."),
]
NearSigma: TypeAlias = Annotated[
    str | None,
    typer.Option(metavar="T,R", help="--near is a measurement with this sigma a component: fixture's units, degrees."),
]
Free: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="x,y,rz",
        help="Only these may differ from --near: along and about base axes.",
        autocompletion=completion.free_directions,
    ),
]


UNKNOWN_CHOICES: Final[dict[str, "UnknownOfTip"]] = {"tip": "tip", "tip-radius": "tip-radius"}


def vector(text: str, option: str) -> tuple[float, float, float]:
    """'x,y,z' as three numbers, none beyond 1e30."""
    numbers = numbers_of(text)
    x, y, z = numbers if len(numbers) == 3 else (None, None, None)
    if x is None or y is None or z is None:
        raise UsageError(f"{option} {text!r} is not three numbers; write x,y,z such as 10,0,-2.5")
    return x, y, z


def unknowns(text: str | None) -> "frozenset[UnknownOfTip]":
    """'tip', 'tip-radius' or both, divided by a comma; nothing where None."""
    names = [] if text is None else [part.strip() for part in text.split(",")]
    for name in names:
        if name not in UNKNOWN_CHOICES:
            raise UsageError(f"--unknown {name!r}: write tip, tip-radius, or tip,tip-radius")
    return frozenset(UNKNOWN_CHOICES[name] for name in names)
