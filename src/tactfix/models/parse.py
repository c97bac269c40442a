"""The plain values of a fixture file in, a fixture out, or everything that is wrong with them at once.

Where some entries are malformed, the rest is still checked for sense: an entry that pydantic refuses is taken out, and
what is left is read again.
"""

import copy
from dataclasses import dataclass, field
from typing import Any

from pydantic import ValidationError

from tactfix.fixture import Fixture
from tactfix.models.build import build_fixture
from tactfix.models.declared import Declared
from tactfix.models.document import FixtureDocument
from tactfix.models.findings import Finding, Path
from tactfix.models.refusals import findings_of, plain_path
from tactfix.models.sense import check_sense

_LISTS = ("distances", "angles")
_DEFAULTS = {"tactfix": 1, "units": "mm"}


@dataclass(slots=True)
class _Sieve:
    """A document in the making: what is left of the values, and what was taken out of them."""

    value: dict[str, Any]
    taken: set[Path] = field(default_factory=set)

    def take_out(self, path: Path, *, key_only: bool) -> None:
        """Take the refused key, or the entry or section around a refused value, out of the values."""
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


def parse_fixture(value: Any, name: str) -> Fixture | list[Finding]:
    """The fixture that value says; name: its name if the file gives none."""
    if not isinstance(value, dict):
        remedy = "begin with tactfix: 1, then units: and features:"
        what = "the file is empty" if value is None else "the file is not a mapping of keys to values"
        return [Finding((), what, remedy)]
    try:
        document = FixtureDocument.model_validate(value)
    except ValidationError as error:
        errors = error.errors(include_url=False)
        return findings_of(errors) + _sense_of_the_rest(value, errors)
    findings = check_sense(document, Declared(tuple(document.features), document.features))
    return findings or build_fixture(document, name)


def _sense_of_the_rest(value: dict[str, Any], errors: list[Any]) -> list[Finding]:
    """What makes no sense in the entries that are well formed."""
    sieve = _Sieve(copy.deepcopy(value))
    for error in errors:
        location = error["loc"]
        missing = error["type"] == "missing"
        path = plain_path(location[:-1] if missing and len(location) > 1 else location)
        sieve.take_out(path, key_only=error["type"] == "extra_forbidden")
    rest = {**_DEFAULTS, **sieve.value}
    kept = {}
    for key in _LISTS:
        if isinstance(rest.get(key), list):
            kept[key] = [i for i in range(len(rest[key])) if (key, i) not in sieve.taken]
            rest[key] = [rest[key][i] for i in kept[key]]
    try:
        document = FixtureDocument.model_validate(rest)
    except ValidationError:
        return []  # nothing is left to make sense of
    declared = Declared(tuple(value["features"]), document.features, ("frame",) in sieve.taken)
    return [_at_home(finding, kept) for finding in check_sense(document, declared)]


def _at_home(finding: Finding, kept: dict[str, list[int]]) -> Finding:
    """The finding with the index that its relation has in the file."""
    match finding.path:
        case (str() as key, int() as index, *rest) if key in kept:
            return Finding((key, kept[key][index], *rest), finding.what, finding.remedy, finding.at_key)
    return finding
