# ruff: noqa: E501 - the lines of machines are as long as they are
"""Logs in the forms that controllers, senders and measuring software write, each against what its text says."""

import numpy as np
import pytest

from tactfix.errors import FileError
from tactfix.files.contact_options import ContactOptions
from tactfix.files.log_options import log_options
from tactfix.files.logs.load import read_log

MM = ContactOptions(units="mm")
P, Q = (1025.5, -20.25, 300.0), (1030.25, -18.5, 301.0)
KUKA = "X {0},Y {1},Z {2},A 10.0,B 90.0,C 0.0"
STATUS = ",S 2,T 35,E1 0.0,E2 0.0,E3 0.0,E4 0.0,E5 0.0,E6 0.0"
EXTERNAL = "[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]"
ABB = "[[{0},{1},{2}],[1,0,0,0],[0,-1,0,1]," + EXTERNAL + "]"
FANUC = (
    "\tX =  {0:.3f}  mm,\tY =   {1:.3f}  mm,\tZ = {2:.3f}  mm,\n\tW =   180.0 deg,\tP = -.131 deg,\tR =  0.000 deg\n"
)
FANUC_HEAD = "   GP1:\n\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',\n"


def read(name, text, count=2, options=MM):
    content = text if isinstance(text, bytes) else text.encode()
    return read_log(name, content, None, options, log_options(f"a:{count}"), complete=False)


GOOD = {
    "kuka .dat": (
        "kuka",
        "&ACCESS RVP\n&REL 1\nDEFDAT TOUCH PUBLIC\n;FOLD EXTERNAL DECLARATIONS\nEXT BAS (BAS_COMMAND :IN,REAL :IN )\n"
        f"DECL E6POS XP1={{{KUKA.format(*P)}{STATUS}}}\n"
        'DECL FDAT FP1={TOOL_NO 1,BASE_NO 0,IPO_FRAME #BASE,POINT2[] " ",TQ_STATE FALSE}\n'
        "DECL PDAT PPDAT1={VEL 100.000,ACC 100.000,APO_DIST 100.000,GEAR_JERK 50.0000,EXAX_IGN 0}\n"
        f"DECL E6POS XP2={{{KUKA.format(*Q)}{STATUS}}}\n"
        'DECL FDAT FP2={TOOL_NO 1,BASE_NO 0,IPO_FRAME #BASE,POINT2[] " ",TQ_STATE FALSE}\n'
        "DECL E6AXIS XHOME={A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\nENDDAT\n",
    ),
    "kuka types": (
        "kuka",
        f"{{POS: {KUKA.format(*P)},S 'B110',T 'B010011'}}\n$POS_ACT={{E6POS: {KUKA.format(*Q)}{STATUS}}}",
    ),
    "kuka frames": (
        "kuka",
        f"GLOBAL FRAME P1={{{KUKA.format(*P)}}} ; a touch\n LIN {{FRAME: {KUKA.format(*Q)}}} C_DIS",
    ),
    "kuka stamps": (
        "kuka",
        f"12:00:01 {{{KUKA.format(*P)}}}\nBASE: {{{KUKA.format(*Q)}}}",
    ),
    "kuka decimal commas": ("kuka", "X;Y;Z;A;B;C\n1025,5;-20,25;300,0;0,0;90,0;0\n1030,25;-18,5;301;0;0;0\n"),
    "kuka Latin-1": ("kuka", b"; Pr\xfcfk\xf6rper\n" + "\n".join(f"{{{KUKA.format(*p)}}}" for p in (P, Q)).encode()),
    "abb module": (
        "abb",
        "MODULE Touch\n  ! a comment with [[1,2,3]]\n  TASK PERS tooldata t1:=[TRUE,[[0,0,120],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n"
        f"  CONST robtarget p10:={ABB.format(*P)};\n  LOCAL VAR robtarget p20:=[[{Q[0]},{Q[1]},\n   {Q[2]}],[1,0,0,0],\n"
        f"   [0,0,0,0],{EXTERNAL}];\n  PERS jointtarget j1:=[[0,0,0,0,30,0],{EXTERNAL}];\nENDMODULE\n",
    ),
    "abb array": ("abb", f"PERS robtarget p{{2}}:=[{ABB.format(*P)},{ABB.format(*Q)}];"),
    "abb pose and value": ("abb", f"PERS pose p1 := [[{P[0]},{P[1]},{P[2]}],[1,0,0,0]];\n{ABB.format(*Q)}\n"),
    "abb motions": (
        "abb",
        f"MoveL {ABB.format(*P)},v100,fine,tool1\\WObj:=wobj1;\n MoveJ {ABB.format(*Q)}, v200, z10, tool1\\WObj:=wobj1;",
    ),
    "abb columns": ("abb", "x\ty\tz\tq1\tq2\tq3\tq4\n1025,5\t-20,25\t300\t1\t0\t0\t0\n1030,25\t-18,5\t301\t1\t0\t0\t0"),
    "fanuc .ls": (
        "fanuc",
        "/PROG  TOUCH\n/ATTR\nOWNER\t\t= MNEDITOR;\n/MN\n   1:  UFRAME_NUM=0 ;\n   2:L P[1] 100mm/sec FINE    ;\n/POS\n"
        f"P[1]{{\n{FANUC_HEAD}{FANUC.format(*P)}   GP2:\n\tUF : 0, UT : 1,\t\n\tJ1=  0.000  mm\n}};\n"
        f'P[2:"seat, left"]{{\n{FANUC_HEAD}{FANUC.format(*Q)}   GP2:\n\tUF : 0, UT : 1,\t\n\tJ1=  0.000  mm\n}};\n/END\n',
    ),
    "fanuc registers": (
        "fanuc",
        "[*POSREG*]$POSREG  Storage: CMOS  Access: RW  : ARRAY[1,100] OF Position Reg \n"
        f"     [1,1] = 'touch'   Group: 1   Config: F U T, 0, 0, 0\n  X: {P[0]}   Y:   {P[1]}   Z:   {P[2]}\n"
        "  W:   180.000   P:     0.000   R:     0.000 \n     [1,2] = ''   Uninitialized\n"
        f"     [1,3] = ''   Group: 1   Config: F U T, 0, 0, 0\n  X: {Q[0]}   Y:   {Q[1]}   Z:   {Q[2]}\n"
        "  W:   180.000   P:     0.000   R:     0.000 \n",
    ),
    "fanuc frames": (
        "fanuc",
        "[*SYSTEM*]$MNUFRAME  Storage: SHADOW  Access: RW  : ARRAY[1,9] OF POSITION\n"
        f"     [1,1] =   Group: 1   Config: N D B, 0, 0, 0\n  X: {P[0]}   Y:   {P[1]}   Z:   {P[2]}\n"
        "  W:     0.000   P:     0.000   R:     0.000\n"
        f"     [1,2] =   Group: 1   Config: N D B, 0, 0, 0\n  X: {Q[0]}   Y:   {Q[1]}   Z:   {Q[2]}\n"
        "  W:     0.000   P:     0.000   R:     0.000\n",
    ),
    "fanuc columns": ("fanuc", "X,Y,Z,W,P,R\n1025.5,-20.25,300,0,0,0\n1030.25,-18.5,301,0,0,0\n"),
    "ur names and remarks": (
        "ur",
        "# touches\ntouch_1_p=p[1.0255, -0.02025, 0.3, 0, 3.14, 0]\n2025-11-28 12:00:00.123 touch 2: p[1.03025,-0.0185,0.301,0,3.14,0]\n",
    ),
    "ur recorder": (
        "ur",
        "timestamp " + " ".join(f"actual_q_{i}" for i in range(6)) + " "
        + " ".join(f"actual_TCP_pose_{i}" for i in range(6)) + " output_int_register_0\n"
        + "100.0 0 0 0 0 0 0 1.0255 -0.02025 0.3 0 3.14 0 1\n101.0 0 0 0 0 0 0 1.03025 -0.0185 0.301 0 3.14 0 2\n",
    ),
    "dmis": (
        "dmis",
        "DMISMN/'T', 4.0\nUNITS/MM,ANGDEC\n$$ PTMEAS/CART,9,9,9\nF(TOP)=FEAT/PLANE,CART,0,0,0,0,0,1\nMEAS/PLANE,F(TOP),2\n"
        "  PTMEAS/CART, 1025.5, -20.25, 300, 0.0, 0.0, 1.0\n PTMEAS/CART,1030.25,-18.5,$\n   301,0,0,1\nENDMES\n",
    ),
    "xyz names": ("xyz", "PT_001\t1025.5\t-20.25\t300.0\nPT_002\t1030.25\t-18.5\t301.0\n"),
    "xyz columns": ("xyz", "x y z nx ny nz\n1025.5 -20.25 300 0 0 1\n1030.25 -18.5 301 0 0 1\n"),
    "xyz of eight": ("xyzijk", "XYZIJK METRIC\n1025.5,-20.25,300.0,0,0,1,0.1,-0.1\n1030.25,-18.5,301.0,0,0,1,0.1,-0.1\n"),
    "xyz of seven": ("xyzijk", "XYZIJK METRIC\n1025.5,-20.25,300.0,0,0,1,4.0\n1030.25,-18.5,301.0,0,0,1,4.0\n"),
    "linuxcnc": ("linuxcnc", f"{P[0]} {P[1]} {P[2]} 0 0 0 0 0 0\n{Q[0]} {Q[1]} {Q[2]} 0 0 0 0 0 0\n"),
    "grbl of CNCjs": (
        "grbl",
        "> G91\nok\n> G38.2 Z-20 F80 (fast)\n[PRB:1025.500,-20.250,300.000:1]\nok\nG38.2Z-20F80\n"
        "2016-12-09T02:44:19.961Z - silly: [Grbl] < [PRB:1030.250,-18.500,301.000:1]\n",
    ),
    "grbl with a stray byte": (
        "grbl",
        b"\xff\xfeGrbl 1.1h ['$' for help]\n".replace(b"\xfe", b"")
        + b"\xff[PRB:1025.500,-20.250,300.000:1]\nok\n[PRB:1030.250,-18.500,301.000:1]\n",
    ),
    "grbl with a standing fourth axis": (
        "grbl",
        "[PRB:1025.500,-20.250,300.000,90.000:1]\n[PRB:1030.250,-18.500,301.000,90.000:1]\n",
    ),
    "TinyG": (
        "grbl",
        '{"r":{"prb":{"e":1,"x":1025.500,"y":-20.250,"z":300.000,"a":0.0}},"f":[1,0,0,1428]}\n{"sr":{"stat":3}}\n'
        'ok\n{"prb":{"e":0,"x":0.0,"y":0.0,"z":0.0}}\n{"prb":{"e":1,"x":1030.250,"y":-18.500,"z":301.000,"a":0.0}}\n',
    ),
    "msr with line numbers": (
        "msr",
        "START\nN1 G800 N1 X0 Y0 Z0 I0 J0 K1\nN2 G801 N1 X1025.5 Y-20.25 Z+300.0 R3.\nTOOLPATH G-CODE\n"
        "G800N2X0Y0Z0I0J0K1\nG801N2X1030.25Y-18.5Z301R3.\nEND\n",
    ),
    "I++ DME dialogue": (
        "ippdme",
        "00005 SetCoordSystem(PartCsy)\n00005 &\n00005 %\n00006 Get(X(), Y(), Z())\n00006 # X(1), Y(2), Z(3)\n00006 %\n"
        "00007 PtMeas(X(1025), Y(-20), Z(300), IJK(0,0,1))\n00007 &\n"
        "00007 # X(1025.5), Y(-20.25), Z(300.0), IJK(0, 0, 1), Q(0), Tool.A(90), ER(2)\n00007 %\n"
        '00008 ! Error(3, 1006, "PtMeas", "Surface not found")\n'
        "00009 # X(9), Y(9), Z(9), IJK(0, 0, 1), Q(50), Tool.A(90), ER(2)\n"
        "00010 # X(1030.25), Y(-18.5), Z(301.0), IJK(0, 0, 1), Q(0), Tool.A(90), ER(2)\n",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", GOOD)
def test_each_form_is_read_as_it_says(case):
    name, text = GOOD[case]
    options = ContactOptions() if name in ("ur", "kuka", "abb", "fanuc", "ippdme", "xyzijk", "dmis") else MM
    log = read(name, text, options=options)
    scale = 1000 if log.units == "m" else 1
    np.testing.assert_allclose(log.points * scale, [P, Q], atol=1e-9)


def test_what_is_told_of_the_good_ones():
    log = read("ippdme", GOOD["I++ DME dialogue"][1])
    assert log.tip_radius == 2.0
    np.testing.assert_array_equal(log.approaches, [[0, 0, -1]] * 2)
    told = "; ".join(log.notes)
    assert "line 11: the machine reports an error" in told
    assert "line 12: the machine reports bad quality, Q(50)" in told
    assert "Tool.A(), stands at 90" in told
    log = read("grbl", GOOD["grbl of CNCjs"][1])
    np.testing.assert_array_equal(log.approaches, [[0, 0, -1]] * 2)
    assert "circle" in "".join(read("xyzijk", GOOD["xyz of seven"][1], options=ContactOptions()).notes)
    assert "stray bytes" in "".join(read("grbl", GOOD["grbl with a stray byte"][1]).notes)
    assert "G38.3" in "".join(read("linuxcnc", GOOD["linuxcnc"][1]).notes)


ONE = "[PRB:1.000,2.000,3.000:1]\n"
REFUSED = [
    ("grbl", "[PRB:1.000,2.000,3.000,0.000:1]\n[PRB:1.000,2.000,3.000,90.000:1]", "line 2.*axes beyond X Y Z changes"),
    ("grbl", "[PRB:1,000,2.000,3.000:1]", "without a decimal point"),
    ("grbl", ONE.replace("3.000", "3.0.00"), "no number"),
    ("grbl", ONE.replace(":1]", ":1"), "']' is missing"),
    ("grbl", ONE.replace(":1]", ":2]"), "neither 1"),
    ("grbl", '{"prb":{"e":1,"x":1.0,"y":2.0,"z":1e999}}', "no number"),
    ("grbl", '{"prb":{"e":1,"x":1.0,"x":2.0,"y":2.0,"z":1}}', "not JSON"),
    ("ippdme", "00001 # X(1), Y(2), Z(3), R(0)\n00002 # X(1), Y(2), Z(3), R(90)", "rotary table, R\\(\\) changes"),
    ("ippdme", "00001 # X(1), Y(2), Z(3), Tool.A(0)\n00002 # X(1), Y(2), Z(3), Tool.A(90)", "Tool.A.., changes"),
    ("ippdme", "00001 # X(1), Y(2), Z(3), ER(1)\n00002 # X(1), Y(2), Z(3), ER(2)", "tip radius is 2"),
    ("ippdme", "00001 # X(1,5), Y(2), Z(3)", "'\\)' is missing"),
    ("ippdme", "00001 # X(1), Y(2), Z(3), Wobble(3)", "WOBBLE"),
    ("msr", "G330 N1 A0 B0 C0 X5 Y0 Z0\nG801 N1 X1 Y2 Z3", "G330 shifts"),
    ("msr", "G801 N1 X1 Y2 Z3 R1 X2", "X stands twice"),
    ("msr", "G801.5 N1 X1 Y2 Z3 R1", "no block"),
    ("kuka", "{" + KUKA.format(1, 2, 3) + ",E1 0.0}\n{" + KUKA.format(1, 2, 3) + ",E1 50.0}", "external axes changes"),
    ("kuka", "{" + KUKA.format("1,5", 2, 3) + "}", "no name"),
    ("kuka", "{" + KUKA.format(1, 2, 3) + ",Q 1}", "Q is not known"),
    ("abb", "[[1,2,3],[1,1,0,0]]", "length 1.41421"),
    ("abb", "[[1,2,3],[1,0,0,0],[0,0,0,0],[0,0,0,0,0,0]]\n[[1,2,3],[1,0,0,0],[0,0,0,0],[5,0,0,0,0,0]]", "axes changes"),
    ("fanuc", f"P[1]{{\n{FANUC_HEAD}{FANUC.format(*P)}}};\nP[2]{{\n{FANUC_HEAD.replace('UF : 0', 'UF : 2')}{FANUC.format(*Q)}}};",
     "user frame, UF, changes"),
    ("ur", "p[1,2,3,0,0,0] p[1,2,3,0,0,0]", "no name|left over"),
    ("ur", "movel(p[1,2,3,0,0,0], a=1.2)", "no name"),
    ("dmis", "UNITS/MM,ANGDEC\nPTMEAS/POL,1,2,3,0,0,1", "'CART' is missing"),
    ("dmis", "UNITS/MM,ANGDEC\nPTMEAS/CART,1,2,3\nUNITS/INCH,ANGDEC\nPTMEAS/CART,1,2,3", "unit changes"),
    ("xyz", "1,5;2,5;3.5", "decimal mark changes"),
    ("xyz", "1.5 2.5 3.5\n1.5,2.5,3.5", "what divides the numbers changes"),
    ("xyz", "42,9984,14.9986,30.4519,0,0,1", "some with a decimal point"),
    ("linuxcnc", "1,5 2 3 0 0 0 0 0 0", "no number|left over"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "text", "what"), REFUSED)
def test_what_would_be_read_wrongly_is_refused(name, text, what):
    with pytest.raises(FileError, match=what):
        read(name, text, count=text.count("\n") + 1)


def test_the_last_hit_that_parameters_tell_again_is_no_contact_and_a_touch_again_is_one():
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
    ],
)
def test_the_approach_of_a_repeated_command(commands, approach):
    found = read("grbl", commands + ONE, 1).approaches[0]
    np.testing.assert_allclose(found, [np.nan] * 3 if approach is None else approach)


def test_reports_in_inch_are_known_by_their_setting():
    assert read("grbl", "$13=1 (report in inches)\n" + ONE, 1, ContactOptions()).units == "in"
    with pytest.raises(FileError, match="does not say its units"):
        read("grbl", ONE, 1, ContactOptions())
