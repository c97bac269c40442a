"""A small part of the study of fixtures by relations: every kind, at angles near folds (0, 90 and 180 degrees)."""

import pytest

from tests.validation.relation_geometry import KINDS
from tests.validation.relations_study import RIGHT, Cell, cells, problem

NOMINAL, NOISY = {(0.0, 0.0)}, {(89.9, 0.0)}
"""Pairs of angle and sigma: of nominal contacts along the axes, and of noisy ones in a turned base."""
MORE_NOISY = {(0.02, 0.02), (179.99, 0.0)}
"""More of the noisy ones."""


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("nominal", "noisy"), [(NOMINAL, NOISY), pytest.param(set(), MORE_NOISY, marks=pytest.mark.slow)], ids=["", "more"]
)
def test_no_true_pose_is_rejected_and_no_located_pose_is_wrong(kind, nominal, noisy, tmp_path):
    chosen = [c for c in cells([kind]) if c.noisy == c.turned and (c.angle, c.sigma) in (noisy if c.noisy else nominal)]
    assert chosen
    for cell in chosen:
        tally = problem(cell, 7, tmp_path)
        complaints = {name: n for name, n in tally.items() if n and name not in (*RIGHT, "slow")}
        assert not complaints, (cell, complaints)


def test_the_study_varies_its_stated_parameters():
    """Twenty kinds, ten angles, four sigmas, base along the axes and rotated, contacts nominal and noisy."""
    every = list(cells(list(KINDS)))
    assert len(KINDS) == 20
    assert len({cell.angle for cell in every}) == 10
    assert len({cell.sigma for cell in every}) == 4
    assert {(cell.turned, cell.noisy) for cell in every if cell.kind == "block"} == {
        (t, n) for t in (False, True) for n in (False, True)
    }
    assert Cell("block", 180.0, 0.02, True, True) in every


@pytest.mark.parametrize(
    "cell",
    [Cell("two pins pair by pair", 90.0, 0.1, True, True), Cell("crossed bars apart", 45.0, 0.0, False, True)],
)
def test_a_ball_next_to_a_fold_frees_no_motion(cell, tmp_path):
    """At 2.4 sigma the sigma points miss their residuals by slightly more than one; nearer points avoid the fold."""
    tally = problem(cell, 1, tmp_path)
    assert tally["located"] == 1
    assert tally["wrong"] == tally["freed"] == 0
