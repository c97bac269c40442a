"""Contacts or a fixture file with a mistake, generated without the package: the truth and the stated values."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from tactfix.contacts import Contacts
from tests.support.problems import Patch, touch_all

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
    """The fixture as its file states it (in_file), the contacts, and the cause to be named; and the truth: the fixture
    touched (built), the contacts without the mistake (right), and the pose.
    """

    in_file: Mapping[str, Patch]
    contacts: Contacts
    code: str
    built: Mapping[str, Patch]
    right: Contacts
    pose: np.ndarray
    rows: frozenset[int] = frozenset()
    features: frozenset[str] = frozenset()


Maker = Callable[[Mapping[str, Patch], tuple[int, ...], np.random.Generator], Case | None]


def touched(patches, counts, rng, tip=TIP, sigma=SIGMA):
    truth = touch_all(patches, dict(zip(patches, counts, strict=True)), rng, sigma=sigma, tip=tip)
    return truth, truth.contacts(rng)


def case_of(patches, truth, right, code, in_file=None, rows=(), features=(), labels=None, **changes) -> Case:
    """A case with a mistake in the fixture file (in_file) or in the contacts (changes)."""
    if labels is not None:
        changes["features"] = tuple(labels)
    named = frozenset(rows), frozenset(features)
    return Case(in_file or patches, replace(right, **changes), code, patches, right, truth.pose, *named)


def off(count: int, size: tuple[float, float]) -> Maker:
    """count contacts off by a size within this range (mm)."""

    def make(patches, counts, rng):
        truth, contacts = touched(patches, counts, rng)
        index = rng.choice(len(contacts), count, replace=False)
        points = contacts.points.copy()
        lengths = rng.choice([-1.0, 1.0], count) * np.exp(rng.uniform(*np.log(size), count))
        points[index] += lengths[:, None] * truth.normals[index]
        return case_of(patches, truth, contacts, "outlier", rows=(index + 1).tolist(), points=points)

    return make


def reversed_approach(patches, counts, rng):
    truth, contacts = touched(patches, counts, rng)
    i = int(rng.integers(len(contacts)))
    approaches = contacts.approaches.copy()
    approaches[i] *= -1
    return case_of(patches, truth, contacts, "approach", rows=[i + 1], approaches=approaches)


def all_normals(patches, counts, rng):
    truth, contacts = touched(patches, counts, rng)
    return case_of(patches, truth, contacts, "approach", approaches=-contacts.approaches)


def swapped(patches, counts, rng):
    truth, contacts = touched(patches, counts, rng)
    names = list(contacts.features)
    while True:
        i, k = rng.choice(len(names), 2, replace=False)
        if names[i] != names[k]:
            break
    names[i], names[k] = names[k], names[i]
    rows = [int(i) + 1, int(k) + 1]
    return case_of(patches, truth, contacts, "swapped_labels", rows=rows, labels=names)


def relabelled(patches, counts, rng):
    truth, contacts = touched(patches, counts, rng)
    names = list(contacts.features)
    i = int(rng.integers(len(names)))
    names[i] = str(rng.choice([name for name in patches if name != names[i]]))
    return case_of(patches, truth, contacts, "relabel", rows=[i + 1], labels=names)


def exchanged(patches, counts, rng):
    truth, contacts = touched(patches, counts, rng)
    a, b = (str(name) for name in rng.choice(list(patches), 2, replace=False))
    other = {a: b, b: a}
    names = [other.get(name, name) for name in contacts.features]
    return case_of(patches, truth, contacts, "feature_exchange", features=[a, b], labels=names)


def wrong_unit(patches, counts, rng):
    truth, contacts = touched(patches, counts, rng)
    factor = float(rng.choice([25.4, 1 / 25.4, 1000.0, 1e-3]))
    return case_of(patches, truth, contacts, "unit", points=contacts.points / factor)


def wrong_tip(patches, counts, rng):
    truth, contacts = touched(patches, counts, rng, tip=float(rng.uniform(0.5, 4.0)))
    stated = float(rng.choice([0.0, TIP]))
    return case_of(patches, truth, contacts, "tip_radius", tip_radius=stated)


def wrong_sigma(patches, counts, rng):
    truth, contacts = touched(patches, counts, rng, sigma=SIGMA * float(rng.uniform(5.0, 15.0)))
    contacts = replace(contacts, sigmas=np.full(len(contacts), SIGMA))
    return case_of(patches, truth, contacts, "sigma")


def wrong_file(change: Callable[[Patch, np.random.Generator], Patch | None], code: str) -> Maker:
    """One feature differs from the file."""

    def make(patches, counts, rng):
        truth, contacts = touched(patches, counts, rng)
        able = [name for name in patches if change(patches[name], np.random.default_rng(0)) is not None]
        if not able:
            return None
        name = str(rng.choice(able))
        in_file = {**patches, name: change(patches[name], rng)}
        return case_of(patches, truth, contacts, code, in_file, features=[name])

    return make


def other_radius(patch, rng):
    return None if patch.kind == "plane" else replace(patch, radius=patch.radius * float(rng.uniform(1.1, 1.6)))


def diameter(patch, rng):
    return None if patch.kind == "plane" else replace(patch, radius=2 * patch.radius)


def all_diameters(patches, counts, rng):
    truth, contacts = touched(patches, counts, rng)
    in_file = {n: diameter(p, rng) or p for n, p in patches.items()}
    return None if in_file == dict(patches) else case_of(patches, truth, contacts, "diameter", in_file)


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
    truth, contacts = touched(patches, counts, rng)
    flip = np.array([-1.0, 1.0, 1.0])
    in_file = {n: replace(p, at=tuple(flip * p.at), along=tuple(flip * p.along)) for n, p in patches.items()}
    return case_of(patches, truth, contacts, "mirrored", in_file)


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
