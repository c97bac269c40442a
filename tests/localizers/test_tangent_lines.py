"""Lines at given distances from four points."""

import numpy as np
import pytest

from tactfix.errors import DegenerateContactsError
from tests.support.common_tangents import tangent_lines
from tests.support.touched_surfaces import AXES, random_rotation, ring, turned_to


def _distances(points, directions, centers):
    arm = centers - points[:, None]
    return np.linalg.norm(np.cross(arm, np.broadcast_to(directions[:, None], arm.shape)), axis=-1)


def _nearest(points, directions, point, direction):
    tilt = np.linalg.norm(np.cross(directions, direction), axis=1)
    return np.min(np.maximum(tilt, np.linalg.norm(np.cross(points - point, direction), axis=1)))


@pytest.mark.parametrize("flatness", [1.0, 1e-2, 1e-5, 1e-9, 0.0])
@pytest.mark.parametrize("equal", [True, False])
def test_truth_is_among_the_lines_and_each_keeps_the_distances(flatness, equal):
    # Nearly coplanar centres are common contacts; the usual two equations are singular there.
    rng = np.random.default_rng(5)
    for _ in range(20):
        rotation, place = random_rotation(rng), rng.normal(size=3)
        direction = rotation @ np.array([0.3, 0.5, 0.8])
        direction /= np.linalg.norm(direction)
        centers = (rng.normal(size=(4, 3)) * [1, 1, flatness]) @ rotation.T + place
        if equal:
            across = turned_to(direction)[:, :2]
            flat = ring(rng.uniform(0, 360, 4))[:, :2]
            normal = rotation[:, 2]
            # Points on a cylinder of radius 1, in the plane perpendicular to normal except for flatness.
            centers = flat @ across.T
            centers += np.outer((flatness * rng.normal(size=4) - centers @ normal) / (direction @ normal), direction)
            centers += place
        radii = np.linalg.norm(np.cross(centers - place, direction), axis=1)
        points, directions = tangent_lines(centers, radii)
        assert len(points) <= 12
        assert _nearest(points, directions, place, direction) < 1e-6
        assert np.abs(_distances(points, directions, centers) - radii).max() < 1e-12


LAYOUTS = {
    "rectangle": np.vstack([ring([0, 80], -1), ring([0, 80], 1)]),
    "square on a circle": ring([0, 90, 180, 270]),
    "three in line and one": np.vstack([ring([0], -1), ring([0], 0), ring([0], 1.5), ring([130], 0.2)]),
    "two and two": np.vstack([ring([0, 180], -0.5), ring([90, 270], 0.5)]),
    "three and one": np.vstack([ring([0, 120, 240], 0), ring([60], 1)]),
    "one side": np.vstack([ring([-40, 40], -1), ring([-40, 40], 1)]),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_tidy_layouts_from_every_side(layout):
    counts = set()
    for axis in AXES:
        centers = LAYOUTS[layout] @ turned_to(axis).T
        points, directions = tangent_lines(centers, np.ones(4), 1e-12)
        counts.add(len(points))
        assert _nearest(points, directions, np.zeros(3), axis / np.linalg.norm(axis)) < 1e-3
    assert len(counts) == 1


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_unit_does_not_matter(scale):
    rng = np.random.default_rng(1)
    centers, radii = rng.normal(size=(4, 3)), rng.uniform(0.5, 1, 4)
    points, directions = tangent_lines(centers, radii)
    scaled, turned = tangent_lines(centers * scale, radii * scale)
    assert len(points) == len(scaled)
    for p, d in zip(points, directions, strict=True):
        assert _nearest(scaled / scale, turned, p, d) < 1e-8


def test_no_line_found_by_newton_from_many_starts_is_missed():
    rng = np.random.default_rng(2)
    met = []
    for _ in range(6):
        centers, radii = rng.normal(size=(4, 3)), rng.uniform(0.6, 1.2, 4)
        points, directions = tangent_lines(centers, radii)
        places, along = _newton(rng, centers, radii)
        assert all(_nearest(points, directions, p, d) < 1e-6 for p, d in zip(places, along, strict=True))
        met.append(len(places))
    # Some sets of four spheres have no common tangent; those of the others are found from most of the 300 starts.
    assert sum(count > 50 for count in met) >= 3


def _newton(rng, centers, radii):
    """Newton's method on (a, s) with |s|^2 = 1 and a . s = 0 from 300 starts, with derivatives by complex steps."""

    def equations(x):
        a, s = x[..., None, :3], x[..., None, 3:]
        moments = np.cross(centers - a, s)
        square = np.sum(s * s, axis=-1)
        return np.concatenate([np.sum(moments**2, axis=-1) - radii**2 * square, square - 1, np.sum(a * s, -1)], axis=-1)

    x = rng.normal(size=(300, 6))
    for _ in range(40):
        jacobian = np.swapaxes(equations(x[:, None] + 1e-30j * np.eye(6)).imag / 1e-30, 1, 2)
        x = x - np.einsum("bij,bj->bi", np.linalg.pinv(jacobian), equations(x))
        x = x[np.abs(x).max(axis=1) < 1e6]
    roots = x[np.abs(equations(x)).max(axis=1) < 1e-12]
    return roots[:, :3], roots[:, 3:]


def test_refusals_and_empty():
    with pytest.raises(DegenerateContactsError, match="one straight line"):
        tangent_lines(np.array([[0.0, 0, 0], [0, 0, 1], [0, 0, 2], [0, 0, 4]]), np.ones(4))
    points, _ = tangent_lines(100 * np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]), np.ones(4))
    assert len(points) == 0
