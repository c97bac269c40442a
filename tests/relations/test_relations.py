"""Distances and angles for every pair of types: residuals that vanish or not, and derivatives by differences."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.geometry.charts import displaced
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, moved
from tactfix.relations.branches import nearest_branch
from tactfix.relations.equations import carried, columns_of, equation, linear_equations
from tactfix.relations.parallels import parallel_pairs
from tests.support.problems import angle, distance, random_pose, rotation

UP, EAST = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])


def leaning(degrees):
    return Rotation.from_euler("y", degrees, degrees=True).apply(UP)


def ball(x, y, z):
    return Sphere([x, y, z], 2.0)


def bar(point, direction=UP):
    return Cylinder(point, direction, 2.0)


def missing_to(relation, one, other, parallel=False):
    """The residuals of the branch that is nearest to the two surfaces."""
    pair = dict(zip(relation.between, (one, other), strict=True))
    if parallel:
        return equation(relation, pair, 1.0, parallel=True).linear(pair)[0]
    return nearest_branch((relation,), pair)[0].linear(pair)[0]


HOLDING = {
    "sphere-sphere": (distance("a", "b", 5.0), ball(1, 1, 1), ball(4, 5, 1)),
    "concentric": (distance("a", "b", 0.0), ball(1, 2, 3), ball(1, 2, 3)),
    "sphere-cylinder": (distance("a", "b", 5.0), ball(3, 4, 70), bar([0, 0, 0])),
    "cylinder-sphere": (distance("a", "b", 5.0), bar([0, 0, 9]), ball(3, 4, 70)),
    "centre on axis": (distance("a", "b", 0.0), ball(0, 0, 70), bar([0, 0, 0])),
    "skew axes": (distance("a", "b", 7.0), bar([0, 0, 0]), bar([20, 7, 30], EAST)),
    "meeting axes": (distance("a", "b", 0.0), bar([0, 0, 0]), bar([20, 0, 30], EAST)),
    "parallel axes": (distance("a", "b", 5.0), bar([0, 0, 0]), bar([3, 4, 30])),
    "coaxial": (distance("a", "b", 0.0), bar([0, 0, 0]), bar([0, 0, 30])),
    "sphere above plane": (distance("a", "b", 4.0), Plane([9, 9, 1], UP), ball(1, 2, 5)),
    "sphere below plane": (distance("b", "a", -4.0), Plane([9, 9, 1], UP), ball(1, 2, -3)),
    "centre in plane": (distance("a", "b", 0.0), Plane([9, 9, 1], UP), ball(1, 2, 1)),
    "step up": (distance("a", "b", 6.0), Plane([9, 9, 1], UP), Plane([1, 2, 7], UP)),
    "step down": (distance("a", "b", 6.0), Plane([9, 9, 7], UP), Plane([1, 2, 1], UP)),
    "slab": (distance("a", "b", 6.0), Plane([9, 9, 7], UP), Plane([1, 2, 1], -UP)),
    "slot": (distance("a", "b", 6.0), Plane([9, 9, 1], UP), Plane([1, 2, 7], -UP)),
    "one plane": (distance("a", "b", 0.0), Plane([9, 9, 1], UP), Plane([1, 2, 1], UP)),
    "axis above plane": (distance("a", "b", 6.0), bar([9, 9, 7], EAST), Plane([1, 2, 1], UP)),
    "axis below plane": (distance("a", "b", 6.0), Plane([1, 2, 1], UP), bar([9, 9, -5], EAST)),
    "planes at 90": (angle("a", "b", 90), Plane([0, 0, 0], UP), Plane([5, 5, 5], EAST)),
    "planes at 60": (angle("a", "b", 60), Plane([0, 0, 0], UP), Plane([5, 5, 5], leaning(60))),
    "planes at 120": (angle("a", "b", 120), Plane([0, 0, 0], UP), Plane([5, 5, 5], leaning(-120))),
    "planes at 0": (angle("a", "b", 0), Plane([0, 0, 0], UP), Plane([5, 5, 5], UP)),
    "planes at 180": (angle("a", "b", 180), Plane([0, 0, 0], UP), Plane([5, 5, 5], -UP)),
    "planes at 0.5": (angle("a", "b", 0.5), Plane([0, 0, 0], UP), Plane([5, 5, 5], leaning(0.5))),
    "axes at 60": (angle("a", "b", 60), bar([0, 0, 0]), bar([5, 5, 5], leaning(60))),
    "axes at 60, turned round": (angle("a", "b", 60), bar([0, 0, 0]), bar([5, 5, 5], leaning(120))),
    "axes at 90": (angle("a", "b", 90), bar([0, 0, 0]), bar([5, 5, 5], EAST)),
    "axes at 0": (angle("a", "b", 0), bar([0, 0, 0]), bar([5, 5, 5], -UP)),
    "axis and plane at 0": (angle("a", "b", 0), bar([0, 0, 0]), Plane([5, 5, 5], -UP)),
    "axis and plane at 30": (angle("a", "b", 30), Plane([5, 5, 5], UP), bar([0, 0, 0], leaning(150))),
    "axis in plane": (angle("a", "b", 90), Plane([5, 5, 5], UP), bar([0, 0, 0], EAST)),
}


@pytest.mark.parametrize("name", HOLDING)
def test_residuals_vanish_where_the_relation_holds_in_any_pose(name):
    relation, one, other = HOLDING[name]
    pair = {"a": one, "b": other}
    for pose in [np.eye(4), random_pose(np.random.default_rng(1)), random_pose(np.random.default_rng(2))]:
        placed = {n: moved(pose, s) for n, s in pair.items()}
        missing = missing_to(relation, *(placed[n] for n in relation.between))
        np.testing.assert_allclose(missing, 0.0, atol=1e-11 if np.array_equal(pose, np.eye(4)) else 1e-9)


def shaken(surface, rng, size):
    """The surface slightly moved and tilted."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec(size * rng.normal(size=3)).as_matrix()
    pose[:3, 3] = size * rng.normal(size=3)
    return moved(pose, surface)


@pytest.mark.parametrize("name", HOLDING)
@pytest.mark.parametrize("size", [1e-4, 0.2])
def test_gradients_against_differences(name, size):
    """Where the relation holds and far from it, including residuals with several components."""
    relation, one, other = HOLDING[name]
    rng = np.random.default_rng(7)
    for _ in range(4):
        pair = {"a": shaken(one, rng, size), "b": shaken(other, rng, size)}
        branch = nearest_branch((relation,), pair)[0]
        columns, _ = columns_of(pair)
        ((_, found),) = linear_equations([branch], pair)
        for n, surface in pair.items():
            for k in range(columns[n].start, columns[n].stop):
                step = np.zeros(columns[n].stop - columns[n].start)
                step[k - columns[n].start] = 1e-6
                ahead, behind = ({**pair, n: displaced(surface, s)} for s in (step, -step))
                values = [branch.linear(moved_pair)[0] for moved_pair in (ahead, behind)]
                np.testing.assert_allclose(found[:, k], (values[0] - values[1]) / 2e-6, atol=2e-5, err_msg=f"{n} {k}")


@pytest.mark.parametrize("degrees", [1.0, 10.0, 90.0, 179.0, 180.0])
def test_residuals_of_unequal_normals_are_their_angle(degrees):
    missing = missing_to(angle("a", "b", 0), Plane([0, 0, 0], UP), Plane([0, 0, 0], leaning(degrees)))
    assert np.linalg.norm(missing) == pytest.approx(np.radians(degrees))
    missing = missing_to(angle("a", "b", 180), Plane([0, 0, 0], UP), Plane([0, 0, 0], leaning(180 - degrees)))
    assert np.linalg.norm(missing) == pytest.approx(np.radians(degrees))


@pytest.mark.parametrize("degrees", [1e-6, 1e-4, 1e-2, 0.3])
def test_spacing_of_pins_that_noise_has_made_not_quite_parallel(degrees):
    """The common perpendicular of such axes may be anywhere, and of any length below the spacing."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        tilt = Rotation.from_rotvec(np.radians(degrees) * np.cross(UP, rotation(rng)[0])).apply(UP)
        missing = missing_to(distance("a", "b", 40.0), bar([0, 0, 0]), bar([40, 0, 0], tilt))
        assert abs(missing[0]) < 0.01


def test_residuals_of_violated_distances_are_the_difference():
    assert missing_to(distance("a", "b", 5.0), ball(0, 0, 0), ball(0, 0, 6)) == pytest.approx([1.0])
    assert missing_to(distance("a", "b", 5.0), Plane([0, 0, 0], UP), ball(0, 0, -5)) == pytest.approx([-10.0])
    assert np.linalg.norm(missing_to(distance("a", "b", 0.0), ball(0, 0, 0), ball(1, 2, 2))) == pytest.approx(3)
    assert np.linalg.norm(missing_to(distance("a", "b", 0.0), bar([0, 0, 0]), ball(3, 4, 9))) == pytest.approx(5)
    assert np.linalg.norm(missing_to(distance("a", "b", 0.0), bar([0, 0, 0]), bar([3, 4, 9]))) == pytest.approx(5)


def test_features_are_parallel_if_other_relations_imply_it():
    relations = (angle("plate", "one", 0), angle("two", "plate", 0), angle("slope", "plate", 30), angle("x", "y", 180))
    assert parallel_pairs(relations) == {
        frozenset(pair) for pair in (("plate", "one"), ("plate", "two"), ("one", "two"), ("x", "y"))
    }


def test_axes_known_to_be_parallel_have_a_spacing_while_they_are_not_yet():
    tilted = bar([40, 0, 0], leaning(20))
    assert abs(missing_to(distance("a", "b", 40.0), bar([0, 0, 0]), tilted, parallel=True)[0]) < 3
    assert np.linalg.norm(missing_to(distance("a", "b", 0.0), bar([0, 0, 0]), tilted, parallel=True)) > 35


ALONG_THE_AXES = [UP, EAST, np.array([0.0, 1.0, 0.0]), -UP]


@pytest.mark.parametrize("axis", ALONG_THE_AXES)
@pytest.mark.parametrize("relation", [angle("a", "b", 0), distance("a", "b", 0.0)], ids=["parallel", "coaxial"])
def test_residuals_are_smooth_where_basis_vectors_switch(axis, relation):
    """The basis perpendicular to a direction along a coordinate axis may be chosen in two ways."""
    one, other = bar([1, 2, 3], axis), bar([1.01, 2.01, 3], axis + 1e-3 * np.roll(axis, 1))
    branch = nearest_branch((relation,), {"a": one, "b": other})[0]
    values = []
    for tilt in np.linspace(-1e-6, 1e-6, 9):
        for around in (np.roll(axis, 1), np.roll(axis, 2)):
            pair = {"a": bar([1, 2, 3], axis + tilt * around), "b": other}
            values.append(carried(branch, pair).linear(pair)[0])
    assert np.ptp(np.array(values), axis=0).max() < 5e-5


@pytest.mark.parametrize("degrees", [89.9, 89.99, 90.0, 90.01])
def test_an_angle_near_90_runs_on_beyond_it(degrees):
    """The residual belongs to one of the two senses of an axis: it has no fold where the other sense begins."""
    relation = angle("a", "b", 89.95)
    pair = {"a": bar([0, 0, 0]), "b": bar([5, 5, 5], leaning(89.94))}
    branch = nearest_branch((relation,), pair)[0]
    (missing,) = branch.linear({**pair, "b": bar([5, 5, 5], leaning(degrees))})[0]
    assert missing == pytest.approx(np.radians(degrees - 89.95), abs=1e-12)
