# ruff: noqa: E501 - texts of machines are as long as they are
"""Poses in the forms that ROS, controllers, programs and people write, and poses with damaged characters.

Each text of FORMS states the same pose: x 300, y 200, z -50 mm, rotated by 5 degrees about z.
"""

import random
import re
import string

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.errors import UsageError
from tactfix.pose_formats import DIALECTS
from tactfix.pose_formats.convert import write_pose
from tactfix.pose_formats.pose import Pose, PoseSyntaxError

C, S = np.cos(np.deg2rad(5)), np.sin(np.deg2rad(5))
QZ, QW = np.sin(np.deg2rad(2.5)), np.cos(np.deg2rad(2.5))
R5 = np.deg2rad(5)
MESSAGE = f"translation:\n    x: 0.3\n    y: 0.2\n    z: -0.05\n  rotation:\n    x: 0.0\n    y: 0.0\n    z: {QZ}\n    w: {QW}\n"
HEADER = "header:\n  stamp:\n    sec: 1700000000\n    nanosec: 123\n  frame_id: base\nchild_frame_id: fixture\n"
ECHO = (
    "At time 1766810488.299839012\n- Translation: [0.300, 0.200, -0.050]\n"
    "- Rotation: in Quaternion (xyzw) [0.000, 0.000, 0.044, 0.999]\n- Rotation: in RPY (radian) [0.000, -0.000, 0.087]\n"
    "- Rotation: in RPY (degree) [0.000, -0.000, 5.000]\n- Matrix:\n  0.996 -0.087  0.000  0.300\n"
    "  0.087  0.996  0.000  0.200\n  0.000  0.000  1.000 -0.050\n  0.000  0.000  0.000  1.000\n"
)
ECHO_1 = (
    "At time 1622031731.625\n- Translation: [0.300, 0.200, -0.050]\n- Rotation: in Quaternion [0.000, 0.000, 0.044, 0.999]\n"
    "            in RPY (radian) [0.000, -0.000, 0.087]\n            in RPY (degree) [0.000, -0.000, 5.000]\n"
)
HAND_EYE = (
    "parameters:\n  eye_on_hand: false\n  freehand_robot_movement: true\n  move_group: manipulator\n  name: cell\n"
    "  robot_base_frame: base\n  tracking_base_frame: camera\ntransformation:\n"
    f"  qw: {QW}\n  qx: 0.0\n  qy: 0.0\n  qz: {QZ}\n  x: 0.3\n  y: 0.2\n  z: -0.05\n"
)
ROWS = f"{C} {-S} 0 300\n{S} {C} 0 200\n0 0 1 -50\n0 0 0 1\n"
NESTED = f"[[{C}, {-S}, 0, 300], [{S}, {C}, 0, 200], [0, 0, 1, -50], [0, 0, 0, 1]]"
UFRAME = f"[[300,200,-50],[{QW},0,0,{QZ}]]"
FORMS = {
    "topic echo": ("ros", HEADER + "transform:\n  " + MESSAGE + "---\n"),
    "topic echo twice": ("ros", (HEADER + "transform:\n  " + MESSAGE + "---\n") * 2),
    "tf message": ("ros", "transforms:\n- " + HEADER.replace("\n", "\n  ") + "transform:\n    " + MESSAGE.replace("\n", "\n  ").rstrip() + "\n---\n"),
    "PoseStamped": ("ros", HEADER.replace("child_frame_id: fixture\n", "") + "pose:\n  " + MESSAGE.replace("translation", "position").replace("rotation", "orientation")),
    "tf2_echo": ("ros", ECHO),
    "tf2_echo of ROS 1": ("ros", ECHO_1 * 3),
    "easy_handeye": ("ros", HAND_EYE),
    "easy_handeye as yaml": ("yaml", HAND_EYE),
    "easy_handeye2": ("ros", "parameters:\n  name: cell\n  calibration_type: eye_on_base\ntransform:\n  " + MESSAGE),
    "publisher with yaw": ("ros-static", f"ros2 run tf2_ros static_transform_publisher --yaw {R5} --x 0.3 --y 0.2 --z -0.05 --frame-id base --child-frame-id f"),
    "publisher of ROS 1": ("ros-static", f"rosrun tf static_transform_publisher 0.3 0.2 -0.05 {R5} 0 0 base fixture 100"),
    "publisher by place": ("ros-static", f"ros2 run tf2_ros static_transform_publisher 0.3 0.2 -0.05 0 0 {QZ} {QW} base fixture"),
    "publisher of a launch file": ("ros-static", f'<node pkg="tf" type="static_transform_publisher" name="f" args="0.3 0.2 -0.05 {R5} 0 0 base f 100"/>'),
    "urdf, rpy first": ("urdf", f"<joint name='j'>\n <origin rpy='0 0 {R5}'\n xyz='0.3 0.2 -0.05' />\n</joint>"),
    "urdf, a comment": ("urdf", f'<!-- <origin xyz="1 2 3"/> -->\n<origin xyz="0.3 0.2 -0.05" rpy="0 0 {R5}"></origin>'),
    "rows of three": ("matrix", "".join(ROWS.splitlines(keepends=True)[:3])),
    "sixteen in a line": ("matrix", ROWS.replace("\n", " ")),
    "sixteen with commas": ("matrix", ROWS.strip().replace("\n", ",").replace(" ", ",")),
    "Python": ("matrix", NESTED),
    "numpy": ("matrix", f"array([[{C}, {-S}, 0., 300.],\n       [{S}, {C}, 0., 200.],\n       [0., 0., 1., -50.],\n       [0., 0., 0., 1.]])"),
    "numpy printed": ("matrix", f"[[ {C} {-S}   0. 300. ]\n [ {S} {C} 0. 200. ]\n [ 0. 0. 1. -50. ]\n [ 0. 0. 0. 1. ]]"),
    "MATLAB": ("matrix", f"T = [{C} {-S} 0 300; {S} {C} 0 200; 0 0 1 -50; 0 0 0 1];"),
    "semicolons": ("csv", f"# units: mm\n{C},{-S},0,300\n{S},{C},0,200\n0,0,1,-50\n0,0,0,1\n"),
    "kuka E6POS": ("kuka", "DECL E6POS XP1={X 300,Y 200,Z -50,A 5,B 0,C 0,S 2,T 35,E1 0.0,E2 0.0,E3 0.0,E4 0.0,E5 0.0,E6 0.0}"),
    "kuka typed": ("kuka", "{FRAME: X 300, Y 200, Z -50, A 5, B 0, C 0}"),
    "abb robtarget": ("abb", f"CONST robtarget p:=[[300,200,-50],[{QW},0,0,{QZ}],[0,-1,0,1],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];"),
    "abb user frame": ("abb-wobjdata", f'TASK PERS wobjdata w:=[FALSE,TRUE,"",{UFRAME},[[0,0,0],[1,0,0,0]]];'),
    "abb object frame": ("abb-wobjdata", f'PERS wobjdata w := [FALSE, TRUE, "", [[300,190,-50],[1,0,0,0]], [[0,10,0],[{QW},0,0,{QZ}]]];'),
    "fanuc .ls": ("fanuc", "P[1]{\n   GP1:\n\tUF : 0, UT : 1,\tCONFIG : 'N U T, 0, 0, 0',\n\tX = 300.0  mm,\tY = 200.0  mm,\tZ = -50.0  mm,\n\tW = 0.0 deg,\tP = .000 deg,\tR = 5.0 deg\n};"),
    "fanuc frame": ("fanuc", "[1,1] =   Group: 1   Config: N D B, 0, 0, 0\n  X: 300.0   Y: 200.0   Z: -50.0\n  W: 0.0   P: 0.0   R: 5.0\n"),
    "g10 in inch": ("g10", f"%\nG20G90\nN10 G10 L2 P1 X{300 / 25.4:.9f} Y{200 / 25.4:.9f} Z{-50 / 25.4:.9f} R5 (G21)\n%"),
    "g10 after both": ("g10", "G20\nG21\n(G20) G10 L2 P1 R5 X300 Y200 Z-50 ; G20"),
    "g10 in one block": ("g10", "g90g21g10l2p2x300y200z-50r5"),
    "g68.2 with G17": ("g68.2", "G17 G90\nG68.2 P0 X300. Y200. Z-50. I5. J0. K0."),
    "siemens in inch": ("siemens", f"N10G70\n; G71\n$P_UIFR[1]=CTRANS(X,{300 / 25.4:.9f},Y,{200 / 25.4:.9f},Z,{-50 / 25.4:.9f}):CROT(X,0,Y,0,Z,5)"),
    "siemens before inch": ("siemens", "$P_UIFR[1]=CTRANS(X,300,Y,200,Z,-50):CROT(Z,5)\nG70\n"),
    "g10 in G90 again": ("g10", "G91 X1\nG90\nG10 L2 P1 X300 Y200 Z-50 R5\nG91"),
    "siemens, axes left out": ("siemens", "$P_UIFR[1] = CTRANS(Y,200,X,300,Z,-50) : CROT(Z,5) ; G54\nN20 G54\nM30"),
    "siemens, fine": ("siemens", "$P_UIFR[2]=CTRANS(X,299,Y,200,Z,-50):CFINE(X,1):CROT(Z,5)"),
    "heidenhain in inch": ("heidenhain", f"0 BEGIN PGM 1 INCH\nCYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+{300 / 25.4:.9f}\nCYCL DEF 7.2 Y+{200 / 25.4:.9f}\nCYCL DEF 7.3 Z{-50 / 25.4:.9f}\nPLANE SPATIAL SPA+0 SPB+0 SPC+5"),
}  # fmt: skip


@pytest.mark.parametrize("form", FORMS)
def test_every_form_gives_the_same_pose(form):
    name, text = FORMS[form]
    pose = DIALECTS[name].read(text)
    pose = pose.in_units("mm") if pose.units else pose
    few = 1e-3 if "tf2_echo" in form else 1e-6
    np.testing.assert_allclose(pose.translation, [300, 200, -50], atol=few)
    np.testing.assert_allclose(pose.rotation, [[C, -S, 0], [S, C, 0], [0, 0, 1]], atol=few * 10)


REFUSED = [
    ("ros", HEADER + "transform:\n  " + MESSAGE + "---\n" + HEADER + "transform:\n  " + MESSAGE.replace("0.3", "0.4"), "differ"),
    ("ros", ECHO.replace("0.044, 0.999", "0.087, 0.996"), "not the same rotation"),
    ("ros", ECHO.replace("0.044, 0.999", "0.044, 0.909"), "no unit quaternion"),
    ("ros-static", "static_transform_publisher 1 2 3 0 0 0 0 base", "no pose"),
    ("ros-static", "static_transform_publisher --x 1 --yaw 1 --qw 1 --frame-id a --child-frame-id b", "not one whole"),
    ("urdf", '<origin xyz="1 2" rpy="0 0 0"/>', "line 1"),
    ("urdf", '<origin xyz="1 2 3" rpy="0 0 0" scale="2"/>', "scale"),
    ("matrix", NESTED.replace("]]", "]"), "left open"),
    ("matrix", ROWS.replace("300", "3e31"), "larger than 1e30"),
    ("matrix", ROWS.replace("300", "1_0"), "no number"),
    ("matrix", ROWS.replace("300", "300,5"), "four rows"),
    ("abb-wobjdata", f'PERS wobjdata w:=[TRUE,TRUE,"",{UFRAME},[[0,0,0],[1,0,0,0]]];', "holds this work object"),
    ("abb-wobjdata", f'PERS wobjdata w:=[FALSE,FALSE,"M7DM1",{UFRAME},[[0,0,0],[1,0,0,0]]];', "mechanical unit"),
    ("kuka", "{X 300,5,Y 200,Z -50,A 5,B 0,C 0}", "no name"),
    ("g10", "G10 L2 P1 X1.2.3 Y2 Z3 R4", "no number"),
    ("g10", "G10 L2 P1 X1 Y2 Z3 R4.5.6", "no number"),
    ("siemens", "$P_UIFR[1]=CTRANS(X,1,Y,2,Z,3);:CROT(Z,5)", "in a comment"),
    ("siemens", "$P_UIFR[1]=CTRANS(X,1,Y,2,Z,3)\nCROT(Z,5)", "more than one frame"),
    ("siemens", "$P_UIFR[1]=CTRANS(X,1,Y,2,Z,3):CSCALE(X,2)", "CSCALE does not follow"),
    ("siemens", "$P_UIFR[1]=CROT(Z,5):CTRANS(X,1)", "no pose"),
    ("siemens", "$P_UIFR[1]=CTRANS(X,1,X,2)", "is given twice"),
    ("siemens", "$P_UIFR[1]=CTRANS(X,1,5)", "no name"),
    ("g10", "G10 L20 P1 X1 Y2 Z3 R4", "L20"),
    ("g10", "G91 G1 X#1\nG10 L2 P1 X1 Y2 Z3 R4", "line 2.*G10 is in G91"),
    ("g68.2", "G91 G68.2 X1 Y2 Z3 I0 J0 K0", "G68.2 is in G91"),
    ("ur", "p[0.1, 0.2, 0.3, 0, 180, 0]", "180 rad is more than a full turn"),
    ("urdf", '<origin xyz="1 2 3" rpy="0 0 90"/>', "90 rad is more than a full turn"),
    ("g10", "G10 L2 P1 X1 Y2 Z3 R4 A5", "A5"),
    ("heidenhain", "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+1\nCYCL DEF 7.2 Y+2\nCYCL DEF 7.3 Z+3\nPLANE SPATIAL SPA+0 SPB+0 SPC+5,5", "no pose"),
    ("yaskawa", "1,2,3,4,5,6e400", "no pose|larger than 1e30"),
    ("csv", "# units: mm\n1,0,0,300\n0,1,0,-20#.5\n0,0,1,3\n0,0,0,1\n", "left over|no number"),
    ("matrix", "1 0 0 3\n0 1 0 5#mm\n0 0 1 3\n", "left over|no number"),
    ("ros-static", "static_transform_publisher --x 0.3 --y 0.2 --z 1#.5 --qx 0 --qy 0 --qz 0 --qw 1", "left over"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "text", "pattern"), REFUSED)
def test_ambiguous_texts_are_rejected(name, text, pattern):
    with pytest.raises(PoseSyntaxError, match=pattern):
        DIALECTS[name].read(text)


WRITTEN = re.compile(r"(?<![G0-9.])(?<!DEF )[-+]?[0-9]+\.[0-9]+(?:[eE][-+]?[0-9]+)?")
NUMBER = r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
ALPHABET = string.printable + "é٣−"


def work_object_translation(changed):
    """x, y, z of a work object from its fourteen numbers: the object frame is relative to the user frame."""
    inside = changed[changed.index('""') + 2 :]
    numbers = [float(number) for number in re.findall(NUMBER, inside)]
    if len(numbers) != 14:
        return None
    w, x, y, z = numbers[3:7]
    return Rotation.from_quat([x, y, z, w]).apply(numbers[7:10]) + numbers[:3]


def translation_by_template(name, text, changed):
    """x, y, z of a changed text, by a pattern of the original text in which only numbers vary; None if it does not match."""
    if name == "abb-wobjdata":
        return work_object_translation(changed)
    around = WRITTEN.split(text)
    words = [re.findall(r"[A-Za-z0-9_]+|[^\sA-Za-z0-9_]", part) for part in around]
    parts = [r"\s*" + r"\s*".join(map(re.escape, found)) + r"\s*" for found in words]
    if name == "g68.2":  # P0 states that three Euler angles follow, which is also the default
        changed = re.sub(r"P0+(?![0-9.])", "", changed)
    match = re.fullmatch(f"({NUMBER})".join(parts), changed, re.IGNORECASE | re.ASCII)
    if match is None:
        return None
    rows = name in ("matrix", "json", "yaml", "csv")
    return [float(match.groups()[i]) for i in ((3, 7, 11) if rows else (0, 1, 2))]


def damaged(text, rng):
    at, kind = rng.randrange(len(text)), rng.randrange(3)
    return text[:at] + ("" if kind == 0 else rng.choice(ALPHABET)) + text[at + (kind < 2) :]


def fuzz(names, changes, seed):
    """Texts with one to three damaged characters are rejected, or read as the pose that their numbers state."""
    rng, refused, read = random.Random(seed), 0, 0
    turn = Rotation.from_euler("ZYX", [25, 12, -7], degrees=True).as_matrix()
    for i in range(changes):
        name = names[i % len(names)]
        matrix = np.eye(4)
        matrix[:3, :3] = np.eye(3) if name == "g10" else turn
        matrix[:3, 3] = [312.25, -208.5, 51.125]
        pose = Pose(matrix, "mm")
        text = write_pose(name, pose, force=True).text
        if isinstance(text, bytes):
            continue
        changed = damaged(text, rng)
        try:
            found = DIALECTS[name].read(changed)
        except (PoseSyntaxError, UsageError):
            refused += 1
            continue
        read += 1
        before = DIALECTS[name].read(text).base_from_fixture
        if np.array_equal(found.base_from_fixture, before):
            continue
        expected = translation_by_template(name, text, changed)
        assert expected is not None, (name, changed)
        np.testing.assert_allclose(found.translation, expected, atol=1e-12, err_msg=changed)
    return refused, read


def test_damaged_poses_are_read_or_refused():
    refused, read = fuzz([name for name in DIALECTS if name != "npy"], 460, seed=11)
    assert refused > 100
    assert read > 100


@pytest.mark.slow
def test_five_thousand_damaged_poses():
    refused, read = fuzz([name for name in DIALECTS if name != "npy"], 5000, seed=11)
    assert refused > 1000
    assert read > 1000
