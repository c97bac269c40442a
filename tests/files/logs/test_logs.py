"""Machine logs: the same nine contacts in every format, and every kind of input that is rejected."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from tactfix.errors import FileError, UsageError
from tactfix.files.contact_options import ContactOptions, LogOptions, parse_features
from tactfix.files.contact_source import load_contacts
from tactfix.files.fixture_file import load_fixture
from tactfix.files.logs import LOG_FORMATS
from tactfix.files.logs.export import contact_csv
from tactfix.files.logs.load import load_log, read_log
from tactfix.pose_formats import DIALECTS
from tactfix.pose_formats.pose import Pose

DATA = Path(__file__).parent / "data"
EXPECTED = json.loads((DATA / "expected.json").read_text())
RUNS = parse_features("bar:5,ball:4")
MM = ContactOptions(units="mm", tip_radius=3.0, sigma=0.003)
BARE = ContactOptions(units="mm", sigma=0.003)
SURFACE = ContactOptions(tip_radius=0.0, sigma=0.003)
BAR, BALL = EXPECTED["fixture"]["bar"], EXPECTED["fixture"]["ball"]
YAML = f"""tactfix: 1
name: logs
units: mm
features:
  bar: {{type: cylinder, radius: {BAR["radius"]}, point: {BAR["point"]}, direction: {BAR["direction"]}}}
  ball: {{type: sphere, radius: {BALL["radius"]}, center: {BALL["center"]}}}
"""


def fixture_of(text, folder):
    path = folder / "fixture.yaml"
    path.write_text(text)
    return load_fixture(path)


@pytest.fixture
def fixture(tmp_path):
    return fixture_of(YAML, tmp_path)


def load(name, text, fixture, options=MM, features="bar:1", **more):
    return load_log(
        name, text.encode(), fixture, options, LogOptions(parse_features(features) if features else (), **more)
    )


@pytest.mark.parametrize(
    ("name", "file", "options", "decimals"),
    [
        ("linuxcnc", "linuxcnc_probeopen.txt", MM, 6),
        ("grbl", "grbl.txt", MM, 4),
        ("msr", "msr.txt", BARE, 4),
        ("xyzijk", "pcdmis_xyzijk_metric.xyz", SURFACE, 6),
        ("xyzijk", "pcdmis_xyzijk_inch.xyz", SURFACE, 6),
        ("ippdme", "ippdme.txt", BARE, 6),
    ],
)
def test_every_format_gives_the_same_contacts(name, file, options, decimals, fixture):
    got, notes = load_log(name, DATA / file, fixture, options, LogOptions(RUNS))
    contacts = got.contacts
    assert contacts.features == ("bar",) * 5 + ("ball",) * 4
    assert got.units == "mm"
    compensated = name == "xyzijk"
    assert contacts.tip_radius == (0 if compensated else 3)
    base_from_fixture = np.array(EXPECTED["base_from_fixture"])
    local = (contacts.points - base_from_fixture[:3, 3]) @ base_from_fixture[:3, :3]
    reach = 0.0 if compensated else 3.0
    # The true distances from the axis (y) of the bar and from the centre of the ball.
    np.testing.assert_allclose(np.hypot(local[:5, 0], local[:5, 2]), BAR["radius"] + reach, atol=0.01)
    np.testing.assert_allclose(np.linalg.norm(local[5:] - BALL["center"], axis=1), BALL["radius"] + reach, atol=0.01)
    has_normals = name not in ("linuxcnc", "grbl")
    assert contacts.has_approach.all() == contacts.has_approach.any() == has_normals
    if has_normals:  # approaches point into the material: against the outward normal
        inward = np.vstack([-local[:5] * [1, 0, 1], BALL["center"] - local[5:]])
        inward /= np.linalg.norm(inward, axis=1)[:, None]
        cosines = np.einsum("ij,ij->i", contacts.approaches @ base_from_fixture[:3, :3], inward)
        assert cosines.min() > 0.98
    assert any("met nothing; dropped" in note for note in notes) == (name == "grbl")


def test_inch_and_metric_agree_and_beat_no_option(fixture):
    inch, _ = load_log("xyzijk", DATA / "pcdmis_xyzijk_inch.xyz", fixture, SURFACE, LogOptions(RUNS))
    metric, _ = load_log("xyzijk", DATA / "pcdmis_xyzijk_metric.xyz", fixture, SURFACE, LogOptions(RUNS))
    np.testing.assert_allclose(inch.contacts.points, metric.contacts.points, atol=2e-6)
    np.testing.assert_allclose(inch.contacts.sigmas, 0.003 * 25.4)  # options are in the unit of the log
    overruled = ContactOptions(units="mm", tip_radius=0.0, sigma=0.003)
    got, notes = load_log("xyzijk", DATA / "pcdmis_xyzijk_inch.xyz", fixture, overruled, LogOptions(RUNS))
    np.testing.assert_allclose(got.contacts.points * 25.4, inch.contacts.points)
    assert any("the option is used" in note for note in notes)


POSES = [
    ((100.0, 20.0, 300.0), (0.0, 0.0, 0.0)),
    ((-5.0, 7.0, 1.0), (90.0, 0.0, 0.0)),
    ((0.0, 0.0, 9.0), (0.0, 90.0, 0.0)),
]
TIPS = [
    (110.0, 20.0, 420.0),
    (-5.0, 17.0, 121.0),
    (120.0, 0.0, -1.0),
]  # offset (10, 0, 120), computed by hand: Rz(A) Ry(B)


@pytest.mark.parametrize("literal", [True, False])
def test_flange_poses_of_kuka(literal, fixture):
    form = "{{X {},Y {},Z {},A {},B {},C {}}}" if literal else "{};{};{};{};{};{}"
    text = "" if literal else "X;Y;Z;A;B;C\n"
    text += "\n".join(form.format(*point, *angles) for point, angles in POSES)
    options = ContactOptions(tip_radius=3.0, sigma=0.1)
    got, notes = load("kuka", text, fixture, options, "bar:2,ball:1", tip_offset=(10.0, 0.0, 120.0))
    np.testing.assert_allclose(got.contacts.points, TIPS, atol=1e-12)
    assert not any("the tip offset" in note for note in notes)
    plain, notes = load("kuka", text, fixture, options, "bar:2,ball:1")
    np.testing.assert_allclose(plain.contacts.points, [point for point, _ in POSES])
    assert any("the tip offset" in note for note in notes)


def test_flange_poses_of_ur_are_in_metres(fixture):
    text = "x,y,z,rx,ry,rz\n# by hand\n0.1,0.02,0.3,0,0,0\np[-0.005, 0.007, 0.001, 0, 0, 1.5707963267948966]\n"
    options = ContactOptions(tip_radius=0.003, sigma=1e-4)
    got, _ = load("ur", text, fixture, options, "bar:2", tip_offset=(0.01, 0.0, 0.12))
    np.testing.assert_allclose(got.contacts.points, TIPS[:2], atol=1e-9)
    assert got.contacts.tip_radius == pytest.approx(3.0)
    assert got.contacts.sigmas[0] == pytest.approx(0.1)


@pytest.mark.parametrize("name", ["ur", "kuka"])
def test_pose_lines_as_the_dialect_writes_them(name, fixture):
    dialect = DIALECTS[name]
    matrix = np.array(EXPECTED["base_from_fixture"])
    line = dialect.write(Pose(matrix, "mm").in_units(dialect.units), ())
    got, _ = load(name, line, fixture, ContactOptions(tip_radius=0.0, sigma=0.1), "ball:1")
    np.testing.assert_allclose(got.contacts.points[0], matrix[:3, 3], atol=1e-6)


REFUSED = [
    ("linuxcnc", "1 2 3 0 0 0 0 0\n", "nine numbers"),
    ("linuxcnc", "1 2 3 0 0 0 0 0 x\n", "column 17.*nine numbers"),
    ("linuxcnc", "1 2 3 0 0 0 0 0 nan\n", "nine numbers"),
    ("linuxcnc", "1 2 3 0 0 0 0 0 0\n4 5 6 0 10 0 0 0 0\n", "line 2, column 19: A B C U V W changes"),
    ("linuxcnc", "\n\n", "no contacts"),
    ("grbl", "[PRB:1,2:1]\n", "x,y,z"),
    ("grbl", "[PRB:1,2,3\n", "column 11: ':' is missing"),
    ("grbl", "[PRB:0,0,0:0]\n", "no contacts"),
    ("msr", "G801 N1 X1 Y2\n", "G801 without"),
    ("msr", "G800 N1 X1 Y2 Z3\nG801 N1 X1 Y2 Z3 R3\n", "G800 without"),
    ("msr", "G330 A0 B0 C0\nG801 N1 X1 Y2 Z3 R3\nG330 A0 B90 C0\n", "line 3.*A B C of G330 changes"),
    ("msr", "G801 N1 X1 Y2 Z3 R3\nG801 N2 X1 Y2 Z3 R2\n", "line 2: the tip radius is 2"),
    ("msr", "G801 N1 X1 Y2 Z3 R-3\n", "negative"),
    ("xyzijk", "1,2,3,0,0,1\n", "start with XYZIJK"),
    ("xyzijk", "XYZIJK CUBITS\n1,2,3,0,0,1\n", "start with XYZIJK"),
    ("xyzijk", "XYZIJK\n1,2\n", "line 2.*2 numbers where"),
    ("ippdme", "00001 # PtMeas(X(1), Y(2))\n", "Z"),
    ("ippdme", "00001 # PtMeas(X(1), Y(2), Z(3), IJK(0,1))\n", "IJK"),
    ("ippdme", "00001 # PtMeas(X(1), Y(2), Z(3\n", "column 31"),
    ("ur", "p[1,2,3,4,5]\n", "line 1"),
    ("kuka", "{X 1,Y 2,Z 3,A 4,B 5}\n", "line 1"),
]


@pytest.mark.parametrize(("name", "text", "pattern"), REFUSED)
def test_invalid_logs_are_rejected_with_a_reason(name, text, pattern, fixture):
    with pytest.raises(FileError, match=pattern):
        load(name, text, fixture)


def test_missing_settings_are_asked_for_all_at_once(fixture):
    with pytest.raises(FileError) as caught:
        load("grbl", "[PRB:1,2,3:1]\n[PRB:oops:1]\n", fixture, ContactOptions(), "")
    message = caught.value.on_command_line
    for word in ("line 2", "--features", "--units", "--tip-radius", "--sigma"):
        assert word in message


def test_the_probe_of_the_fixture_answers_but_not_for_compensated_points(tmp_path):
    fixture = fixture_of(YAML + "probe: {tip_radius: 2.5, sigma: 0.01}\n", tmp_path)
    got, _ = load("grbl", "[PRB:1,2,3:1]\n", fixture, ContactOptions(units="in"))
    assert got.contacts.tip_radius == 2.5
    np.testing.assert_allclose(got.contacts.points, [[25.4, 50.8, 76.2]])
    with pytest.raises(FileError, match="tip radius"):
        load("xyzijk", "XYZIJK\n1,2,3,0,0,1\n", fixture, ContactOptions())


def test_features_must_agree_with_the_log(fixture):
    with pytest.raises(FileError, match=r"1 contacts \(line 2: the probe met nothing; dropped\), and features for 2"):
        load("grbl", "[PRB:1,2,3:1]\n[PRB:0,0,0:0]\n", fixture, features="bar:2")
    with pytest.raises(UsageError, match="did you mean 'ball'"):
        load("grbl", "[PRB:1,2,3:1]\n", fixture, features="bell:1")
    for wrong in ("bar", "bar:0", "bar:-1", "bar:1,", ":3", "bar:x"):
        with pytest.raises(UsageError, match="NAME:COUNT"):
            parse_features(wrong)


def test_options_that_do_not_fit_the_format(fixture):
    with pytest.raises(UsageError, match="needs poses"):
        load("grbl", "[PRB:1,2,3:1]\n", fixture, tip_offset=(0.0, 0.0, 1.0))
    with pytest.raises(UsageError, match="did you mean 'grbl'"):
        load("gerbil", "", fixture)


def test_skipped_lines_are_noted(fixture):
    msr = "START\nG800 N1 I0 J0 K1\nG800 N2 I0 J0 K1\nG801 N2 X1 Y2 Z3 R3\nG801 N7 X1 Y2 Z3 R3\nG802 N1\nEND\n"
    got, notes = load("msr", msr, fixture, BARE, "bar:2")
    assert [bool(has) for has in got.contacts.has_approach] == [True, False]
    assert got.contacts.ids == ("N2", "N7")
    all_notes = "; ".join(notes)
    assert "line 5: point N7 has no G800" in all_notes
    assert "line 2: point N1 has no measurement; dropped" in all_notes
    assert "line 6" in all_notes
    dialogue = "00001 PtMeas(X(1), Y(2), Z(3))\n00001 &\n00001 ! Error(3, 1006)\n00002 # PtMeas(X(1), Y(2), Z(3))\n"
    got, notes = load("ippdme", dialogue, fixture)
    assert len(got.contacts) == 1
    assert any("line 3: the machine reports an error" in note for note in notes)
    _, notes = load("linuxcnc", "1 2 3 0 5 0 0 0 0\n", fixture)
    assert any("is 0 5 0" in note for note in notes)
    _, notes = load("msr", "G801 N1 X1 Y2 Z3 R3\n", fixture)
    assert not any("option is used" in note for note in notes)
    _, notes = load("msr", "G801 N1 X1 Y2 Z3 R2\n", fixture)
    assert any("the log says tip radius 2.0, the option says 3.0" in note for note in notes)


@pytest.mark.parametrize(("name", "file", "options"), [("msr", "msr.txt", BARE), ("grbl", "grbl.txt", MM)])
def test_the_contact_file_of_a_log_has_the_same_contacts(name, file, options, fixture):
    read = read_log(name, DATA / file, None, options, LogOptions(RUNS), complete=False)
    again = load_contacts(contact_csv(read).encode(), fixture)
    direct = load_log(name, DATA / file, fixture, options, LogOptions(RUNS))[0].contacts
    assert np.array_equal(again.points, direct.points)
    np.testing.assert_allclose(again.approaches, direct.approaches, atol=1e-15)
    assert again.features == direct.features
    assert again.tip_radius == direct.tip_radius


def test_import_omits_unstated_settings():
    runs = parse_features("a:1")
    read = read_log("grbl", b"[PRB:1,2,3:1]\n", None, ContactOptions(units="mm"), LogOptions(runs), complete=False)
    text = contact_csv(read)
    assert "tip_radius" not in text
    assert "sigma" not in text
    header, row = csv.reader(text.splitlines()[1:])
    assert header == ["feature", "x", "y", "z", "id"]
    assert row == ["a", "1.0", "2.0", "3.0", "line 1"]


def test_every_format_has_a_name_and_a_title():
    assert list(LOG_FORMATS) == [
        "linuxcnc",
        "grbl",
        "msr",
        "xyzijk",
        "xyz",
        "ippdme",
        "dmis",
        "ur",
        "kuka",
        "abb",
        "fanuc",
    ]
    assert all(log.title for log in LOG_FORMATS.values())
