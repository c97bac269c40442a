"""Numbers and texts against reference vectors that were computed independently, in both directions."""

import json
from pathlib import Path

import numpy as np
import pytest

from tactfix.errors import PoseRefusedError
from tactfix.pose_formats import DIALECTS
from tactfix.pose_formats.convert import write_pose
from tactfix.pose_formats.pose import Pose, rigid_matrix

REFERENCE = json.loads((Path(__file__).parent / "data" / "pose_dialects.json").read_text())
NAMES = {
    "kuka": "kuka", "abb": "abb", "fanuc": "fanuc", "ur": "ur", "yaskawa": "yaskawa", "staubli": "staubli",
    "mecademic": "mecademic", "kawasaki": "kawasaki", "comau": "comau", "doosan": "doosan",
    "mitsubishi": "mitsubishi", "ros_quat": "ros-static", "ros_rpy": "urdf", "siemens_rpy": "siemens",
    "heidenhain_spatial": "heidenhain", "fanuc_cnc_g68_2": "g68.2", "linuxcnc_g10_l2": "g10",
}  # fmt: skip
CASES = [
    pytest.param(case, key, id=f"{NAMES[key]}-{case['name']}")
    for case in REFERENCE["cases"]
    for key in NAMES
    if case["values"][key] is not None
]


def pose_of(case):
    return Pose(rigid_matrix(case["T_mm"]), "mm")


@pytest.mark.parametrize(("case", "key"), CASES)
def test_numbers_are_those_of_the_vendor(case, key):
    dialect = DIALECTS[NAMES[key]]
    got = dialect.numbers.of(pose_of(case).in_units(dialect.units).base_from_fixture)
    np.testing.assert_allclose(got, case["values"][key], atol=1e-9, rtol=0)
    assert not np.any(np.signbit(got) & (got == 0)), "a negative zero"


@pytest.mark.parametrize(("case", "key"), CASES)
def test_text_is_that_of_the_vendor(case, key):
    assert case["text"][key] in write_pose(NAMES[key], pose_of(case)).text


@pytest.mark.parametrize(("case", "key"), CASES)
def test_text_of_the_vendor_is_read(case, key):
    dialect = DIALECTS[NAMES[key]]
    text = case["text"][key]
    if key == "heidenhain_spatial":  # rotation only; the origin is that of the preceding datum shift
        x, y, z = case["values"][key][:3]
        shift = f"CYCL DEF 7.1 X{x:+.4f}\nCYCL DEF 7.2 Y{y:+.4f}\nCYCL DEF 7.3 Z{z:+.4f}"
        text = f"CYCL DEF 7.0 DATUM SHIFT\n{shift}\n{text}"
    back = dialect.read(text).in_units("mm")
    length, angle = dialect.most_rounding
    unit = {"mm": 1.0, "m": 1000.0}[dialect.units]
    np.testing.assert_allclose(back.translation, np.array(case["T_mm"])[:3, 3], atol=1.01 * length * unit + 1e-12)
    np.testing.assert_allclose(back.rotation, np.array(case["T_mm"])[:3, :3], atol=1.01 * angle + 1e-12)


@pytest.mark.parametrize("case", [c for c in REFERENCE["cases"] if c["values"]["linuxcnc_g10_l2"] is None])
def test_g10_refuses_a_tilt(case):
    with pytest.raises(PoseRefusedError, match="tilt"):
        write_pose("g10", pose_of(case))


@pytest.mark.parametrize("case", REFERENCE["cases"], ids=lambda case: case["name"])
@pytest.mark.parametrize("name", ["matrix", "json", "yaml", "csv", "npy", "ros"])
def test_structured_texts_contain_the_pose(case, name):
    pose = pose_of(case)
    back = DIALECTS[name].read(write_pose(name, pose).text)
    ratio = 1000.0 if name == "ros" else 1.0
    np.testing.assert_allclose(back.rotation, pose.rotation, atol=1e-15 if name != "ros" else 1e-14)
    np.testing.assert_allclose(back.translation * ratio, pose.translation, atol=0, rtol=1e-15)
