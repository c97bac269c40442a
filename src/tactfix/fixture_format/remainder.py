"""What is left of a fixture file when its malformed entries are taken out, and whether that makes sense."""

from __future__ import annotations

import copy
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

from tactfix.fixture_format.declared import Declared
from tactfix.fixture_format.json_schema import is_well_formed
from tactfix.fixture_format.problems import Finding, Path
from tactfix.fixture_format.sense import check_sense

if TYPE_CHECKING:
    from tactfix.fixture_format.entries import FixtureEntry
    from tactfix.fixture_format.pydantic_errors import Refusal

_LISTS = ("distances", "angles")
_DEFAULTS = {"tactfix": 1, "units": "mm"}


@dataclass(slots=True)
class _Sieve:
    """What is left of the values of a file, and what was taken out of them."""

    value: dict[str, Any]
    taken: set[Path] = field(default_factory=set)

    def take_out(self, path: Path, *, key_only: bool) -> None:
        """Take out the refused key, or the entry or section around a refused value."""
        end = len(path) if key_only else min(len(path), 2 if path[0] in ("features", "touch", *_LISTS) else 1)
        if path[:end] in self.taken:
            return
        self.taken.add(path[:end])
        parent: Any = self.value
        for part in path[: end - 1]:
            parent = parent[part] if not isinstance(parent, dict) or part in parent else {}
        if isinstance(parent, list):
            parent[int(path[end - 1])] = None  # keeps the indices of the others until all are known
        elif isinstance(parent, dict):
            parent.pop(path[end - 1], None)


def sense_of_the_rest(value: dict[str, Any], refusals: list[Refusal]) -> list[Finding]:
    """What makes no sense in the entries that are well formed."""
    sieve = _Sieve(copy.deepcopy(value))
    for refusal in refusals:
        sieve.take_out(refusal.path, key_only=refusal.is_unknown_key)
    rest = {**_DEFAULTS, **sieve.value}
    kept = {}
    for key in _LISTS:
        if isinstance(rest.get(key), list):
            kept[key] = [i for i in range(len(rest[key])) if (key, i) not in sieve.taken]
            rest[key] = [rest[key][i] for i in kept[key]]
    if not is_well_formed(rest):
        return []  # nothing is left to make sense of
    document = cast("FixtureEntry", rest)
    declared = Declared(tuple(value["features"]), document["features"], ("frame",) in sieve.taken)
    return [_at_home(finding, kept) for finding in check_sense(document, declared)]


def _at_home(finding: Finding, kept: dict[str, list[int]]) -> Finding:
    """The finding with the index that its relation has in the file."""
    match finding.path:
        case (str() as key, int() as index, *rest) if key in kept:
            return Finding((key, kept[key][index], *rest), finding.what, finding.remedy, finding.at_key)
    return finding
