"""Parts of the validation study with few contacts on each feature, and the objects read from their files."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import tactfix
from tests.validation.relation_geometry import KINDS, Angle, Part
from tests.validation.relation_touches import Touched, by_relations, touches


def turned_part(
    kind: str, rng: np.random.Generator, angle: Angle, most: int | Mapping[str, int]
) -> tuple[Part, Touched]:
    """A part of a kind and its touches in a rotated base, with at most this number on each feature."""
    part = KINDS[kind].make(angle)
    return part, few_touches(part, rng, most)


def few_touches(part: Part, rng: np.random.Generator, most: int | Mapping[str, int]) -> Touched:
    """Touches of a part in a rotated base, at most this number on each feature, or on each of a type."""
    base = np.eye(4)
    base[:3, :3], base[:3, 3] = Rotation.random(random_state=rng).as_matrix(), rng.uniform(-300, 300, 3)
    touched = touches(part, base, rng, nominal=False)
    limits = {name: most if isinstance(most, int) else most[thing.kind] for name, thing in part.things.items()}
    few = [i for i, name in enumerate(touched.names) if touched.names[:i].count(name) < limits[name]]
    parts = {n: getattr(touched, n)[few] for n in ("points", "normals", "approaches")}
    return replace(touched, names=tuple(touched.names[i] for i in few), **parts)


def few_contacts_on(
    kind: str,
    seed: int,
    folder: Path,
    angle: tuple[float, float] = (60.0, 0.0),
    most: int | Mapping[str, int] = 3,
) -> tuple[tactfix.Fixture, tactfix.Contacts, Touched]:
    """A part in a rotated base with noisy contacts, at most so many a feature; angle: value and sigma in the file."""
    rng = np.random.default_rng([seed, *kind.encode()])
    part, touched = turned_part(kind, rng, Angle(*angle, angle[0], 0.0), most)
    return (*as_read(part, touched, rng, folder), touched)


def as_read(
    part: Part, touched: Touched, rng: np.random.Generator, folder: Path
) -> tuple[tactfix.Fixture, tactfix.Contacts]:
    """The fixture and the contacts that the package reads from the files of a part and of noisy contacts."""
    (folder / "fixture.yaml").write_text(by_relations(part))
    (folder / "contacts.csv").write_text(touched.csv(0.01, rng.standard_normal(len(touched.names))))
    fixture = tactfix.load_fixture(folder / "fixture.yaml")
    return fixture, tactfix.load_contacts(folder / "contacts.csv", fixture)
