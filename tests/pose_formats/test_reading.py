"""Reading of poses: texts as people write them, and texts that are no pose."""

import json

import numpy as np
import pytest

from tactfix.errors import FileError, UsageError
from tactfix.files.pose_file import load_pose
from tactfix.formats import SUFFIXES
from tactfix.pose_formats import DIALECTS
from tactfix.pose_formats.convert import write_pose
from tactfix.pose_formats.pose import PoseSyntaxError
from tests.support.plain_poses import pose, turn

FLAT = np.eye(4).tolist()
MIRRORED = np.diag([1.0, 1.0, -1.0, 1.0]).tolist()
SCALED = np.diag([1.01, 1.01, 1.01, 1.0]).tolist()


def result(**changes):
    return json.dumps({"schema": "tactfix/locate/1", "units": "mm", "status": "located", "transform": FLAT} | changes)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("kuka", "{ x 1, y -2.5 ,Z 3e0, A 0, B 0,\n C 0 }"),
        ("kuka", "; was {X 9,Y 9,Z 9,A 0,B 0,C 0}\nBASE_DATA[1]={X 1,Y -2.5,Z 3,A 0,B 0,C 0}"),
        ("abb", "CONST pose p := [ [1, -2.5, 3.0], [1,0,0,0] ];"),
        ("abb", "[[1,-2.5,3],[-1,0,0,0]]"),
        ("ur", "set_tcp(p[.001,-.0025,.003,0,0,0])"),
        ("g68.2", "(a) G21\nG68.2 X1 Y-2.5 Z3 I0 J0 K0"),
        ("siemens", "$P_UIFR[1] = CTRANS(X,1,Y,-2.5,Z,3) : CROT(X,0,Y,0,Z,0)"),
        ("yaskawa", "1,-2.5, 3 ,0,0,0"),
    ],
)
def test_blanks_case_and_context_do_not_matter(name, text):
    np.testing.assert_allclose(DIALECTS[name].read(text).in_units("mm").base_from_fixture[:3, 3], [1, -2.5, 3])


@pytest.mark.parametrize(
    ("name", "text", "pattern"),
    [
        ("kuka", "nothing", "no pose"),
        ("kuka", "{X 1,Y 2,Z 3,A 0,B 0}", "lacks C"),
        ("kuka", "{X 1,Y 2,Z 3,A 0,B 0,C 0}\n{X 1,Y 2,Z 3,A 0,B 0,C 0}", "2 poses"),
        ("abb", "[[1,2,3],[1,1,0,0]]", "length 1.41421"),
        ("yaskawa", "1,2,3,4,5,6,7", "no pose"),
        ("g68.2", "G68.2 X1 Y2 Z3 I0 J0", "K is missing"),
        ("matrix", "1 0 0 0\n0 1 0 0\n", "four rows"),
        ("matrix", "1 0 0 0\n0 1 0 zero\n0 0 1 0\n0 0 0 1\n", "line 2"),
        ("matrix", "1 0 0 0\n0 1 0 0\n0 0 nan 0\n0 0 0 1\n", "line 3, column 5"),
        ("matrix", "1 0 0 0\n0 1 0 0\n0 0 1 0\n5 6 7 1\n", "transpose"),
        ("matrix", "1 0 0 0\n0 1 0 0\n0 0 -1 0\n0 0 0 1\n", "mirrors"),
        ("matrix", "1 0 0.1 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "does not rotate"),
        ("csv", "# units: parsec\n1,0,0,0\n0,1,0,0\n0,0,1,0\n0,0,0,1\n", "parsec"),
        ("json", "{", "not JSON"),
        ("json", "[]", "transform"),
        ("json", result(transform=None, status="ambiguous"), "ambiguous"),
        ("json", result(status="underdetermined"), "underdetermined"),
        ("json", result(transform=MIRRORED), "mirrors"),
        ("json", result(transform=SCALED), "does not rotate"),
        ("json", result(transform=[[1, 2], [3]]), "different length"),
        ("json", result(transform=[["a"] * 4] * 4), "not a number"),
        ("json", result(transform=[[True] * 4] * 4), "not a number"),
        ("json", result(units="parsec"), "parsec"),
        ("json", result(schema="tactfix/fit/1"), "schema"),
        ("json", result(covariance=[[1.0]]), "6 x 6"),
        ("json", result(covariance=(-np.eye(6)).tolist()), "covariance"),
        ("json", result(covariance=np.triu(np.ones((6, 6))).tolist()), "covariance"),
        ("yaml", "a: [", "not YAML"),
        ("ros", "transform: {translation: {x: 0, y: 0}, rotation: {x: 0, y: 0, z: 0, w: 1}}", "TransformStamped"),
        ("ros", "transform: {translation: {x: 0, y: 0, z: .nan}, rotation: {x: 0, y: 0, z: 0, w: 1}}", "finite"),
        ("npy", b"\x93NUMPYxx", "numpy"),
        ("json", '{"units": "mm", "units": "m", "transform": null}', "'units' is given twice in one object"),
        ("yaml", "units: mm\nunits: m\n", "line 2.*'units' is given twice, first in line 1"),
        ("ros", "transform:\n  rotation: {x: 0, y: 0, y: 1, z: 0, w: 1}\n", "line 2.*'y' is given twice"),
        ("json", "[" * 100_000, "too deep"),
        ("yaml", "[" * 100_000, "not YAML"),
        ("json", '{"transform": ' + "9" * 5000 + "}", "cannot be read"),
        ("json", result(transform=[[10**400] * 4] * 4), "not a number"),
        ("yaml", "transform: [[" + "9" * 5000 + "]]", "not a number"),
        ("yaml", "transform: 2001-99-99", "not a number"),
    ],
)
def test_invalid_poses_are_rejected_with_a_reason(name, text, pattern):
    with pytest.raises(PoseSyntaxError, match=pattern):
        DIALECTS[name].read(text)


def test_a_power_of_ten_is_a_number_in_yaml():
    text = "units: mm\ntransform: [[1, 0, 0, 1e-3], [0, 1, 0, 2e1], [0, 0, 1, 0], [0, 0, 0, 1e0]]\n"
    assert DIALECTS["yaml"].read(text).translation.tolist() == [1e-3, 20.0, 0.0]


def test_few_digits_are_made_a_rotation_and_all_digits_are_kept():
    turned = turn("z", 30) @ turn("x", 50)
    exact = write_pose("matrix", pose(turned)).text
    assert np.array_equal(DIALECTS["matrix"].read(exact).rotation, turned)
    rounded = "\n".join(" ".join(f"{float(word):.6f}" for word in line.split()) for line in exact.splitlines())
    back = DIALECTS["matrix"].read(rounded).rotation
    assert np.abs(back @ back.T - np.eye(3)).max() < 1e-14
    assert np.abs(back - turned).max() < 1e-6


def test_matrix_is_four_lines_that_numpy_reads():
    turned = turn("z", 30) @ turn("x", 50)
    text = write_pose("matrix", pose(turned, (0.1, 1e-17, 1e22), covariance=np.eye(6))).text
    assert np.array_equal(np.loadtxt(text.splitlines())[:3, :3], turned)
    assert len(text.splitlines()) == 4


@pytest.mark.parametrize("name", ["json", "yaml", "csv", "npy", "matrix", "kuka", "abb-wobjdata", "urdf", "ur"])
def test_files_are_known_by_their_ending_or_content(tmp_path, name):
    suffix = next(ending for ending, dialect in SUFFIXES.items() if dialect == name)
    path = tmp_path / f"pose{suffix}"
    written = write_pose(name, pose(turn("z", 30), (1.0, 2.0, 3.0), covariance=np.eye(6))).text
    path.write_bytes(written if isinstance(written, bytes) else b"\xef\xbb\xbf" + written.encode())
    loaded = load_pose(path, units=None if DIALECTS[name].has_units else "mm")
    np.testing.assert_allclose(loaded.in_units("mm").translation, [1, 2, 3])
    if name in ("json", "yaml"):
        assert np.array_equal(loaded.covariance, np.eye(6))


def test_errors_name_the_file_and_a_wrong_unit_is_rejected(tmp_path):
    path = tmp_path / "pose.json"
    path.write_text(result(status="inconsistent", transform=None))
    with pytest.raises(FileError, match=r"pose\.json: status is 'inconsistent'"):
        load_pose(path)
    path.write_text(result())
    with pytest.raises(UsageError, match="is in mm"):
        load_pose(path, units="m")
    with pytest.raises(UsageError, match="parsec"):
        load_pose(path, units="parsec")
    with pytest.raises(UsageError, match=r"^there is no pose format 'kukka'; did you mean 'kuka'\?$"):
        load_pose(path, dialect="kukka")
    with pytest.raises(FileError, match="no such file"):
        load_pose(tmp_path / "none.json")
    with pytest.raises(FileError, match="this is a pose, not the name of a file"):
        load_pose("{X 1, Y 2, Z 3, A 0, B 0, C 0}")
    text = tmp_path / "pose"
    text.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FileError, match="UTF-8"):
        load_pose(text)
