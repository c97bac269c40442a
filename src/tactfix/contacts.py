"""Contacts: the touches that a probe reports, as arrays in base coordinates and in the fixture's units."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactfix.geometry.arrays import Bools, Floats, frozen


@dataclass(frozen=True, slots=True, eq=False)
class Contacts:
    """n touches. Lengths are in the fixture's units, coordinates in base.

    features: the feature that each contact touched (n names).
    points (n, 3): centre of the tip where tip_radius > 0, point of the surface where it is 0.
    approaches (n, 3): unit direction of the probe's travel, into the material; a row of nan where the file gave none.
    sigmas (n,): one standard deviation of each contact along the surface normal, the probe's alone (no feature sigma).
    rows (n,): data row in the contact file, counted from 1. ids: what the file calls each contact, None without a name.
    """

    features: tuple[str, ...]
    points: Floats
    approaches: Floats
    sigmas: Floats
    tip_radius: float
    rows: tuple[int, ...]
    ids: tuple[str | None, ...]

    def __post_init__(self) -> None:
        for name in ("points", "approaches", "sigmas"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    def __len__(self) -> int:
        return len(self.features)

    @property
    def has_approach(self) -> Bools:
        """Which contacts (n,) say how the probe came."""
        return np.asarray(np.isfinite(self.approaches).all(axis=1))

    def on(self, feature: str) -> "Contacts":
        """The contacts on one feature, in order."""
        return self.subset([i for i, name in enumerate(self.features) if name == feature])

    def subset(self, indices: Sequence[int]) -> "Contacts":
        """The contacts with these indices (from 0), in that order."""
        index = np.asarray(indices, dtype=np.intp)
        pick = tuple(int(i) for i in index)
        return Contacts(
            features=tuple(self.features[i] for i in pick),
            points=self.points[index],
            approaches=self.approaches[index],
            sigmas=self.sigmas[index],
            tip_radius=self.tip_radius,
            rows=tuple(self.rows[i] for i in pick),
            ids=tuple(self.ids[i] for i in pick),
        )

    def label(self, index: int) -> str:
        """How messages call a contact: its row, and its id where the file gives one."""
        return f"row {self.rows[index]}" + (f" ({self.ids[index]})" if self.ids[index] else "")
