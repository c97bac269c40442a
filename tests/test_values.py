"""Frozen values: neither they nor their copies and pickles can be modified."""

import copy
import pickle
from collections.abc import Callable
from dataclasses import FrozenInstanceError, field, replace

import numpy as np
import pytest

from tactfix.geometry.arrays import Frozen, UnitVector
from tactfix.values import ReadOnly, frozen_value


@frozen_value
class Place:
    point: Frozen
    normal: UnitVector
    offset: Frozen | None = None
    names: ReadOnly[str, int] = field(default_factory=dict)


@frozen_value(eq=True)
class Count:
    contacts: int
    unit: str = "mm"


WAYS: dict[str, Callable[[Place], Place]] = {
    "made": lambda place: place,
    "replaced": lambda place: replace(place, offset=[1.0, 2.0]),
    "copied": copy.deepcopy,
    "pickled": lambda place: pickle.loads(pickle.dumps(place)),
}


@pytest.mark.parametrize("way", WAYS)
def test_nothing_in_a_value_can_be_written_to(way):
    given = np.array([1.0, 2.0, 3.0])
    place = WAYS[way](Place(given, [0, 0, 2], names={"a": 1}))
    given[0] = 7.0
    assert place.point.tolist() == [1.0, 2.0, 3.0]
    assert place.normal.tolist() == [0.0, 0.0, 1.0]
    for array in (place.point, place.normal, *([place.offset] if place.offset is not None else [])):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    with pytest.raises(TypeError):
        place.names["b"] = 2
    with pytest.raises(FrozenInstanceError, match="point"):
        place.point = given
    with pytest.raises(FrozenInstanceError):
        del place.point


def test_a_missing_or_unknown_field_is_refused():
    with pytest.raises(TypeError, match="normal"):
        Place([1, 2, 3])
    with pytest.raises(TypeError, match="unit_"):
        Count(3, unit_="in")


def test_defaults_made_anew_are_not_shared():
    one, other = (Place([0, 0, 0], [1, 0, 0]) for _ in range(2))
    assert one.names == other.names == {}
    assert one.names is not other.names


def test_equal_by_fields_only_where_asked():
    assert Count(3) == Count(3)
    assert hash(Count(3)) == hash(Count(3))
    assert Count(3) != Count(4)
    place = Place([0, 0, 0], [1, 0, 0])
    assert place == place  # noqa: PLR0124
    assert place != copy.copy(place)
    assert repr(Count(3)) == "Count(contacts=3, unit='mm')"
    assert repr(Count(np.int64(3), "m")) == "Count(contacts=3, unit='m')"
