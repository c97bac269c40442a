"""Whether the entries of a fixture file make sense together; each rule lives with the section that it is about."""

from dataclasses import dataclass

from tactfix.models.document import FixtureDocument
from tactfix.models.findings import Finding, Path
from tactfix.suggestions import did_you_mean


@dataclass(frozen=True, slots=True)
class Declared:
    """The names of all features of the file, those among them that are refused already, and whether the frame is."""

    names: frozenset[str]
    refused: frozenset[str] = frozenset()
    frame_refused: bool = False

    def unknown(self, name: str, path: Path) -> list[Finding]:
        """The finding that there is no feature of this name, none where there is."""
        if name in self.names:
            return []
        return [Finding(path, f"there is no feature {name!r}", did_you_mean(name, sorted(self.names)))]


def check_sense(document: FixtureDocument, declared: Declared) -> list[Finding]:
    """Everything that is well formed and makes no sense."""
    return []
