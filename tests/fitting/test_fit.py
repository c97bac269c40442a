"""The fit of one feature: status, reasons, sides, tips and sigmas."""

import numpy as np
import pytest

from tactfix.contacts import Contacts
from tactfix.errors import TipDoesNotFitError, UsageError
from tactfix.fitting.fit import fit
from tests.support.touched_surfaces import axis_error, on_cylinder, on_sphere, random_rotation, ring


def _contacts(points, approaches=None, sigma=1e-4, tip=0.0):
    n = len(points)
    approaches = np.full((n, 3), np.nan) if approaches is None else np.asarray(approaches, float)
    lengths = np.linalg.norm(approaches, axis=1, keepdims=True)
    return Contacts(
        ("part",) * n,
        np.asarray(points, float),
        approaches / lengths,
        np.full(n, sigma),
        tip,
        tuple(range(1, n + 1)),
        (None,) * n,
    )


def _bar(rng, n, radius, tip=0.0, side="outer", noise=0.0):
    """Tip centres on a bar or bore along z through the origin, approached along the normal."""
    surface = on_cylinder(rng, n, radius, 4 * radius)
    outward = surface * [1, 1, 0] / radius * (1 if side == "outer" else -1)
    return surface + (tip + noise * rng.normal(size=(n, 1))) * outward, -outward


@pytest.mark.parametrize("side", ["outer", "inner"])
@pytest.mark.parametrize("radius", [6.0, None])
def test_bar_and_bore_with_a_tip(side, radius):
    rng = np.random.default_rng(1)
    points, approaches = _bar(rng, 9, 6.0, 1.5, side, 1e-4)
    result = fit("cylinder", _contacts(points, approaches, tip=1.5), radius, side)
    assert result.status == "located"
    assert result.surface.side == side
    assert axis_error(result.surface, np.zeros(3), [0, 0, 1], 6.0) < 1e-3
    assert result.chi2 <= result.chi2_limit
    assert result.dof == (5 if radius else 4)
    assert result.rms == pytest.approx(np.sqrt(np.mean(result.residuals**2)), rel=1e-6)
    assert (result.sigma["radius"][0] == 0) == (radius is not None)


@pytest.mark.parametrize("side", ["outer", "inner"])
@pytest.mark.parametrize("radius", [6.0, None])
def test_the_side_that_would_fit_is_named(side, radius):
    points, approaches = _bar(np.random.default_rng(1), 9, 6.0, 1.5, side, 1e-4)
    wrong = "inner" if side == "outer" else "outer"
    result = fit("cylinder", _contacts(points, approaches, tip=1.5), radius, wrong)
    assert result.status == "inconsistent"
    assert any(text.startswith(f"the {side} side would fit") for text in result.warnings)


@pytest.mark.parametrize("radius", [1.0, None])
def test_no_side_is_proposed_if_neither_fits(radius):
    """One approach from inside among others from outside; a tip of 1.5, which does not fit into a bore of radius 1."""
    points, approaches = _bar(np.random.default_rng(1), 9, 6.0, 1.5, "outer", 1e-4)
    approaches[4] *= -1
    result = fit("cylinder", _contacts(points, approaches, tip=1.5), radius, "outer")
    assert result.status == "inconsistent"
    assert not any("--side" in text for text in result.warnings)


def test_residuals_are_positive_out_of_the_material():
    rng = np.random.default_rng(2)
    for side in ("outer", "inner"):
        points, approaches = _bar(rng, 12, 5.0, 1.0, side)
        points[3] -= 0.05 * approaches[3]
        result = fit("cylinder", _contacts(points, approaches, 0.05, 1.0), 5.0, side)
        assert np.argmax(result.residuals) == 3


@pytest.mark.parametrize("side", ["outer", "inner"])
def test_sphere_of_three_contacts_needs_the_approach(side):
    center = np.array([1.0, 2, 3])
    sign = 1 if side == "outer" else -1
    # Near one pole: for contacts near a great circle, approaches along the normals do not distinguish the mirror image.
    surface = center + 5.0 * np.array([[0.28, 0, 0.96], [-0.28, 0, 0.96], [0, 0.6, 0.8]])
    outward = sign * (surface - center) / 5.0
    points = surface + 1.0 * outward
    ambiguous = fit("sphere", _contacts(points, tip=1.0), 5.0, side)
    assert ambiguous.status == "ambiguous"
    assert sum(c.accepted for c in ambiguous.candidates) == 2
    assert ambiguous.surface is None
    located = fit("sphere", _contacts(points, -outward, tip=1.0), 5.0, side)
    assert located.status == "located"
    assert located.surface.center == pytest.approx(center, abs=1e-9)
    (fallen,) = [c for c in located.candidates if not c.accepted]
    assert {r.code for r in fallen.reasons} == {"approach"}
    assert {r.row for r in fallen.reasons} <= {1, 2, 3}


def test_plane_side_follows_from_the_approach_and_the_tip_stays_outside():
    points = np.array([[0.0, 0, 1], [1, 0, 1], [0, 1, 1]])
    result = fit("plane", _contacts(points, [[0, 0, -1]] * 3, tip=0.25))
    assert result.surface.normal == pytest.approx([0, 0, 1])
    assert result.surface.point[2] == pytest.approx(0.75)
    below = fit("plane", _contacts(points, [[0, 0.3, 1]] * 3, tip=0.25))
    assert below.surface.normal == pytest.approx([0, 0, -1])
    assert below.surface.point[2] == pytest.approx(1.25)
    assert fit("plane", _contacts(points)).status == "ambiguous"
    grazing = fit("plane", _contacts(points, [[1, 0, 0]] * 3))
    assert grazing.status == "ambiguous"
    assert any("grazes" in w for w in grazing.warnings)


def test_table_1_names_the_cylinder_that_the_radius_excludes():
    points = [
        [2.927025, 2, 1.625],
        [1.775, 2.8, 1.443785],
        [1.372975, 2.6, 3.11662],
        [2.075, 3.4, 2.185405],
        [3.527025, 3.2, 3.10824],
    ]
    result = fit("cylinder", _contacts(points, sigma=2e-6), 1.0)
    assert result.status == "located"
    (fallen,) = [c for c in result.candidates if not c.accepted]
    assert [r.code for r in fallen.reasons] == ["fit"]
    assert "0.9165" in fallen.reasons[0].message


def test_too_few_and_degenerate_contacts_are_underdetermined():
    few = fit("cylinder", _contacts(ring([0, 90, 200, 300], 1.0)))
    assert few.status == "underdetermined"
    assert "1 more needed" in few.warnings[0]
    line = fit("cylinder", _contacts([[0, 0, z] for z in range(6)]))
    assert line.status == "underdetermined"
    assert "straight line" in line.warnings[0]


def test_a_surface_that_noise_leaves_open_is_underdetermined():
    # Six contacts on two lines five degrees apart: the radius is undetermined at this sigma.
    points = np.vstack([ring([0, 5], z) for z in (-1, 0, 1)]) + 1e-4 * np.eye(6)[:, :3]
    result = fit("cylinder", _contacts(points, sigma=1e-3))
    assert result.status == "underdetermined"
    assert result.surface is None


def test_contradiction_is_inconsistent_and_names_a_contact():
    rng = np.random.default_rng(4)
    points, approaches = _bar(rng, 10, 5.0)
    points[6] -= 0.4 * approaches[6]
    result = fit("cylinder", _contacts(points, approaches), 5.0)
    assert result.status == "inconsistent"
    assert result.candidates[0].reasons[0].code == "fit"
    assert result.candidates[0].reasons[0].row == 7
    assert fit("sphere", _contacts([[0, 0, 0], [90, 0, 0], [0, 90, 0]]), 1.0).status == "inconsistent"


def test_a_double_root_is_located_once_with_a_warning_and_a_large_sigma():
    angle = np.array([0.0, 2, 4])
    points = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(3)])
    for radius in (1.0, 1.0 + 1e-9, 1.0 - 1e-5):
        result = fit("sphere", _contacts(points, sigma=1e-5), radius)
        assert result.status == "located"
        assert any("double root" in w for w in result.warnings)
        # At sqrt(2 sigma radius) off the plane the residual is sigma.
        assert result.sigma["center"][2] == pytest.approx(np.sqrt(2e-5), rel=0.5)


def test_invalid_input():
    points, approaches = _bar(np.random.default_rng(5), 8, 2.0, -3.0, "inner")
    with pytest.raises(TipDoesNotFitError):
        fit("cylinder", _contacts(points, approaches, tip=3.0), 2.0, "inner")
    with pytest.raises(UsageError):
        fit("plane", _contacts(points), 1.0)
    # A fitted sphere of tip centres smaller than the tip: the ball's radius would be negative.
    small = fit("sphere", _contacts(on_sphere(np.random.default_rng(6), 8, radius=2.0), tip=3.0))
    assert small.status == "inconsistent"
    assert "tip of radius 3" in small.candidates[0].reasons[0].message


def _touched(kind, rng):
    """A rotation, and contacts with outward normals on a surface rotated by it."""
    rotation = random_rotation(rng)
    exact = {
        "plane": rng.normal(size=(7, 3)) * [3, 2, 0],
        "sphere": on_sphere(rng, 8, radius=5.0),
        "cylinder": on_cylinder(rng, 10, 5.0, 20.0),
    }
    normals = {
        "plane": np.tile([0, 0, 1.0], (7, 1)),
        "sphere": exact["sphere"] / 5,
        "cylinder": exact["cylinder"] * [1, 1, 0] / 5,
    }
    return rotation, exact[kind] @ rotation.T, normals[kind] @ rotation.T


def _fitted(kind, rotation, points, normals):
    """The parameters of the best surface, and their sigmas."""
    result = fit(kind, _contacts(points, -normals, 0.01), None)
    assert result.status == "located"
    surface, sigmas = result.surface, np.concatenate(list(result.sigma.values()))
    if kind == "cylinder":
        turned = surface.direction * np.sign(surface.direction @ rotation[:, 2])
        return np.array([*surface.point, *turned, surface.radius]), sigmas
    if kind == "plane":
        return np.array([*surface.point, *surface.normal]), sigmas
    return np.array([*surface.center, surface.radius]), sigmas


KINDS = ["plane", "sphere", "cylinder"]


@pytest.mark.parametrize("kind", KINDS)
def test_sigma_is_what_a_sigma_of_each_contact_does(kind):
    """One contact at a time is moved by a sigma to either side; the effects add in quadrature."""
    rotation, exact, normals = _touched(kind, np.random.default_rng(7))
    effects = []
    for step in 0.01 * np.eye(len(exact))[:, :, None]:
        ahead, behind = (_fitted(kind, rotation, exact + off * normals, normals)[0] for off in (step, -step))
        effects.append((ahead - behind) / 2)
    sigmas = _fitted(kind, rotation, exact, normals)[1]
    assert sigmas == pytest.approx(np.linalg.norm(effects, axis=0), rel=1e-2)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_sigma_agrees_with_monte_carlo(kind):
    rng = np.random.default_rng(7)
    rotation, exact, normals = _touched(kind, rng)
    noise = rng.normal(scale=0.01, size=(300, len(exact), 1))
    numbers, sigmas = zip(*(_fitted(kind, rotation, exact + off * normals, normals) for off in noise), strict=True)
    assert sigmas[-1] == pytest.approx(np.std(numbers, axis=0), rel=0.25)


def test_unit_of_length_does_not_matter():
    rng = np.random.default_rng(8)
    points, approaches = _bar(rng, 7, 5.0, 1.0, noise=1e-4)
    mm = fit("cylinder", _contacts(points, approaches, 1e-4, 1.0))
    m = fit("cylinder", _contacts(points / 1000, approaches, 1e-7, 1e-3))
    assert mm.status == m.status == "located"
    assert m.chi2 == pytest.approx(mm.chi2, rel=1e-6)
    assert m.sigma["point"] * 1000 == pytest.approx(mm.sigma["point"], rel=1e-5)
    assert m.sigma["direction"] == pytest.approx(mm.sigma["direction"], rel=1e-5)
