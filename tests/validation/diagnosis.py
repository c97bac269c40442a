"""How often the mistake that was made is the one that is named: python -m tests.validation.diagnosis [draws].

Fixtures, poses, touches and mistakes are made in made_mistakes and support.problems, which share no code with the
package. For each mistake: named first (alone, or first of those that cannot be told apart), among the first three or
those that cannot be told apart, not named, and a good contact blamed alone; and how often it is named first where it is
the likeliest explanation (`likelihoods`).
"""

import json
import time
from argparse import ArgumentParser
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from tactfix.localization.locate import locate
from tests.support.problems import placed
from tests.validation.likelihoods import named_score, one_good_out_score, true_score
from tests.validation.made_mistakes import FIXTURES, MISTAKES, Case


def is_named(case: Case, cause) -> bool:
    """Whether it is the mistake that was made. The whole fixture with x and y exchanged is its mirror image."""
    if case.code == "mirrored" and not case.features and cause.code == "axes":
        return not cause.features
    rows = not case.rows or set(cause.rows) == case.rows
    features = not case.features or set(cause.features) == case.features
    return cause.code == case.code and rows and features


SAME = 1e-3
"""Share of chi-square by which causes differ that are one to the contacts."""


def verdict(case: Case, result) -> str:
    """Where the mistake is named; "unseen" where the contacts do not show it."""
    if result.status != "inconsistent" and not result.diagnosis:
        return "unseen"
    if not result.diagnosis:
        return "not named"
    first = result.diagnosis[0]
    causes = list(first.causes) if first.one_of else [first]
    # What leaves the same residuals is the same to any contacts: which of these comes first says nothing.
    alike = [cause for cause in causes if abs(cause.chi2 - causes[0].chi2) <= SAME * (1 + causes[0].chi2)]
    if any(is_named(case, cause) for cause in alike):
        return "first" if not first.one_of else "first of several"
    if any(is_named(case, cause) for cause in [*causes, *result.diagnosis[1:3]]):
        return "among"
    bad = not first.one_of and not set(first.rows) <= case.rows
    return "good blamed" if bad else "not named"


COLUMNS = ("first", "first of several", "among", "not named", "good blamed", "unseen")


@dataclass(frozen=True)
class Judged:
    """One draw, and what was said of it: a line of the journal. said: a column of the table, "none" where the fixture
    allows no such mistake. likeliest: whether what was done is the likeliest of all that is named and of one good
    contact being bad (`likelihoods`).
    """

    mistake: str
    fixture: str
    draw: int
    said: str
    seconds: float
    likeliest: bool


def judged(mistake: str, fixture: str, draw: int) -> Judged:
    """The verdict on one draw."""
    patches, counts = FIXTURES[fixture]
    case = MISTAKES[mistake](patches, counts, np.random.default_rng([draw, len(fixture), len(mistake)]))
    if case is None:
        return Judged(mistake, fixture, draw, "none", 0.0, likeliest=False)
    begun = time.process_time()
    result = locate(placed(case.said), case.contacts)
    seconds = time.process_time() - begun
    return Judged(mistake, fixture, draw, verdict(case, result), round(seconds, 3), is_likeliest(case, result))


def is_likeliest(case: Case, result) -> bool:
    """Whether nothing else that is named, and no good contact blamed alone, is more likely than what was done."""
    named = [cause for entry in result.diagnosis for cause in (entry.causes or [entry])]
    others = [named_score(case, cause) for cause in named if not is_named(case, cause)]
    return bool(true_score(case) <= min([one_good_out_score(case), *others]) + SAME)


def read(journal: Path) -> list[Judged]:
    """The whole lines of a journal; a line that was cut short is left out."""
    lines = journal.read_text(encoding="utf-8").splitlines(keepends=True) if journal.exists() else []
    return [Judged(**json.loads(line)) for line in lines if line.endswith("\n")]


def table(done: Iterable[Judged]) -> Iterator[str]:
    """A row for each mistake, over all fixtures; the last columns: where what was done is the likeliest that is named,
    how often that is, and how often it is named first then.
    """
    found = [one for one in done if one.said != "none"]
    yield f"| mistake | draws | {' | '.join(COLUMNS)} | worst ms | likeliest | first then |"
    for mistake in MISTAKES:
        rows = [one for one in found if one.mistake == mistake]
        said = Counter(one.said for one in rows)
        slowest = max((one.seconds for one in rows), default=0.0)
        then = [one.said in ("first", "first of several") for one in rows if one.likeliest and one.said != "unseen"]
        counts = " | ".join(str(said[column]) for column in COLUMNS)
        yield f"| {mistake} | {len(rows)} | {counts} | {1000 * slowest:.0f} | {len(then)} | {sum(then)} |"


def main(draws: int, journal: Path, only: str) -> None:
    """Judge what the journal does not hold yet, every mistake and fixture once before any twice; print the table."""
    done = read(journal)
    known = {(one.mistake, one.fixture, one.draw) for one in done}
    with journal.open("a", encoding="utf-8") as file:
        for draw in range(draws):
            for mistake in MISTAKES:
                for fixture in FIXTURES:
                    if (mistake, fixture, draw) in known or only not in f"{mistake} {fixture}":
                        continue
                    done.append(judged(mistake, fixture, draw))
                    file.write(json.dumps(asdict(done[-1])) + "\n")
                    file.flush()
    print(*table(done), sep="\n")
    for one in done:
        if one.said in ("not named", "good blamed"):
            print(f"{one.said}: {one.mistake}, {one.fixture}, draw {one.draw}")


if __name__ == "__main__":
    reader = ArgumentParser(description=__doc__)
    reader.add_argument("draws", type=int, nargs="?", default=200)
    reader.add_argument("--journal", type=Path, default=Path("diagnosis.jsonl"), help="resumed where it is there")
    reader.add_argument("--only", default="", help="part of a mistake's or fixture's name")
    asked = reader.parse_args()
    main(asked.draws, asked.journal, asked.only)
