# ruff: noqa: E501 - the lines of machines are as long as they are
"""Logs of two touches in the forms that controllers, senders and measuring software write."""

P, Q = (1025.5, -20.25, 300.0), (1030.25, -18.5, 301.0)
KUKA = "X {0},Y {1},Z {2},A 10.0,B 90.0,C 0.0"
STATUS = ",S 2,T 35,E1 0.0,E2 0.0,E3 0.0,E4 0.0,E5 0.0,E6 0.0"
EXTERNAL = "[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]"
ABB = "[[{0},{1},{2}],[1,0,0,0],[0,-1,0,1]," + EXTERNAL + "]"
FANUC = (
    "\tX =  {0:.3f}  mm,\tY =   {1:.3f}  mm,\tZ = {2:.3f}  mm,\n\tW =   180.0 deg,\tP = -.131 deg,\tR =  0.000 deg\n"
)
FANUC_HEAD = "   GP1:\n\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',\n"

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
    "kuka .src": (
        "kuka",
        "DEF touch( )\n;FOLD INI\nBAS (#INITMOV,0 )\n$TOOL=TOOL_DATA[1]\n$BASE = BASE_DATA[3]\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}\n"
        f"LIN {{{KUKA.format(*P)}}} C_DIS\n$BASE=BASE_DATA[3]\nSPTP {{{KUKA.format(*Q)}{STATUS}}}\nEND\n",
    ),
    "kuka without braces": (
        "kuka",
        f"P1: {KUKA.format(*P).replace(',', ' ')}\nX={Q[0]} Y={Q[1]} Z={Q[2]} A=10 B=90 C=0\n",
    ),
    "kuka columns with names": (
        "kuka",
        "Name;Time;X;Y;Z;A;B;C;\nP1;12:00:01;1025,5;-20,25;300,0;10;90;0;\nP2;12:00:02;1030,25;-18,5;301;10;90;0;\n",
    ),
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
    "abb named motions": (
        "abb",
        f"CONST robtarget p10:={ABB.format(*P)}; CONST robtarget p20:={ABB.format(*Q)}; ! two\nPROC main()\n"
        f"MoveAbsJ [[0,0,0,0,30,0],{EXTERNAL}]\\NoEOffs,v100,fine,tool0;\nMoveL p10,v100,fine,probe\\WObj:=table;\n"
        "SearchL\\Stop,di1,p20,p10,v20,probe\\WObj:=table;\nENDPROC\n",
    ),
    "abb stamps": ("abb", f"12:00:01 {ABB.format(*P)}\n2025-11-28 12:00:02 p20 = {ABB.format(*Q)}\n"),
    "abb columns of EGM": ("abb", "time,X,Y,Z,Q0,Q1,Q2,Q3\n0.1,1025.5,-20.25,300,1,0,0,0\n0.2,1030.25,-18.5,301,0,1,0,0\n"),
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
    "fanuc single lines": (
        "fanuc",
        f"CURPOS.DG\n Frame #: 1 Tool #: 2\nX: {P[0]} Y: {P[1]} Z: {P[2]}\nW: 180.0 P: 0.0 R: 0.0\n"
        f"PR[2:seat] = X: {Q[0]} Y: {Q[1]} Z: {Q[2]} W: 180.0 P: 0.0 R: 0.0\n",
    ),
    "fanuc columns with names": (
        "fanuc",
        "Point,X,Y,Z,W,P,R\nP[1],1025.5,-20.25,300,0,0,0\nP[2],1030.25,-18.5,301,0,0,0\n",
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
    "ur lists of Python": ("ur", "[1.0255, -0.02025, 0.3, 0, 3.14, 0]\n1701212345.123 (1.03025, -0.0185, 0.301, 0, 3.14, 0)\n"),
    "ur variables": (
        "ur",
        "#Fri Nov 28\n global touch_1_p=p[1.0255,-0.02025,.3,.0,3.14,.0]\n global touch_1_q=[0.1, -1.5, 1.6, 0, 0, 0]\ncount=3\n"
        "touch_2=p[1.03025, -0.0185, 0.301, 0, 3.14, 0]\n",
    ),
    "ur recorder of all": (
        "ur",
        "timestamp,robot_mode,wrench_calc_from_currents_0,TCP_offset_0,TCP_offset_1,"
        + ",".join(f"actual_TCP_pose_{i}" for i in range(6))
        + ",\n100.0,7,0.5,0.1,0.2,1.0255,-0.02025,0.3,0,3.14,0,\n101.0,7,0.6,0.1,0.2,1.03025,-0.0185,0.301,0,3.14,0,\n",
    ),
    "dmis of one sensor": (
        "dmis",
        "UNITS/MM,ANGDEC\nTEXT/OPER,'PTMEAS follow'\nSNSLCT/S(A0)\nPRCOMP/ON\nROTAB/RT(1),ABSL,CW,90\nPTMEAS/CART,1025.5,-20.25,300\n"
        "SNSLCT/S(A0)\nPTMEAS/CART,1030.25,-18.5,301\n",
    ),
    "dmis": (
        "dmis",
        "DMISMN/'T', 4.0\nUNITS/MM,ANGDEC\n$$ PTMEAS/CART,9,9,9\nF(TOP)=FEAT/PLANE,CART,0,0,0,0,0,1\nMEAS/PLANE,F(TOP),2\n"
        "  PTMEAS/CART, 1025.5, -20.25, 300, 0.0, 0.0, 1.0\n PTMEAS/CART,1030.25,-18.5,$\n   301,0,0,1\nENDMES\n",
    ),
    "xyz names": ("xyz", "PT_001\t1025.5\t-20.25\t300.0\nPT_002\t1030.25\t-18.5\t301.0\n"),
    "xyz columns": ("xyz", "x y z nx ny nz\n1025.5 -20.25 300 0 0 1\n1030.25 -18.5 301 0 0 1\n"),
    "xyz of names": (
        "xyz",
        "Group;Point ID;X [mm];Y [mm];Z [mm];I;J;K\nA;p1;1025,5;-20,25;300;0;0;1\nA;p2;1030,25;-18,5;301;0;0;1\n",
    ),
    "xyz of letters": ("xyz", "X1025.5Y-20.25Z300.0A0\nP2, X=1030.25, Y=-18.5, Z=301, A=0\n"),
    "xyz in any case": ("xyzijk", "xyzijk metric\n1025.5,-20.25,300,0,0,1\n1030.25,-18.5,301,0,0,1\n"),
    "xyz of eight": ("xyzijk", "XYZIJK METRIC\n1025.5,-20.25,300.0,0,0,1,0.1,-0.1\n1030.25,-18.5,301.0,0,0,1,0.1,-0.1\n"),
    "xyz of seven": ("xyzijk", "XYZIJK METRIC\n1025.5,-20.25,300.0,0,0,1,4.0\n1030.25,-18.5,301.0,0,0,1,4.0\n"),
    "linuxcnc with remarks": (
        "linuxcnc",
        f"# top\n{P[0]} {P[1]} {P[2]} 0 0 0 0 0 0\n; front\n{Q[0]} {Q[1]} {Q[2]} 0 0 0 0 0 0\n",
    ),
    "linuxcnc": ("linuxcnc", f"{P[0]} {P[1]} {P[2]} 0 0 0 0 0 0\n{Q[0]} {Q[1]} {Q[2]} 0 0 0 0 0 0\n"),
    "grbl of CNCjs": (
        "grbl",
        "> G91\nok\n> G38.2 Z-20 F80 (fast)\n[PRB:1025.500,-20.250,300.000:1]\nok\nG38.2Z-20F80\n"
        "2016-12-09T02:44:19.961Z - silly: [Grbl] < [PRB:1030.250,-18.500,301.000:1]\n",
    ),
    "grbl of Candle": (
        "grbl",
        "[CTRL+X] < Grbl 1.1f ['$' for help]\nG91 < ok\nG38.2Z-20F80 < [PRB:1025.500,-20.250,300.000:1]; ok\n"
        "G0Z2 < ok\nG38.2 Z-4 F50 < [PRB:1030.250,-18.500,301.000:1]; ok\n",
    ),
    "grbl of gSender": (
        "grbl",
        "[22:44:38] Centre finding probe cycle in progress\n[22:44:38] [ G91 ] ok\n[22:44:43] [ [ PROBE ] ] Probe Completed.\n"
        "[22:44:43] [ G38.2 Z-20 F200 ] [PRB:1025.500,-20.250,300.000:1]\n[22:44:43] [ G38.2 Z-20 F200 ] ok\n"
        "[22:44:46] [ G38.2 Z-5 F80 ] [PRB:1030.250,-18.500,301.000:1]\n[22:44:46] [ $# ] [G54:0.000,0.000,0.000]\n"
        "[22:44:46] [ $# ] [PRB:1030.250,-18.500,301.000:1]\n[22:44:46] [ $# ] ok\n",
    ),
    "grbl of the Serial Port JSON Server": (
        "grbl",
        '{"P":"COM3","D":"[PRB:1025.500,-20.250,300.000:1]\\n"}\n{"P":"COM3","D":"ok\\n"}\n'
        '{"P":"COM3","D":"{\\"prb\\":{\\"e\\":1,\\"x\\":1030.25,\\"y\\":-18.5,\\"z\\":301.0}}\\n"}\n',
    ),
    "grbl in colour, quotes and seconds": (
        "grbl",
        "\x1b[32m[PRB:1025.500,-20.250,300.000:1]\x1b[0m\nb'ok\\r\\n'\n1701212345.123 [PRB:1030.250,-18.500,301.000:1]\n",
    ),
    "Marlin": (
        "grbl",
        "Send: G30 X10 Y20\nRecv: Bed X: 1025.50 Y: -20.25 Z: 300.00\nRecv: ok\nBed X: 1030.25 Y: -18.50 Z: 301.00\n",
    ),
    "g2core": (
        "grbl",
        '{"r":{"prb":{"e":1,"x":1025.5,"y":-20.25,"z":300.0,"a":0,"b":0}},"f":[1,0,8]}\n{"prb":{"e":1,"x":1030.25,"y":-18.5,"z":301}}\n',
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
