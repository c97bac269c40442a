"""Time and memory of locate with a scan of one feature of a fixture by relations.

    OMP_NUM_THREADS=1 python -m tests.validation.relations_scan [CONTACTS]

The fixture is a plate with a bar and a ball. The plate has CONTACTS contacts (default 100,000), far more than needed;
bar and ball have three each, too few to be located alone. Processor time; memory is the largest resident set, before
and after.
"""

import argparse
import resource
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from tactfix import Contacts, contacts_from_arrays, locate
from tests.relations.touched_parts import few_contacts_on
from tests.validation.cost_table import megabytes

SIGMA = 0.01


def scanned(contacts: Contacts, truth, count: int) -> Contacts:
    """The contacts with those on the plate replaced by count contacts in the same rectangle."""
    plate = contacts.by_feature["plate"]
    others = np.setdiff1d(np.arange(len(contacts)), plate)
    rng = np.random.default_rng(5)
    along = rng.uniform(-1, 1, (count, len(plate) - 1)) @ np.diff(truth.points[plate], axis=0)
    points = truth.points[plate[0]] + along + SIGMA * rng.standard_normal((count, 1)) * truth.normals[plate[0]]
    return contacts_from_arrays(
        ["plate"] * count + [contacts.features[i] for i in others],
        np.vstack([points, contacts.points[others]]),
        approaches=np.vstack([np.repeat(contacts.approaches[plate[:1]], count, axis=0), contacts.approaches[others]]),
        sigma=SIGMA,
        tip_radius=0.0,
    )


def main(count: int) -> None:
    with TemporaryDirectory() as folder:
        fixture, contacts, truth = few_contacts_on("bar beside ball on plate", 1, Path(folder), (60.0, 0.0))
    many = scanned(contacts, truth, count)
    before, begun = megabytes(resource.RUSAGE_SELF), time.process_time()
    result = locate(fixture, many, explain=False)
    took = time.process_time() - begun
    most = megabytes(resource.RUSAGE_SELF)
    print(f"{count} contacts on the plate: {result.status}, {took:.2f} s, {before:.0f} MB before, {most:.0f} at most")


if __name__ == "__main__":
    reader = argparse.ArgumentParser(description=__doc__)
    reader.add_argument("contacts", type=int, nargs="?", default=100_000)
    main(reader.parse_args().contacts)
