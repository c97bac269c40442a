"""The dialects of robot controllers, machine tools and ROS that are one line of numbers.

Conventions, units and literal syntax were gathered from the vendors' manuals and checked against independent code;
if only one source confirmed a convention, its title says so.
"""

from collections.abc import Callable
from typing import Final

from tactfix.formats import PoseFormat
from tactfix.geometry.arrays import Floats
from tactfix.pose_formats.controller_text import (
    heidenhain_units,
    read_abb,
    read_fanuc,
    read_g10,
    read_kuka,
    read_siemens,
    read_tilted_plane,
    read_ur,
    read_wobjdata,
)
from tactfix.pose_formats.dialect import Dialect, NumberReader, Numbers, NumberSyntax, numeric
from tactfix.pose_formats.orientation import EulerAngles, Orientation, Quaternion, RotationVector, TurnAboutZ
from tactfix.pose_formats.ros_text import read_static, read_urdf

# R = Rz(third) Ry(second) Rx(first): fixed axes x, y, z, written in that order.
_FIXED_XYZ: Final = EulerAngles("ZYX", order=(2, 1, 0))
_ZYX: Final = EulerAngles("ZYX")
_XYZ: Final = EulerAngles("XYZ")
_ZYZ: Final = EulerAngles("ZYZ")
_ZXZ: Final = EulerAngles("ZXZ")

_SIX: Final = ",".join(["%.6f"] * 6)
_NO_COMMENT: Final = ("", "")


def _robot(
    name: PoseFormat,
    title: str,
    labels: str,
    orientation: Orientation,
    template: str,
    comment: tuple[str, str] = _NO_COMMENT,
    around: str = "{}",
    reader: NumberReader | None = None,
    units_of: Callable[[str], str | None] | None = None,
) -> Dialect:
    """A dialect in mm and degrees, or mm and a quaternion; units_of: finds the unit given in a text, if any."""
    words = tuple(labels.split())
    in_degrees = not isinstance(orientation, Quaternion)
    syntax = NumberSyntax(template, tuple(in_degrees and i > 2 for i in range(len(words))), comment, around)
    numbers = Numbers(words, "mm", orientation, "deg" if in_degrees else "")
    if units_of is not None:
        find_units = units_of

        def reader(text: str) -> tuple[Floats, str | None]:
            return syntax.read(text), find_units(text)

    return numeric(name, title, numbers, syntax, reader)


def _metric(
    name: PoseFormat,
    title: str,
    labels: str,
    orientation: Orientation,
    template: str,
    comment: tuple[str, str],
    around: str = "{}",
    reader: NumberReader | None = None,
) -> Dialect:
    """A dialect in m and rad, or m and a quaternion."""
    words = tuple(labels.split())
    unit = "" if isinstance(orientation, Quaternion) else "rad"
    syntax = NumberSyntax(template, (False,) * len(words), comment, around)
    return numeric(name, title, Numbers(words, "m", orientation, unit), syntax, reader)


_ABB_POSE: Final = "[[%.6f,%.6f,%.6f],[%.9f,%.9f,%.9f,%.9f]]"
_ABB_LABELS: Final = "X Y Z q1 q2 q3 q4"

ROBOTS: Final = (
    _robot(
        "kuka",
        "KUKA FRAME: Rz(A) Ry(B) Rx(C)",
        "X Y Z A B C",
        _ZYX,
        "{X %.6f,Y %.6f,Z %.6f,A %.6f,B %.6f,C %.6f}",
        ("; ", ""),
        reader=read_kuka,
    ),
    _robot(
        "abb",
        "ABB RAPID pose: quaternion w, x, y, z",
        _ABB_LABELS,
        Quaternion(True),
        _ABB_POSE,
        ("! ", ""),
        reader=read_abb,
    ),
    _robot(
        "abb-wobjdata",
        "ABB RAPID wobjdata with this user frame",
        _ABB_LABELS,
        Quaternion(True),
        f'[FALSE,TRUE,"",{_ABB_POSE},[[0,0,0],[1,0,0,0]]]',
        ("! ", ""),
        "PERS wobjdata wobj_fixture:={};",
        reader=read_wobjdata,
    ),
    _robot(
        "fanuc",
        "FANUC user frame: Rz(R) Ry(P) Rx(W)",
        "X Y Z W P R",
        _FIXED_XYZ,
        "X = %9.3f mm, Y = %9.3f mm, Z = %9.3f mm, W = %9.3f deg, P = %9.3f deg, R = %9.3f deg",
        reader=read_fanuc,
    ),
    _metric(
        "ur",
        "Universal Robots pose: rotation vector",
        "x y z rx ry rz",
        RotationVector(),
        "p[%.9f, %.9f, %.9f, %.9f, %.9f, %.9f]",
        ("# ", ""),
        reader=read_ur,
    ),
    _robot(
        "yaskawa",
        "Yaskawa user frame: Rz(Rz) Ry(Ry) Rx(Rx)",
        "X Y Z Rx Ry Rz",
        _FIXED_XYZ,
        "%.3f,%.3f,%.3f,%.4f,%.4f,%.4f",
    ),
    _robot("staubli", "Staubli VAL3 trsf: Rx(rx) Ry(ry) Rz(rz)", "x y z rx ry rz", _XYZ, "{" + _SIX + "}", ("// ", "")),
    _robot(
        "mecademic", "Mecademic SetWrf: Rx(alpha) Ry(beta) Rz(gamma)", "x y z alpha beta gamma", _XYZ, f"SetWrf({_SIX})"
    ),
    _robot("kawasaki", "Kawasaki TRANS: Rz(O) Ry(A) Rz(T)", "X Y Z O A T", _ZYZ, f"TRANS({_SIX})", ("; ", "")),
    _robot(
        "comau",
        "Comau PDL2 POS: Rz(e1) Ry(e2) Rz(e3), from one source",
        "x y z e1 e2 e3",
        _ZYZ,
        f"POS({_SIX},'')",
        ("-- ", ""),
    ),
    _robot("doosan", "Doosan posx: Rz(A) Ry(B) Rz(C)", "x y z A B C", _ZYZ, f"posx({_SIX})", ("# ", "")),
    _robot(
        "mitsubishi",
        "Mitsubishi MELFA position: Rz(C) Ry(B) Rx(A), from one source",
        "X Y Z A B C",
        _FIXED_XYZ,
        f"({_SIX})(7,0)",
    ),
)

MACHINES: Final = (
    _robot(
        "siemens",
        "Siemens 840D frame, MD10600 = 1: Rz(Z) Ry(Y) Rx(X)",
        "X Y Z RX RY RZ",
        _FIXED_XYZ,
        "$P_UIFR[1]=CTRANS(X,%.6f,Y,%.6f,Z,%.6f):CROT(X,%.6f,Y,%.6f,Z,%.6f)",
        ("; ", ""),
        reader=read_siemens,
    ),
    # PLANE SPATIAL only rotates; the datum shift before it, along the axes not yet rotated, sets the origin.
    _robot(
        "heidenhain",
        "Heidenhain datum shift and PLANE SPATIAL: Rz(SPC) Ry(SPB) Rx(SPA)",
        "X Y Z SPA SPB SPC",
        _FIXED_XYZ,
        "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X%+.6f\nCYCL DEF 7.2 Y%+.6f\nCYCL DEF 7.3 Z%+.6f\n"
        "PLANE SPATIAL SPA%+.6f SPB%+.6f SPC%+.6f",
        ("; ", ""),
        units_of=heidenhain_units,
    ),
    _robot(
        "g68.2",
        "G68.2 tilted work plane, in mm (G21): Rz(I) Rx(J) Rz(K)",
        "X Y Z I J K",
        _ZXZ,
        "G68.2 X%.4f Y%.4f Z%.4f I%.4f J%.4f K%.4f",
        ("(", ")"),
        reader=read_tilted_plane,
    ),
    _robot(
        "g10",
        "LinuxCNC G10 L2, in mm (G21): a turn about Z, no tilt",
        "X Y Z R",
        TurnAboutZ(),
        "G10 L2 P1 X%.4f Y%.4f Z%.4f R%.4f",
        ("(", ")"),
        reader=read_g10,
    ),
)

ROS_LINES: Final = (
    _metric(
        "ros-static",
        "ROS static_transform_publisher: quaternion x, y, z, w",
        "x y z qx qy qz qw",
        Quaternion(False),
        "--x %.9f --y %.9f --z %.9f --qx %.9f --qy %.9f --qz %.9f --qw %.9f",
        ("# ", ""),
        "ros2 run tf2_ros static_transform_publisher {} --frame-id base --child-frame-id fixture",
        reader=lambda text: (read_static(text), None),
    ),
    _metric(
        "urdf",
        "URDF origin: Rz(yaw) Ry(pitch) Rx(roll)",
        "x y z roll pitch yaw",
        EulerAngles("ZYX", order=(2, 1, 0), degrees=False),
        '<origin xyz="%.9f %.9f %.9f" rpy="%.9f %.9f %.9f"/>',
        ("<!-- ", " -->"),
        reader=lambda text: (read_urdf(text), None),
    ),
)
