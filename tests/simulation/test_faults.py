"""Each simulated fault has its stated effect and no other."""

import numpy as np
import pytest

from tactfix.errors import UsageError
from tactfix.geometry.surfaces import Sphere
from tactfix.localization.locate import locate
from tactfix.mistakes import FAULT_KINDS
from tactfix.simulation.faults import Fault, parse_fault
from tactfix.simulation.simulate import simulate
from tests.support.placed_cells import ball_and_bar, cube_corner, placed, three_balls

SEED = 5


def pair(fault, fixture=None, **options):
    fixture = fixture or ball_and_bar()
    if fault.kind == "wrong-tip":  # effective only with several tool orientations
        options["orientations"] = 4
    return simulate(fixture, seed=SEED, **options), simulate(fixture, seed=SEED, fault=fault, **options)


@pytest.mark.parametrize("kind", FAULT_KINDS)
def test_a_fault_keeps_pose_and_count_and_is_described(kind):
    right, wrong = pair(Fault(kind))
    assert np.array_equal(right.base_from_fixture, wrong.base_from_fixture)
    assert len(right.contacts) == len(wrong.contacts)
    assert right.mistake is None
    assert wrong.mistake
    changed = (
        not np.array_equal(right.contacts.points, wrong.contacts.points)
        or not np.array_equal(right.contacts.approaches, wrong.contacts.approaches)
        or right.contacts.features != wrong.contacts.features
        or right.contacts.tip_radius != wrong.contacts.tip_radius
    )
    assert changed


def test_an_outlier_is_one_contact_off_along_its_normal():
    right, wrong = pair(Fault("outlier", 0.7))
    off = np.linalg.norm(wrong.contacts.points - right.contacts.points, axis=1)
    assert np.sort(off)[-1] == pytest.approx(0.7)
    assert np.sort(off)[-2] == 0


def test_a_reversed_approach_is_the_one_asked_for():
    right, wrong = pair(Fault("reversed-approach", 3))
    turned = (wrong.contacts.approaches * right.contacts.approaches).sum(axis=1)
    assert np.flatnonzero(turned < 0).tolist() == [2]
    with pytest.raises(UsageError, match="row 99"):
        pair(Fault("reversed-approach", 99))


def test_swapped_labels_are_two_of_different_features():
    right, wrong = pair(Fault("swapped-labels"))
    differ = [
        i for i, (a, b) in enumerate(zip(right.contacts.features, wrong.contacts.features, strict=True)) if a != b
    ]
    assert len(differ) == 2
    assert sorted(right.contacts.features) == sorted(wrong.contacts.features)
    alone = placed("one", {"ball": Sphere([0, 0, 0], 10.0)}, {}, 1.0, 0.01)
    with pytest.raises(UsageError, match="two features"):
        pair(Fault("swapped-labels"), alone)


def test_a_wrong_unit_scales_all_coordinates():
    right, wrong = pair(Fault("wrong-unit"))
    assert np.allclose(wrong.contacts.points * 25.4, right.contacts.points)
    with pytest.raises(UsageError, match="positive"):
        pair(Fault("wrong-unit", 0.0))


def test_a_forgotten_tip_keeps_tip_centres_and_states_radius_zero():
    right, wrong = pair(Fault("forgotten-tip"))
    assert wrong.contacts.tip_radius == 0
    assert np.allclose(wrong.contacts.points, right.contacts.points)
    with pytest.raises(UsageError, match="RADIUS"):
        pair(Fault("forgotten-tip"), tip_radius=0.0)


def test_a_late_trigger_moves_every_contact_along_its_approach():
    right, wrong = pair(Fault("late-trigger", 0.25))
    assert np.allclose(wrong.contacts.points, right.contacts.points + 0.25 * right.contacts.approaches)


def test_expansion_keeps_the_origin_and_moves_distant_points():
    right, wrong = pair(Fault("thermal-growth", 1e-3), three_balls())
    rotation, shift = right.base_from_fixture[:3, :3], right.base_from_fixture[:3, 3]
    before, after = ((s.contacts.points - shift) @ rotation for s in (right, wrong))
    # The tip does not expand: the surface point moves by a thousandth of its distance from the origin.
    assert np.linalg.norm(after - before, axis=1) == pytest.approx(1e-3 * np.linalg.norm(before, axis=1), rel=0.2)


@pytest.mark.parametrize("text", ["outlier", "outlier:0.5", "wrong-unit:1000", "thermal-growth:1e-4"])
def test_faults_are_read(text):
    fault = parse_fault(text)
    name, _, value = text.partition(":")
    assert fault == Fault(name, float(value) if value else None)


@pytest.mark.parametrize(
    ("text", "pattern"),
    [
        ("outlyer", "outlier"),
        ("outlier:much", "number"),
        ("outlier:nan", "number"),
        ("outlier:1_0", "number"),
        ("outlier:1e308", "number"),
        ("", "use one of"),
    ],
)
def test_invalid_faults_are_rejected(text, pattern):
    with pytest.raises(UsageError, match=pattern):
        parse_fault(text)


@pytest.mark.parametrize("kind", FAULT_KINDS)
def test_three_balls_reveal_every_fault_but_one(kind):
    """Twelve contacts on three balls detect every mistake except a mirrored fixture, because three balls are their own
    mirror image.
    """
    _, wrong = pair(Fault(kind), three_balls())
    if kind == "mirrored":
        result = locate(three_balls(), wrong.contacts)
        turned = result.base_from_fixture[:3, :3].T @ wrong.base_from_fixture[:3, :3]
        assert turned @ np.diag([-1.0, 1.0, 1.0]) == pytest.approx(np.diag([1.0, 1.0, -1.0]), abs=1e-3)
        return
    assert locate(three_balls(), wrong.contacts, explain=False).status != "located"


def test_three_planes_hide_a_forgotten_tip():
    right, wrong = pair(Fault("forgotten-tip"), cube_corner())
    result = locate(cube_corner(), wrong.contacts)
    assert result.status == "located"
    moved = np.linalg.norm(result.base_from_fixture[:3, 3] - right.base_from_fixture[:3, 3])
    assert moved == pytest.approx(3.0 * np.sqrt(3), abs=0.1)


@pytest.mark.parametrize(
    "fault", [Fault("outlier", 1e308), Fault("late-trigger", float("nan")), Fault("wrong-unit", 1e-300)]
)
def test_a_fault_out_of_range_is_rejected_however_it_is_given(fault: Fault) -> None:
    with pytest.raises(UsageError, match="out of range"):
        simulate(ball_and_bar(), sigma=0.01, tip_radius=1.0, fault=fault)
