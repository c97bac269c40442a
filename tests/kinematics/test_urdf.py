"""URDF files: the chain against an independent one, only origins changed on writing, and errors with line numbers."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.geometry.arrays import Floats
from tactfix.kinematics.urdf import corrected_urdf, urdf_robot
from tactfix.kinematics.urdf_syntax import UrdfError

ARM = """<?xml version="1.0"?>
<!-- an arm -->
<robot name="arm">
  <link name="world"/>
  <link name="one"><visual><origin xyz="9 9 9"/></visual></link>
  <link name="two"/>
  <link name="rail"/>
  <link name="flange"/>
  <link name="ball"/>
  <joint name="A1" type="revolute">
    <origin rpy="0.1 -0.2 3.0" xyz="0.01 0 0.4"/>
    <parent link="world"/> <child link="one"/>
    <axis xyz="0 0 1"/> <limit lower="-2.9" upper="2.9" effort="0" velocity="0"/>
  </joint>
  <joint type="continuous" name="A2">
    <parent link="one"/> <child link="two"/>
    <axis xyz="0 -1 0"/>
  </joint>
  <joint name="slide" type="prismatic">
    <origin xyz="0 0.3 0" rpy="0 1.5707963267948966 0"
    ></origin>
    <parent link="two"/> <child link="rail"/>
    <axis xyz="2 0 2"/> <limit lower="-0.1" upper="0.5" effort="0" velocity="0"/>
  </joint>
  <joint name="hand" type="fixed">
    <origin xyz="0 0 0.1"/> <parent link="rail"/> <child link="flange"/>
  </joint>
  <joint name="ball_joint" type="fixed">
    <origin xyz="0.01 0 0.03"/> <parent link="flange"/> <child link="ball"/>
  </joint>
</robot>
"""
Q = np.random.default_rng(2).uniform(-1, 1, (6, 3)) * [1, 1, 100]


def tips(text: str, joints: Floats) -> Floats:
    """The origin of the ball's link in mm, from the file, without code of the package."""
    parts = {joint.find("child").get("link"): joint for joint in ET.fromstring(text).iter("joint")}  # type: ignore[union-attr]
    found = []
    for q in joints:
        rotation, origin = Rotation.identity(), np.zeros(3)
        amounts = iter(q)
        for link in ("one", "two", "rail", "flange", "ball"):
            joint = parts[link]
            own = joint.find("origin")
            attributes = {} if own is None else own.attrib
            origin = origin + rotation.apply([1e3 * float(v) for v in attributes.get("xyz", "0 0 0").split()])
            rotation = rotation * Rotation.from_euler("xyz", [float(v) for v in attributes.get("rpy", "0 0 0").split()])
            if joint.get("type") == "fixed":
                continue
            axis = np.array([float(v) for v in joint.find("axis").get("xyz").split()])  # type: ignore[union-attr]
            axis = axis / np.linalg.norm(axis) * next(amounts)
            if joint.get("type") == "prismatic":
                origin = origin + rotation.apply(axis)
            else:
                rotation = rotation * Rotation.from_rotvec(axis)
        found.append(origin)
    return np.array(found)


def test_the_chain_is_that_of_the_file() -> None:
    robot = urdf_robot(ARM, "ball", None, 1000.0)
    assert robot.chain.points(Q, np.zeros(21)) == pytest.approx(tips(ARM, Q), abs=1e-9)
    assert [joint.name for joint in robot.chain.joints] == ["A1", "A2", "slide"]
    assert [joint.is_prismatic for joint in robot.chain.joints] == [False, False, True]
    limits = [(joint.low, joint.high) for joint in robot.chain.joints]
    assert limits == [(-2.9, 2.9), (-np.inf, np.inf), (-100.0, 500.0)]


@pytest.mark.parametrize("only", [None, "joint_1.offset", "joint_2.x", "tip.z"])
def test_the_corrected_file_is_the_robot_with_its_errors(only: str | None) -> None:
    robot = urdf_robot(ARM, "ball", None, 1000.0)
    values = 0.02 * np.random.default_rng(4).normal(size=21)
    if only is not None:
        values[[name != only for name in robot.chain.names()]] = 0.0
    text = corrected_urdf(robot, values, ["sigma -- of nothing"])
    assert tips(text, Q) == pytest.approx(robot.chain.points(Q, values), abs=1e-9)
    without_origins = [re.sub(r"\s*<origin[^>]*>(</origin>)?", "", t) for t in (ARM, text)]
    note = "<!--\n  sigma - - of nothing\n-->\n"
    assert without_origins[1].replace(note, "") == without_origins[0]
    assert '<visual><origin xyz="9 9 9"/></visual>' in text


def test_the_comment_is_before_the_robot_element() -> None:
    text = ARM.replace("<!-- an arm -->", "").replace("<robot", "<!-- what a <robot> -->\n<robot", 1)
    written = corrected_urdf(urdf_robot(text, "ball", None, 1000.0), np.zeros(21), ["a---b"])
    assert tips(written, Q) == pytest.approx(tips(ARM, Q), abs=1e-9)
    assert written.replace("<!--\n  a- - -b\n-->\n", "") == text


def test_without_errors_only_the_comment_is_added() -> None:
    robot = urdf_robot(ARM, "ball", None, 1000.0)
    assert corrected_urdf(robot, np.zeros(21), ["x"]).replace("<!--\n  x\n-->\n", "") == ARM


def test_a_joint_at_a_right_angle_of_pitch_keeps_its_orientation() -> None:
    robot = urdf_robot(ARM, "ball", None, 1000.0)
    values = np.zeros(21)
    values[[name == "joint_3.x" for name in robot.chain.names()]] = 1.0
    assert 'rpy="0.0 1.5707963267948966 0.0"' in corrected_urdf(robot, values, [])


BAD = {
    "no link": (ARM, "bal", None, r"no link 'bal'; did you mean 'ball'\?"),
    "unknown base": (ARM, "ball", "wordl", "no link 'wordl'"),
    "base aside": (ARM, "one", "two", "'two' is not above 'one'"),
    "not XML": (ARM.replace("</robot>", ""), "ball", None, "line 3[0-9].*this is not XML"),
    "a bad number": (ARM.replace("0 0.3 0", "0 O.3 0"), "ball", None, "line 20, column 5: xyz is '0 O.3 0'"),
    "loop": (ARM.replace('<parent link="world"/>', '<parent link="ball"/>'), "ball", None, "line 10: .*close a loop"),
    "two above": (
        ARM.replace('<child link="flange"/>', '<child link="rail"/>'), "ball", None, "line 25: .*child of two joints"
    ),
    "no such parent": (ARM.replace('<parent link="two"/>', '<parent link="too"/>'), "ball", None, "line 19: .*'too'"),
    "planar": (ARM.replace('"continuous"', '"planar"'), "ball", None, "line 15: joint 'A2' is planar"),
    "document type": (ARM.replace("<!-- an arm -->", "<!DOCTYPE r [<!ENTITY a 'b'>]>"), "ball", None, "DOCTYPE"),
    "xacro": (ARM.replace("<!-- an arm -->", "").replace('<link name="two"/>', "<xacro:arm/>"), "ball", None, "xacro"),
    "zero axis": (ARM.replace("0 -1 0", "0 0 0"), "ball", None, "axis of joint 'A2' is zero"),
    "other": ("<html/>", "ball", None, "not <robot>"),
    "two links of a name": (ARM.replace('<link name="rail"/>', '<link name="two"/>'), "ball", None, "second link"),
    "limits reversed": (ARM.replace('lower="-2.9"', 'lower="3.9"'), "ball", None, "limits 3.9 to 2.9"),
    "an underscore in a vector": (ARM.replace('xyz="0 0.3 0"', 'xyz="0 0_0.3 0"'), "ball", None, "not three numbers"),
    "digits of another script": (ARM.replace('lower="-2.9"', 'lower="-\u0662"'), "ball", None, "lower is"),
    "beyond any length": (ARM.replace('xyz="0 0.3 0"', 'xyz="0 1e300 0"'), "ball", None, "not three numbers"),
    "two axes": (ARM.replace('<axis xyz="0 -1 0"/>', "<axis/><axis/>"), "ball", None, "second <axis>"),
    "no parent": (ARM.replace('<parent link="two"/>', ""), "ball", None, "has no <parent>"),
    "nothing moves": (ARM, "ball", "rail", "no joint between the base and 'ball' moves"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "tip", "base", "message"), BAD.values(), ids=BAD.keys())
def test_unusable_files_are_rejected_with_line_numbers(text: str, tip: str, base: str | None, message: str) -> None:
    with pytest.raises(UrdfError, match=message):
        urdf_robot(text, tip, base, 1000.0)


def test_a_tip_without_a_fixed_joint_of_its_own_is_not_written() -> None:
    robot = urdf_robot(ARM, "rail", None, 1000.0)
    values = np.zeros(len(robot.chain.parameters))
    values[-1] = 1.0
    with pytest.raises(UrdfError, match="no place"):
        corrected_urdf(robot, values, [])
