"""What fit answers: plain frozen values in base coordinates and the contacts' unit."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from tactfix.geometry.arrays import Floats, frozen
from tactfix.geometry.surfaces import SidedSurface, SidedType
from tactfix.results import Reason, Status


@dataclass(frozen=True, slots=True, eq=False)
class FitCandidate:
    """A surface through the contacts (true radius, base coordinates), and why it fell if it did.

    doubts: approaches too close to grazing to speak for or against it, in words.
    """

    surface: SidedSurface
    chi2: float
    rms: float
    poorly_determined: bool
    reasons: tuple[Reason, ...] = ()
    doubts: tuple[str, ...] = ()

    @property
    def accepted(self) -> bool:
        """Whether nothing speaks against it."""
        return not self.reasons


@dataclass(frozen=True, slots=True, eq=False)
class FitResult:
    """The answer of fit; see "JSON of fit" in samples/README.md.

    surface, chi2, rms, residuals (n,) and sigma are given when status is "located", else None or empty. residuals:
    along the outward normal, positive out of the material. sigma: one standard deviation of each number of the
    surface, under the names of the JSON (point, normal, center, direction: (3,); radius: (1,), 0 where it was given).
    chi2_limit: what every candidate's chi2 was held against. dof: contacts minus parameters.
    """

    kind: SidedType
    status: Status
    surface: SidedSurface | None
    candidates: tuple[FitCandidate, ...]
    dof: int
    chi2: float | None
    chi2_limit: float | None
    rms: float | None
    residuals: Floats = field(default_factory=lambda: np.zeros(0))
    sigma: Mapping[str, Floats] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "residuals", frozen(self.residuals))
        object.__setattr__(self, "sigma", MappingProxyType({k: frozen(v) for k, v in self.sigma.items()}))
