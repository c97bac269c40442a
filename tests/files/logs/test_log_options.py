# ruff: noqa: E501 - the lines of machines are as long as they are
"""Options for machine logs: work offset, approaches, repeated touches, the tip offset of poses."""

import numpy as np
import pytest

from tactfix.cli.app import run
from tactfix.errors import FileError, UsageError
from tactfix.files.contact_options import ContactOptions, log_options
from tactfix.files.contact_source import load_contacts
from tactfix.files.fixture_file import load_fixture
from tactfix.files.logs.export import contact_csv
from tactfix.files.logs.load import load_log, read_log

MM = ContactOptions(units="mm")
PRB = "[PRB:{0:.3f},{1:.3f},{2:.3f}:1]\n"


def read(name, text, options=MM, **settings):
    wanted = log_options(settings.pop("features", "a:1"), **settings)
    return read_log(name, text.encode(), None, options, wanted, complete=False)


def test_a_misspelt_log_format_is_corrected():
    with pytest.raises(UsageError, match=r"^no format of machine logs is called 'linux'; did you mean 'linuxcnc'\?$"):
        read("linux", "1 2 3 0 0 0 0 0 0")


def test_an_unreadable_log_does_not_ask_for_features():
    with pytest.raises(FileError) as caught:
        read("linuxcnc", "feature,x,y,z\n", features=None)
    assert "--features" not in caught.value.on_command_line


OFFSETS = {  # each maps (1, 2, 3) to (98, 201, 303), computed by hand: a quarter turn about z
    "base.src": "BASE_DATA[1]={X 100,Y 200,Z 300,A 90,B 0,C 0}",
    "g54.ngc": "G21 G10 L2 P1 X100 Y200 Z300 R90",
    "inch.ngc": "G20G10L2P1X3.937007874Y7.874015748Z11.81102362R90",
    "frame.csv": "# units: m\n0,-1,0,0.1\n1,0,0,0.2\n0,0,1,0.3\n0,0,0,1\n",
    "frame.txt": "[[0 -1 0 100]\n [1 0 0 200]\n [0 0 1 300]]",
}


@pytest.mark.parametrize("file", OFFSETS)
def test_the_work_offset_transforms_points_and_approaches(file, tmp_path):
    path = tmp_path / file
    path.write_text(OFFSETS[file])
    log = read("linuxcnc", "1 2 3 0 0 0 0 0 0", work_offset=str(path), approach="0,-1,0")
    np.testing.assert_allclose(log.points, [[98, 201, 303]], atol=1e-6)
    np.testing.assert_allclose(log.approaches, [[1, 0, 0]], atol=1e-12)
    assert not any("reports in" in note for note in log.notes)


def test_poses_turn_with_the_work_offset_and_the_tip_with_them(tmp_path):
    path = tmp_path / "base.src"
    path.write_text(OFFSETS["base.src"])
    settings = {"work_offset": str(path), "tip_offset": (0.0, 0.0, 50.0)}
    log = read("kuka", "{X 1,Y 2,Z 3,A 0,B 90,C 0}", **settings)  # flange z along x, then y
    np.testing.assert_allclose(log.points, [[98, 251, 303]], atol=1e-9)
    np.testing.assert_allclose(log.rotations[0], [[0, -1, 0], [0, 0, 1], [-1, 0, 0]], atol=1e-12)


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("linuxcnc", "1 2 3 0 0 0 0 0 0", "the active work coordinates"),
        ("kuka", "{X 1,Y 2,Z 3,A 0,B 0,C 0}", "the active base"),
        ("abb", "[[1,2,3],[1,0,0,0]]", "the active work object"),
        ("fanuc", "X = 1, Y = 2, Z = 3, W = 0, P = 0, R = 0", "the active user frame"),
        ("grbl", PRB.format(1, 2, 3), None),
        ("ur", "p[1,2,3,0,0,0]", None),
    ],
)
def test_a_format_with_an_open_frame_states_the_frame_of_results(name, text, expected):
    notes = [note for note in read(name, text, ContactOptions("mm")).notes if "reports in" in note]
    assert [expected in note for note in notes] == ([True] if expected else [])


def test_approaches_by_feature_apply_only_to_logs_without_approaches():
    text = "G91\nG38.2 X5\n" + PRB.format(1, 2, 3) + "G90\n" + PRB.format(11, 2, 3) + PRB.format(21, 2, 3)
    log = read("grbl", text, features="top:2,front:1", approach="top: 0,0,-2; front:0,1,0")
    np.testing.assert_array_equal(log.approaches, [[1, 0, 0], [0, 0, -1], [0, 1, 0]])


@pytest.mark.parametrize("wrong", ["0,0", "0,0,0", "top:0,0,1;0,0,1", "top:0,0,1;top:0,0,1", "0,0,1x", ":0,0,1", ""])
def test_invalid_approaches_are_rejected(wrong):
    with pytest.raises(UsageError, match="approach"):
        log_options("top:1", approach=wrong)
    with pytest.raises(UsageError, match="which is none of features="):
        read("grbl", PRB.format(1, 2, 3), approach="bottom:0,0,1")


def test_the_last_of_consecutive_touches_of_a_place_is_used():
    touches = [(0, 0, 0.4), (0, 0, 0.02), (10, 0, 0.5), (10, 0, 0), (0, 0, 0), (0, 0, 5)]
    text = "".join(PRB.format(*touch) for touch in touches)
    log = read("grbl", text, features="a:4", repeats="last")
    np.testing.assert_array_equal(log.points, [touches[i] for i in (1, 3, 4, 5)])
    assert sum("touched again" in note for note in log.notes) == 2
    assert len(read("grbl", text, features="a:6").points) == 6
    inch = "".join(PRB.format(*np.divide(touch, 25.4)) for touch in touches)
    assert len(read("grbl", inch, ContactOptions("in"), features="a:4", repeats="last").points) == 4
    with pytest.raises(UsageError, match="write all or last"):
        log_options("a:1", repeats="first")


def test_a_tip_of_metres_is_asked_about():
    pose = "p[0.1,0.2,0.3,0,0,0]"
    with pytest.raises(UsageError, match="120 m from the flange"):
        read("ur", pose, ContactOptions(), tip_offset=(0.0, 0.0, 120.0))
    np.testing.assert_allclose(read("ur", pose, ContactOptions(), tip_offset=(0.0, 0.0, 0.12)).points[0, 2], 0.42)


FIXTURE = "tactfix: 1\nname: f\nunits: mm\nprobe: {tip_radius: 2, sigma: 0.01}\nfeatures:\n  a: {type: sphere, radius: 5, center: [0, 0, 0]}\n"
POSES = {
    "kuka": "{X 100,Y 200,Z 300,A 30,B 40,C 50}",
    "ur": "p[0.1,0.2,0.3,0.3,-0.4,1.5]",
    "abb": "[[100,200,300],[0.5,-0.5,0.5,0.5]]",
    "fanuc": "X = 100, Y = 200, Z = 300, W = 30, P = 40, R = 50",
}


@pytest.mark.parametrize("name", POSES)
def test_a_contact_file_keeps_flange_orientations(name, tmp_path):
    path = tmp_path / "fixture.yaml"
    path.write_text(FIXTURE)
    fixture = load_fixture(path)
    offset = (0.001, 0.002, 0.12) if name == "ur" else (1.0, 2.0, 120.0)
    wanted = log_options("a:1", offset)
    direct = load_log(name, POSES[name].encode(), fixture, None, wanted)[0].contacts
    read_again = load_contacts(contact_csv(read(name, POSES[name], None, tip_offset=offset)).encode(), fixture)
    np.testing.assert_allclose(read_again.points, direct.points, atol=1e-9)
    np.testing.assert_allclose(read_again.flange_rotations, direct.flange_rotations, atol=1e-12)
    np.testing.assert_allclose(read_again.tip_offset, [1, 2, 120])
    np.testing.assert_allclose(direct.points[0] - direct.flange_rotations[0] @ [1, 2, 120], [100, 200, 300], atol=1e-9)


def test_the_commands_take_them(tmp_path, capsys):
    fixture, log, base = tmp_path / "fixture.yaml", tmp_path / "log.txt", tmp_path / "g54.ngc"
    fixture.write_text(FIXTURE)
    centre = np.array([10.0, 20.0, 30.0])
    directions = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, 0, 1]])
    log.write_text("".join(f"{x} {y} {z} 0 0 0 0 0 0\n" for x, y, z in centre + 7 * directions))
    base.write_text("G10 L2 P1 X100 Y0 Z0 R0")
    say = ["--contacts-format", "linuxcnc", "--features", "a:4", "--units", "mm"]
    assert run(["locate", str(fixture), str(log), *say, "--json", "--work-offset", str(base)]) == 4
    out, err = capsys.readouterr()
    assert '"center": [110.0' in out.replace("109.99999999999999", "110.0").replace("110.00000000000001", "110.0")
    assert "reports in" not in err
    assert run(["import", str(log), *say, "--approach", "0,0,-1", "--repeats", "last"]) == 0
    out, err = capsys.readouterr()
    assert out.splitlines()[1] == "feature,x,y,z,ax,ay,az,id"
    assert "reports in the active work coordinates" in err
    assert run(["locate", str(fixture), str(log), "--approach", "0,0,-1"]) == 2
    assert "for machine logs" in capsys.readouterr().err
