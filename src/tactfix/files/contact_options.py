"""What a caller says about a contact file, and what is settled once options, file and fixture have been heard."""

from typing import TypeAlias

from tactfix.contacts import Unknown
from tactfix.errors import UsageError
from tactfix.fixture import Probe
from tactfix.units import LEAST_LENGTH, MOST_LENGTH, UNITS, factor, which_unit
from tactfix.values import frozen_value

Vector: TypeAlias = tuple[float, float, float]


@frozen_value(eq=True)
class ContactOptions:
    """What is said from outside about a contact file; it beats the file, which beats the fixture's probe block.

    Parameters
    ----------
    units : {"mm", "m", "um", "in"}, optional
        The unit of all lengths in the contact file, and of tip_radius, sigma and tip_offset here (as if they stood in
        the file).
    tip_radius : float, optional
        Of the probe's tip.
    sigma : float, optional
        One standard deviation of a contact along the surface normal.
    tip_offset : tuple of three floats, optional
        The tip's centre (3,) in the flange frame.
    unknown : frozenset of {"tip", "tip-radius"}
        What of the tip is going to be found from the contacts, and so need not be said.
    of_flange : bool
        Whether the points are the flange's origin (a file says so).

    Raises
    ------
    UsageError
        A value that no file could have.

    Examples
    --------
    >>> tactfix.ContactOptions(units="in", sigma=0.0002).units
    'in'
    """

    units: str | None = None
    tip_radius: float | None = None
    sigma: float | None = None
    tip_offset: Vector | None = None
    unknown: frozenset[Unknown] = frozenset()
    of_flange: bool = False

    def __post_init__(self) -> None:
        if self.units is not None and self.units not in UNITS:
            raise UsageError(f"units is {self.units!r}; {which_unit(self.units)}")
        if self.tip_radius is not None and not 0 <= self.tip_radius <= MOST_LENGTH:
            raise UsageError(f"tip radius {self.tip_radius:g} is not a length; write 0 for points of the surface")
        if self.sigma is not None and not self.sigma > 0:
            raise UsageError(f"sigma {self.sigma:g} is not above zero; no probe is exact")
        if self.sigma is not None and not LEAST_LENGTH <= self.sigma <= MOST_LENGTH:
            raise UsageError(f"sigma {self.sigma:g} is no length; write what the probe is good for, like 0.005")


@frozen_value(eq=True)
class Settings:
    """What holds for a contact file: its own units; tip radius, sigma and tip offset in the units of the result."""

    units: str
    target_units: str
    tip_radius: float | None
    sigma: float | None
    tip_offset: Vector | None = None

    @property
    def scale(self) -> float:
        """What lengths of the file are multiplied by."""
        return factor(self.units, self.target_units)


def settle(options: ContactOptions, header: ContactOptions, probe: Probe, fixture_units: str | None) -> Settings | None:
    """Options beat the header of the file, which beats the fixture's probe; None where nothing says the units."""
    units = options.units or header.units or fixture_units
    if units is None:
        return None
    scale = factor(units, fixture_units or units)

    def first(option: float | None, in_file: float | None, in_fixture: float | None) -> float | None:
        said = in_file if option is None else option
        return in_fixture if said is None else said * scale

    def first_offset(option: Vector | None, in_file: Vector | None) -> Vector | None:
        said = in_file if option is None else option
        return probe.tip_offset if said is None else (said[0] * scale, said[1] * scale, said[2] * scale)

    return Settings(
        units,
        fixture_units or units,
        first(options.tip_radius, header.tip_radius, probe.tip_radius),
        first(options.sigma, header.sigma, probe.sigma),
        first_offset(options.tip_offset, header.tip_offset),
    )
