"""Pose files without a known suffix: recognized by marks that only one format has, and never guessed."""

import numpy as np
import pytest

from tactfix.files.pose_file import load_pose, recognized
from tactfix.pose_formats import DIALECTS
from tactfix.pose_formats.convert import write_pose
from tactfix.pose_formats.pose import Pose
from tests.pose_formats.test_as_people_write import FORMS
from tests.support.command_line import tactfix

NUMBERS_ALONE = {"matrix", "json", "csv", "npy", "yaskawa", "staubli", "mitsubishi"}
AT = np.eye(4)
AT[:3, 3] = [300, 200, -50]


@pytest.mark.parametrize("name", DIALECTS)
def test_written_poses_are_recognized_unless_they_are_only_numbers(name):
    text = write_pose(name, Pose(AT, "mm", np.eye(6) * 1e-6, "plate"), force=True).text
    if not isinstance(text, bytes):
        assert recognized(text) == (None if name in NUMBERS_ALONE else name)


@pytest.mark.parametrize("case", [case for case, (name, _) in FORMS.items() if name not in NUMBERS_ALONE | {"yaml"}])
def test_poses_in_common_forms_are_recognized(case):
    name, text = FORMS[case]
    assert recognized(text) == name
    assert recognized(text.replace("\n", "\r\n")) == name


@pytest.mark.parametrize(
    "text",
    [
        "1,2,3,4,5,6",
        "1 0 0 1\n0 1 0 2\n0 0 1 3\n0 0 0 1",
        "p[1,2,3,0,0,0]\n{X 1,Y 2,Z 3,A 0,B 0,C 0}",
        "",
        "x: 1\nw: 2\n",
    ],
)
def test_numbers_alone_and_the_marks_of_two_are_of_no_format(text):
    assert recognized(text) is None


@pytest.mark.parametrize(
    "text",
    [
        "G10 L2 P1 X300 Y200 Z-50 R0",
        "$BASE={X 300,Y 200,Z -50,A 0,B 0,C 0}",
        'PERS wobjdata w:=[FALSE,TRUE,"",[[300,200,-50],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];',
        "UFRAME[1] X: 300 Y: 200 Z: -50 W: 0 P: 0 R: 0",
    ],
)
def test_a_work_offset_is_read_with_any_file_name(tmp_path, text):
    (tmp_path / "offset.txt").write_text(text)
    (tmp_path / "log").write_text("1 2 3 0 0 0 0 0 0\n")
    np.testing.assert_allclose(load_pose(tmp_path / "offset.txt").base_from_fixture, AT)
    options = ["--contacts-format", "linuxcnc", "--features", "ball:1", "--units", "mm"]
    done = tactfix("import", tmp_path / "log", *options, "--work-offset", tmp_path / "offset.txt")
    assert done.returncode == 0
    assert "\nball,301.0,202.0,-47.0" in done.stdout
