"""The sample logs of samples/machine-files: the same six touches of a corner, in every format."""

from pathlib import Path

import numpy as np
import pytest

from tactfix.errors import FileError
from tactfix.files.contact_file import read_contact_file
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
def test_the_samples_of_all_formats_have_the_same_touches(name):
    asks_unit = name in ("linuxcnc", "grbl", "msr", "xyz")
    options, features = ContactOptions("mm" if asks_unit else None), log_options("top:3,front:2,left:1")
    log = read_log(name, FOLDER / FILES[name], None, options, features, complete=False)
    points = log.points * (1000 if log.units == "m" else 1)
    reach = 0 if name == "xyzijk" else 2
    for point, approach, (normal, distance) in zip(points, log.approaches, PLANES, strict=True):
        assert np.dot(normal, point) == pytest.approx(distance + reach)
        assert np.isnan(approach).all() or np.dot(normal, approach) == pytest.approx(-1)
    assert np.isfinite(log.approaches).all() == (name in ("grbl", "msr", "xyzijk", "ippdme", "dmis"))


@pytest.mark.parametrize("name", LOG_FORMATS)
def test_a_log_given_as_a_contact_file_is_one_line_of_error(name):
    with pytest.raises(FileError) as caught:
        read_contact_file(FOLDER / FILES[name])
    assert len(caught.value.lines) == 1
    assert "--contacts-format" in caught.value.on_command_line


def test_answers_of_a_measuring_machine_alone_are_no_columns_in_units():
    answers = b"00169 # X(-43.0), Y(15.0), Z(30.4), IJK(0, 0, 1), ER(1.0)\n"
    with pytest.raises(FileError, match=r"no header row|no known column") as caught:
        read_contact_file(answers)
    assert "--contacts-format" in caught.value.on_command_line
