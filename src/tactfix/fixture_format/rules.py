"""Touch boxes: of features that exist, with a low end below the high one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from tactfix.fixture_format.build import AXES
from tactfix.fixture_format.declared import Declared
from tactfix.fixture_format.problems import Finding

if TYPE_CHECKING:
    from tactfix.fixture_format.entries import FixtureEntry


def check_touch(document: FixtureEntry, declared: Declared) -> Iterator[Finding]:
    """Findings about touch boxes as such; whether a box leaves something of its surface is a matter of geometry."""
    for name, box in document.get("touch", {}).items():
        yield from declared.unknown(name, ("touch", name), at_key=True)
        for axis in AXES:
            low, high = box.get(axis) or (None, None)
            if low is not None and high is not None and low >= high:
                what = f"touch.{name}.{axis} goes from {low:g} to {high:g}"
                remedy = "write [low, high] with low below high, null for an open end, or leave the axis out"
                yield Finding(("touch", name, axis), what, remedy)
