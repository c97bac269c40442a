"""The result of fit, in base coordinates and the contacts' unit."""

from collections.abc import Mapping
from dataclasses import field
from typing import Annotated, Any

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Floats, Frozen, frozen
from tactfix.geometry.surfaces import SidedSurface, SidedType, radius_of
from tactfix.results import JsonResult, Reason, Status
from tactfix.values import frozen_value, read_only


@frozen_value
class FitCandidate:
    """A surface through the contacts (true radius, base coordinates), and why it was rejected if it was.

    doubts: approaches too close to grazing to accept or reject it, in words.
    """

    surface: SidedSurface
    chi2: float
    rms: float
    poorly_determined: bool
    reasons: tuple[Reason, ...] = ()
    doubts: tuple[str, ...] = ()

    @property
    def accepted(self) -> bool:
        """Whether there is no reason to reject it."""
        return not self.reasons


def _frozen_arrays(arrays: Mapping[str, Floats]) -> Mapping[str, Floats]:
    return read_only({name: frozen(array) for name, array in arrays.items()})


@frozen_value
class FitResult(JsonResult):
    """The result of fit; "JSON of fit" in samples/README.md describes each field.

    Attributes
    ----------
    kind : {"plane", "sphere", "cylinder"}
        Type of the surface.
    status : {"located", "underdetermined", "ambiguous", "inconsistent"}
        "located" if one surface is accepted.
    dof : int
        Contacts minus parameters.
    surface : Plane, Sphere, Cylinder or None
        In base; None unless located, as chi2 and rms.
    candidates : tuple of FitCandidate
        Every surface that explains the contacts, and why it was rejected if it was.
    chi2, chi2_limit, rms : float or None
        Sum of squared residuals over sigma, its limit for every candidate, and the rms (units).
    residuals : (n,) array
        Along the outward normal, positive out of the material; empty unless located.
    sigma : mapping of str to array
        One standard deviation of each number of the surface (point, normal, center, direction: (3,); radius: (1,), 0
        if it was given); empty unless located.
    warnings : tuple of str
        In words.
    units : str or None
        Of all lengths; None if the contacts have none.
    contacts : Contacts or None
        The contacts of the fit; None in a result that was read from JSON.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> contacts = tactfix.load_contacts("samples/robot-cell-plate/contacts.csv", fixture)
    >>> tactfix.fit("plane", contacts.on("plate")).dof
    1
    """

    kind: SidedType
    status: Status
    dof: int
    surface: SidedSurface | None = None
    candidates: tuple[FitCandidate, ...] = ()
    chi2: float | None = None
    chi2_limit: float | None = None
    rms: float | None = None
    residuals: Frozen = field(default_factory=lambda: np.zeros(0))
    sigma: Annotated[Mapping[str, Floats], _frozen_arrays] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    units: str | None = None
    contacts: Contacts | None = None

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `tactfix fit --json` as dictionaries, lists and numbers."""
        from tactfix.report.json_report import fit_json

        return fit_json(self)

    @classmethod
    def from_json(cls, text: str | bytes) -> "FitResult":
        """The result from the JSON of `to_json` or `tactfix fit --json`; doubts of candidates are not in it.

        Raises UsageError for any other text.
        """
        from tactfix.report.json_reader import fit_result

        return fit_result(text)

    def _repr_html_(self) -> str:
        """The surface and the residuals for a notebook."""
        from tactfix.report.fit_summary import fit_html

        return fit_html(self)

    def __repr__(self) -> str:
        radius = (
            "" if self.surface is None or not radius_of(self.surface) else f", radius {radius_of(self.surface):.6g}"
        )
        if self.rms is None:
            left = sum(candidate.accepted for candidate in self.candidates)
            return f"<FitResult {self.kind}: {self.status}, {left} of {len(self.candidates)} candidates left>"
        return f"<FitResult {self.kind}: {self.status}{radius}, {len(self.residuals)} contacts, rms {self.rms:.2g}>"
