"""The sample logs of samples/machine-files: the same six touches of a corner, in every format."""

from pathlib import Path

import numpy as np
import pytest

from tactfix.files.contact_options import ContactOptions, log_options
from tactfix.files.logs import LOG_FORMATS
from tactfix.files.logs.load import read_log

FOLDER = Path(__file__).parents[3] / "samples" / "machine-files"
FILES = {
    "linuxcnc": "linuxcnc.txt", "grbl": "grbl.log", "msr": "results.msr", "xyzijk": "points.xyz",
    "xyz": "points-bare.xyz", "ippdme": "ippdme.log", "dmis": "points.dmis", "ur": "ur.txt", "kuka": "kuka.dat",
    "abb": "abb.mod", "fanuc": "fanuc.ls",
}  # fmt: skip
# On three planes through (120, 80, 40), with normals z, -y and -x, and a tip of radius 2.
PLANES = [((0, 0, 1), 40)] * 3 + [((0, -1, 0), -80)] * 2 + [((-1, 0, 0), -120)]


@pytest.mark.parametrize("name", LOG_FORMATS)
def test_a_sample_of_each_format_tells_the_same_touches(name):
    asks_unit = name in ("linuxcnc", "grbl", "msr", "xyz")
    options, features = ContactOptions("mm" if asks_unit else None), log_options("top:3,front:2,left:1")
    log = read_log(name, FOLDER / FILES[name], None, options, features, complete=False)
    points = log.points * (1000 if log.units == "m" else 1)
    reach = 0 if name == "xyzijk" else 2
    for point, approach, (normal, distance) in zip(points, log.approaches, PLANES, strict=True):
        assert np.dot(normal, point) == pytest.approx(distance + reach)
        assert np.isnan(approach).all() or np.dot(normal, approach) == pytest.approx(-1)
    assert np.isfinite(log.approaches).all() == (name in ("grbl", "msr", "xyzijk", "ippdme", "dmis"))
