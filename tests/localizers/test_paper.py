"""The digits printed in the paper, with its misprints marked."""

import numpy as np
import pytest

from tactfix.localizers.axis_directions import direction_forms
from tactfix.localizers.cylinder import localize_cylinder
from tactfix.localizers.homogeneous_forms import product
from tactfix.localizers.sphere import localize_sphere
from tactfix.localizers.sphere_distances import AxisDistance, localize_sphere_at_distances

# Section 5.2: five points, rounded to six decimals, on a cylinder of radius 1 through (2, 2, 2).
BAR = np.array(
    [
        [2.927025, 2.0, 1.625],
        [1.775, 2.8, 1.443785],
        [1.372975, 2.6, 3.11662],
        [2.075, 3.4, 2.185405],
        [3.527025, 3.2, 3.10824],
    ]
)
BALL = np.array([[5.456074, 4.6, 2.543645], [5.981074, 4.4, 3.841479]])
ROUNDED = 1e-6

# Eq. 46 over x^3, x^2 y, x^2 z, x y^2, x y z, x z^2, y^3, y^2 z, y z^2, z^3 with z = 1.
EQ_46 = np.array(
    [-0.504446, 0.854990, 3.124352, 4.371015, 16.119020, -5.257678, -2.048000, -3.701228, 0.489010, -1.785361]
)
# Eq. 47 over x^2, x y, x z, y^2, y z, z^2.
EQ_47 = np.array([0.875140, -5.049719, -9.049719, 6.400000, 0.316760, 0.724860])


def test_section_4_2_both_centers():
    points = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0]])
    heights = sorted(c.surface.center[2] for c in localize_sphere(points, 2.0))
    assert heights == pytest.approx([-np.sqrt(3), np.sqrt(3)], abs=1e-14)


@pytest.mark.parametrize(("q", "falls"), [((-4, 1, 1), False), ((1, 1, -4), True)])
def test_section_4_2_eliminates_with_the_computed_direction(q, falls):
    # Misprint: q = (-4, 1, 1) is stated, eq. 15 computes with (1, 1, -4).
    upper = max(localize_sphere(np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0]]), 2.0), key=lambda c: c.surface.center[2])
    assert ((np.array([1.0, 0, 0]) - upper.surface.center) @ np.array(q) > 0) == falls


def test_eq_47_is_the_quadric_up_to_a_factor():
    quadric, _ = direction_forms(BAR)
    factor = EQ_47[3] / quadric[3]
    # The paper computed p4 squared and the determinants from rounded coordinates: six printed digits agree.
    assert quadric * factor == pytest.approx(EQ_47, abs=2e-5)


def test_eq_46_is_the_cubic_up_to_multiples_of_the_quadric():
    # The solver uses all five contacts in eq. 41, so its cubic is the printed one plus a linear form times eq. 47.
    quadric, cubic = direction_forms(BAR)
    basis = np.array([cubic, *(product(e, 1, quadric, 2) for e in np.eye(3))])
    weights, *_ = np.linalg.lstsq(basis.T, EQ_46, rcond=None)
    assert weights @ basis == pytest.approx(EQ_46, abs=2e-5)
    assert abs(weights[0]) > 0.1


def test_table_1():
    found = sorted((c.surface for c in localize_cylinder(BAR)), key=lambda s: s.radius)
    assert [s.radius for s in found] == pytest.approx([0.9165152, 1.0000002], abs=2e-7)
    wrong, right = found
    assert right.direction / right.direction[2] == pytest.approx([0.4045198, 0.8090397, 1], abs=1e-7)
    # Misprint: (-257.042261, -71.59786, 1) is printed; the printed points give this one in exact arithmetic.
    assert wrong.direction / wrong.direction[2] == pytest.approx([-257.0618786, -71.6031586, 1], abs=2e-5)
    assert np.linalg.norm(np.cross(right.point - [2, 2, 2], right.direction)) < 3e-7
    off = np.cross(wrong.point - [2.7512154, 2.6399998, 2.2570532], wrong.direction)
    assert np.linalg.norm(off) < 2e-7


def test_the_known_radius_leaves_one_of_them():
    (only,) = localize_cylinder(BAR, 1.0, ROUNDED)
    assert only.surface.direction / only.surface.direction[2] == pytest.approx(
        [0.3 / 0.74162, 0.6 / 0.74162, 1], abs=2e-6
    )


def test_section_6_centers_from_two_contacts_and_the_distance_to_the_axis():
    axis = AxisDistance(np.array([2.0, 2, 2]), np.array([0.3, 0.6, 0.74162]), 3.0)
    found = sorted(
        (c.surface.center for c in localize_sphere_at_distances(BALL, 1.0, (axis,), ROUNDED)), key=lambda c: c[1]
    )
    assert len(found) == 2
    assert found[0] == pytest.approx([5.681074, 3.8, 3.09986], abs=2e-6)
    assert found[1] == pytest.approx([5.600545, 5.180286, 3.345141], abs=2e-6)
