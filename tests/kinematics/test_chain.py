"""Kinematic chains against closed forms and an independent forward kinematics by scipy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.geometry.arrays import Floats
from tactfix.kinematics.chain import Chain, Joint
from tactfix.kinematics.denavit_hartenberg import Convention, Row, chain_of_rows, corrected_rows
from tactfix.kinematics.link import Link, axis_frame, chain_of_links


def placed(xyz: tuple[float, float, float], rpy: tuple[float, float, float] = (0, 0, 0)) -> Floats:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = Rotation.from_euler("xyz", rpy).as_matrix(), xyz
    return matrix


def row_matrix(row: Row, convention: Convention, q: float) -> Floats:
    """The transformation of a Denavit-Hartenberg row as printed in textbooks, from its four parameters."""
    prismatic = row.joint is not None and row.joint.is_prismatic
    theta, d = (row.theta, row.d + q) if prismatic else (row.theta + q, row.d)
    ct, st, ca, sa = np.cos(theta), np.sin(theta), np.cos(row.alpha), np.sin(row.alpha)
    if convention == "standard":
        return np.array(
            [[ct, -st * ca, st * sa, row.a * ct], [st, ct * ca, -ct * sa, row.a * st], [0, sa, ca, d], [0, 0, 0, 1]]
        )
    return np.array(
        [[ct, -st, 0, row.a], [st * ca, ct * ca, -sa, -sa * d], [st * sa, ct * sa, ca, ca * d], [0, 0, 0, 1]]
    )


ROWS = (
    Row(25.0, 400.0, -np.pi / 2, 0.1, 0.0, Joint("1")),
    Row(455.0, 3.0, 0.0, -np.pi / 2, 0.0, Joint("2")),
    Row(35.0, 0.0, np.pi / 2, 0.0, 0.0, Joint("3")),
    Row(0.0, 60.0, 0.3, 0.2, 0.0, Joint("4", is_prismatic=True)),
    Row(0.0, 80.0, np.pi, 0.0, 0.0, Joint("5")),
)
CONFIGURATIONS = np.random.default_rng(3).uniform(-1.5, 1.5, (7, 5))


def skew_links(axes: Floats) -> list[Link]:
    rng = np.random.default_rng(5)
    return [
        Link(placed(tuple(rng.uniform(-300, 300, 3)), tuple(rng.uniform(-2, 2, 3))), axis, Joint(str(k), k == 2))
        for k, axis in enumerate(axes)
    ]


CHAINS = {
    "links along axes": chain_of_links(skew_links(np.array([[0, 0, 1], [0, -1, 0], [1, 0, 0.0]])), placed((1, 2, 3))),
    "oblique links": chain_of_links(skew_links(np.array([[1, 2, 3], [0, 1, 1], [-1, 0, 2.0]])), placed((9, 0, 50))),
    "standard rows": chain_of_rows(ROWS, "standard", placed((3, 4, 120))),
    "modified rows": chain_of_rows(ROWS, "modified", placed((3, 4, 120))),
}


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_rows_are_those_of_the_textbooks(convention: Convention) -> None:
    chain = CHAINS[f"{convention} rows"]
    nominal = np.zeros(len(chain.parameters))
    for q, tip, frame in zip(
        CONFIGURATIONS, chain.points(CONFIGURATIONS, nominal), chain.base_from_tip(CONFIGURATIONS, nominal), strict=True
    ):
        expected = np.eye(4)
        for row, amount in zip(ROWS, q, strict=True):
            expected = expected @ row_matrix(row, convention, amount)
        expected = expected @ placed((3, 4, 120))
        assert tip == pytest.approx(expected[:3, 3], abs=1e-9)
        assert frame == pytest.approx(expected, abs=1e-9)


def test_a_planar_arm_with_errors_is_the_closed_form() -> None:
    links = [Link(np.eye(4), np.eye(3)[2], Joint("1")), Link(placed((300, 0, 0)), np.eye(3)[2], Joint("2"))]
    chain = chain_of_links(links, placed((200, 0, 0)))
    values = np.zeros(len(chain.parameters))
    by_name = dict(zip(chain.names(), range(len(values)), strict=True))
    for name, value in {"joint_1.offset": 0.1, "joint_2.offset": -0.2, "joint_2.x": 5.0, "tip.y": 7.0}.items():
        values[by_name[name]] = value
    a, b = 0.4 + 0.1, 0.4 + 0.1 + 1.1 - 0.2
    x = 305 * np.cos(a) + 200 * np.cos(b) - 7 * np.sin(b)
    y = 305 * np.sin(a) + 200 * np.sin(b) + 7 * np.cos(b)
    assert chain.points(np.array([[0.4, 1.1]]), values)[0] == pytest.approx([x, y, 0], abs=1e-9)


@pytest.mark.parametrize("chain", CHAINS.values(), ids=CHAINS.keys())
@pytest.mark.parametrize("size", [0.0, 0.05], ids=["nominal", "with errors"])
def test_the_jacobian_is_that_of_differences(chain: Chain, size: float) -> None:
    q = CONFIGURATIONS[:, : len(chain.joints)]
    values = size * np.random.default_rng(7).normal(size=len(chain.parameters))
    motion = chain.tip(q, values)
    step = 1e-6
    differences = [
        (chain.points(q, values + step * e) - chain.points(q, values - step * e)) / (2 * step)
        for e in np.eye(len(values))
    ]
    assert motion.points == pytest.approx(chain.points(q, values), abs=1e-9)
    assert np.abs(motion.jacobian - np.stack(differences, axis=-1)).max() < 1e-5


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_corrected_rows_are_the_robot_with_its_errors(convention: Convention) -> None:
    chain = CHAINS[f"{convention} rows"]
    values = 0.01 * np.random.default_rng(8).normal(size=len(chain.parameters))
    values[-3:] = 0.0
    again = chain_of_rows(corrected_rows(ROWS, convention, chain, values), convention, placed((3, 4, 120)))
    moved = again.points(CONFIGURATIONS, np.zeros(len(again.parameters)))
    assert moved == pytest.approx(chain.points(CONFIGURATIONS, values), abs=1e-9)


def test_only_parallel_axes_have_beta() -> None:
    names = CHAINS["standard rows"].names()
    assert [name for name in names if name.endswith("beta")] == ["joint_2.beta", "joint_5.beta"]


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0], [0.6, 0, 0.8], [-0.48, 0.6, 0.64]])
def test_the_axis_frame_is_a_rotation_with_the_axis_third(axis: list[float]) -> None:
    frame = axis_frame(np.array(axis, dtype=float))
    assert frame[:, 2] == pytest.approx(axis)
    assert frame.T @ frame == pytest.approx(np.eye(3))
    assert np.linalg.det(frame) == pytest.approx(1.0)


@pytest.mark.parametrize("chain", CHAINS.values(), ids=CHAINS)
def test_joints_may_be_none_and_of_any_number_type(chain: Chain) -> None:
    values = np.zeros(len(chain.parameters))
    assert chain.points(np.zeros((0, len(chain.joints))), values).shape == (0, 3)
    ones = np.ones((2, len(chain.joints)))
    for kind in (np.int64, np.float32):
        np.testing.assert_array_equal(chain.points(ones.astype(kind), values.astype(kind)), chain.points(ones, values))
