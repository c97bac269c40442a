"""Contacts: the touches that a probe reports, as arrays in base coordinates and in the fixture's units."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from tactfix.errors import MissingExtraError, UsageError
from tactfix.geometry.arrays import Bools, Floats, Frozen, Ints, frozen
from tactfix.values import frozen_value

if TYPE_CHECKING:
    from pandas import DataFrame

Unknown: TypeAlias = Literal["tip", "tip-radius"]
"""Parameters of the tip to estimate from the contacts: its centre in the flange frame, its effective radius."""

GRAZING = 0.5
"""Sine of the angle between approach and surface above which the side of the probe is certain, whatever the sigma of
the normal: 30 degrees. A pose with a sigma of more than 0.1 rad (`free_motions.UNDERDETERMINED_ANGLE`) is
underdetermined, so SURE (5) sigma of the normal are 29 degrees at most."""


@frozen_value
class Contacts:
    """n touches. Lengths are in the fixture's units, coordinates in base.

    Parameters
    ----------
    features : tuple of str
        The feature that each contact touched (n names).
    points : (n, 3) array
        Centre of the tip where tip_radius > 0, point of the surface where it is 0.
    approaches : (n, 3) array
        Unit direction of the probe's travel, into the material; a row of nan if unknown.
    sigmas : (n,) array
        One standard deviation of each contact along the surface normal, the probe's alone (no feature sigma).
    tip_radius : float
        Of the probe's tip.
    rows : tuple of int
        Data row (n,) in the contact file, counted from 1.
    ids : tuple of str or None
        Names of the contacts in the file (n), None without a name.
    flange_rotations : (n, 3, 3) array, optional
        base_from_flange at each touch; None if unknown.
    tip_offset : (3,) array, optional
        The tip's centre in the flange frame with which the points were computed; None if unknown.
    units : str, optional
        Of all lengths here; None: that of the fixture.

    Notes
    -----
    Select contacts by mask, slice or index, and join them by `+`. `contacts_from_arrays` checks its arguments.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> contacts = tactfix.load_contacts("samples/robot-cell-plate/contacts.csv", fixture)
    >>> contacts.on("ball")
    <Contacts: 5 (ball 5), tip radius 3 mm>
    """

    features: tuple[str, ...]
    points: Frozen
    approaches: Frozen
    sigmas: Frozen
    tip_radius: float
    rows: tuple[int, ...]
    ids: tuple[str | None, ...]
    flange_rotations: Frozen | None = None
    tip_offset: Frozen | None = None
    units: str | None = None

    def __len__(self) -> int:
        return len(self.features)

    @cached_property
    def by_feature(self) -> Mapping[str, Ints]:
        """The indices (from 0) of the contacts on each touched feature, in the order of the first touches."""
        names = np.array(self.features)
        return {name: np.flatnonzero(names == name) for name in dict.fromkeys(self.features)}

    @cached_property
    def centre(self) -> Floats:
        """The mean of the points (3,)."""
        return frozen(np.add.reduce(self.points) / len(self))

    @cached_property
    def spread(self) -> float:
        """The root mean square distance of the points from their centre; 1 if that is 0."""
        arms = self.points - self.centre
        return float(np.sqrt((arms * arms).sum() / len(self))) or 1.0

    @cached_property
    def has_approach(self) -> Bools:
        """Which contacts (n,) have a known approach."""
        return np.asarray(np.isfinite(self.approaches).all(axis=1))

    def on(self, feature: str) -> "Contacts":
        """The contacts on one feature, in order."""
        return self.subset(self.by_feature.get(feature, ()))

    def __getitem__(self, which: int | slice | Sequence[int] | Sequence[bool] | Ints | Bools) -> "Contacts":
        """The contacts of a slice, a mask (n,) of booleans, or these indices (from 0); of one index that one alone."""
        if isinstance(which, slice):
            return self.subset(np.arange(len(self))[which])
        return self.subset([which] if isinstance(which, int | np.integer) else which)

    def __iter__(self) -> Iterator["Contacts"]:
        """Each contact alone, in order."""
        return (self.subset([i]) for i in range(len(self)))

    def __add__(self, other: "Contacts") -> "Contacts":
        """These contacts and then the other ones; rows keep their numbers.

        Raises UsageError if tip radius, tip offset, units, or whether flange rotations are known differ.
        """
        if self.units and other.units and self.units != other.units:
            raise UsageError(f"contacts in {self.units} and in {other.units} cannot be joined; give both in one unit")
        if self.tip_radius != other.tip_radius or not _alike(self.tip_offset, other.tip_offset):
            raise UsageError("contacts of different tips cannot be joined; locate them apart, or give one tip radius")
        if (self.flange_rotations is None) != (other.flange_rotations is None):
            raise UsageError("contacts with and without flange rotations cannot be joined; give all of them, or none")
        rotations = None
        if self.flange_rotations is not None and other.flange_rotations is not None:
            rotations = np.concatenate([self.flange_rotations, other.flange_rotations])
        return Contacts(
            features=self.features + other.features,
            points=np.concatenate([self.points, other.points]),
            approaches=np.concatenate([self.approaches, other.approaches]),
            sigmas=np.concatenate([self.sigmas, other.sigmas]),
            tip_radius=self.tip_radius,
            rows=self.rows + other.rows,
            ids=self.ids + other.ids,
            flange_rotations=rotations,
            tip_offset=self.tip_offset,
            units=self.units or other.units,
        )

    def to_dataframe(self) -> "DataFrame":
        """The contacts as a pandas DataFrame: feature, x, y, z, ax, ay, az, sigma, id, by row.

        Raises MissingExtraError if pandas is not installed.
        """
        try:
            from pandas import DataFrame, Index
        except ImportError as error:
            raise MissingExtraError("dataframe", "a DataFrame of contacts") from error
        numbers = np.column_stack([self.points, self.approaches, self.sigmas])
        frame = DataFrame(
            numbers, columns=["x", "y", "z", "ax", "ay", "az", "sigma"], index=Index(self.rows, name="row")
        )
        frame.insert(0, "feature", list(self.features))
        frame["id"] = list(self.ids)
        return frame

    def __repr__(self) -> str:
        counts = ", ".join(f"{name} {len(index)}" for name, index in self.by_feature.items())
        unit = f" {self.units}" if self.units else ""
        return f"<Contacts: {len(self)} ({counts}), tip radius {self.tip_radius:g}{unit}>"

    def subset(self, indices: Sequence[int] | Sequence[bool] | Ints | Bools) -> "Contacts":
        """The contacts with these indices (from 0), in that order, or of a mask (n,) of booleans.

        Raises UsageError for a mask whose length is not the number of contacts.
        """
        index = np.asarray(indices)
        if index.dtype == np.bool_:
            if index.shape != (len(self),):
                raise UsageError(f"a mask of shape {index.shape} for {len(self)} contacts; give one boolean for each")
            index = np.flatnonzero(index)
        if index.ndim != 1 or (index.size and not np.issubdtype(index.dtype, np.integer)):
            raise UsageError(f"{indices!r} are no indices; give whole numbers or booleans, or take on(feature)")
        if index.size and not (index.min() >= -len(self) and index.max() < len(self)):
            raise UsageError(f"there are {len(self)} contacts, with indices from 0; an index is out of range")
        index = index.astype(np.intp, copy=False)
        pick = tuple(int(i) for i in index)
        return Contacts(
            features=tuple(self.features[i] for i in pick),
            points=self.points[index],
            approaches=self.approaches[index],
            sigmas=self.sigmas[index],
            tip_radius=self.tip_radius,
            rows=tuple(self.rows[i] for i in pick),
            ids=tuple(self.ids[i] for i in pick),
            flange_rotations=None if self.flange_rotations is None else self.flange_rotations[index],
            tip_offset=self.tip_offset,
            units=self.units,
        )

    def with_tip(self, change: Floats, tip_radius: float) -> "Contacts":
        """The same touches with the tip's centre displaced by change (3,), flange frame, and with this tip radius.

        Without flange rotations change must be zero.
        """
        if self.flange_rotations is None:
            return replace(self, tip_radius=tip_radius)
        before = np.zeros(3) if self.tip_offset is None else self.tip_offset
        points = self.points + self.flange_rotations @ change
        return replace(self, points=points, tip_radius=tip_radius, tip_offset=before + change)

    def moved(self, a_from_b: Floats) -> "Contacts":
        """The contacts, given in frame b, in frame a; a_from_b (4, 4)."""
        rotation, translation = a_from_b[:3, :3], a_from_b[:3, 3]
        return replace(
            self,
            points=self.points @ rotation.T + translation,
            approaches=self.approaches @ rotation.T,
            flange_rotations=None if self.flange_rotations is None else rotation @ self.flange_rotations,
        )

    def labelled(self, features: Sequence[str]) -> "Contacts":
        """The same contacts on other features (n names)."""
        return replace(self, features=tuple(features))

    def label(self, index: int) -> str:
        """The name of a contact in messages: its row, and its id if the file gives one."""
        return f"row {self.rows[index]}" + (f" ({self.ids[index]})" if self.ids[index] else "")


def _alike(one: Floats | None, other: Floats | None) -> bool:
    if one is None or other is None:
        return one is other
    return bool(np.array_equal(one, other))
