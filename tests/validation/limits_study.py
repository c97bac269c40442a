"""How often limits around a rough pose leave one pose for few touches of a real part, and what other poses remain.

python -m tests.validation.limits_study [DRAWS]

Reads the touches of the cast part (`tests/localization/test_real_part.py`), draws a few of them without approaches, and
locates within 20 deg and 20 mm of the published pose. Chi-square of the remaining poses is recomputed.
"""

import json
import sys
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from tactfix import load_contacts, load_fixture, locate
from tactfix.geometry.surfaces import Plane
from tactfix.placement import Placement
from tests.localization.test_real_part import drawn
from tests.support.shared_data import shared_data

LIMIT = 20.0


def chi_square(fixture, contacts, pose):
    """Chi-square of contacts at a pose (4, 4)."""
    total = 0.0
    for name, place, sigma in zip(contacts.features, contacts.points, contacts.sigmas, strict=True):
        surface, point = fixture.features[name].surface, (place - pose[:3, 3]) @ pose[:3, :3]
        if isinstance(surface, Plane):
            gap = (point - surface.point) @ surface.normal
        else:
            gap = np.linalg.norm(np.cross(point - surface.point, surface.direction)) - surface.radius
        total += float(gap / sigma) ** 2
    return total


def main(draws):
    fixture = load_fixture(shared_data("reference", "real", "cmm_part", "fixture.yaml"))
    contacts = load_contacts(str(shared_data("reference", "real", "cmm_part", "contacts.csv")), fixture)
    text = shared_data("reference", "real", "cmm_part", "published.json").read_text()
    published = np.array(json.loads(text)["base_from_fixture"])
    placed = replace(fixture, placement=Placement(published, (20.0, np.radians(LIMIT))))
    for count in (6, 7, 8, 9, 11):
        rng, located, within, half, others, worst = np.random.default_rng(100 + count), 0, 0, 0, 0, 0.0
        for _ in range(draws):
            few = drawn(contacts, count, rng)
            result = locate(placed, few, explain=False)
            located += result.status == "located"
            left = [candidate.base_from_fixture for candidate in result.candidates if candidate.accepted]
            turns = [np.degrees(Rotation.from_matrix(pose[:3, :3] @ published[:3, :3].T).magnitude()) for pose in left]
            if result.status in ("located", "ambiguous"):
                within += sum(turn <= LIMIT for turn in turns) == 1
                half += sum(turn <= LIMIT / 2 for turn in turns) == 1
                wrong = [chi_square(fixture, few, p) for p, turn in zip(left, turns, strict=True) if turn > 0.5]
                others += len(wrong)
                worst = max([worst, *wrong])
        print(
            f"{count} contacts, {draws} draws: located {located}; one within {LIMIT:g} deg without the widening "
            f"{within}, one within {LIMIT / 2:g} deg {half}; {others} other poses left, chi-square at most {worst:.1f}",
            flush=True,
        )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
