"""The names that a fixture file declares, for whoever checks the names that it uses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tactfix.fixture_format.problems import Finding, Path
from tactfix.wording import did_you_mean

if TYPE_CHECKING:
    from tactfix.fixture_format.entries import FeatureEntry


@dataclass(frozen=True, slots=True)
class Declared:
    """All names of features in the file, in its order; those that are well formed; whether the frame is refused."""

    names: tuple[str, ...]
    features: Mapping[str, FeatureEntry]
    frame_refused: bool = False

    def unknown(self, name: str, path: Path, *, at_key: bool = False) -> list[Finding]:
        """The finding that there is no feature of this name; none where there is."""
        if name in self.names:
            return []
        return [Finding(path, f"there is no feature {name!r}", did_you_mean(name, self.names), at_key)]

    def type_of(self, name: str) -> str | None:
        """plane, sphere or cylinder; None where the file does not say properly (which is told elsewhere)."""
        return self.features[name]["type"] if name in self.features else None
