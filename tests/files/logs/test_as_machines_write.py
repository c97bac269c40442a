# ruff: noqa: E501 - the lines of machines are as long as they are
"""Logs in the forms that controllers, senders and measuring software write, each against its expected contacts."""

import numpy as np
import pytest

from tactfix.errors import FileError
from tactfix.files.contact_options import ContactOptions, log_options
from tactfix.files.logs.load import read_log
from tests.support.machine_logs import FANUC, FANUC_HEAD, GOOD, KUKA, P, Q

MM = ContactOptions(units="mm")


def read(name, text, count=2, options=MM):
    content = text if isinstance(text, bytes) else text.encode()
    return read_log(name, content, None, options, log_options(f"a:{count}"), complete=False)


@pytest.mark.parametrize("case", GOOD)
def test_each_form_is_read_as_stated(case):
    name, text = GOOD[case]
    options = ContactOptions() if name in ("ur", "kuka", "abb", "fanuc", "ippdme", "xyzijk", "dmis") else MM
    log = read(name, text, options=options)
    scale = 1000 if log.units == "m" else 1
    np.testing.assert_allclose(log.points * scale, [P, Q], atol=1e-9)


def test_notes_on_valid_logs():
    log = read("ippdme", GOOD["I++ DME dialogue"][1])
    assert log.tip_radius == 2.0
    np.testing.assert_array_equal(log.approaches, [[0, 0, -1]] * 2)
    notes = "; ".join(log.notes)
    assert "line 11: the machine reports an error" in notes
    assert "line 12: the machine reports bad quality, Q(50)" in notes
    assert "Tool.A(), is 90" in notes
    log = read("grbl", GOOD["grbl of CNCjs"][1])
    np.testing.assert_array_equal(log.approaches, [[0, 0, -1]] * 2)
    assert "circle" in "".join(read("xyzijk", GOOD["xyz of seven"][1], options=ContactOptions()).notes)
    assert "stray bytes" in "".join(read("grbl", GOOD["grbl with a stray byte"][1]).notes)
    for case in ("grbl of Candle", "grbl of gSender", "Marlin"):
        log = read("grbl", GOOD[case][1])
        np.testing.assert_array_equal(log.approaches, [[0, 0, -1]] * 2)
    assert log.units == "mm"
    assert "active coordinates" in "".join(log.notes)
    assert "G38.3" in "".join(read("linuxcnc", GOOD["linuxcnc"][1]).notes)


ONE = "[PRB:1.000,2.000,3.000:1]\n"
AT = "{" + KUKA.format(1, 2, 3) + "}\n"
LISTED = "X: 1.0\nY: 2.0\nZ: 3.0\nW: 0.0\nP: 0.0\nR: 0.0\n"
REFUSED = [
    ("grbl", "[PRB:1.000,2.000,3.000,0.000:1]\n[PRB:1.000,2.000,3.000,90.000:1]", "line 2.*axes beyond X Y Z changes"),
    ("grbl", "[PRB:1,000,2.000,3.000:1]", "without a decimal point"),
    ("grbl", ONE.replace("3.000", "3.0.00"), "no number"),
    ("grbl", ONE.replace(":1]", ":1"), "']' is missing"),
    ("grbl", ONE.replace(":1]", ":2]"), "neither 1"),
    ("grbl", '{"prb":{"e":1,"x":1.0,"y":2.0,"z":1e999}}', "not a number"),
    ("grbl", '{"prb":{"e":1,"x":1.0,"x":2.0,"y":2.0,"z":1}}', "not JSON"),
    ("grbl", "Bed X: 1.00 Y: 2.00 Z: 3.0.0", "column 24: '3.0.0' is no number"),
    ("grbl", "Bed X: 1.00 Y: 2.00", "'Z' is missing"),
    ("grbl", ONE + "Bed X: 1.00 Y: 2.00 Z: 3.00", "the controller changes"),
    ("grbl", '{"D":"[PRB:1.000,2.000,3.000:1]","data":"x"}', "not a whole probe report"),
    ("grbl", "b'[PRB:1.000,2.000,3.000:1]", "not a whole probe report"),
    ("grbl", '{"prb":{"e":1,"x":1,"y":2,"z":3,"a":0}}\n{"prb":{"e":1,"x":1,"y":2,"z":3,"a":90}}', "the axis A changes"),
    ("ippdme", "00001 # X(1), Y(2), Z(3), R(0)\n00002 # X(1), Y(2), Z(3), R(90)", "rotary table, R\\(\\) changes"),
    ("ippdme", "00001 # X(1), Y(2), Z(3), Tool.A(0)\n00002 # X(1), Y(2), Z(3), Tool.A(90)", "Tool.A.., changes"),
    ("ippdme", "00001 # X(1), Y(2), Z(3), ER(1)\n00002 # X(1), Y(2), Z(3), ER(2)", "tip radius is 2"),
    ("ippdme", "00001 # X(1,5), Y(2), Z(3)", "'\\)' is missing"),
    ("ippdme", "00001 # X(1), Y(2), Z(3), Wobble(3)", "WOBBLE"),
    ("msr", "G330 N1 A0 B0 C0 X5 Y0 Z0\nG801 N1 X1 Y2 Z3", "G330 shifts"),
    ("msr", "G801 N1 X1 Y2 Z3 R1 X2", "X is given twice"),
    ("msr", "G801.5 N1 X1 Y2 Z3 R1", "no block"),
    ("kuka", "{" + KUKA.format(1, 2, 3) + ",E1 0.0}\n{" + KUKA.format(1, 2, 3) + ",E1 50.0}", "external axes changes"),
    ("kuka", "{" + KUKA.format("1,5", 2, 3) + "}", "no name"),
    ("kuka", "{" + KUKA.format(1, 2, 3) + ",Q 1}", "Q is not known"),
    ("abb", "[[1,2,3],[1,1,0,0]]", "length 1.41421"),
    ("abb", "[[1,2,3],[1,0,0,0],[0,0,0,0],[0,0,0,0,0,0]]\n[[1,2,3],[1,0,0,0],[0,0,0,0],[5,0,0,0,0,0]]", "axes changes"),
    ("fanuc", f"P[1]{{\n{FANUC_HEAD}{FANUC.format(*P)}}};\nP[2]{{\n{FANUC_HEAD.replace('UF : 0', 'UF : 2')}{FANUC.format(*Q)}}};",
     "user frame, UF, changes"),
    ("ur", "p[1,2,3,0,0,0] p[1,2,3,0,0,0]", "no name|left over"),
    ("grbl", "$13=0\n" + ONE + "$13=1\n" + ONE, "line 3.*unit changes to in below reports in mm"),
    ("grbl", 'G21\n{"prb":{"e":1,"x":1,"y":2,"z":3}}\nG20\n{"prb":{"e":1,"x":1,"y":2,"z":3}}', "G20 or G21, changes: in"),
    ("dmis", "UNITS/MM\nPTMEAS/CART,1,2,3\nUNITS/INCH", "line 3.*unit changes to in below touches in mm"),
    ("dmis", "PTMEAS/CART,1,2,3\nUNITS/MM", "line 2.*unit that is not given"),
    ("dmis", "UNITS/MM\nPTMEAS/CART,1,5,2,5,3,5", "i, j, k have the length 7.68"),
    ("msr", "G331 C0\nG801 N1 X1 Y2 Z3\nG331 C90\nG801 N2 X1 Y2 Z3", "the model, X Y Z A B C of G331, changes: 0 0 0 0 0 90"),
    ("kuka", "$ACT_TOOL=1\n" + AT + "$ACT_TOOL=2\n" + AT, "line 4.*ACT_TOOL changes: 2"),
    ("kuka", "FDAT_ACT={TOOL_NO 1}\n" + AT + "FDAT_ACT={TOOL_NO 2}\n" + AT, "FDAT_ACT changes"),
    ("kuka", "DECL E6POS XP1=" + AT + "DECL FDAT FP1={TOOL_NO 1,BASE_NO 0,IPO_FRAME #TCP}", "part in the gripper"),
    ("abb", "PDispSet [[10,0,0],[1,0,0,0]];\n[[1,2,3],[1,0,0,0]]", "line 1.*program displacement"),
    ("fanuc", "CURRENT USER FRAME POSITION:\n" + LISTED + "\nCURRENT WORLD POSITION:\n" + LISTED, "frame of the positions changes: WORLD"),
    ("fanuc", "1: UTOOL_NUM=1 ;\n4: UTOOL_NUM=2 ;\nP[1]{\nGP1:\n" + FANUC.format(*P) + "\n};", "UT, selected changes: 2"),
    ("ur", "movel(p[1,2,3,0,0,0], a=1.2)", "not a name"),
    ("dmis", "UNITS/MM,ANGDEC\nPTMEAS/POL,1,2,3,0,0,1", "'CART' is missing"),
    ("dmis", "UNITS/MM,ANGDEC\nPTMEAS/CART,1,2,3\nUNITS/INCH,ANGDEC\nPTMEAS/CART,1,2,3", "unit changes"),
    ("xyz", "1,5;2,5;3.5", "decimal mark changes"),
    ("xyz", "1.5 2.5 3.5\n1.5,2.5,3.5", "the separator of the numbers changes"),
    ("xyz", "42,9984,14.9986,30.4519,0,0,1", "some with a decimal point"),
    ("kuka", "LIN_REL {X 10,Y 0,Z 0,A 0,B 0,C 0}", "relative motion"),
    ("kuka", f"LIN {{{KUKA.format(1, 2, 3)}}}\n$BASE=BASE_DATA[3]\nLIN {{{KUKA.format(1, 2, 3)}}}", "line 3.*.BASE changes"),
    ("kuka", f"BAS(#TOOL,1)\nLIN {{{KUKA.format(1, 2, 3)}}}\nBAS(#TOOL,2)\nLIN {{{KUKA.format(1, 2, 3)}}}", "line 4.*.TOOL changes"),
    ("kuka", "P1: X 1 Y 2 Z 3 A 0 B 0", "lacks C"),
    ("kuka", "P1: X 1,5 Y 2 Z 3 A 0 B 0 C 0", "no name|not known"),
    ("kuka", '<RIst X="1.0" Y="2.0" Z="3.0" A="0" B="0" C="0"/>', "not a whole position"),
    ("kuka", "Name,X,Y,Z,A,B,C,W\nP1,1,2,3,0,0,0,0", "column 'W' is not known"),
    ("abb", "CONST robtarget p1:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\nMoveL p1,v10,fine,t\\WObj:=a;\n"
     "CONST robtarget p2:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\nMoveL p2,v10,fine,t\\WObj:=b;", "line 4.*the work object changes: b"),
    ("fanuc", "[*SYSTEM*]$MNUFRAME  Storage: SHADOW\n [1,1] = Group: 1 Config: N D B, 0, 0, 0\n X: 1 Y: 2 Z: 3\n W: 0 P: 0 R: 0\n"
     "[*SYSTEM*]$MNUTOOL  Storage: SHADOW\n [1,1] = Group: 1 Config: N D B, 0, 0, 0\n X: 1 Y: 2 Z: 3\n W: 0 P: 0 R: 0", "the list changes"),
    ("fanuc", "Frame #: 1 Tool #: 1\nX: 1 Y: 2 Z: 3\nW: 0 P: 0 R: 0\nFrame #: 2 Tool #: 1\nX: 1 Y: 2 Z: 3\nW: 0 P: 0 R: 0", "user frame, UF, changes"),
    ("ur", "[1, 2, 3, 0, 0]", "',' is missing"),
    ("ur", "timestamp TCP_offset_0 " + " ".join(f"actual_TCP_pose_{i}" for i in range(6)) + "\n1 0.1 1 2 3 0 0 0\n1 0.2 1 2 3 0 0 0",
     "the tool's offset, tcp_offset_0, changes"),
    ("dmis", "UNITS/MM\nPTMEAS/CART,1,2,3\nROTAB/RT(1),INCR,CW,90\nPTMEAS/CART,1,2,3", "the rotary table changes"),
    ("dmis", "UNITS/MM\nROTAB/RT(1),INCR,CW,90\nPTMEAS/CART,1,2,3\nROTAB/RT(1),INCR,CW,90\nPTMEAS/CART,1,2,3", "the rotary table changes"),
    ("dmis", "UNITS/MM\nSNSLCT/S(A0)\nPTMEAS/CART,1,2,3\nSNSLCT/S(A90)\nPTMEAS/CART,1,2,3", "the sensor changes"),
    ("dmis", "UNITS/MM\nRAWDAT/CART,1,2,3", "RAWDAT"),
    ("xyz", "1025,5,-20,25,300,0", "have the length 301.04, not 1"),
    ("xyz", "X [mm],Y [in],Z [mm]\n1,2,3", "unit 'in'"),
    ("xyz", "X [cubits],Y,Z\n1,2,3", "unit 'cubits'"),
    ("xyz", "X1.0 Y2.0 Z3.0 A0\nX1.0 Y2.0 Z3.0 A90", "the axis A changes"),
    ("xyz", "X1.0 Y2,0 Z3.0", "not a letter"),
    ("xyz", "X1.0 Y2.0 I0 J0 K1", "a point has X, Y and Z"),
    ("linuxcnc", "1,5 2 3 0 0 0 0 0 0", "no number|left over"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "text", "pattern"), REFUSED)
def test_ambiguous_texts_are_rejected(name, text, pattern):
    with pytest.raises(FileError, match=pattern):
        read(name, text, count=text.count("\n") + 1)


def test_a_last_hit_repeated_in_parameters_is_no_contact():
    text = ONE + "ok\n$#\n[G54:0.000,0.000,0.000]\n[TLO:0.000]\n" + ONE + "ok\n"
    assert len(read("grbl", text, 1).points) == 1
    assert len(read("grbl", ONE + "ok\n" + ONE, 2).points) == 2


@pytest.mark.parametrize(
    ("commands", "approach"),
    [
        ("G91\nG38.2 X5 Y-5\n", [1 / np.sqrt(2), -1 / np.sqrt(2), 0]),
        ("G91\nG38.4 Z5\n", [0, 0, -1]),
        ("G90\nG38.2 Z-5\n", None),
        ("G38.2 Y4 (G90)\n", [0, 1, 0]),
        ("G91\nG38.2 Z-5\nALARM:4\n", None),
        ("G91\nG38.2 Z-5 A10\n", None),
        ("[22:44:38] [ G90 ] ok\nG38.2 X62\n", None),
        ("[22:44:38] [ $G ] [GC:G0 G54 G17 G21 G90 G94 M5 M9 T1 F0 S0]\nG38.2 X62\n", None),
        ("G90 < ok\nG38.2 X62\n", None),
        ("G91 < ok\nG38.2 X5 < ", [1, 0, 0]),
        ("G91 < ok\nG38.2 X5 < error:9\n", None),
    ],
)
def test_the_approach_of_a_repeated_command(commands, approach):
    found = read("grbl", commands + ONE, 1).approaches[0]
    np.testing.assert_allclose(found, [np.nan] * 3 if approach is None else approach)


def test_a_message_next_to_a_json_report_hides_no_contact():
    text = '{"prb":{"e":1,"x":1.0,"y":2.0,"z":3.0},"msg":"Probe contact"}\n{"r":{"prb":{"e":1,"x":4,"y":5,"z":6}},"msg":"ok"}\n'
    np.testing.assert_array_equal(read("grbl", text, 2).points, [[1, 2, 3], [4, 5, 6]])
    assert len(read("grbl", '{"msg":"Probe contact"}\n' + ONE, 1).points) == 1


def test_frames_of_tools_bases_and_the_robot_are_no_touches():
    frames = "BASE_DATA[1]=" + AT + "DECL FRAME TOOL_DATA[2]=" + AT + "$WORLD=" + AT + "$ROBROOT=" + AT
    log = read("kuka", frames + "XP1={" + KUKA.format(*P) + "}", 1)
    np.testing.assert_array_equal(log.points, [P])
    assert any(note.startswith("4 frames") for note in log.notes)


def test_a_unit_listed_last_applies_to_preceding_reports():
    assert read("grbl", ONE + "$13=1\n", 1, ContactOptions()).units == "in"


def test_a_program_that_selects_tools_does_not_change_positions_of_one_tool():
    program = "1: UTOOL_NUM=1 ;\n4: UTOOL_NUM=2 ;\n"
    position = f"P[1]{{\n{FANUC_HEAD}{FANUC.format(*P)}}};"
    np.testing.assert_array_equal(read("fanuc", program + position, 1).points, [P])


def test_reports_in_inch_are_known_by_their_setting():
    assert read("grbl", "$13=1 (report in inches)\n" + ONE, 1, ContactOptions()).units == "in"
    with pytest.raises(FileError, match="does not say its units"):
        read("grbl", ONE, 1, ContactOptions())
