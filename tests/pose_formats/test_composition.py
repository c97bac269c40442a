"""Inverse and composition of poses; a tilt that is not significant."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.cli.app import run
from tactfix.errors import PoseRefusedError, UsageError
from tactfix.pose_formats.convert import write_pose
from tactfix.pose_formats.pose import Pose, composed, inverted

RNG = np.random.default_rng(7)


def matrix(rotation, translation):
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = rotation.as_matrix(), translation
    return found


def some_pose(units="mm"):
    root = RNG.normal(size=(6, 6)) * np.repeat([1e-4, 0.02], 3)[:, None]
    return Pose(matrix(Rotation.from_quat(RNG.normal(size=4)), RNG.normal(size=3) * 300), units, root @ root.T)


def disturbed(pose, errors):
    """The pose with errors (d_rot, d_t) as defined for its covariance."""
    turned = Rotation.from_rotvec(errors[:3]) * Rotation.from_matrix(np.array(pose.rotation))
    return matrix(turned, pose.translation + errors[3:])


def errors_of(found, expected):
    turn = Rotation.from_matrix(found[:3, :3] @ expected[:3, :3].T).as_rotvec()
    return np.concatenate([turn, found[:3, 3] - expected[:3, 3]])


def sampled(pose, n=1500):
    return RNG.multivariate_normal(np.zeros(6), pose.covariance, size=n, method="eigh")


def assert_like(covariance, errors):
    sigma = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(
        np.cov(errors.T) / np.outer(sigma, sigma), covariance / np.outer(sigma, sigma), atol=0.15
    )


def test_an_inverse_is_one_and_its_covariance_is_that_of_sampled_inverses():
    pose = some_pose()
    back = inverted(pose)
    np.testing.assert_allclose(back.base_from_fixture @ pose.base_from_fixture, np.eye(4), atol=1e-10)
    np.testing.assert_allclose(inverted(back).covariance, pose.covariance, atol=1e-12)
    found = [errors_of(np.linalg.inv(disturbed(pose, e)), back.base_from_fixture) for e in sampled(pose)]
    assert_like(back.covariance, np.array(found))


def test_composed_poses_and_their_covariance():
    outer, inner = some_pose(), some_pose()
    both = composed(outer, inner)
    np.testing.assert_allclose(both.base_from_fixture, outer.base_from_fixture @ inner.base_from_fixture, atol=1e-10)
    pairs = zip(sampled(outer), sampled(inner), strict=True)
    found = [errors_of(disturbed(outer, a) @ disturbed(inner, b), both.base_from_fixture) for a, b in pairs]
    assert_like(both.covariance, np.array(found))


def test_units_are_reconciled_or_asked_for():
    outer, inner = some_pose("m"), some_pose("mm")
    expected = outer.in_units("mm").base_from_fixture @ inner.base_from_fixture
    np.testing.assert_allclose(composed(outer, inner).base_from_fixture, expected)
    with pytest.raises(UsageError, match="give units"):
        composed(Pose(np.eye(4), None), inner)


def test_convert_composes_a_new_offset_from_an_old_one(tmp_path, capsys):
    old, shift = tmp_path / "old.ngc", tmp_path / "shift.src"
    old.write_text("G10 L2 P1 X100 Y0 Z0 R90")
    shift.write_text("{X 1,Y 2,Z 3,A 10,B 0,C 0}")
    assert run(["convert", str(shift), "--on", str(old), "--to", "g10", "--quiet"]) == 0
    assert capsys.readouterr().out.endswith("G10 L2 P1 X98.0000 Y1.0000 Z3.0000 R100.0000\n")
    assert run(["convert", str(old), "--inverse", "--to", "g10", "--quiet"]) == 0
    assert capsys.readouterr().out.endswith("G10 L2 P1 X0.0000 Y100.0000 Z0.0000 R-90.0000\n")


@pytest.mark.parametrize(("of_sigma", "held"), [(1.0, True), (2.5, True), (3.5, False), (100.0, False)])
def test_an_insignificant_tilt_is_left_out_with_a_note(of_sigma, held):
    sigma = np.deg2rad(0.0064)
    tilted = matrix(Rotation.from_euler("z", 30, degrees=True), [10, 20, 30])
    tilted = matrix(Rotation.from_rotvec([of_sigma * sigma, 0, 0]), np.zeros(3)) @ tilted
    pose = Pose(tilted, "mm", np.diag([sigma**2] * 3 + [0.01] * 3))
    if held:
        written = write_pose("g10", pose)
        assert "leaves out a tilt" in written.notes[0]
        assert written.text.splitlines()[-1].endswith("R30.0000")
    else:
        with pytest.raises(PoseRefusedError, match="tilt"):
            write_pose("g10", pose)
    with pytest.raises(PoseRefusedError, match="tilt"):
        write_pose("g10", Pose(tilted, "mm"))
