"""How often the mistake that was made is the one that is named: python -m tests.validation.diagnosis [draws].

Fixtures, poses, touches and mistakes are made here and in support.problems, which share no code with the package. For
each mistake and fixture: named first (alone, or first of those that cannot be told apart), among the first three or
those that cannot be told apart, not named, and a good contact blamed alone.
"""

import json
import time
from argparse import ArgumentParser
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from tactfix.localization.locate import locate
from tests.support.problems import Patch, placed, touch_all

TIP, SIGMA = 2.0, 0.02

FIXTURES: Mapping[str, tuple[Mapping[str, Patch], tuple[int, ...]]] = {
    "plate, pin, ball": (
        {
            "plate": Patch("plane", (150, 100, 0), length=150.0),
            "pin": Patch("cylinder", (0, 0, 0), radius=10.0, length=15.0, middle=25.0),
            "ball": Patch("sphere", (300, 180, 60), radius=19.05, up=-0.4),
        },
        (5, 5, 4),
    ),
    "four planes": (
        {
            "right": Patch("plane", (0, -50, -60), (1, 0, 0), length=40.0),
            "back": Patch("plane", (-70, 0, -45), (0, 1, 0), length=40.0),
            "top": Patch("plane", (-80, -40, 0), (0, 0, 1), length=40.0),
            "slope": Patch("plane", (-90, -80, -20), (-1, -1, 1), length=15.0),
        },
        (4, 4, 4, 3),
    ),
    "three balls": (
        {
            "one": Patch("sphere", (10, 20, 5), radius=12.7, up=-0.4),
            "two": Patch("sphere", (190, 30, 15), radius=9.525, up=-0.4),
            "three": Patch("sphere", (60, 155, 25), radius=19.05, up=-0.4),
        },
        (5, 5, 5),
    ),
    "plate, two pins": (
        {
            "plate": Patch("plane", (150, 80, 0), length=120.0),
            "pin_1": Patch("cylinder", (20, 10, 0), radius=10.0, length=15.0, middle=25.0),
            "pin_2": Patch("cylinder", (320, 40, 0), radius=8.0, length=15.0, middle=25.0),
        },
        (5, 5, 5),
    ),
    "bar, ball, plane": (
        {
            "bar": Patch("cylinder", (10, 0, 40), (1, 0, 0), radius=15.0, length=60.0, middle=0.0),
            "ball": Patch("sphere", (30, 120, 50), radius=19.05, up=-0.2),
            "side": Patch("plane", (90, 60, 30), (1, 1, 0), length=25.0),
        },
        (5, 4, 4),
    ),
    "plate, pins, balls": (
        {
            "plate": Patch("plane", (150, 100, 0), length=150.0),
            "pin": Patch("cylinder", (5, 15, 0), radius=10.0, length=15.0, middle=25.0),
            "post": Patch("cylinder", (280, 20, 0), radius=12.0, length=15.0, middle=25.0),
            "ball": Patch("sphere", (300, 180, 60), radius=19.05, up=-0.4),
            "marble": Patch("sphere", (40, 210, 50), radius=12.7, up=-0.4),
        },
        (5, 4, 4, 4, 4),
    ),
}


@dataclass(frozen=True)
class Case:
    """What is touched (built), what the file says (said), the contacts, and what has to be named."""

    said: Mapping[str, Patch]
    contacts: object
    code: str
    rows: frozenset[int] = frozenset()
    features: frozenset[str] = frozenset()


Maker = Callable[[Mapping[str, Patch], tuple[int, ...], np.random.Generator], Case | None]


def touched(patches, counts, rng, tip=TIP, sigma=SIGMA):
    truth = touch_all(patches, dict(zip(patches, counts, strict=True)), rng, sigma=sigma, tip=tip)
    return truth, truth.contacts(rng)


def off(count: int, size: tuple[float, float]) -> Maker:
    """So many contacts off by a size between these (mm)."""

    def make(patches, counts, rng):
        truth, contacts = touched(patches, counts, rng)
        index = rng.choice(len(contacts), count, replace=False)
        points = contacts.points.copy()
        lengths = rng.choice([-1.0, 1.0], count) * np.exp(rng.uniform(*np.log(size), count))
        points[index] += lengths[:, None] * truth.normals[index]
        return Case(patches, replace(contacts, points=points), "outlier", frozenset((index + 1).tolist()))

    return make


def reversed_approach(patches, counts, rng):
    _, contacts = touched(patches, counts, rng)
    i = int(rng.integers(len(contacts)))
    approaches = contacts.approaches.copy()
    approaches[i] *= -1
    return Case(patches, replace(contacts, approaches=approaches), "approach", frozenset([i + 1]))


def all_normals(patches, counts, rng):
    _, contacts = touched(patches, counts, rng)
    return Case(patches, replace(contacts, approaches=-contacts.approaches), "approach")


def swapped(patches, counts, rng):
    _, contacts = touched(patches, counts, rng)
    names = list(contacts.features)
    while True:
        i, k = rng.choice(len(names), 2, replace=False)
        if names[i] != names[k]:
            break
    names[i], names[k] = names[k], names[i]
    return Case(
        patches, replace(contacts, features=tuple(names)), "swapped_labels", frozenset([int(i) + 1, int(k) + 1])
    )


def relabelled(patches, counts, rng):
    _, contacts = touched(patches, counts, rng)
    names = list(contacts.features)
    i = int(rng.integers(len(names)))
    names[i] = str(rng.choice([name for name in patches if name != names[i]]))
    return Case(patches, replace(contacts, features=tuple(names)), "relabel", frozenset([i + 1]))


def exchanged(patches, counts, rng):
    _, contacts = touched(patches, counts, rng)
    a, b = (str(name) for name in rng.choice(list(patches), 2, replace=False))
    other = {a: b, b: a}
    names = tuple(other.get(name, name) for name in contacts.features)
    return Case(patches, replace(contacts, features=names), "feature_exchange", features=frozenset([a, b]))


def wrong_unit(patches, counts, rng):
    _, contacts = touched(patches, counts, rng)
    factor = float(rng.choice([25.4, 1 / 25.4, 1000.0, 1e-3]))
    return Case(patches, replace(contacts, points=contacts.points / factor), "unit")


def wrong_tip(patches, counts, rng):
    _, contacts = touched(patches, counts, rng, tip=float(rng.uniform(0.5, 4.0)))
    said = float(rng.choice([0.0, TIP]))
    return Case(patches, replace(contacts, tip_radius=said), "tip_radius")


def wrong_sigma(patches, counts, rng):
    _, contacts = touched(patches, counts, rng, sigma=SIGMA * float(rng.uniform(5.0, 15.0)))
    return Case(patches, replace(contacts, sigmas=np.full(len(contacts), SIGMA)), "sigma")


def wrong_file(change: Callable[[Patch, np.random.Generator], Patch | None], code: str) -> Maker:
    """One feature is not what the file says."""

    def make(patches, counts, rng):
        _, contacts = touched(patches, counts, rng)
        able = [name for name in patches if change(patches[name], np.random.default_rng(0)) is not None]
        if not able:
            return None
        name = str(rng.choice(able))
        said = {**patches, name: change(patches[name], rng)}
        return Case(said, contacts, code, features=frozenset([name]))

    return make


def other_radius(patch, rng):
    return None if patch.kind == "plane" else replace(patch, radius=patch.radius * float(rng.uniform(1.1, 1.6)))


def diameter(patch, rng):
    return None if patch.kind == "plane" else replace(patch, radius=2 * patch.radius)


def all_diameters(patches, counts, rng):
    _, contacts = touched(patches, counts, rng)
    said = {n: diameter(p, rng) or p for n, p in patches.items()}
    return None if said == dict(patches) else Case(said, contacts, "diameter")


def other_side(patch, rng):
    return None if patch.kind == "plane" else replace(patch, side="inner" if patch.side == "outer" else "outer")


def elsewhere(patch, rng):
    shift = rng.normal(size=3)
    shift *= rng.uniform(0.3, 5.0) / np.linalg.norm(shift)
    if patch.kind == "plane":
        along = np.asarray(patch.along, float) / np.linalg.norm(patch.along)
        shift = along * np.copysign(rng.uniform(0.3, 5.0), shift[0])
    if patch.kind == "cylinder":
        along = np.asarray(patch.along, float) / np.linalg.norm(patch.along)
        shift = shift - (shift @ along) * along
    return replace(patch, at=tuple(np.asarray(patch.at, float) + shift))


def xy_exchanged(patch, rng):
    x, y, z = patch.at
    return None if patch.kind == "plane" or x == y else replace(patch, at=(y, x, z))


def mirrored(patches, counts, rng):
    _, contacts = touched(patches, counts, rng)
    flip = np.array([-1.0, 1.0, 1.0])
    said = {n: replace(p, at=tuple(flip * p.at), along=tuple(flip * p.along)) for n, p in patches.items()}
    return Case(said, contacts, "mirrored")


MISTAKES: Mapping[str, Maker] = {
    "one contact 0.3-3 mm off": off(1, (0.3, 3.0)),
    "one contact 0.14-0.3 mm off": off(1, (0.14, 0.3)),
    "two contacts": off(2, (0.3, 3.0)),
    "three contacts": off(3, (0.3, 3.0)),
    "one approach reversed": reversed_approach,
    "all approaches reversed": all_normals,
    "two labels swapped": swapped,
    "one label wrong": relabelled,
    "two features exchanged": exchanged,
    "coordinates in another unit": wrong_unit,
    "tip radius": wrong_tip,
    "sigma 5-15 times too small": wrong_sigma,
    "one radius": wrong_file(other_radius, "radius"),
    "one diameter": wrong_file(diameter, "diameter"),
    "all diameters": all_diameters,
    "one side": wrong_file(other_side, "side"),
    "one feature 0.3-5 mm elsewhere": wrong_file(elsewhere, "feature_place"),
    "x and y of one feature": wrong_file(xy_exchanged, "axes"),
    "mirrored": mirrored,
}


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
    bad = first.code == "outlier" and not first.one_of and not set(first.rows) <= case.rows
    return "good blamed" if bad else "not named"


COLUMNS = ("first", "first of several", "among", "not named", "good blamed", "unseen")


@dataclass(frozen=True)
class Judged:
    """One draw, and what was said of it: a line of the journal. said: a column of the table, "none" where the fixture
    allows no such mistake.
    """

    mistake: str
    fixture: str
    draw: int
    said: str
    seconds: float


def judged(mistake: str, fixture: str, draw: int) -> Judged:
    """The verdict on one draw."""
    patches, counts = FIXTURES[fixture]
    case = MISTAKES[mistake](patches, counts, np.random.default_rng([draw, len(fixture), len(mistake)]))
    if case is None:
        return Judged(mistake, fixture, draw, "none", 0.0)
    begun = time.process_time()
    result = locate(placed(case.said), case.contacts)
    seconds = time.process_time() - begun
    return Judged(mistake, fixture, draw, verdict(case, result), round(seconds, 3))


def read(journal: Path) -> list[Judged]:
    """The whole lines of a journal; a line that was cut short is left out."""
    lines = journal.read_text(encoding="utf-8").splitlines(keepends=True) if journal.exists() else []
    return [Judged(**json.loads(line)) for line in lines if line.endswith("\n")]


def table(done: Iterable[Judged]) -> Iterator[str]:
    """A row for each mistake, over all fixtures."""
    found = [one for one in done if one.said != "none"]
    yield f"| mistake | draws | {' | '.join(COLUMNS)} | worst ms |"
    for mistake in MISTAKES:
        rows = [one for one in found if one.mistake == mistake]
        said = Counter(one.said for one in rows)
        slowest = max((one.seconds for one in rows), default=0.0)
        yield f"| {mistake} | {len(rows)} | {' | '.join(str(said[c]) for c in COLUMNS)} | {1000 * slowest:.0f} |"


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
