"""How often the mistake that was made is the one named by locate: python -m tests.validation.diagnosis [draws].

Fixtures, poses, touches and mistakes come from made_mistakes and support.problems, which share no code with the
package. Counted for each mistake: named first (alone, or with others that fit equally well), named among the first
three or among those that fit equally well, not named, and a good contact blamed alone; and how often it is named first
if it is the likeliest explanation (`likelihoods`).
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
    """Whether a cause is the mistake that was made. Exchanging x and y of the whole fixture mirrors it."""
    if case.code == "mirrored" and not case.features and cause.code == "axes":
        return not cause.features
    rows = not case.rows or set(cause.rows) == case.rows
    features = not case.features or set(cause.features) == case.features
    return cause.code == case.code and rows and features


SAME = 1e-3
"""Share of chi-square by which causes differ that are one to the contacts."""


def verdict(case: Case, result) -> str:
    """The rank of the mistake in the diagnosis; "unseen" if the contacts do not show it."""
    if result.status != "inconsistent" and not result.diagnosis:
        return "unseen"
    if not result.diagnosis:
        return "not named"
    first = result.diagnosis[0]
    causes = list(first.causes) if first.one_of else [first]
    # Causes that leave the same residuals cannot be distinguished by contacts: their order has no meaning.
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
    """One draw and its result, a line of the journal. said: a column of the table, "none" if the fixture does not allow
    the mistake. likeliest: whether the mistake made is likelier than every other cause named and than any single good
    contact being bad (`likelihoods`).
    """

    mistake: str
    fixture: str
    draw: int
    said: str
    seconds: float
    likeliest: bool


def judged(mistake: str, fixture: str, draw: int) -> Judged:
    """The result of one draw."""
    patches, counts = FIXTURES[fixture]
    case = MISTAKES[mistake](patches, counts, np.random.default_rng([draw, len(fixture), len(mistake)]))
    if case is None:
        return Judged(mistake, fixture, draw, "none", 0.0, likeliest=False)
    begun = time.process_time()
    result = locate(placed(case.in_file), case.contacts)
    seconds = time.process_time() - begun
    return Judged(mistake, fixture, draw, verdict(case, result), round(seconds, 3), is_likeliest(case, result))


def is_likeliest(case: Case, result) -> bool:
    """Whether no other cause named, and no good contact blamed alone, is more likely than the mistake made."""
    named = [cause for entry in result.diagnosis for cause in (entry.causes or [entry])]
    others = [named_score(case, cause) for cause in named if not is_named(case, cause)]
    return bool(true_score(case) <= min([one_good_out_score(case), *others]) + SAME)


def read(journal: Path) -> list[Judged]:
    """The complete lines of a journal; an incomplete line is left out."""
    lines = journal.read_text(encoding="utf-8").splitlines(keepends=True) if journal.exists() else []
    return [Judged(**json.loads(line)) for line in lines if line.endswith("\n")]


def table(done: Iterable[Judged]) -> Iterator[str]:
    """A row for each mistake, over all fixtures; last columns: how often the mistake made is the likeliest
    explanation, and how often it is then named first.
    """
    found = [one for one in done if one.said != "none"]
    yield f"| mistake | draws | {' | '.join(COLUMNS)} | worst ms | likeliest | first then |"
    for mistake in MISTAKES:
        rows = [one for one in found if one.mistake == mistake]
        verdicts = Counter(one.said for one in rows)
        slowest = max((one.seconds for one in rows), default=0.0)
        then = [one.said in ("first", "first of several") for one in rows if one.likeliest and one.said != "unseen"]
        counts = " | ".join(str(verdicts[column]) for column in COLUMNS)
        yield f"| {mistake} | {len(rows)} | {counts} | {1000 * slowest:.0f} | {len(then)} | {sum(then)} |"


def main(draws: int, journal: Path, only: str) -> None:
    """Compute draws that the journal lacks, every mistake and fixture once before any twice; print the table."""
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
    arguments = reader.parse_args()
    main(arguments.draws, arguments.journal, arguments.only)
