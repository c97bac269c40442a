"""Contact sets on three balls, computed from poses and points on spheres; and readers of sets that fail on purpose."""

import os
import signal
import time
from functools import partial
from pathlib import Path

import numpy as np

from tactfix.batching.task import ContactSet
from tactfix.contacts import Contacts
from tactfix.files.contact_options import ContactOptions
from tactfix.files.contact_sets import SetReader
from tactfix.fixture import Fixture

CENTERS = {"a": (0.0, 0.0, 0.0), "b": (200.0, 0.0, 0.0), "c": (0.0, 150.0, 0.0)}
RADIUS = 12.7
FIXTURE = "tactfix: 1\nname: balls\nunits: mm\nprobe: {tip_radius: 0.0, sigma: 0.01}\nfeatures:\n" + "".join(
    f"  {name}: {{type: sphere, radius: {RADIUS}, center: [{', '.join(map(str, center))}]}}\n"
    for name, center in CENTERS.items()
)
HEADER = "feature,x,y,z,ax,ay,az"
PLAIN = SetReader("csv", ContactOptions())


def pose(seed: int) -> np.ndarray:
    """base_from_fixture (4, 4), a pose that depends on the number of the set."""
    rng = np.random.default_rng(seed)
    q, r = np.linalg.qr(rng.standard_normal((3, 3)))
    q = q * np.sign(np.diag(r))
    matrix = np.eye(4)
    matrix[:3, :3] = q * np.linalg.det(q)
    matrix[:3, 3] = rng.uniform(-900, 900, 3)
    return matrix


def rows(seed: int, noise: float = 0.0) -> list[str]:
    """Rows of a contact file: five touches along the normal on each ball."""
    rng = np.random.default_rng(seed + 10_000)
    matrix = pose(seed)
    lines = []
    for name, center in CENTERS.items():
        normals = rng.standard_normal((5, 3))
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        reach = RADIUS + noise * rng.standard_normal((5, 1))
        points = (np.array(center) + reach * normals) @ matrix[:3, :3].T + matrix[:3, 3]
        approaches = -normals @ matrix[:3, :3].T
        lines += [
            f"{name},{','.join(map(repr, [*point.tolist(), *approach.tolist()]))}"
            for point, approach in zip(points, approaches, strict=True)
        ]
    return lines


def contact_file(seed: int, noise: float = 0.0) -> str:
    return "\n".join([HEADER, *rows(seed, noise)]) + "\n"


def write_cell(directory: Path, count: int) -> tuple[Path, Path]:
    """Write a fixture file and a directory with count contact files, 000.csv and so on."""
    fixture, sets = directory / "balls.yaml", directory / "sets"
    fixture.write_text(FIXTURE)
    sets.mkdir()
    for k in range(count):
        (sets / f"{k:03d}.csv").write_text(contact_file(k))
    return fixture, sets


def contact_sets(count: int) -> list[ContactSet]:
    return [ContactSet(f"set {k}", contact_file(k).encode()) for k in range(count)]


def slow(seconds: float) -> partial:
    return partial(_slow, seconds)


def _slow(seconds: float, fixture: Fixture, contact_set: ContactSet) -> tuple[Contacts, tuple[str, ...]]:
    time.sleep(seconds)
    return PLAIN(fixture, contact_set)


def deadly(fixture: Fixture, contact_set: ContactSet) -> tuple[Contacts, tuple[str, ...]]:
    """A reader that kills its own process at the set named "set 3"."""
    if contact_set.name == "set 3":
        os.kill(os.getpid(), signal.SIGKILL)
    return PLAIN(fixture, contact_set)


def buggy(fixture: Fixture, contact_set: ContactSet) -> tuple[Contacts, tuple[str, ...]]:
    if contact_set.name == "set 3":
        raise ZeroDivisionError("as any bug")
    return PLAIN(fixture, contact_set)


def blank(result: object) -> str:
    return "not located"
